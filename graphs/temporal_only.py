"""ReSTIR PT that reuses over frames, not over pixels. An ablation."""

from pipeline import pipeline

graph = pipeline("Temporal reuse only", rounds=0)
