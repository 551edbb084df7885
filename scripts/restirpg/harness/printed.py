"""Findings in a terminal: every table, or one narrow one."""

import io
import math

import rich.box
from rich.console import Console
from rich.table import Table

from restirpg.harness import statistics as st
from restirpg.harness.tables import all_tables, error_of, reference_line, test_of, verdict_sentence


def _console(stream, width):
    """A console to which labels and files are no markup."""
    return Console(file=stream, width=width, markup=False, emoji=False, highlight=False)


def as_text(findings, width=None):
    """The tables of all scenes for a terminal; the same findings give the same text."""
    stream = io.StringIO()
    console = _console(stream, width or 170)
    for scene in findings:
        console.print(f"\n{scene.scene}  ({scene.seeds} {scene.unit}s)", style="bold")
        if sentence := verdict_sentence(scene):
            console.print(sentence)
        console.print(reference_line(scene))
        for warning in scene.warnings:
            console.print(f"warning: {warning}")
        for title, header, rows in all_tables(scene):
            table = Table(title=title, box=rich.box.SIMPLE_HEAD, title_justify="left")
            for number, name in enumerate(header):
                table.add_column(name, justify="left" if number == 0 else "right", overflow="fold")
            for row in rows:
                table.add_row(*row)
            console.print(table)
    unit = findings[0].unit if findings else "seed"
    console.print(
        f"± is one standard error over {unit}s. Tests are paired by {unit}. "
        f'"lower", "higher" and "biased" mean p < {100 * st.LEVEL:.0f}%, corrected (Holm) over all methods and scenes.'
    )
    return "\n".join(line.rstrip() for line in stream.getvalue().splitlines()) + "\n"


def in_brief(findings):
    """The verdict of each scene and one table of at most 80 columns."""
    stream = io.StringIO()
    console = _console(stream, 80)
    for scene in findings:
        console.print(f"\n{scene.scene}, {scene.seeds} {scene.unit}s", style="bold")
        if sentence := verdict_sentence(scene):
            console.print(sentence)
        for warning in scene.warnings:
            console.print(f"warning: {warning}")
        title, mode = "single frames", "single"
        if scene.at and scene.unit == "seed":
            title, mode = f"frame {scene.at[-1]}", test_of(scene, scene.at[-1])
        columns = [(title, "mape", mode)]
        columns += [] if scene.at else [("equal time", "mape", "time")]
        columns += [("denoised", "denoised", "frame")] if scene.methods[0].denoised else []
        table = Table(box=rich.box.SIMPLE_HEAD)
        table.add_column("method", overflow="fold")
        for title, _, _ in columns:
            table.add_column(title, justify="right", no_wrap=True)
        table.add_column("ms/frame", justify="right", no_wrap=True)
        for method in scene.methods:
            cells = [_short(method, metric, kind) for _, metric, kind in columns]
            table.add_row(method.label, *cells, f"{method.frame_ms.mean():.0f}")
        console.print(table)
    unit = findings[0].unit if findings else "seed"
    console.print(
        f"Errors: MAPE ± one standard error over {unit}s. *: significantly different from the first method "
        f"(p < {100 * st.LEVEL:.0f}%, corrected for all tests)."
    )
    return "\n".join(line.rstrip() for line in stream.getvalue().splitlines()) + "\n"


def _short(method, metric, mode):
    """An error in percent to one place, with a star where the method was told apart from the first."""
    value, error = (100 * number for number in error_of(method, metric, mode))
    mark = "*" if method.adjusted.get((metric, mode), 1) < st.LEVEL else " "
    spread = "" if math.isnan(error) else f" ± {error:.1f}"
    return "—" if math.isnan(value) else f"{value:.1f}{spread}% {mark}"
