"""ReSTIR PG with a memory: statistics of earlier frames count, by 0.9 a frame. Not in the paper, whose frames have
enough samples.

In a small image a cell sees few different paths a frame (benchmarks/results/restir_pg).
"""

from pipeline import pipeline

graph = pipeline("ReSTIR PG, decaying statistics", train="selected", fit={"decay": 0.9})
