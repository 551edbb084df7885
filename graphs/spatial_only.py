"""ReSTIR PT that reuses over pixels, not over frames. An ablation."""

from pipeline import pipeline

graph = pipeline("Spatial reuse only", temporal=False)
