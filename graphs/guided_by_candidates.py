"""ReSTIR PT guided by its candidates, one path per pixel before any reuse: what ReSTIR PG learns from, less the reuse.
An ablation."""

from pipeline import pipeline

graph = pipeline("Guided by candidates", train="candidates")
