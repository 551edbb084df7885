"""The paper's comparison at the paper's size: four methods and ReSTIR PG+, single frames 11 to 20 of 1920x1080.

    scripts/reproduce.py --paper-size SCENE[@WxH]... [--list] [--out out/paper_size] [options of scripts/compare.py]
    scripts/reproduce.py --paper-size --collect out/paper_size [--results FOLDER]

The first line is scripts/compare.py with the options below on each scene in turn. The reference is rendered, and errors
are measured, in random tiles alone. Finished runs are kept in OUT/cache, one a (scene, method, seed), each under a
checksum: the same command goes on where it was interrupted, and another number of --reference-frames takes no run
again. --scheduler spreads the runs over machines, as for scripts/compare.py. --list says how many hours each scene
takes. The second line writes summary.csv and tables.md from all scenes that are finished. Exit code: as
scripts/compare.py.
"""

import argparse
import csv
import io
from pathlib import Path

import restirpg
from restirpg.harness import UserError, compare, files, program, render

GRAPHS = ("restir_pt", "restir_pg", "raw_pt_ruppert2020", "raw_pt_derevyannykh2022", "restir_pg_plus")
FIRST, OURS, RUPPERT = GRAPHS[0], GRAPHS[1], GRAPHS[2]
FRAMES, TILES, TILE_SIDE, REFERENCE_FRAMES = 20, 64, 24, 1024
SIZE = "1920x1080"
#: Microseconds per pixel and frame on two cores: of veach_ajar on the fastest machine seen, of living_room on the slowest.
COSTS = (10.0, 28.0)


def graph_file(name):
    """Of the graphs that come with the package."""
    return str(restirpg.GRAPHS / f"{name}.py")


def scene_at_size(text):
    """`SCENE[@WxH]`: the file and `WxH`."""
    scene, _, size = text.partition("@")
    program.size(size or SIZE)
    return scene, size or SIZE


