"""A graph with the pass: the graph file of the repository, and one pass more behind it."""

from restirpg import Graph, prev

graph = Graph("Path tracer, two stops brighter")
gbuffer = graph.add("gbuffer", "GBuffer")
paths = graph.add("paths", "PathTracerGuided", surface=gbuffer.surface, direct=True, bounces=1)
mean = graph.add(
    "accumulate", "Accumulate", indirect=paths.radiance, emission=gbuffer.emission, history=prev("accumulate.sums")
)
bright = graph.add("bright", "Exposure", radiance=mean.mean, stops=2.0)
graph.output("image", bright.image)
graph.output("before", mean.mean)
