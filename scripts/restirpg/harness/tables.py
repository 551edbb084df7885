"""Findings as rows of text: for the terminal and the report."""

import math

from restirpg.harness import denoised, equal_cost
from restirpg.harness import statistics as st
from restirpg.harness.analysis import METRICS, settled_frames

TITLES = {"mape": "MAPE", "relmse": "relMSE", "bias": "bias"}


def with_error(value, error, scale=1.0, unit=""):
    """`1.234 ± 0.012`: the error to two digits, the value to as many places."""
    value, error = value * scale, error * scale
    if math.isnan(value):
        return "—"
    if math.isnan(error) or error <= 0:
        return f"{value:.4g}{unit}"
    places = min(12, max(0, 1 - math.floor(math.log10(error))))
    if places > 6:
        return f"{value:.3g} ± {error:.1g}{unit}"
    return f"{value:.{places}f} ± {error:.{places}f}{unit}"


def error_of(method, metric, mode):
    """Mean and standard error over seeds: after the last frame ("frame"), at equal "time", of "single" frames
    (MAPE alone), or at a frame. Metric "denoised": MAPE after denoising of the last "frame" or the whole "image"."""
    if metric == "denoised":
        return st.mean_se(method.denoised[mode])
    if mode == "single":
        return st.mean_se(method.single)
    if mode in ("frame", "time"):
        return (method.equal_frame if mode == "frame" else method.equal_time)[metric]
    return st.mean_se(method.curves[metric][:, list(method.frames).index(mode)])


def verdict(method, baseline, metric, mode):
    """The method's error against the baseline's: ratio of means, and a word that needs p < LEVEL."""
    kind = (metric, mode)
    if not method.against:
        return "baseline"
    own, other = (error_of(each, metric, mode)[0] for each in (method, baseline))
    ratio = f"×{own / other:.3f} " if other > 0 and own > 0 else ""
    p = method.adjusted[kind]
    if math.isnan(p):
        return f"{ratio}not tested"
    if p >= st.LEVEL:
        return f"{ratio}not different (p = {p:.2g})"
    return f"{ratio}{'lower' if method.against[kind].difference < 0 else 'higher'} (p = {max(p, 1e-99):.2g})"


def is_significant(text):
    """Whether a cell claims a difference."""
    return any(word in text for word in ("lower (", "higher (", "biased ("))


def bias_verdict(method):
    """Whether the bias of the picture's mean differs from none."""
    p = method.adjusted["bias"]
    if math.isnan(p):
        return "not tested"
    return f"{'biased' if p < st.LEVEL else 'none found'} (p = {max(p, 1e-99):.2g})"


def block_cell(method):
    """How many 8x8 blocks are biased after correction over all blocks, methods and scenes."""
    p = method.adjusted["blocks"]
    if math.isnan(p):
        return "not tested"
    if p >= st.LEVEL:
        return f"none of {method.block_p.size} (p = {p:.2g})"
    return f"{method.biased_blocks} of {method.block_p.size} biased (p = {max(p, 1e-99):.2g})"


def _frames_in_words(frames):
    """`frame 8`, or `mean of frames 1, 8 and 9`; of many `mean of 10 frames, 11 to 20`."""
    if len(frames) == 1:
        return f"frame {frames[0]}"
    if len(frames) > 6:
        return f"mean of {len(frames)} frames, {frames[0]} to {frames[-1]}"
    return f"mean of frames {', '.join(map(str, frames[:-1]))} and {frames[-1]}"


def _settled_in_words(scene):
    """Which single frames are averaged."""
    if scene.at:
        return _frames_in_words(scene.at)
    frames = scene.methods[0].frames
    settled = frames[settled_frames(frames)]
    return f"mean of {len(settled)}, from frame {settled[0]} on"


