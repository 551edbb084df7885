"""The report's charts, as SVG text."""

import io

import matplotlib
import matplotlib.ticker
import numpy as np

from restirpg.harness import statistics as st
from restirpg.harness.analysis import METRICS

matplotlib.use("svg")
matplotlib.rcParams.update(
    {
        "svg.fonttype": "none",
        "svg.hashsalt": "restirpg",
        "font.size": 9,
        "font.family": "sans-serif",
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.alpha": 0.25,
        "legend.frameon": False,
        "figure.autolayout": True,
        "text.parse_math": False,  # labels and files are no markup
    }
)

from matplotlib import pyplot  # noqa: E402

# Okabe and Ito's palette: told apart by readers of every colour vision.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#F0E442"]
LINES = ["-", "--", "-.", ":"]  # of as many times eight curves


def _look(number):
    """Colour and line of the curve with that number: no two of the first 32 look alike."""
    return {
        "color": COLOURS[number % len(COLOURS)],
        "linestyle": LINES[number // len(COLOURS) % len(LINES)],
    }


TITLES = {
    "mape": "MAPE, %",
    "single": "MAPE of single frames, %",
    "relmse": "relMSE, less the reference's noise",
    "bias": "signed bias of the mean, %",
}
PERCENT = ("mape", "single", "bias")  # the unit they have everywhere


def _svg(figure):
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    pyplot.close(figure)
    text = stream.getvalue()
    return text[text.index("<svg") :]


def _curve(axes, x, values, number, label):
    mean, se = st.mean_se(values)
    look = _look(number)
    axes.plot(x, mean, **look, label=label, linewidth=1.4, marker="o" if len(x) == 1 else None)
    if np.all(np.isfinite(se)):
        axes.fill_between(x, mean - se, mean + se, color=look["color"], alpha=0.25, linewidth=0)


def log_axis(axis):
    """A logarithmic scale with a handful of plain numbers at its ticks, whatever the range."""
    low, high = axis.get_view_interval()
    decades = np.log10(high / low) if low > 0 else 1
    subs = (1, 2, 5) if decades > 1 else (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9)
    locator = matplotlib.ticker.LogLocator(base=10, subs=subs if decades < 3 else (1,), numticks=20)
    few = sum(low <= tick <= high for tick in locator.tick_values(low, high)) < 3
    axis.set_major_locator(matplotlib.ticker.MaxNLocator(4) if few else locator)
    axis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:g}"))
    axis.set_minor_locator(matplotlib.ticker.NullLocator())


def _frame_axis(axes, scene):
    if scene.at:  # single frames
        axes.xaxis.set_major_locator(matplotlib.ticker.MaxNLocator(integer=True))
        axes.set_xlabel("frame")
        return
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:g}"))
    axes.set_xlabel("frames")


def error_curves(scene, metric, over):
    """A metric over "frames" or "time" (GPU seconds); bands are one standard error over seeds or tiles."""
    figure, axes = pyplot.subplots(figsize=(4.15, 3.0))
    positive = True
    for number, method in enumerate(scene.methods):
        x = method.frames if over == "frames" else method.gpu_ms.mean(axis=0) / 1e3
        values = method.curves[metric] * (100 if metric in PERCENT else 1)
        known = ~np.isnan(values).any(axis=0)  # a picture without a valid pixel has no error
        x, values = x[known], values[:, known]
        _curve(axes, x, values, number, method.label)
        positive &= bool(values.size and np.all(values.mean(axis=0) > 0))
    axes.set_yscale("log" if positive else "linear")
    if positive:
        log_axis(axes.yaxis)
    if over == "frames":
        _frame_axis(axes, scene)
    else:
        axes.set_xscale("log")
        log_axis(axes.xaxis)
        axes.set_xlabel("GPU time, s")
        axes.axvline(scene.common_ms / 1e3, color="#888", linestyle=":", linewidth=1)
    axes.set_ylabel(TITLES[metric])
    axes.legend(fontsize=8)
    return _svg(figure)


def bias_curves(scene):
    """Signed bias of the mean over frames, in percent, with the reference's own 95% band in grey."""
    figure, axes = pyplot.subplots(figsize=(4.15, 3.0))
    for number, method in enumerate(scene.methods):
        _curve(axes, method.frames, 100 * method.curves["bias"], number, method.label)
    band = 196 * scene.noise["relative_se"]
    axes.axhspan(-band, band, color="#888", alpha=0.2, linewidth=0, label="reference ± 95%")
    _frame_axis(axes, scene)
    axes.set_ylabel(TITLES["bias"])
    axes.legend(fontsize=8)
    return _svg(figure)


def _stacked_bars(rows, unit, most=10):
    """Horizontal stacked bars; rows: label -> {part: value}. Small parts beyond `most` are summed."""
    totals = {}
    for parts in rows.values():
        for name, value in parts.items():
            totals[name] = totals.get(name, 0) + value
    shown = sorted((name for name in totals if totals[name] > 0), key=totals.get, reverse=True)[:most]
    figure, axes = pyplot.subplots(figsize=(12.5, 1.2 + 0.4 * len(rows)))
    left = np.zeros(len(rows))
    colours = matplotlib.colormaps["tab20"].colors
    for number, name in enumerate([*shown, "other"]):
        values = np.array(
            [
                sum(value for part, value in parts.items() if (part if part in shown else "other") == name)
                for parts in rows.values()
            ],
            float,
        )
        if values.any():
            axes.barh(range(len(rows)), values, left=left, label=name, color=colours[number % 20], height=0.65)
        left += values
    for row, total in enumerate(left):
        axes.text(total, row, f" {total:.4g}", va="center")
    axes.set_yticks(range(len(rows)), list(rows))
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(unit)
    axes.legend(loc="upper left", bbox_to_anchor=(1, 1))
    return _svg(figure)


def pass_costs(scene):
    """GPU milliseconds per frame of each pass, stacked."""
    return _stacked_bars({method.label: method.passes for method in scene.methods}, "GPU ms/frame")


def memory(scene):
    """MiB of the scene and of each resource, stacked."""
    return _stacked_bars(
        {method.label: {name: size / 2**20 for name, size in method.memory.items()} for method in scene.methods},
        "MiB",
    )


def charts(scene):
    """[(title, svg)] of a scene's curves: six, or three of single frames, to fill rows of three."""
    if scene.at:
        errors = [(metric, "frames") for metric in METRICS]
    else:
        errors = [("single", "frames"), *((metric, over) for metric in METRICS for over in ("frames", "time"))]
    return [
        *((f"{metric} over {over}", error_curves(scene, metric, over)) for metric, over in errors),
        ("bias over frames", bias_curves(scene)),
    ]


def bars(scene):
    """[(title, svg)] of a scene's costs."""
    return [("cost of passes", pass_costs(scene)), ("memory", memory(scene))]


def colour_map(name, entries=128):
    """A matplotlib colour map as a flat list of bytes, for the viewer."""
    return (matplotlib.colormaps[name](np.linspace(0, 1, entries))[:, :3] * 255).round().astype(int).ravel().tolist()
