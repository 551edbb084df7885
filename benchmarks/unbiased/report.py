"""What a recording found: a dictionary of numbers, as JSON and as Markdown."""

import json

import numpy as np


def findings_of(method, bounces, invalid, verdicts, reference_samples, block):
    """The numbers of one recording. Biases and errors are relative to the reference's mean."""
    case = method.case
    device = method.renderer.device_info
    rows = {}
    for k, verdict in verdicts.items():
        rows[k] = {
            "ratio": 1 + verdict.image.difference,
            "standard_error": verdict.image.se,
            "image_z": verdict.image.difference / verdict.image.se,
            "image_p": verdict.image.p,
            "detectable_image": verdict.detectable,
            "largest_z": float(np.abs(verdict.z).max()),
            "limit": verdict.limit,
            "blocks": int(verdict.z.size),
            "detectable_block": verdict.detectable_block,
            "ks_p": verdict.normality,
            "biased": verdict.biased,
        }
    return {
        "method": case.method.label,
        "scene": case.scene.stem,
        "size": list(case.size),
        "bounces": bounces,
        "runs": next(iter(verdicts.values())).runs,
        "circle": case.motion.circle,
        "fps": case.motion.fps,
        "reference_samples": reference_samples,
        "block": block,
        "invalid": invalid,
        "device": f"{device['name']}, {device['driver']}, {device['backend']}",
        "sessions": method.samples.sessions(),
        "biased": bool(invalid or any(row["biased"] for row in rows.values())),
        "frames": rows,
    }


def motion_text(findings):
    """What moves, in words."""
    parts = []
    if findings["circle"]:
        parts.append(f"camera in a circle of {findings['circle']:g} m")
    if findings["fps"]:
        parts.append(f"animated at {findings['fps']:g} frames a second")
    return ", ".join(parts) or "static"


def as_markdown(findings):
    """A heading, a line of what was run and a table."""
    width, height = findings["size"]
    commits = ", ".join(dict.fromkeys(session["commit"] for session in findings["sessions"]))
    lines = [
        f"\n### {findings['method']}, {findings['scene']}, {motion_text(findings)}\n",
        f"{width}x{height}, bounce cap {findings['bounces']}, R = {findings['runs']} runs, reference of "
        f"{findings['reference_samples']} samples a pixel, {findings['invalid']} NaN or infinite; "
        f"{findings['device']}; commit {commits}.\n",
        f"| k | ratio of image means | z | smallest bias found | largest abs z of {findings['block']}x"
        f"{findings['block']} blocks | limit | smallest bias found, median block | KS p | verdict |",
        "| --- " * 9 + "|",
    ]
    for k, row in findings["frames"].items():
        lines.append(
            f"| {k} | {row['ratio']:.4f} ± {row['standard_error']:.4f} | {row['image_z']:+.2f} "
            f"| {row['detectable_image']:.2%} | {row['largest_z']:.2f} of {row['blocks']} "
            f"| {row['limit']:.2f} | {row['detectable_block']:.1%} | {row['ks_p']:.2g} "
            f"| {'BIASED' if row['biased'] else 'none found'} |"
        )
    return "\n".join(lines) + "\n"


def as_json(findings):
    """The same, for programs."""
    return json.dumps(findings, indent=1) + "\n"
