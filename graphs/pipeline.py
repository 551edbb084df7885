"""ReSTIR DI for direct light, ReSTIR PT for the rest: the pipeline that the methods share. Methods differ in its
arguments.

The tracing pass is always called `paths`.
"""

from restirpg import Graph, prev


def pipeline(
    name="ReSTIR PT",
    bounces=8,
    temporal=True,
    rounds=1,
    train=None,
    guide=None,
    learn=None,
    splat={},
    fit={},
    reuse={},
    direct={},
    trees=1,
    guided_bounces=64,
    show="resampled",
):
    """Build the graph.

    temporal, rounds: reuse over frames, and rounds of spatial reuse, for direct and indirect light alike.
    train: the training data of the hash grid's guide. None: no such guide. "selected": the paths that resampling
    selects. "candidates": the paths that it selects from. "temporal": what an additional resampling over frames alone
    selects. "raw": all bounces of the path trees, weighted by the light that came back along them.
    splat, fit: knobs of GuidingSplat and GuidingFit.
    guide: another guide in place of the hash grid: its port, or a function that adds its pass and returns the port. The
    function gets the graph and a dictionary of the inputs surface, motion and previous_surface.
    learn: a function of the graph and the pass `paths`; it adds the pass that trains the guide after the paths.
    reuse, direct: knobs of ReSTIRReuse and ReSTIRDI.
    trees: path trees per pixel, from which one path is resampled.
    guided_bounces: bounces from the primary hit on that the guide samples, and that it learns from if train is "raw".
    show: "resampled", or "candidates": the indirect light of the initial paths alone.
    """
    if train and guide:
        raise ValueError("train is for the guide of the hash grid; with another guide, leave it out")
    g = Graph(name)
    gbuffer = g.add("gbuffer", "GBuffer", jitter=False)
    before = {
        "surface": gbuffer.surface,
        "motion": gbuffer.motion,
        "previous_surface": prev("gbuffer.surface"),
    }
    direct_light = g.add(
        "direct",
        "ReSTIRDI",
        history=prev("direct.reservoirs"),
        temporal=temporal,
        rounds=rounds,
        **direct,
        **before,
    )
    if train:
        guide = prev("fit.guide")
    elif callable(guide):
        guide = guide(g, before)
    paths = g.add(
        "paths",
        "PathTracerGuided",
        surface=gbuffer.surface,
        bounces=bounces,
        trees=trees,
        guided_bounces=guided_bounces,
        guide=guide,
    )

    def resample(name, **knobs):
        return g.add(
            name,
            "ReSTIRReuse",
            candidates=paths.candidates,
            history=prev(f"{name}.reservoirs"),
            **knobs,
            **before,
        )

    resampled = resample("reuse", temporal=temporal, rounds=rounds, **reuse)
    if learn:
        learn(g, paths)
    if train:
        training = {
            "selected": lambda: {"paths": resampled.reservoirs, "surface": gbuffer.surface},
            "candidates": lambda: {"paths": paths.candidates, "surface": gbuffer.surface},
            "temporal": lambda: {"paths": resample("temporal_reuse", rounds=0).reservoirs, "surface": gbuffer.surface},
            "raw": lambda: {"samples": paths.samples},
        }[train]()
        statistics = g.add("splat", "GuidingSplat", guide=prev("fit.guide"), **training, **splat)
        g.add("fit", "GuidingFit", statistics=statistics.statistics, history=prev("fit.guide"), **fit)
    image = g.add(
        "accumulate",
        "Accumulate",
        direct=direct_light.radiance,
        indirect=resampled.radiance if show == "resampled" else paths.radiance,
        emission=gbuffer.emission,
        history=prev("accumulate.sums"),
    )
    g.output("image", image.mean)
    g.output("variance", image.variance)
    g.output("invalid", image.invalid)
    return g


graph = pipeline()
