#!/usr/bin/python3
"""Compare the path tracer with Mitsuba 3: block means of independent runs, tested for equality.

    compare_with_mitsuba.py SCENE.glb ... --mitsuba-python VENV/bin/python [--materials gltf|diffuse|converter]
                            [--size 64x64] [--bounces 8]

Null hypothesis: both render the same expected image. R independent runs a renderer give the mean of every block of
pixels with its variance; Welch's t a block and channel, Bonferroni over all of them at 1%. Prints one table row a
scene and, where they are not found equal, writes the map of p-values and both images to --out. Exit code 1 when one
is not equal.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import requirements
from clone import ROOT
from gltf_edits import environment_for_mitsuba, environment_of, environment_settings, make_diffuse, read_glb, write_glb
from scipy import stats

from restirpg.harness import UserError, program
from restirpg.harness.render import find_package, refusals
from restirpg.harness.statistics import LEVEL, Test, block_means, welch

#: Of the image means. 64 runs of 64 samples tell about as much in the Cornell boxes of results/mitsuba (0.34% and 0.26%
#: would have been found): with a smaller limit most scenes would stay undecided.
LARGEST_RATIO_ERROR = 0.003
HEADER = (
    "| scene | cap | runs x samples, ours | Mitsuba | image mean, ours / Mitsuba | blocks x channels "
    "| smallest p x tests | smallest bias found, image | median block | verdict |\n" + "| --- " * 10 + "|"
)


@dataclass(frozen=True)
class Comparison:
    """What the runs of both renderers, float (R, H, W, 3), say about one scene."""

    ratio: float  # of the image means
    ratio_se: float
    detectable_image: float  # smallest relative bias of the image mean that would be found
    p: np.ndarray  # a block and channel, before correction
    detectable_block: float  # median over blocks of the smallest relative bias that would be found

    @property
    def corrected_p(self):
        """NaN where a block could not be tested."""
        return float(np.minimum(self.p.min() * self.p.size, 1.0))

    @property
    def verdict(self):
        """Are they "equal" or "DIFFERENT"? "undecided": the means may be too far apart, but their error is too large to
        say so; or there was no test.
        """
        off = abs(self.ratio - 1)
        if self.corrected_p < LEVEL or off - 3 * self.ratio_se > LARGEST_RATIO_ERROR:
            return "DIFFERENT"
        near = off + 2 * self.ratio_se < LARGEST_RATIO_ERROR
        return "equal" if near and self.corrected_p >= LEVEL else "undecided"


def compare(ours, theirs, block):
    """Test two sets of independent runs, (R, H, W, 3), for one expected image."""
    mean_ours, mean_theirs = ours.mean(axis=(1, 2, 3), dtype=float), theirs.mean(axis=(1, 2, 3), dtype=float)
    image = welch(mean_ours, mean_theirs)
    scale = mean_theirs.mean()
    blocks_ours, blocks_theirs = (
        np.moveaxis(block_means(np.moveaxis(runs, -1, 1), block), 1, -1) for runs in (ours, theirs)
    )
    p = stats.ttest_ind(blocks_ours, blocks_theirs, equal_var=False).pvalue
    level = np.maximum(blocks_theirs.mean(axis=0), 1e-3 * scale)
    variance = blocks_ours.var(axis=0, ddof=1) / len(ours) + blocks_theirs.var(axis=0, ddof=1) / len(theirs)
    same = (variance == 0) & (blocks_ours.mean(axis=0) == blocks_theirs.mean(axis=0))  # as black ones are
    p = np.where(same, 1.0, p)
    typical = Test(0.0, float(np.median(np.sqrt(variance) / level)), len(ours) + len(theirs) - 2, 1.0)
    return Comparison(
        float(mean_ours.mean() / scale),
        float(image.se / scale),
        float(image.smallest_detectable() / scale),
        p,
        typical.smallest_detectable(p.size),
    )


def render_ours(scene_file, environment, options):
    """Independent runs of the path tracer, (R, H, W, 3): stretches of frames, each of which draws fresh numbers."""
    import restirpg

    renderer = restirpg.Renderer(
        restirpg.load_scene(scene_file, environment=environment),
        restirpg.load_graph(ROOT / "graphs" / "path_tracer.py"),
        size=options.size,
        seed=options.seed,
        backend=options.backend,
        bounces=options.bounces,
    )
    sums = [np.zeros((*options.size[::-1], 3))]
    for run in range(1, options.runs + 1):
        renderer.render(options.frames)
        sums.append(renderer.output("image").astype(float) * run)
    return np.diff(sums, axis=0)


def render_mitsuba(scene_file, environment, folder, options):
    """Independent runs of Mitsuba, (R, H, W, 3). The bounce cap n is its max_depth n + 2."""
    import restirpg

    light = []
    if environment and Path(environment).is_file():
        radiance = environment_for_mitsuba(read_environment(environment))
        restirpg.write_exr(folder / "mitsuba.exr", {"": radiance})
        light = ["--envmap", str(folder / "mitsuba.exr")]
    elif environment:
        light = ["--env", environment]
    size = "x".join(map(str, options.size))
    command = [
        options.mitsuba_python,
        Path(__file__).with_name("mitsuba_runs.py"),
        options.converter,
        options.mitsuba_runs,
        folder / "runs.npy",
        "converter" if options.materials == "diffuse" else options.materials,
        scene_file,
        "--spp",
        options.samples,
        "--depth",
        options.bounces + 2,
        "--res",
        size,
        "--variant",
        options.variant,
        "--seed",
        1000 * options.seed,
        *light,
    ]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, env={**os.environ, "PYTHONPATH": ""})
    if done.returncode != 0:
        sys.stderr.write(done.stderr)
        raise UserError(f"{scene_file.name}: Mitsuba failed on it, as it says above")
    return np.load(folder / "runs.npy")


def read_environment(path):
    """An .exr or .hdr environment as float (H, W, 3). Raises UserError."""
    import restirpg

    if Path(path).suffix.lower() == ".exr":
        return restirpg.read_exr(path)
    try:
        return decode_radiance(Path(path).read_bytes())
    except (ValueError, IndexError):
        raise UserError(
            f"{path}: read for Mitsuba are Radiance files of run-length coded RGBE rows from the top, without EXPOSURE, "
            "COLORCORR or PRIMARIES; write it as one, or as .exr"
        ) from None


def decode_radiance(data):
    """A Radiance file of the plainest kind, bytes, as float (H, W, 3); raises ValueError or IndexError."""
    header, _, rest = data.partition(b"\n\n")
    size, _, body = rest.partition(b"\n")
    edges = re.fullmatch(rb"-Y (\d+) \+X (\d+)", size)
    changed = any(line.startswith((b"EXPOSURE", b"COLORCORR", b"PRIMARIES")) for line in header.split(b"\n"))
    if not header.startswith(b"#?") or b"FORMAT=32-bit_rle_rgbe" not in header or changed or not edges:
        raise ValueError
    return decode_rgbe(body, *map(int, edges.groups()))


def decode_rgbe(body, height, width):
    """Run-length coded Radiance scanlines (Ward 1991) to float (H, W, 3); raises ValueError or IndexError."""
    data, at = np.frombuffer(body, np.uint8), 0
    image = np.empty((height, 4, width), np.uint8)
    for row in image:
        if bytes(data[at : at + 4]) != bytes((2, 2, width >> 8 & 255, width & 255)):
            raise ValueError
        at += 4
        for channel in row:
            at = decode_channel(data, at, channel)
    mantissa, exponent = image[:, :3].transpose(0, 2, 1).astype(float), image[:, 3].astype(int)
    return np.where(exponent[..., None] > 0, np.ldexp(mantissa, exponent[..., None] - 136), 0.0)


def decode_channel(data, at, channel):
    """Fill one channel of a scanline from the place `at`; returns the place behind it."""
    x = 0
    while x < len(channel):
        count = int(data[at])
        run = count > 128
        count -= 128 * run
        if not 0 < count <= len(channel) - x:
            raise ValueError
        channel[x : x + count] = data[at + 1] if run else data[at + 1 : at + 1 + count]
        at, x = at + 1 + (1 if run else count), x + count
    return at


def write_failure(name, folder, ours, theirs, result):
    """Both images and the map of p-values (smallest over channels) as PNG."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    folder.mkdir(parents=True, exist_ok=True)
    figure, axes = pyplot.subplots(1, 3, figsize=(15, 5))
    for axis, image, title in zip(axes, (ours.mean(axis=0), theirs.mean(axis=0)), ("ours", "Mitsuba")):
        axis.imshow(np.clip(image / (4 * theirs.mean()), 0, 1) ** (1 / 2.2))
        axis.set_title(title)
    shown = axes[2].imshow(np.log10(np.maximum(result.p.min(axis=2), 1e-12)), cmap="inferno", vmin=-12, vmax=0)
    axes[2].set_title("log10 p of a block")
    figure.colorbar(shown, ax=axes[2])
    figure.savefig(folder / f"{name}.png", dpi=80)
    pyplot.close(figure)


