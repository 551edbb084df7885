"""ReSTIR PG+: ReSTIR PG whose spatial reuse takes neighbours that look like the pixel, of pools from a wider disk.

Against ReSTIR PG it costs some 5% of a frame more; benchmarks/results/restir_pg_plus.md has the errors. The other methods take the same
neighbours by `reuse.pool=8,reuse.radius=120`.
"""

from pipeline import pipeline

graph = pipeline("ReSTIR PG+", train="selected", reuse={"pool": 8, "radius": 120.0})
