"""Start and stop a viewer: from Python by view(), from a shell by main()."""

import argparse
import asyncio
import functools
import html
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from aiohttp import web

import restirpg
from restirpg import commands
from restirpg.harness import UserError, given_reference, program, render

from . import camera
from .rendering import RenderThread
from .server import Server
from .session import Session
from .watch import Watch

MOST_GRAPHS = 4
_PATIENCE = 2  # s that a request at hand has once the viewer ends


class Viewer:
    """A running viewer. `url`: its address, which holds the token. A notebook shows it in place."""

    def __init__(self, session, port=0, watch=None):
        self.session = session
        self._loop = asyncio.new_event_loop()
        self._server = Server(session, self._loop)
        self.rendering = self._server.thread = RenderThread(session, self._server.publish, watch)
        self._runner = web.AppRunner(self._server.application(), access_log=None)
        self._network = threading.Thread(target=self._loop.run_forever, name="restirpg viewer's network", daemon=True)
        self._network.start()
        try:
            port = self._wait(self._serve(port))
        except OSError as error:
            self._end_loop()
            raise UserError(f"port {port}: cannot listen: {error.strerror}; choose another with --port") from None
        self.url = f"http://127.0.0.1:{port}/{self._server.token}/"
        self.rendering.start()

    def _wait(self, coroutine):
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result()

    async def _serve(self, port):
        await self._runner.setup()
        site = web.TCPSite(self._runner, "127.0.0.1", port, shutdown_timeout=_PATIENCE)
        await site.start()
        return site._server.sockets[0].getsockname()[1]

    def _end_loop(self):
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._network.join()
        self._loop.close()

    def close(self):
        """Stop rendering and serving."""
        if not self._loop.is_closed():
            self.rendering.stop()
            self._wait(self._runner.cleanup())
            self._end_loop()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def _repr_html_(self):
        return f'<iframe src="{html.escape(self.url)}" width="100%" height="760" style="border: 0"></iframe>'


def _as_restirpg_errors(function):
    """The function, whose UserErrors are restirpg.Errors: it is called from Python."""

    @functools.wraps(function)
    def called(*arguments, **options):
        try:
            return function(*arguments, **options)
        except UserError as error:
            raise restirpg.WrongValueError(str(error)) from None

    return called


@_as_restirpg_errors
def view(
    graphs,
    scene,
    size=(640, 360),
    reference=None,
    port=0,
    captures="out/captures",
    pose=None,
    allow_outside=False,
    **options,
):
    """Look at a scene through one graph or several, live, in a browser on this machine. Returns a Viewer.

    graphs: a graph file, a restirpg.Graph or a description, or a list of up to 4. scene: a file or what load_scene
    returns. reference: an EXR file of the scene's own camera, to measure errors against. captures: the folder where
    films are put. pose: where the camera stands at first, as Renderer.camera has it. allow_outside: of load_scene; the
    command lines that the page copies say so too. options: of restirpg.Renderer, but no window and no fps. Raises restirpg.Error.
    """
    if options.get("fps"):
        raise UserError("the viewer has a speed of its own for animations: leave out fps")
    if options.get("window") is not None:
        raise UserError("the viewer shows whole pictures: leave out window, or give a smaller size")
    sources = list(graphs) if isinstance(graphs, (list, tuple)) else [graphs]
    if not 1 <= len(sources) <= MOST_GRAPHS:
        raise UserError(f"give 1 to {MOST_GRAPHS} graphs, not {len(sources)}")
    if from_file := isinstance(scene, (str, Path)):
        scene = restirpg.load_scene(scene, allow_outside=allow_outside)
    image, header = None, {}
    if reference is not None:
        image = np.asarray(restirpg.read_exr(reference), np.float32)
        if image.shape[:2] != (size[1], size[0]):
            raise UserError(
                f"{reference}: {image.shape[1]}x{image.shape[0]} pixels; the viewer shows {size[0]}x{size[1]}"
            )
        header = given_reference.check(reference, scene.hash, size)
        asked = SimpleNamespace(
            environment=scene.environment,
            # A scene that was loaded before does not say which of its cameras it has.
            camera=0 if from_file else header.get(given_reference.CAMERA),
            energy_compensation=options.get("energy_compensation"),
        )
        for line in given_reference.warnings_of(reference, header, asked, scene.environment_hash, {}):
            print(f"warning: {line}", file=sys.stderr)
    mean_of = given_reference.mean_of_header(header)
    session = Session(scene, sources, size, image, captures, allow_outside, mean_of, **options)
    if pose is not None:
        session.apply({"do": "pose", **pose})
    return Viewer(session, port, Watch([pane.file for pane in session.panes if pane.file]))


def _port(text):
    if not (text.isdecimal() and int(text) < 65536):
        raise argparse.ArgumentTypeError(f"'{text}' is no port: a number from 0 (any that is free) to 65535")
    return int(text)


def _pose(text):
    try:
        return camera.from_option(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is no pose: position, target and up (x,y,z each) and the vertical field of "
            "view in radians, ten numbers with commas"
        ) from None


def _name():
    """How the user called it: the program runs this package, as `restirpg view`."""
    started = Path(sys.argv[0]).name
    return "restirpg view" if started == "__main__.py" else started


def _parse(arguments):
    parser = argparse.ArgumentParser(
        prog=_name(),
        description="Look at a scene through one graph, or several side by side, live in a browser. The page is served on the "
        "loopback address alone; over ssh, forward the port that is printed: ssh -L PORT:127.0.0.1:PORT HOST.",
    )
    parser.add_argument("graphs", metavar="GRAPH", nargs="+", help="graph files, up to 4")
    parser.add_argument("--scene", required=True, help="glTF file")
    parser.add_argument("--size", type=program.size, default=(640, 360), help="WIDTHxHEIGHT (640x360)")
    parser.add_argument("--reference", help="EXR file of the scene's own camera, to measure errors against")
    parser.add_argument("--port", type=_port, default=0, help="0: any that is free")
    parser.add_argument(
        "--captures", default="out/captures", metavar="FOLDER", help="where films are put (%(default)s)"
    )
    parser.add_argument("--pose", type=_pose, help="where the camera stands at first, as the page copies it")
    parser.add_argument("--bounces", type=program.bounces, help="bounce cap (the scene's, or the graph's own)")
    parser.add_argument("--device", help="number or part of the name, as `restirpg devices` lists them")
    program.add_allow_outside(parser)
    return commands.parsed(parser, arguments)


def main(arguments):
    """The command line. Returns the exit code."""
    options = _parse(arguments)

    def body(_):
        render.find_package()
        with render.refusals():
            viewer = view(
                options.graphs,
                options.scene,
                options.size,
                options.reference,
                options.port,
                options.captures,
                options.pose,
                options.allow_outside,
                device=options.device,
                bounces=options.bounces,
            )
        with viewer:
            print(viewer.url, flush=True)
            print("Open this address in a browser. Ctrl-C ends the viewer.", file=sys.stderr, flush=True)
            try:
                threading.Event().wait()
            except KeyboardInterrupt:  # how a viewer is ended
                print(file=sys.stderr)
        return 0

    return program.run(_name(), body)
