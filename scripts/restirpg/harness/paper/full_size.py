"""The paper's comparison at the paper's size: four methods and ReSTIR PG+, single frames 11 to 20 of 1920x1080.

    scripts/reproduce.py --paper-size SCENE[@WxH]... [--list] [--out out/paper_size] [options of scripts/compare.py]
    scripts/reproduce.py --paper-size --collect out/paper_size [--results FOLDER]

The first line is scripts/compare.py with the graphs and defaults below on each scene in turn. The reference is rendered, and errors
are measured, in random tiles alone. Finished runs are kept in OUT/cache, one a (scene, method, seed), each under a
checksum: the same command goes on where it was interrupted, and another number of --reference-frames takes no run
again. --scheduler spreads the runs over machines, as for scripts/compare.py. --list says how many hours each scene
takes. The second line writes, from all scenes that are finished, summary.csv, tables.md and tile_errors.csv: each
method's errors in each tile, the mean over the measured frames (relMSE less the reference's noise). Exit code: as
scripts/compare.py.
"""

import argparse
import csv
import io
import math
import statistics
from pathlib import Path

import restirpg
from restirpg import commands
from restirpg.harness import UserError, compare, files, program, render

GRAPHS = ("restir_pt", "restir_pg", "raw_pt_ruppert2020", "raw_pt_derevyannykh2022", "restir_pg_plus")
FIRST, OURS, RUPPERT = GRAPHS[0], GRAPHS[1], GRAPHS[2]
FRAMES = 20
#: Microseconds per pixel and frame on two cores: of veach_ajar on the fastest machine seen, of living_room on the slowest.
COSTS = (10.0, 28.0)


def graph_file(name):
    """Of the graphs that come with the package."""
    return str(restirpg.GRAPHS / f"{name}.py")


def scene_at_size(text):
    """`SCENE[@WxH]`: the file and (W, H), or None."""
    scene, _, size = text.partition("@")
    return scene, program.size(size) if size else None


