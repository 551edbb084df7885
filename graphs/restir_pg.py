"""ReSTIR PG: the initial paths of ReSTIR PT are guided by the paths that it selected in the frame before.

[Zeng et al. 2025, "ReSTIR PG: Path Guiding with Spatiotemporally Resampled Paths"]
"""

from pipeline import pipeline

graph = pipeline("ReSTIR PG", train="selected")