def check_scenes(options):
    """Raise UserError where a scene is none, or has light that Mitsuba would not get."""
    for path in options.scenes:
        own = environment_settings(read_glb(path)[0])
        changed = [name for name, usual in (("strength", 1), ("rotation", 0)) if own.get(name, usual) != usual]
        if changed and "environment" in own and not options.environment:
            raise UserError(
                f"{path}: Mitsuba would not get the {' and '.join(changed)} of its environment; put it into the image, and "
                "give that in --environment"
            )


def prepare(path, folder, options):
    """A copy in `folder` of the scene for both renderers, and its environment: a file, "r,g,b" or None."""
    document, binary = read_glb(path)
    environment = options.environment or environment_of(document)
    if isinstance(environment, list):
        environment = ",".join(map(str, environment))
    elif environment and not options.environment:
        environment = str(path.parent / environment)
    document.get("asset", {}).get("extras", {}).pop("restirpg", None)  # names a file that is not in `folder`
    document = make_diffuse(document) if options.materials == "diffuse" else document
    return write_glb(folder / path.name, document, binary), environment


def run_scene(path, options):
    """Render and test one scene; prints its row of the table and returns whether it passed."""
    name = path.stem + {"gltf": "", "diffuse": "_made_diffuse", "converter": "_converted"}[options.materials]
    with tempfile.TemporaryDirectory(prefix="mitsuba-") as temporary:
        folder = Path(temporary)
        scene_file, environment = prepare(path, folder, options)
        ours = render_ours(scene_file, environment, options)
        theirs = render_mitsuba(scene_file, environment, folder, options)
    result = compare(ours, theirs, options.block)
    row = (
        name,
        options.bounces,
        f"{options.runs} x {options.frames}",
        f"{options.mitsuba_runs} x {options.samples}",
        f"{result.ratio:.5f} +- {result.ratio_se:.5f}",
        result.p.size,
        f"{result.corrected_p:.2g}",
        f"{result.detectable_image:.2%}",
        f"{result.detectable_block:.1%}",
        result.verdict,
    )
    print("|", " | ".join(map(str, row)), "|", flush=True)
    if result.verdict != "equal":
        write_failure(name, options.out, ours, theirs, result)
    return result.verdict == "equal"


