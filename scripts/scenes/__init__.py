"""The embedded scenes, each a function that returns a SceneFile."""

from . import analytic

SCENES = {build.__name__: build for family in (analytic,) for build in family.FAMILY}
