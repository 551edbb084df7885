"""ReSTIR PT without reuse: each pixel's own candidates, resampled. An ablation."""

from pipeline import pipeline

graph = pipeline("RIS only", temporal=False, rounds=0)
