"""ReSTIR PT guided by Markov chains that raw path-traced samples move, after Alber et al. 2025.

"Real-Time Markov Chain Path Guiding for Global Illumination and Single Scattering": four chains per cell, each of which
is a lobe aimed at a point.
"""

from pipeline import pipeline

from restirpg import prev


def chains(g, paths):
    """The guide, for the next frame."""
    g.add("guide", "GuidingChain", samples=paths.samples, history=prev("guide.guide"))


graph = pipeline("Alber 2025 on raw samples", guide=prev("guide.guide"), learn=chains)