def equal_tables(scene):
    """[(title, header, rows)] of the errors at equal frames, of single frames, and at equal time."""
    tables = []
    frames = int(scene.methods[0].frames[-1])
    for mode, title in (
        ("frame", f"Equal frames: after {frames}"),
        ("time", f"Equal time: after {scene.common_ms / 1e3:.3g} s of GPU time"),
    ):
        header, rows = ["method"], []
        header += [text for metric in METRICS for text in (TITLES[metric], "against the first")]
        header += ["GPU ms/frame", "wall ms/frame"] if mode == "frame" else ["frames"]
        for method in scene.methods:
            values = method.equal_frame if mode == "frame" else method.equal_time
            row = [method.label]
            for metric in METRICS:
                scale, unit = (100, "%") if metric == "mape" else (1, "")
                row += [
                    with_error(*values[metric], scale, unit),
                    verdict(method, scene.methods[0], metric, mode),
                ]
            if mode == "frame":
                row += [with_error(*st.mean_se(times)) for times in (method.frame_ms, method.frame_wall_ms)]
            else:
                frames_then = [st.at_time(times, method.frames, scene.common_ms) for times in method.gpu_ms]
                mean = sum(frames_then) / len(frames_then)
                row.append("—" if math.isnan(mean) else f"{mean:.3g}")
            rows.append(row)
        tables.append((title, header, rows))
    rows = [
        [
            method.label,
            with_error(*st.mean_se(method.single), 100, "%"),
            verdict(method, scene.methods[0], "mape", "single"),
            *([] if method.flip is None else [with_error(*st.mean_se(method.flip))]),
        ]
        for method in scene.methods
    ]
    title = f"Single frames: {_settled_in_words(scene)}"
    flip = [] if scene.methods[0].flip is None else ["FLIP of the last frame"]
    tables.insert(1, (title, ["method", "MAPE", "against the first", *flip], rows))
    return tables


def test_of(scene, frame):
    """The name that the tests of a measured frame have."""
    return "frame" if frame == scene.at[-1] else frame


def _single_frame_tables(scene):
    """[(title, header, rows)] of the errors of single frames, a row each, and of what a frame costs."""
    tables, baseline = [], scene.methods[0]
    for metric in METRICS:
        scale, unit = (100, "%") if metric == "mape" else (1, "")
        rows = []
        for frame in scene.at:
            row = [str(frame)]
            for method in scene.methods:
                row.append(with_error(*error_of(method, metric, frame), scale, unit))
                if method is not baseline:
                    text = verdict(method, baseline, metric, test_of(scene, frame))
                    row.append(text if is_significant(text) else text.split()[0] if text[0] == "×" else "—")
            rows.append(row)
        header = ["frame", baseline.label]
        header += [text for method in scene.methods[1:] for text in (method.label, "to the first")]
        tables.append((f"{TITLES[metric]} of single frames", header, rows))
    costs = [
        [
            method.label,
            *(with_error(*st.mean_se(times)) for times in (method.frame_ms, method.frame_wall_ms)),
        ]
        for method in scene.methods
    ]
    if scene.unit == "tile":
        tables.insert(0, _tile_table(scene))
    return [*tables, ("Cost", ["method", "GPU ms/frame", "wall ms/frame"], costs)]


def _tile_table(scene):
    """(title, header, rows) of the mean over all measured frames, in tiles: what both kinds of noise leave unsure."""
    baseline, rows = scene.methods[0], []
    for method in scene.methods:
        own, against = scene.reference_se.get(method.label, (float("nan"), float("nan")))
        row = [method.label, with_error(*st.mean_se(method.single), 100, "%"), with_error(100 * own, math.nan, 1, "%")]
        if method is baseline:
            row += ["baseline", "—", "—"]
        else:
            quotient, se = st.ratio(method.single, baseline.single)
            row += [
                with_error(quotient - 1, se, 100, "%"),
                with_error(100 * against, math.nan, 1, "%"),
                verdict(method, baseline, "mape", "single"),
            ]
        rows.append(row)
    header = [
        "method",
        "MAPE ± by tiles",
        "± by the reference",
        "change from the first ± by tiles",
        "± by the reference",
        "tested",
    ]
    return (
        f"Mean of {len(scene.at)} single frames, {scene.at[0]} to {scene.at[-1]}, in {scene.seeds} tiles",
        header,
        rows,
    )


