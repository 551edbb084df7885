"""ReSTIR DI: direct light at the primary hit by resampling light points over candidates, frames and pixels.

The rest of the light, indirect or by way of a mirror or smooth glass, is a plain path tracer's: the picture
is that of path_tracer.py, but for the pixel filter, which reuse over frames and pixels keeps at the pixel's
centre.
"""

from restirpg import Graph, prev


def pipeline(bounces=8, temporal=True, rounds=1):
    g = Graph("ReSTIR DI")
    gbuffer = g.add("gbuffer", "GBuffer", jitter=False)
    direct = g.add(
        "direct",
        "ReSTIRDI",
        surface=gbuffer.surface,
        motion=gbuffer.motion,
        previous_surface=prev("gbuffer.surface"),
        history=prev("direct.reservoirs"),
        temporal=temporal,
        rounds=rounds,
    )
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface, direct=False, bounces=bounces)
    image = g.add(
        "accumulate",
        "Accumulate",
        direct=direct.radiance,
        indirect=paths.radiance,
        emission=gbuffer.emission,
        history=prev("accumulate.sums"),
    )
    g.output("image", image.mean)
    g.output("variance", image.variance)
    g.output("invalid", image.invalid)
    g.output("direct", direct.radiance)
    return g


graph = pipeline()
