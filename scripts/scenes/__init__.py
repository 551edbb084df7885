"""The embedded scenes, each a function that returns a SceneFile."""

from . import analytic, court, door, gallery

SCENES = {build.__name__: build for family in (analytic, door, gallery, court) for build in family.FAMILY}
