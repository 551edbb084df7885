"""ReSTIR PG+: ReSTIR PG with another spatial reuse, less noise of colour, and fewer samples of direct light and training.

Spatial reuse pairs pixels that look alike, so that each shift of a path serves two. Six partners take as many shifts as
three neighbours. Each partner is chosen from four. Three partners lie within about 10 pixels (16 at most), three within
a third of that, at any picture size up to 1080 lines.
A pixel shows the light of all paths (and light points) that its last merge chose from, not of the chosen one alone.
Direct light is resampled from 16 candidates and 3 neighbours, not 32 and 5. The guide learns from 135 rows of pixels at
most.
Errors and times: benchmarks/results/restir_pg_plus. Other methods get the same reuse and light by
`reuse.reciprocal=true,reuse.neighbours=6,reuse.pool=4,reuse.radius=10,reuse.least_radius=10,reuse.shade=merged` and
`direct.neighbours=3,direct.candidates=16,direct.shade=merged`. `paths.trees=2` (two path trees) lowers the error
further; a frame then takes longer.
"""

from pipeline import pipeline

PAIRS = {"reciprocal": True, "neighbours": 6, "pool": 4, "radius": 10.0, "least_radius": 10.0, "shade": "merged"}
LIGHT = {"neighbours": 3, "candidates": 16, "shade": "merged"}
SETTINGS = {"train": "selected", "splat": {"rows": 135}, "reuse": PAIRS, "direct": LIGHT}

graph = pipeline("ReSTIR PG+", **SETTINGS)