def fixed_options():
    """Of scripts/compare.py."""
    return [
        "--at", ",".join(map(str, range(FRAMES // 2 + 1, FRAMES + 1))), "--tiles", str(TILES), "--seeds", "1",
        # At equal time its frames have half the variance of path tracing's; it shares no seed with the methods.
        "--reference-graph", graph_file(OURS), "--reference-frames", str(REFERENCE_FRAMES), "--reference-batches", "16",
    ]  # fmt: skip


def parse(arguments):
    """The command line, and what of it compare.py is given."""
    parser = argparse.ArgumentParser(
        prog="reproduce.py --paper-size", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "scenes", nargs="*", type=scene_at_size, metavar="SCENE[@WxH]", help=f"scene files; pixels ({SIZE})"
    )
    parser.add_argument("--list", action="store_true", help="say about how many hours each scene takes, and end")
    parser.add_argument("--out", default="out/paper_size", help="folder of runs and reports (%(default)s)")
    parser.add_argument("--device", metavar="NAME", help="what renders the methods (the best device)")
    parser.add_argument("--collect", metavar="FOLDER", help="write the table of what is finished there")
    parser.add_argument("--results", metavar="FOLDER", help="where --collect writes (the folder that it reads)")
    return parser.parse_known_args(arguments)


def refuse_one_folder_for_two(scenes):
    """Raise UserError where two scenes' reports would lie in one folder."""
    names = [Path(scene).stem for scene, _ in scenes]
    for name in names:
        if names.count(name) > 1:
            raise UserError(
                f"two scenes would be called '{name}', whose reports lie in one folder; "
                "ask for them one after the other, each with an --out of its own"
            )


def record(options, further):
    """Compare on each scene; returns the largest exit code, at once where a mistake or a signal ended one."""
    worst = 0
    for scene, size in options.scenes:
        out = Path(options.out)
        device = f",device={options.device}" if options.device else ""
        graphs = [f"{graph_file(name)}@label={name}{device}" for name in GRAPHS]
        own = [
            "--scenes",
            scene,
            "--size",
            size,
            "--out",
            str(out / Path(scene).stem),
            "--cache",
            str(out / "cache"),
        ]
        code = compare.main([*graphs, *own, *fixed_options(), *further])
        worst = max(worst, code)
        if code > 1:
            break
    return worst


def read_rows(folder):
    """The rows of every scene's tiles.csv, with the scene's name in place of its file."""
    rows = []
    for file in sorted(Path(folder).glob("*/tiles.csv")):
        with open(file, newline="") as stream:
            rows += [{**row, "scene": Path(row["scene"]).stem} for row in csv.DictReader(stream)]
    if not rows:
        raise UserError(f"{folder}: no scene is finished there; each has a tiles.csv in a folder of its own")
    return rows


def by_scene(rows):
    """{scene: {method: row}} in the order of the rows."""
    scenes = {}
    for row in rows:
        scenes.setdefault(row["scene"], {})[row["method"]] = row
    return scenes


def sentence(scene, methods):
    """What was found in a scene, in plain words."""
    error = {name: float(row["mape"]) for name, row in methods.items()}
    best = min(error, key=error.get)
    text = f"{scene}: the lowest mean error has {best}, {100 * error[best]:.1f}%"
    if OURS in error and best != OURS:
        text += f"; {OURS} does not have the lowest: {100 * error[OURS]:.1f}%"
    for name, row in methods.items():
        p = float(row["p"])
        if name != FIRST and p == p:
            change = 100 * float(row["change"])
            text += f"; {name} errs {abs(change):.1f}% {'less' if change < 0 else 'more'} than {FIRST}"
            text += "" if p < 0.01 else ", which is not significant"
    return text + "."


def as_markdown(scenes):
    """The table of all scenes, and a sentence each."""
    lines = [
        "| scene | method | MAPE ± by tiles ± by the reference | change from restir_pt ± by tiles ± by the reference | p | GPU s a frame |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for scene, methods in scenes.items():
        for name, row in methods.items():
            value = {key: float(text) for key, text in row.items() if key not in ("scene", "method")}
            error = " ± ".join(f"{100 * value[key]:.2f}" for key in ("mape", "mape_se", "mape_reference_se"))
            change = " ± ".join(f"{100 * value[key]:.2f}" for key in ("change", "change_se", "change_reference_se"))
            tested = name != FIRST
            cells = [
                scene,
                name,
                f"{error}%",
                f"{change}%" if tested else "",
                f"{value['p']:.1g}" if tested else "",
                f"{value['gpu_ms'] / 1e3:.1f}",
            ]
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join([*lines, "", *(f"- {sentence(scene, methods)}" for scene, methods in scenes.items())]) + "\n"


def collect(folder, results):
    """Write summary.csv and tables.md."""
    rows = read_rows(folder)
    results = Path(results)
    files.make_folder(results, "--results")
    stream = io.StringIO(newline="")
    writer = csv.DictWriter(stream, list(rows[0]))
    writer.writeheader()
    writer.writerows(rows)
    files.write(results / "summary.csv", stream.getvalue())
    files.write(results / "tables.md", as_markdown(by_scene(rows)))
    print(f"{results}: summary.csv and tables.md of {len(by_scene(rows))} scenes")
    return 0


def print_list(scenes):
    """About how long each scene takes on two cores."""
    for scene, size in scenes:
        width, height = program.size(size)
        methods = len(GRAPHS) * FRAMES * width * height
        reference = REFERENCE_FRAMES * TILES * TILE_SIDE**2
        low, high = (1e-6 * cost * (methods + reference) / 3600 for cost in COSTS)
        print(
            f"{Path(scene).stem:24} {width}x{height}  {low:.1f} to {high:.1f} hours, {len(GRAPHS)} methods, {FRAMES} frames"
        )
    return 0


def main(arguments):
    """The command line. Returns the exit code."""
    options, further = parse(arguments)

    def body(_):
        render.find_package()
        if options.collect:
            return collect(options.collect, options.results or options.collect)
        if not options.scenes:
            raise UserError("no scene given; name one or more, as in scripts/reproduce.py --paper-size veach_ajar.glb")
        if options.list:
            return print_list(options.scenes)
        refuse_one_folder_for_two(options.scenes)
        return 0

    code = program.run("reproduce.py", body)
    return code if code or options.collect or options.list else record(options, further)
