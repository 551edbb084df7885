"""The initial paths of ReSTIR PG+, without resampling; the guide still learns from what resampling selects."""

from pipeline import pipeline
from restir_pg_plus import SETTINGS

graph = pipeline("Candidates, guided by ReSTIR PG+", show="candidates", **SETTINGS)
