#!/usr/bin/python3
"""How many samples a cell of the guiding grid gets in a frame, from the paths that ReSTIR PT selected and
from its raw candidates.

    PYTHONPATH=build/python benchmarks/guiding/samples_per_cell.py [--scene NAME|FILE ...] [--size 160x90]
        [--bounces N] [--markdown FILE]

A sample is a smooth bounce of a path that carries light. Candidates are unguided here (alpha = 1), so that
both columns see the same frames. The paper's Table 1 does not say what it averages over; three averages are
given: over the cells that the method touched, over those that either did, and weighted by the samples
themselves (what a sample sees), sum n^2 / sum n. [Zeng et al. 2025, table 1]
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

from restirpg.harness import cell_counts, files, program, render, scenes

ROOT = Path(__file__).resolve().parents[2]

SCENES = ["door_ajar", "door_ajar_diffuse", "bidirectional_room", "living_room", "temple"]
GRAPH = str(ROOT / "graphs" / "restir_pg.py")


def parse():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", nargs="+", default=SCENES)
    parser.add_argument("--size", type=program.size, default=(160, 90))
    parser.add_argument("--bounces", type=program.bounces, help="bounce cap (the scene's, or the graph's own)")
    parser.add_argument("--markdown", type=Path)
    return parser.parse_args()


def count(arguments):
    """Print the table, and write it where that is asked for."""
    import restirpg

    if arguments.markdown:
        files.prepare(arguments.markdown, arguments.scene, "--markdown")
    lines = [
        "| scene | cells, ReSTIR / raw | own cells | cells of either | sample-weighted |",
        "| --- | --- | --- | --- | --- |",
    ]
    description = json.dumps(render.describe_graph(GRAPH))
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.scene:
            scene = restirpg.load_scene(scenes.file_of(name, folder))
            found = cell_counts.measure(scene, description, arguments.size, seeds=[1], bounces=arguments.bounces)
            (restir, raw), (cells, raw_cells) = found["averages"].mean((0, 1)), found["cells"][0, -1]
            pairs = " | ".join(f"{a:.2f} / {b:.2f} ({a / b:.1f})" for a, b in zip(restir, raw))
            lines.append(f"| {Path(name).stem} | {cells} / {raw_cells} | {pairs} |")
            print(lines[-1], flush=True)
    if arguments.markdown:
        files.write(arguments.markdown, "\n".join(lines) + "\n")


def main():
    """The command line. Returns the exit code."""
    arguments = parse()

    def body(_):
        render.find_package()
        with render.refusals():
            count(arguments)
        return 0

    return program.run("samples_per_cell.py", body)


if __name__ == "__main__":
    sys.exit(main())
