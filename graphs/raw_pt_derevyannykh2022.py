"""ReSTIR PT guided in screen space by raw path-traced samples, after Derevyannykh 2022.

"Real-Time Path-Guiding Based on Parametric Mixture Models": one lobe per pixel, for the bounce at the primary
hit. The settings are the best of benchmarks/results/derevyannykh2022_sweep.
"""

from pipeline import pipeline

graph = pipeline(
    "Derevyannykh 2022 on raw samples", train="raw", cells="screen", fit={"product": True, "neighbours": 24}
)
