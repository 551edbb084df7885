"""The embedded scenes, each a function that returns a SceneFile."""

from . import analytic, court, door, gallery, pavilion, rooms, street, temple

SCENES = {
    build.__name__: build
    for family in (analytic, door, gallery, court, rooms, temple, pavilion, street)
    for build in family.FAMILY
}
