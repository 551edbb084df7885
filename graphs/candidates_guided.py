"""The initial paths of ReSTIR PG, without resampling; the guide still learns from what resampling selects.

[Zeng et al. 2025, figure 6]
"""

from pipeline import pipeline

graph = pipeline("Candidates, guided", train="selected", show="candidates")
