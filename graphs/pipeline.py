"""ReSTIR DI for direct light, ReSTIR PT for the rest: the pipeline that the methods share. Methods differ in its arguments.

The tracing pass is always called `paths`.
"""

from restirpg import Graph, prev


def pipeline(name="ReSTIR PT", bounces=8, temporal=True, rounds=1):
    """The graph. temporal, rounds: reuse over frames, and rounds of reuse over pixels, for direct and indirect light alike."""
    g = Graph(name)
    gbuffer = g.add("gbuffer", "GBuffer", jitter=False)
    before = {"motion": gbuffer.motion, "previous_surface": prev("gbuffer.surface")}
    direct = g.add("direct", "ReSTIRDI", surface=gbuffer.surface, history=prev("direct.reservoirs"),
                   temporal=temporal, rounds=rounds, **before)
    paths = g.add("paths", "PathTracerGuided", surface=gbuffer.surface, bounces=bounces)
    reuse = g.add("reuse", "ReSTIRReuse", surface=gbuffer.surface, candidates=paths.candidates,
                  history=prev("reuse.reservoirs"), temporal=temporal, rounds=rounds, **before)
    image = g.add("accumulate", "Accumulate", direct=direct.radiance, indirect=reuse.radiance,
                  emission=gbuffer.emission, history=prev("accumulate.sums"))
    g.output("image", image.mean)
    g.output("variance", image.variance)
    g.output("invalid", image.invalid)
    return g


graph = pipeline()
