"""The initial paths of guided_by_candidates.py, without resampling. An ablation."""

from pipeline import pipeline

graph = pipeline("Candidates, guided by its candidates", train="candidates", show="candidates")