def _equal_frame_time_table(scene):
    """(title, header, rows) of single frames that cost the same."""
    first, *others = equal_cost.compare(scene)
    rows = []
    for own in (first, *others):
        row = [own.label, own.setting, f"×{with_error(*own.time)}", with_error(*st.mean_se(own.values), 100, "%")]
        change = with_error(own.ratio[0] - 1, own.ratio[1], 100, "%")
        rows.append([*row, "—" if own is first else change, _tested_at_equal_cost(own, first)])
    header = ["method", "setting", "frame time in the runs", "MAPE", "change from the first", "tested in this scene"]
    return f"Equal frame time: single frames, {_settled_in_words(scene)}", header, rows


def _tested_at_equal_cost(own, first):
    """A verdict, where both methods' frames (equal_cost.Equal) took the same time."""
    off = f"not at equal time (×{own.time[0]:.2f})"
    if own is first:
        return "baseline" if own.is_equal else f"baseline, {off}"
    if not own.is_equal:
        return off
    if not first.is_equal:
        return f"the first is not at equal time (×{first.time[0]:.2f})"
    if math.isnan(own.p):
        return "not tested"
    word = "not different" if own.p >= st.LEVEL else "lower" if own.ratio[0] < 1 else "higher"
    return f"{word} (p = {max(own.p, 1e-99):.2g})"


def error_tables(scene):
    """[(title, header, rows)] of the errors: of single frames, or at equal frames and at equal time."""
    found = _single_frame_tables(scene) if scene.at else equal_tables(scene)
    return [_equal_frame_time_table(scene), *found] if scene.equal_cost else found


def percent(share):
    """`31%`, `310%`: a share to two digits, without an exponent."""
    return f"{float(f'{100 * share:.2g}'):g}%"


def _compared_in_words(baseline, found):
    """(words, whether there is a difference): who errs how much less or more than the first method, who is not told
    apart from it, and who was not tested.

    found: [(label, error as a share of the first's, corrected p)].
    """
    parts = []
    for label, share, p in found:
        if p < st.LEVEL:
            change = f"{percent(abs(1 - share))} {'less' if share < 1 else 'more'}"
            parts.append(f"{label} has {change} error than {baseline}" if not parts else f"{label} {change}")
    parts = [", ".join(parts)] if parts else []
    different = bool(parts)
    for verb, labels in (
        ("told apart from", [label for label, _, p in found if p >= st.LEVEL]),
        ("tested against", [label for label, _, p in found if math.isnan(p)]),
    ):
        if len(labels) == len(found) > 1:
            parts.append(f"no method is {verb} {baseline}")
        elif labels:
            are = "is" if len(labels) == 1 else "are"
            parts.append(f"{' and '.join(labels)} {are} not {verb} {'it' if parts else baseline}")
    return "; ".join(parts), different


def _tested(scene, mode):
    """What _compared_in_words() takes, of MAPE in one way of comparing."""
    baseline, *others = scene.methods
    other = error_of(baseline, "mape", mode)[0]
    found = [(method, method.adjusted.get(("mape", mode), math.nan)) for method in others]
    return [
        (method.label, error_of(method, "mape", mode)[0] / other if other > 0 else math.nan, p if other > 0 else 1)
        for method, p in found
    ]


def equal_cost_sentence(scene):
    """What was found at equal frame time, in one sentence; "" where that was not asked for."""
    if not scene.equal_cost:
        return ""
    first, *others = equal_cost.compare(scene)
    if not first.is_equal:
        return f"At equal frame time nobody is tested: a frame of {first.label} takes ×{first.time[0]:.2f} of the time."
    tested = [own for own in others if own.is_equal]
    words, _ = _compared_in_words(first.label, [(own.label, own.ratio[0], own.p) for own in tested])
    off = [f"{own.label} is not at equal time (×{own.time[0]:.2f})" for own in others if not own.is_equal]
    return f"At equal frame time, {'; '.join([*filter(None, [words]), *off])}."


