#!/usr/bin/python3
"""How many samples a cell of the guiding grid gets in a frame, from the paths that ReSTIR PT selected and
from its raw candidates.

    PYTHONPATH=build/python benchmarks/guiding/samples_per_cell.py [--scene NAME|FILE ...] [--size 160x90]
        [--markdown FILE]

A sample is a smooth bounce of a path that carries light. Candidates are unguided here (alpha = 1), so that
both columns see the same frames. The paper's Table 1 does not say what it averages over; three averages are
given: over the cells that the method touched, over those that either did, and weighted by the samples
themselves (what a sample sees), sum n^2 / sum n. [Zeng et al. 2025, table 1]
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import numpy as np  # noqa: E402
import restirpg  # noqa: E402
from harness.guiding import SUMS, VALID, VERTEX, grid_of, read_table  # noqa: E402

SCENES = ["door_ajar", "door_ajar_diffuse", "bidirectional_room", "living_room", "temple"]
PORTS = {"ReSTIR": "reuse.vertices", "raw": "paths.vertices"}
FIRST, LAST = 8, 12  # frames that are counted: reuse has settled


def counts_of(renderer, port):
    """{key: samples} of the last frame."""
    grid = grid_of(read_table(renderer.read_port("splat.statistics"), SUMS)[0])
    v = renderer.read_port(port).view(VERTEX)
    v = v[v["surface"] & VALID != 0]
    keys = grid.keys(grid.positions(v["position"]), v["surface"] >> 16 & 7, v["surface"] & 0xFFFF)[0]
    return dict(zip(*np.unique(keys, return_counts=True)))


def averages(mine, other):
    """Means over the cells of `mine`, over those of both, and weighted by the samples."""
    n = np.array(list(mine.values()), float)
    return n.mean(), n.sum() / len(mine.keys() | other.keys()), (n**2).sum() / n.sum()


def measure(scene, size):
    """One row: {method: averages}, means over the counted frames; and the last frame's numbers of cells."""
    renderer = restirpg.Renderer(
        scene, restirpg.load_graph(ROOT / "graphs" / "restir_pg.py"), size=size, seed=1
    )
    renderer.set("paths.alpha", 1.0)
    renderer.render(FIRST - 1)
    rows = []
    for _ in range(FIRST, LAST + 1):
        renderer.render(1)
        counts = {method: counts_of(renderer, port) for method, port in PORTS.items()}
        rows.append([averages(counts["ReSTIR"], counts["raw"]), averages(counts["raw"], counts["ReSTIR"])])
    return np.mean(rows, 0), len(counts["ReSTIR"]), len(counts["raw"])


def load(name, folder):
    if Path(name).is_file():
        return restirpg.load_scene(name)
    subprocess.run(
        [sys.executable, ROOT / "scripts" / "make_scenes.py", name, "--out", folder],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return restirpg.load_scene(Path(folder) / f"{name}.glb")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scene", nargs="+", default=SCENES)
    parser.add_argument("--size", type=lambda text: tuple(map(int, text.split("x"))), default=(160, 90))
    parser.add_argument("--markdown", type=Path)
    arguments = parser.parse_args()
    lines = [
        "| scene | cells, ReSTIR / raw | own cells | cells of either | sample-weighted |",
        "| --- | --- | --- | --- | --- |",
    ]
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.scene:
            (restir, raw), cells, raw_cells = measure(load(name, folder), arguments.size)
            pairs = " | ".join(f"{a:.2f} / {b:.2f} ({a / b:.1f})" for a, b in zip(restir, raw))
            lines.append(f"| {Path(name).stem} | {cells} / {raw_cells} | {pairs} |")
            print(lines[-1], flush=True)
    if arguments.markdown:
        arguments.markdown.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
