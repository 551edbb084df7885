"""The report: one HTML file that needs no network, and the pictures as EXR."""

import base64
import datetime
import difflib
import io
import json
import shlex
import subprocess
import sys
from pathlib import Path

import jinja2
import numpy as np

import restirpg
from restirpg.colour import luminance, relative_error
from restirpg.harness import files, given_reference, pictures, plots, render, tables
from restirpg.harness import statistics as st
from restirpg.harness.jobs import file_name
from restirpg.harness.mean_knobs import mean_of

from matplotlib import pyplot  # isort: skip  (plots has chosen the backend)

FOLDER = Path(__file__).resolve().parent
# Bytes of half floats in one report; single frames and means of seeds are left out first.
PICTURE_BUDGET = 96 << 20
KINDS = {
    "image": "picture (first seed)",
    "mean": "mean of all seeds",
    "frame": "last frame alone",
    "denoised": "last frame, denoised",
}


def _half(image):
    """A float image as base64 of half floats, row by row, three channels; clipped to what a half can hold."""
    halves = np.clip(np.nan_to_num(image, nan=0), -65504, 65504).astype("<f2")
    return base64.b64encode(halves.tobytes()).decode()


def _kinds_within_budget(findings):
    pixels = sum(method.images["image"].size * 2 for scene in findings for method in scene.methods)
    there = _kinds_there(findings)
    return [kind for number, kind in enumerate(there, 1) if number == 1 or number * pixels <= PICTURE_BUDGET]


def _kinds_there(findings):
    """The kinds of pictures that all methods have."""
    return [kind for kind in KINDS if all(kind in method.images for scene in findings for method in scene.methods)]


def _viewer_data(scene, kinds):
    """What viewer.js shows of a scene: see its head for the format."""
    truth = scene.reference["mean"].astype(float)
    y = luminance(truth)
    error = np.array([relative_error(method.images["image"], truth) for method in scene.methods])
    exposure = -float(np.log2(max(np.percentile(y, 90), 1e-6))) - 1
    pictures = [{"label": "reference", "image": _half(truth)}]
    pictures += [
        {"label": method.label, **{kind: _half(method.images[kind]) for kind in kinds}} for method in scene.methods
    ]
    return {
        "width": truth.shape[1],
        "height": truth.shape[0],
        "floor": 0.01 * float(y.mean()),
        "exposure": round(exposure, 1),
        "scale": max(float(np.percentile(np.nan_to_num(error), 98)), 1e-6),
        "pictures": pictures,
    }


def graph_lines(description):
    """A graph as lines of text: a pass and its type, then its wiring and its knobs."""
    lines = []
    for entry in description["passes"]:
        lines.append(f"{entry['name']}: {entry['type']}")
        for name, source in sorted(entry.get("inputs", {}).items()):
            wired = f"{source['pass']}.{source['output']}" if source else "nothing"
            lines.append(f"    {name} <- {f'prev({wired})' if source and source.get('delayed') else wired}")
        lines += [f"    {name} = {json.dumps(value)}" for name, value in sorted(entry.get("knobs", {}).items())]
    return lines + [f"output {entry['name']} <- {entry['pass']}.{entry['output']}" for entry in description["outputs"]]


def side_by_side(left, right):
    """Rows (left line, right line, differs) of two lists of lines; "" where a side has no such line."""
    rows = []
    for kind, a, b, c, d in difflib.SequenceMatcher(None, left, right, autojunk=False).get_opcodes():
        for offset in range(max(b - a, d - c)):
            rows.append(
                (
                    left[a + offset] if a + offset < b else "",
                    right[c + offset] if c + offset < d else "",
                    kind != "equal",
                )
            )
    return rows


def _graphs(scene):
    """[(baseline's label, method's label, rows)]; a single method beside itself."""
    labels = list(scene.descriptions)
    first = graph_lines(scene.descriptions[labels[0]])
    return [
        (labels[0], label, side_by_side(first, graph_lines(scene.descriptions[label])))
        for label in labels[1:] or labels
    ]


