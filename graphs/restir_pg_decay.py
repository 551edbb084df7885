"""ReSTIR PG with a memory: a cell's statistics are multiplied by 0.9 in each frame, not discarded. Not in the paper, whose
frames have enough samples.

In a small image a cell sees few different paths per frame (benchmarks/results/restir_pg).
"""

from pipeline import pipeline

graph = pipeline("ReSTIR PG, decaying statistics", train="selected", fit={"decay": 0.9})
