"""The initial paths of guided_by_temporal.py, without resampling. An ablation."""

from pipeline import pipeline

graph = pipeline("Candidates, guided by temporal reuse", train="temporal", show="candidates")