def _png(pixels):
    """sRGB pixels in [0, 1] as a data URI."""
    stream = io.BytesIO()
    pyplot.imsave(stream, pixels)
    return f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode()}"


def _crops(scene):
    """[(label, [two crops], error)] of the reference and of each method's last frame: where the methods differ most."""
    truth = scene.reference["mean"].astype(float)
    frames = {method.label: method.images["frame"] for method in scene.methods}
    corners, side = pictures.crops_of([relative_error(np.nan_to_num(frame), truth) for frame in frames.values()])
    exposure = pictures.exposure_of(truth)

    def cut(image):
        shown = pictures.displayable(image, exposure)
        return [_png(shown[y : y + side, x : x + side]) for x, y in corners]

    def error(method):
        values = st.mean_se(method.curves["mape"][:, -1] if scene.at else method.single)
        return f"MAPE {tables.with_error(*values, 100, '%')}"

    return [("reference", cut(truth), "")] + [
        (method.label, cut(frames[method.label]), error(method)) for method in scene.methods
    ]


def exr_names(scene):
    """{label: the name of its EXR} of the reference and each method."""
    stem = Path(scene.scene).stem
    return {label: f"{stem}.{file_name(label)}.exr" for label in ("reference", *(m.label for m in scene.methods))}


def commit():
    """The clone's commit, with "+ changes" when the working tree differs from it; that of the build for an installed
    package, which may lie in another project's repository."""

    def git(*arguments):
        try:
            run = subprocess.run(["git", "-C", str(render.ROOT), *arguments], capture_output=True, text=True)
        except OSError:  # git is not installed
            return ""
        return run.stdout.strip() if run.returncode == 0 else ""

    top = git("rev-parse", "--show-toplevel")
    name = git("rev-parse", "--short=12", "HEAD") if top and render.ROOT.samefile(top) else ""
    changes = " + changes" if name and git("status", "--porcelain", "--untracked-files=no") else ""
    return name + changes or restirpg.COMMIT


