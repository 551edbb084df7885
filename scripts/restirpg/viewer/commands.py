"""What the page may ask for: do_NAME(session, arguments) for the message {"do": NAME, arguments}.

Each raises UserError or restirpg.Error, and leaves all as it was then.
"""

import inspect

from restirpg.harness import UserError

from . import camera
from .film import Film
from .reference import SOURCES
from .values import as_finite, as_number, as_triple

VIEWS = ("image", "difference", "error")


def do_orbit(session, x, y):
    """Turn about the target, radians."""
    session.move(camera.orbit(session.camera, as_number(x), as_number(y)))


def do_look(session, x, y):
    """Turn the head, radians."""
    session.move(camera.look(session.camera, as_number(x), as_number(y)))


def do_pan(session, x, y):
    """Shift by fractions of the picture's height."""
    session.move(camera.pan(session.camera, as_number(x), as_number(y)))


def do_dolly(session, amount):
    """Go towards the target."""
    session.move(camera.dolly(session.camera, as_number(amount, -5, 5)))


def do_fly(session, x, y, z):
    """Move by fractions of the target's distance along right, up and forward."""
    step = camera.distance(session.camera)
    session.move(camera.fly(session.camera, *(step * as_number(value, -10, 10) for value in (x, y, z))))


def do_zoom(session, factor):
    """Another field of view."""
    session.move(camera.zoom(session.camera, as_number(factor, 0.1, 10)))


def do_fov(session, yfov):
    """The vertical field of view, radians."""
    session.move(camera.with_fov(session.camera, float(as_finite(yfov))))


def do_focus(session, x, y):
    """Orbit about what the pixel shows: the target goes to its depth."""
    depth = session.inspector.geometry(x, y)["depth"]
    if depth > 0:
        session.move(camera.focus(session.camera, depth))


def do_pose(session, position, target, up, yfov):
    """A camera as the page copied it."""
    vectors = {"position": position, "target": target, "up": up}
    pose = {name: as_triple(vector, name) for name, vector in vectors.items()}
    session.move({**pose, "yfov": float(as_finite(yfov))})


def do_home(session):
    """The scene's own camera, also where it goes as the animation goes on."""
    session.follow()


def do_camera(session, number):
    """One of the scene's cameras, where it stands now."""
    cameras = session.scene_cameras()
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < len(cameras):
        raise UserError(f"there is no camera {number!r}; the scene has {len(cameras)}, counted from 0")
    session.move(cameras[number])


def do_play(session, on):
    """Render on, or pause."""
    session.playing, session.steps = bool(on), 0


def do_step(session):
    """Pause, and render one frame."""
    session.playing = False
    session.steps = min(session.steps + 1, 100)


def do_restart(session):
    """Forget all history."""
    for pane in session.panes:
        pane.renderer.cut()
        pane.forget()


def do_keep(session, on):
    """Whether history is kept over moves of the camera, as in a real-time renderer, or cut."""
    session.keep = bool(on)
    do_restart(session)


def do_exposure(session, stops):
    """Of the picture as shown."""
    session.exposure, session.stale = float(as_number(stops, -20, 20)), True


def do_view(session, name, left=0, right=1):
    """The pictures, the difference of two, by their graphs' places, or their errors against the reference."""
    if name not in VIEWS:
        raise UserError(f"there is no view {name!r}")
    if name == "difference":
        if len(session.panes) < 2:
            raise UserError("a difference takes two graphs; give two on the command line")
        for side in (left, right):
            session.pane(side)
        session.sides = left, right
    if name == "error" and session.reference.source == "none":
        raise UserError("errors take a reference; have one traced, or give one with --reference")
    session.view, session.stale = name, True


def do_set(session, pane, knob, value):
    """Turn a knob. What was averaged with its old value is forgotten."""
    session.pane(pane).set(str(knob), value)
    session.begin(session.pane(pane))


def do_reset(session, pane):
    """All knobs as the graph gives them."""
    chosen = session.pane(pane)
    for knob in list(chosen.changed):
        chosen.set(knob, None)
    session.begin(chosen)


def do_show(session, pane, port):
    """Show a port in place of the picture, or (null) the picture."""
    chosen = session.pane(pane)
    chosen.show(port)
    session.stale = True
    if chosen.waits:  # it may have a new renderer
        session.place(chosen)


def do_seed(session, value):
    """Other random numbers, from a first frame on."""
    session.seed = int(as_number(value, 0, 2**32 - 1))
    for pane in session.panes:
        pane.renderer.seed = session.seed
    do_restart(session)


def do_time(session, seconds):
    """Of the scene's animation."""
    session.go_to(float(as_number(seconds, 0)))


def do_speed(session, factor):
    """Of the scene's animation: a frame advances it by factor / 30 s; with 0 it stands still."""
    session.speed = float(as_number(factor, -100, 100))


def do_reference(session, source):
    """What errors are measured against: "none", the "file" that was given, or "traced" beside the graphs."""
    if source not in SOURCES or (source == "file" and session.reference.image is None):
        raise UserError(f"there is no reference {source!r}; a file is given with --reference")
    session.reference.use(source)
    session.view = "image" if source == "none" and session.view == "error" else session.view
    session.stale = True


def do_film(session, frames, kind):
    """Write pictures of the next frames into a folder; 0 frames: end the film at hand. A pause is one of the film too."""
    if frames == 0:
        session.end_film()
    elif session.film:
        raise UserError("a film is being recorded; stop it before the next one")
    else:
        session.film = Film(session.captures, session, frames, kind)
        session.playing = True


def do_reload(session):
    """Read graph files and shaders anew. Each graph that is refused stays as it was."""
    session.reload()


COMMANDS = {name.removeprefix("do_"): act for name, act in list(globals().items()) if name.startswith("do_")}


def run(session, message):
    """Do what a message says, whose "id" is not of the command."""
    name = message.get("do")
    command = COMMANDS.get(name) if isinstance(name, str) else None
    if command is None:
        raise UserError(f"there is no command {name!r}")
    arguments = {key: value for key, value in message.items() if key not in ("do", "id")}
    try:
        inspect.signature(command).bind(session, **arguments)
    except TypeError as error:
        raise UserError(f"{name}: {error}") from None
    command(session, **arguments)
