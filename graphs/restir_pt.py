"""ReSTIR PT without path guiding: the baseline on which the guided methods stand. Direct light by ReSTIR DI."""

from pipeline import pipeline

graph = pipeline()