def provenance(program, code, devices):
    """[(name, value)] of what every report tells: how, when and from what it was made. `devices`: as probed."""
    names = sorted({", ".join(str(device[key]) for key in ("name", "driver", "backend")) for device in devices})
    return [
        ("command", shlex.join([program, *sys.argv[1:]])),
        ("written", datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ("commit", commit()),
        ("code hash", code),
        ("device", "; ".join(names)),
    ]


def _motion(settings):
    """[(name, value)] of what moved and which frames were measured."""
    motion, rows = settings.motion, []
    if settings.at:
        rows.append(("single frames measured", ", ".join(map(str, settings.at))))
    if motion:
        rows.append(
            ("motion", f"animation at {motion.fps:g} frames per second, camera on a circle of {motion.circle:g} m")
        )
    return rows


#: What the material model does with light that a rough surface scatters more than once.
ENERGY = {
    False: "single-scattering GGX, as in the code of the paper: the roughest white metal returns 0.40",
    True: "energy-compensated GGX (Kulla & Conty 2017): a white metal returns 1",
}


def _caps(settings, comparison):
    """[(name, value)] of the bounce cap that all runs have, or that those of each scene have."""
    if settings.bounces is not None:
        return [("bounce cap", str(settings.bounces))]
    rows = []
    for plan in comparison.plans:
        of_scene = plan.methods[0].bounces is not None
        means = {label: mean_of(own) for label, own in plan.knobs.items()}
        caps = {label: mean["bounces"] for label, mean in means.items() if "bounces" in mean}
        alike = len(set(caps.values())) == 1
        told = str(next(iter(caps.values()))) if alike else ", ".join(f"{label} {cap}" for label, cap in caps.items())
        whose = "the scene's own" if of_scene else "the graphs' own"
        rows.append((f"bounce cap of {plan.scene}", f"{told or 'none'} ({whose})"))
    return rows


def _provenance(settings, comparison, program):
    rows = provenance(program, comparison.code, comparison.device.values())
    rows += [
        (
            "size, frames, seeds",
            f"{settings.size[0]}x{settings.size[1]}, {settings.frames}, {settings.seeds}",
        ),
        *_motion(settings),
        ("seeds", ", ".join(map(str, comparison.seeds()))),
        ("rough surfaces", ENERGY[settings.energy_compensation]),
        *_caps(settings, comparison),
    ]
    rows += [
        (
            f"method {method.label}",
            " ".join([method.graph, *(f"{name}={value}" for name, value in method.knobs)]),
        )
        for method in settings.methods
    ]
    return rows + [(f"scene {plan.scene}", f"content {plan.methods[0].scene_hash}") for plan in comparison.plans]


def template(name):
    """A template of this folder; a name that it does not know is an error."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template(name)


def _encoded(charts):
    return [(title, base64.b64encode(svg.encode()).decode()) for title, svg in charts]


def scene_views(findings, family, folder=None):
    """What scene.html.j2 shows: (one dictionary per scene, what all scenes of the page share). family: over whose
    methods and scenes tests were corrected, in words. folder: of the EXR files, beside the page; None: there are none."""
    kinds = _kinds_within_budget(findings)
    scenes = [
        {
            "name": scene.scene,
            "findings": scene,
            "verdict": tables.verdict_sentence(scene),
            "crops": _crops(scene),
            "exr": exr_names(scene),
            "reference": tables.reference_line(scene),
            "tables": tables.all_tables(scene),
            "graphs": _graphs(scene),
            "charts": _encoded(plots.charts(scene)),
            "bars": _encoded(plots.bars(scene)),
            "data": json.dumps(_viewer_data(scene, kinds)).replace("<", "\\u003c"),
        }
        for scene in findings
    ]
    maps = {"error": plots.colour_map("inferno"), "signed": plots.colour_map("RdBu_r")}
    return scenes, {
        "family": family,
        "exr_folder": folder,
        "style": (FOLDER / "report.css").read_text(),
        "script": (FOLDER / "viewer.js").read_text(),
        "maps": json.dumps(maps),
        "kinds": {kind: KINDS[kind] for kind in kinds},
        "left_out": [KINDS[kind] for kind in _kinds_there(findings) if kind not in kinds],
        "significant": tables.is_significant,
        "level": 100 * st.LEVEL,
    }


def write(findings, settings, comparison, file, program):
    """Write the report of `findings` to `file`. program: which was called for it."""
    scenes, shared = scene_views(findings, "the report", "images")
    text = template("report.html.j2").render(
        title=", ".join(method.label for method in settings.methods),
        scenes=scenes,
        failures=comparison.failures,
        provenance=_provenance(settings, comparison, program),
        **shared,
    )
    files.write(file, text)


def write_pictures(findings, folder):
    """Write SCENE.METHOD.exr, references too: the first seed's picture; as layers the seeds' mean, the last frame
    alone, and that frame denoised where it was.

    Of tiles these are stacks; SCENE.METHOD.whole.exr is the first seed's last frame. Returns the names of the files.
    """
    files.make_folder(folder, "--out")
    written = []

    def write_exr(name, layers, origin, **attributes):
        texts = {key: json.dumps(value) for key, value in attributes.items()}
        render.write_exr(folder / name, layers, {**origin, **texts})
        written.append(name)

    for scene in findings:
        names = exr_names(scene)
        knobs = scene.reference["meta"]["knobs"]
        own = {**scene.origin, **({given_reference.KNOBS: json.dumps(knobs)} if knobs else {})}
        write_exr(names["reference"], {"": scene.reference["mean"]}, own, reference=scene.reference["meta"])
        for method in scene.methods:
            name, graph = names[method.label], scene.descriptions[method.label]
            layers = {kind: method.images[kind] for kind in ("mean", "frame", "denoised") if kind in method.images}
            write_exr(name, {"": method.images["image"], **layers}, scene.origin, graph=graph)
            if "whole" in method.images:
                write_exr(name.replace(".exr", ".whole.exr"), {"": method.images["whole"]}, scene.origin, graph=graph)
    return written
