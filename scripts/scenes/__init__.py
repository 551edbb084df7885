"""The embedded scenes, each a function that returns a SceneFile."""

from . import analytic, door

SCENES = {build.__name__: build for family in (analytic, door) for build in family.FAMILY}