def parse_arguments():
    """The command line, with sizes as integers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=Path)
    requirements.add_options(parser, required=True)
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba; LLVM's needs DRJIT_LIBLLVM_PATH")
    parser.add_argument(
        "--materials",
        choices=("gltf", "diffuse", "converter"),
        default="gltf",
        help="gltf: the file's, by gltf_bsdf.py; diffuse: every one rewritten as exactly Lambert and opaque, "
        "without vertex normals; converter: what gltf_to_mitsuba.py takes for them, `principled` for most",
    )
    parser.add_argument("--environment", help="r,g,b or an .exr or .hdr file; default: what the scene names")
    parser.add_argument("--backend", help="software or rayquery")
    parser.add_argument("--size", type=program.size, default=(64, 64))
    parser.add_argument("--block", type=program.positive, default=8, help="edge of a block in pixels; divides the size")
    parser.add_argument("--bounces", type=program.bounces, default=8)
    parser.add_argument("--seed", type=program.whole(0), default=1, help="another one repeats a test on fresh numbers")
    parser.add_argument("--runs", type=program.whole(2), default=64)
    parser.add_argument("--frames", type=program.positive, default=16, help="samples a pixel of each of our runs")
    parser.add_argument("--mitsuba-runs", type=program.whole(2), default=64)
    parser.add_argument(
        "--samples", type=program.positive, default=16, help="samples a pixel of each of Mitsuba's runs"
    )
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "mitsuba", help="folder of pictures of failures")
    options = parser.parse_args()
    if any(edge % options.block for edge in options.size):
        parser.error(f"--block {options.block} does not divide --size")
    return options


def main():
    """Compare every scene. Returns the exit code: 0 when all are equal."""
    options = parse_arguments()

    def body(_):
        find_package()
        check_scenes(options)  # before anything long starts
        requirements.check(options)
        print(HEADER)
        with refusals():
            return 0 if all([run_scene(path, options) for path in options.scenes]) else 1  # noqa: C419  (every one is run)

    return program.run("compare_with_mitsuba.py", body)


if __name__ == "__main__":
    sys.exit(main())
