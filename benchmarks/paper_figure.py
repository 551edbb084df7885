#!/usr/bin/python3
"""Figure 1 of the paper from a finished scene of scripts/reproduce.py --paper-size: the whole picture, and crops by every
method.

    benchmarks/paper_figure.py out/paper_size/SCENE --scene SCENE.glb --bounces N --crop X,Y --crop X,Y
        [--side 216] [--frames 256] [--png FILE]

Pictures are each method's last frame, errors those of its tiles.csv. The reference is rendered in the crops alone, by
ReSTIR PG with a seed of its own.
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np
from clone import ROOT

import restirpg
from restirpg.harness import UserError, files, pictures, program, render
from restirpg.harness.paper import page

NAMES = {
    "restir_pt": "no guiding",
    "raw_pt_derevyannykh2022": "Derevyannykh 2022",
    "raw_pt_ruppert2020": "Ruppert 2020",
    "restir_pg": "ReSTIR PG",
    "restir_pg_plus": "ReSTIR PG+",
}
SHOWN = "restir_pg"  # as the whole picture
MEASURED = "MAPE in tiles of the whole picture"


def corner(text):
    """`X,Y` in pixels."""
    x, _, y = text.partition(",")
    if not (text.isascii() and x.isdigit() and y.isdigit()):
        raise argparse.ArgumentTypeError(f"'{text}' is not X,Y in pixels, as in 900,440")
    return int(x), int(y)


def parse(arguments):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="of the scene's report, with images/ and tiles.csv")
    parser.add_argument("--scene", required=True, help="its file")
    parser.add_argument(
        "--crop",
        type=corner,
        required=True,
        action="append",
        metavar="X,Y",
        help="left upper corner of a crop; give it twice",
    )
    parser.add_argument("--side", type=program.positive, default=216, help="of the crops, in pixels (%(default)s)")
    parser.add_argument("--bounces", type=program.bounces, required=True, help="bounce cap of the reference")
    parser.add_argument("--frames", type=program.positive, default=256, help="of the reference (%(default)s)")
    parser.add_argument("--png", default="out/paper_figure.png", help="file to write (%(default)s)")
    return parser.parse_args(arguments)


def render_reference(options, corners, size):
    """The crops, in a picture that is black elsewhere."""
    scene = restirpg.load_scene(options.scene)
    graph = restirpg.load_graph(ROOT / "graphs/restir_pg.py")
    image = np.zeros((size[1], size[0], 3), np.float32)
    with restirpg.Renderer(
        scene,
        graph,
        size=size,
        seed=20202,
        window=(*corners[0], options.side, options.side),
        bounces=options.bounces,
    ) as renderer:
        for x, y in corners:
            renderer.move_window(x, y)
            renderer.render(options.frames)
            image[y : y + options.side, x : x + options.side] = renderer.output("image")[..., :3]
    return image


def read_errors(file):
    """{method: its error} of a tiles.csv."""
    mend = "name the folder of a scene that scripts/reproduce.py --paper-size has finished"
    try:
        with open(file, newline="") as stream:
            rows = {row.get("method"): row for row in csv.DictReader(stream)}
    except OSError as error:
        raise UserError(f"{file}: cannot be read: {error.strerror}; {mend}") from None
    if SHOWN not in rows:
        raise UserError(f"{file}: no row is of {SHOWN}, whose picture is shown; {mend}")
    try:
        return {
            name: f"{100 * float(row['mape']):.1f} ± {100 * float(row['mape_se']):.1f}%" for name, row in rows.items()
        }
    except (KeyError, TypeError, ValueError):  # no such column, a row that is too short, no number
        raise UserError(f"{file}: it lacks numbers in a column mape or mape_se; {mend}") from None


def check_crops(corners, side, size):
    """Raise UserError where a crop reaches beyond the picture, or where there are not two."""
    if len(corners) != 2:
        raise UserError(f"the figure has two crops, not {len(corners)}; give --crop twice")
    for x, y in corners:
        if x + side > size[0] or y + side > size[1]:
            raise UserError(
                f"--crop {x},{y}: {side}x{side} pixels from there reach beyond the picture of {size[0]}x{size[1]}; "
                "choose another corner, or a smaller --side"
            )


def draw(options):
    """Write the figure. Returns the exit code."""
    corners = options.crop
    error = read_errors(options.folder / "tiles.csv")
    name = Path(options.scene).stem
    columns = [
        pictures.Picture(
            title, restirpg.read_exr(options.folder / "images" / f"{name}.{method}.whole.exr"), error[method]
        )
        for method, title in NAMES.items()
        if method in error
    ]
    whole = next(picture for picture in columns if picture.title == NAMES[SHOWN])
    size = whole.image.shape[1::-1]
    check_crops(corners, options.side, size)
    columns.append(pictures.Picture("reference", render_reference(options, corners, size), ""))
    figure = pictures.teaser(name, pictures.exposure_of(whole.image), (corners, options.side), whole, columns, MEASURED)
    files.write(options.png, page.Picture("figure", "", figure).png())
    return 0


def main(arguments):
    """The command line. Returns the exit code."""
    options = parse(arguments)

    def body(_):
        render.find_package()
        files.prepare(options.png, [options.scene], "--png")
        with render.refusals():
            return draw(options)

    return program.run("paper_figure.py", body)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
