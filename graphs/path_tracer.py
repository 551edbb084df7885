"""Path tracer: next event estimation and BSDF sampling combined by MIS, no reuse, no guiding. The reference."""

from restirpg import Graph, prev


def pipeline(bounces=8):
    g = Graph("Path tracer")
    gbuffer = g.add("gbuffer", "GBuffer", jitter=True)
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface, direct=True, bounces=bounces)
    image = g.add(
        "accumulate", "Accumulate", indirect=paths.radiance, emission=gbuffer.emission, history=prev("accumulate.sums")
    )
    g.output("image", image.mean)
    g.output("variance", image.variance)
    g.output("invalid", image.invalid)
    return g


graph = pipeline()