def verdict_sentence(scene):
    """What was found, in one sentence of plain words: MAPE against the first method. Another one is of equal frame time,
    where that was asked for."""
    return " ".join(filter(None, [_verdict_sentence(scene), equal_cost_sentence(scene)]))


def _verdict_sentence(scene):
    baseline, *others = scene.methods
    if not others:
        return ""
    ways = (
        {test_of(scene, scene.at[-1]): f"in frame {scene.at[-1]}"}
        if scene.at
        else {"single": "in single frames", "time": "at equal time"}
    )
    if scene.unit == "tile":
        ways = {"single": f"in single frames, {scene.at[0]} to {scene.at[-1]}"}
    found = {way: _compared_in_words(baseline.label, _tested(scene, mode)) for mode, way in ways.items()}
    said = {text for text, _ in found.values()}
    if len(said) == 1 and not any(different for _, different in found.values()):
        text = f"{said.pop()}, {' or '.join(found)}"
        return (text if len(others) == 1 else text[0].upper() + text[1:]) + "."  # a method's label keeps its case
    text = "; ".join(f"{way}, {words}" for way, (words, _) in found.items())
    return text[0].upper() + text[1:] + "."


def denoised_tables(scene):
    """[(title, header, rows)] of errors after denoising; none where that was not asked for."""
    baseline = scene.methods[0]
    if not baseline.denoised:
        return []
    names = {
        "frame": f"frame {scene.at[-1]}" if scene.at else "last frame",
        "image": f"mean of {int(baseline.frames[-1])} frames",
    }
    kinds = {kind: names[kind] for kind in denoised.kinds(scene.at)}
    header = ["method", *(text for kind in kinds.values() for text in (f"{kind}, denoised", "against the first"))]
    rows = [
        [
            method.label,
            *(
                text
                for kind in kinds
                for text in (
                    with_error(*error_of(method, "denoised", kind), 100, "%"),
                    verdict(method, baseline, "denoised", kind),
                )
            ),
        ]
        for method in scene.methods
    ]
    return [("Error after denoising: MAPE of what Open Image Denoise makes of the picture", header, rows)]


def quality_table(scene):
    """(title, header, rows) of bias and correlation."""
    header = [
        "method",
        "bias of the mean",
        "tested",
        "smallest detectable",
        "8×8 blocks",
        "blotches, one frame",
        "blotches, picture",
        "boiling, lag 1",
    ]
    rows = [
        [
            method.label,
            with_error(method.bias.difference, method.bias.se, 100, "%"),
            bias_verdict(method),
            percent(method.bias.smallest_detectable(scene.bias_tests)) if method.bias.dof else "—",
            block_cell(method),
            with_error(*method.spatial_frame),
            with_error(*method.spatial_image),
            with_error(*method.temporal),
        ]
        for method in scene.methods
    ]
    return "Bias and correlation" + (f" of frame {scene.at[-1]}" if scene.at else ""), header, rows


def reference_line(scene):
    """What is known of the reference, in one line."""
    meta = scene.reference["meta"]
    if not meta["batches"]:
        return f"reference: {meta['source']}, taken as exact: its own error is not known"
    return (
        f"reference{f' of frame {scene.at[-1]}' if scene.at else ''}: {meta['source']}, "
        f"{meta['batches']} batches of {meta['frames']} frames; "
        f"standard error of its mean {percent(scene.noise['relative_se'])}; "
        f"its noise is {scene.noise['relmse']:.2g} of relMSE (subtracted) and a floor of "
        f"{percent(scene.noise['mape'])} under MAPE (not subtracted)"
    )


def all_tables(scene):
    """[(title, header, rows)] of everything that is told of a scene."""
    return [*error_tables(scene), *denoised_tables(scene), quality_table(scene)]
