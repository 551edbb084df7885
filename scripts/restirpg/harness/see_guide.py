"""See what guides the paths at some pixels: fitted lobes, the directions they were fitted to, and the true
product rho L_i cos.

    scripts/see_guide.py --scene FILE --pixel X Y [--pixel X Y ...]
        [--graph graphs/restir_pg.py]
        [--frames 64] [--size 160x90] [--cell-size SHARE] [--raw] [--allow-outside] [-o out/guide.png] [--markdown FILE]

One row of maps per pixel, each the hemisphere about the surface's normal: azimuth to the right, cosine
downwards from 1 to 0, so that equal areas are equal solid angles. The product is a render of what the point
sees (five faces of a cube, path traced with one bounce less, without what is emitted towards the point
itself: direct light is not ReSTIR PT's); it stands for the product on diffuse surfaces alone. Printed are the
Kullback-Leibler divergence of the directions' histogram from the product, the same for as many independent
draws from the product itself (the least that chance allows), and chi-square over its degrees of freedom,
against the count of samples. [Zeng et al. 2025, figure 4]

--raw: instead of the vertices of the paths that the guide learns from, those of raw unguided path trees, weighted by
light, BSDF and cosine.
"""

import argparse
import io
from pathlib import Path

import numpy as np

import restirpg
from restirpg import commands
from restirpg.harness import files, program, render


def parse(arguments):
    """The command line as a namespace."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", type=Path, required=True, help=".glb or .gltf")
    program.add_allow_outside(parser)
    parser.add_argument(
        "--pixel",
        type=int,
        nargs=2,
        metavar=("X", "Y"),
        action="append",
        required=True,
        help="a pixel; may be repeated",
    )
    parser.add_argument(
        "--graph",
        type=Path,
        default=restirpg.GRAPHS / "restir_pg.py",
        help="a graph with the passes GuidingSplat, GuidingFit and ReSTIRReuse, which learns from paths unless --raw is given",
    )
    parser.add_argument("--frames", type=program.positive, default=64, help="frames to learn from (%(default)s)")
    parser.add_argument("--size", type=program.size, default=(160, 90), metavar="WxH", help="pixels (160x90)")
    parser.add_argument(
        "--cell-size",
        type=program.length,
        metavar="SHARE",
        help="of the guide's cells, as a share of the picture's height (default: the graph's own)",
    )
    parser.add_argument("--raw", action="store_true", help="learn from raw path trees")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="write the table to this file")
    parser.add_argument("-o", type=Path, default=Path("out/guide.png"), metavar="PNG", help="the maps (%(default)s)")
    return commands.parsed(parser, arguments)


def see(arguments):
    """Learn, print the table and draw the maps."""
    from restirpg.harness import guide_maps

    scene = restirpg.load_scene(arguments.scene, allow_outside=arguments.allow_outside)
    learner = guide_maps.Learner(
        scene,
        restirpg.load_graph(arguments.graph).description,
        arguments.pixel,
        arguments.size,
        cell_size=arguments.cell_size,
        raw=arguments.raw,
    )
    points, samples, mixtures = learner.run(arguments.frames)
    lines, maps, random = [], [], np.random.default_rng(1)
    products = guide_maps.products_at(points, scene, learner.bounces)
    for pixel, point, product, mine, mixture in zip(arguments.pixel, points, products, samples, mixtures):
        for frames, count, effective, histogram in guide_maps.histograms(mine, point):
            row = (frames, count, effective, *guide_maps.score(histogram, effective, product, random))
            lines.append("| {} {} | {} | {} | {:.0f} | {:.3f} | {:.3f} | {:.1f} |".format(*pixel, *row))
        directions = point.histogram(np.concatenate([d for d, _ in mine]), np.concatenate([w for _, w in mine]))
        lobes = guide_maps.lobes_in(mixture, point) if mixture else None
        maps.append((f"pixel {pixel[0]} {pixel[1]}", (product, directions, lobes)))
    head = [
        "| pixel | frames | samples | effective | KL | KL by chance | chi-square / dof |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    print("\n".join(head + lines))
    if arguments.markdown:
        files.write(arguments.markdown, "\n".join(head + lines) + "\n")
    picture = io.BytesIO()
    guide_maps.draw(maps, ("L_i cos", "directions", "fitted lobes")).savefig(picture, format="png", dpi=90)
    files.write(arguments.o, picture.getvalue())
    return 0


def main(arguments):
    """The command line. Returns the exit code."""
    arguments = parse(arguments)

    def body(_):
        render.find_package()
        for file, option in ((arguments.o, "-o"), (arguments.markdown, "--markdown")):
            if file:
                files.prepare(file, [arguments.scene, arguments.graph], option)
        with render.refusals():
            return see(arguments)

    return program.run("see_guide.py", body)
