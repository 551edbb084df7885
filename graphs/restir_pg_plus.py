"""ReSTIR PG+: ReSTIR PG whose spatial reuse pairs pixels that look alike, so that each shift of a path serves two.

Six partners take as many shifts as three neighbours. Each partner is chosen from four, three of them within some 10
pixels (16 at most) and three within a third of that, whatever the size of the picture, up to 1080 lines. Of a picture of
more than 270 lines the guide learns from 270 at most.
benchmarks/results/restir_pg_plus has the errors. The other methods take the same reuse by
`reuse.reciprocal=true,reuse.neighbours=6,reuse.pool=4,reuse.radius=10,reuse.least_radius=10`. Two path trees,
`paths.trees=2`, lower the error further, for a dearer frame.
"""

from pipeline import pipeline

PAIRS = {"reciprocal": True, "neighbours": 6, "pool": 4, "radius": 10.0, "least_radius": 10.0}

graph = pipeline("ReSTIR PG+", train="selected", splat={"rows": 270}, reuse=PAIRS)
