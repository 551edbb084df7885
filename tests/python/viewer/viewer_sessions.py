"""What the tests of the viewer's session share."""

from renderer_scenes import restirpg

SIZE = (16, 16)
PAGE_SIZE = (32, 18)


def images(session):
    return [pane.picture().copy() for pane in session.panes]


def depth_graph():
    """A graph whose picture has one channel."""
    graph = restirpg.Graph("Depth")
    graph.output("depth", graph.add("gbuffer", "GBuffer").depth)
    return graph
