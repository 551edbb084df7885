"""ReSTIR PG+: ReSTIR PG with another spatial reuse, and less work where it is hardly missed.

Spatial reuse pairs pixels that look alike, so that each shift of a path serves two. Six partners take as many shifts as
three neighbours. Each partner is chosen from four, three of them within some 10 pixels (16 at most) and three within a
third of that, whatever the size of the picture, up to 1080 lines. The guide learns from 135 rows of pixels at most.
Direct light is resampled from 16 candidates and 3 neighbours, in place of 32 and 5.
benchmarks/results/restir_pg_plus has the errors and times. The other methods take the same by
`reuse.reciprocal=true,reuse.neighbours=6,reuse.pool=4,reuse.radius=10,reuse.least_radius=10` and
`direct.neighbours=3,direct.candidates=16`. Two path trees, `paths.trees=2`, lower the error further, for a dearer frame.
"""

from pipeline import pipeline

PAIRS = {"reciprocal": True, "neighbours": 6, "pool": 4, "radius": 10.0, "least_radius": 10.0}
LIGHT = {"neighbours": 3, "candidates": 16}

graph = pipeline("ReSTIR PG+", train="selected", splat={"rows": 135}, reuse=PAIRS, direct=LIGHT)
