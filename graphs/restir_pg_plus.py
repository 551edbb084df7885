"""ReSTIR PG+: ReSTIR PG with two path trees per pixel, whose spatial reuse takes neighbours that look like the pixel.

A frame takes some 1.6 times as long as that of ReSTIR PG. benchmarks/results/restir_pg_plus.md has the errors. The
other methods take the same by `paths.trees=2,reuse.pool=8,reuse.least_radius=10`.
"""

from pipeline import pipeline

graph = pipeline("ReSTIR PG+", train="selected", trees=2, reuse={"pool": 8, "least_radius": 10.0})
