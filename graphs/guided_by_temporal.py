"""ReSTIR PT guided by the paths that reuse over frames alone selects, in a pass beside its own reuse. An ablation."""

from pipeline import pipeline

graph = pipeline("Guided by temporal reuse", train="temporal")