#: Of scripts/compare.py, written as on its command line.
DEFAULTS = {
    "size": "1920x1080",
    "at": ",".join(map(str, range(FRAMES // 2 + 1, FRAMES + 1))),
    "tiles": 64,
    "seeds": 1,
    # At equal time its frames have half the variance of path tracing's; it shares no seed with the methods.
    "reference_graph": graph_file(OURS),
    "reference_frames": 1024,
    "reference_batches": 16,
    "out": "out/paper_size",
    "self_test": False,
    "trials": 60,
}


def parse(arguments):
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="reproduce.py --paper-size", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "scenes", nargs="*", type=scene_at_size, metavar="SCENE[@WxH]", help="scene files; pixels (those of --size)"
    )
    parser.add_argument("--list", action="store_true", help="say about how many hours each scene takes, and end")
    parser.add_argument("--device", metavar="NAME", help="what renders the methods (the best device)")
    parser.add_argument("--collect", metavar="FOLDER", help="write the table of what is finished there")
    parser.add_argument("--results", metavar="FOLDER", help="where --collect writes (the folder that it reads)")
    compare.add_options(parser, **DEFAULTS)
    return commands.parsed(parser, arguments)


def check(options):
    """Raise UserError where a scene is not there, or the command line has what would change nothing."""
    if options.collect:
        if options.scenes or options.list:
            raise UserError("--collect reads what is finished; leave out --list and the scenes")
        return
    if options.results:
        raise UserError("--results is where --collect writes; add --collect, or leave it out")
    if not options.scenes:
        raise UserError("no scene given; name one or more, as in scripts/reproduce.py --paper-size veach_ajar.glb")
    for scene, _ in options.scenes:
        if not Path(scene).is_file():
            raise UserError(f"{scene}: no such scene; scripts/make_scenes.py writes the embedded ones to out/scenes")
    if not options.list:
        refuse_one_folder_for_two(options.scenes)


def refuse_one_folder_for_two(scenes):
    """Raise UserError where two scenes' reports would lie in one folder."""
    names = [Path(scene).stem for scene, _ in scenes]
    for name in names:
        if names.count(name) > 1:
            raise UserError(
                f"two scenes would be called '{name}', whose reports lie in one folder; "
                "ask for them one after the other, each with an --out of its own"
            )


def record(options):
    """Compare on each scene; returns the largest exit code, at once where a mistake or a signal ended one."""
    worst = 0
    for scene, size in options.scenes:
        out = Path(options.out)
        device = f",device={options.device}" if options.device else ""
        graphs = [f"{graph_file(name)}@label={name}{device}" for name in GRAPHS]
        own = {
            "methods": graphs,
            "scenes": [scene],
            "size": size or options.size,
            "out": str(out / Path(scene).stem),
            "cache": options.cache or str(out / "cache"),
        }
        code = compare.run(argparse.Namespace(**{**vars(options), **own}), "reproduce.py", parse([]))
        worst = max(worst, code)
        if code > 1:
            break
    return worst


#: Columns of a tiles.csv as they were called before, and as they are.
RENAMED = {"gpu_ms": "gpu_ms_per_frame", "wall_ms": "wall_ms_per_frame"}


def read_rows(folder):
    """The rows of every scene's tiles.csv, older ones too, with the scene's name in place of its file."""
    rows = []
    for file in sorted(Path(folder).glob("*/tiles.csv")):
        with open(file, newline="") as stream:
            rows += [
                {RENAMED.get(name, name): value for name, value in {**row, "scene": Path(row["scene"]).stem}.items()}
                for row in csv.DictReader(stream)
            ]
    if not rows:
        raise UserError(f"{folder}: no scene is finished there; each has a tiles.csv in a folder of its own")
    return rows


def tile_errors(folder):
    """{(scene, method, tile): (MAPE, relMSE)} of every finished scene, the mean over the measured frames."""
    found = {}
    for file in sorted(Path(folder).glob("*/tiles.csv")):
        runs = file.with_name("runs.csv")
        if not runs.is_file():
            raise UserError(f"{runs}: the errors of the tiles are missing; run the scene's command again")
        with open(runs, newline="") as stream:
            for row in csv.DictReader(stream):
                key = Path(row["scene"]).stem, row["method"], int(row["tile"])
                found.setdefault(key, []).append((float(row["mape_single"]), float(row["relmse"])))
    return {key: tuple(statistics.fmean(column) for column in zip(*errors)) for key, errors in found.items()}


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
        "| scene | method | MAPE ± by tiles ± by the reference | change from restir_pt ± by tiles ± by the reference | p | GPU s/frame |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for scene, methods in scenes.items():
        for name, row in methods.items():
            value = {key: float(text) for key, text in row.items() if key not in ("scene", "method")}
            error = _with_errors(value, "mape", "mape_se", "mape_reference_se")
            change = _with_errors(value, "change", "change_se", "change_reference_se")
            tested = name != FIRST
            cells = [
                scene,
                name,
                error,
                change if tested else "",
                f"{value['p']:.1g}" if tested else "",
                f"{value['gpu_ms_per_frame'] / 1e3:.1f}",
            ]
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join([*lines, "", *(f"- {sentence(scene, methods)}" for scene, methods in scenes.items())]) + "\n"


def _with_errors(value, *names):
    """A number and its standard errors in percent; "—" where one is not known."""
    return " ± ".join("—" if math.isnan(value[name]) else f"{100 * value[name]:.2f}" for name in names) + "%"


def as_csv(rows):
    """The text of a CSV file of rows, each {column: value}."""
    stream = io.StringIO(newline="")
    writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()


def collect(folder, results):
    """Write summary.csv, tables.md and tile_errors.csv."""
    rows = read_rows(folder)
    errors = [
        {"scene": scene, "method": method, "tile": tile, "mape": f"{mape:.9g}", "relmse": f"{relmse:.9g}"}
        for (scene, method, tile), (mape, relmse) in tile_errors(folder).items()
    ]
    results = Path(results)
    files.make_folder(results, "--results")
    files.write(results / "summary.csv", as_csv(rows))
    files.write(results / "tables.md", as_markdown(by_scene(rows)))
    files.write(results / "tile_errors.csv", as_csv(errors))
    print(f"{results}: summary.csv, tables.md and tile_errors.csv of {len(by_scene(rows))} scenes")
    return 0


def print_list(options):
    """About how long each scene takes on two cores."""
    frames = options.at[-1]
    views = len(options.at) if options.circle or options.fps else 1
    reference = views * options.reference_frames * options.tiles * options.tile_size**2
    for scene, size in options.scenes:
        width, height = size or options.size
        methods = len(GRAPHS) * options.seeds * frames * width * height
        low, high = (1e-6 * cost * (methods + reference) / 3600 for cost in COSTS)
        seeds = f", {options.seeds} seeds" if options.seeds > 1 else ""
        print(
            f"{Path(scene).stem:24} {width}x{height}  {low:.1f} to {high:.1f} hours, {len(GRAPHS)} methods, "
            f"{frames} frames{seeds}"
        )
    return 0


def main(arguments):
    """The command line. Returns the exit code."""
    options = parse(arguments)

    def body(_):
        render.find_package()
        check(options)
        if options.collect:
            return collect(options.collect, options.results or options.collect)
        return print_list(options) if options.list else 0

    code = program.run("reproduce.py", body)
    return code if code or options.collect or options.list else record(options)
