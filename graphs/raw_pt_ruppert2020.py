"""ReSTIR PT guided by raw path-traced samples, in the manner of Ruppert et al. 2020, "Robust Fitting of Parallax-Aware
Mixtures for Path Guiding", adapted to real time: weighted EM over decaying statistics in the same grid, lobes aimed at
what they saw."""

from pipeline import pipeline

graph = pipeline(
    "Ruppert 2020 on raw samples",
    train="raw",
    splat={"parallax": True},
    fit={"parallax": True, "cosine": True, "decay": 0.9, "weight_prior": 0.01, "concentration_prior": 0.2},
)
