"""ReSTIR PT guided in screen space by raw path-traced samples, after Derevyannykh 2022.

"Real-Time Path-Guiding Based on Parametric Mixture Models": one lobe per pixel, for the bounce at the primary
hit. The settings are the best of benchmarks/results/derevyannykh2022_sweep.
"""

from pipeline import pipeline

from restirpg import prev


def lobes(g, before):
    """The guide: it learns from the samples of the frame before."""
    history = {"samples": prev("paths.samples"), "history": prev("guide.statistics")}
    return g.add("guide", "GuidingScreen", product=True, neighbours=24, **history, **before).guide


graph = pipeline("Derevyannykh 2022 on raw samples", guide=lobes)
