"""The initial paths of ReSTIR PT, without resampling. [Zeng et al. 2025, figure 6]"""

from pipeline import pipeline

graph = pipeline("Candidates, unguided", show="candidates")
