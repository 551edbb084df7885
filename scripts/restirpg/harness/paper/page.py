"""The evaluation's report: sections of figures, tables and whole comparisons, as one HTML file that needs no
network."""

import base64
import csv
import io
import math
from dataclasses import dataclass, field
from pathlib import Path

from restirpg.harness import files, report, tables
from restirpg.harness import statistics as st


@dataclass(frozen=True)
class Estimate:
    """A number with its standard error (NaN: not known), shown times `scale` with `unit`."""

    mean: float
    se: float = math.nan
    scale: float = 1.0
    unit: str = ""

    def __str__(self):
        return tables.with_error(float(self.mean), float(self.se), self.scale, self.unit)


def estimate(values):
    """The mean of independent runs."""
    return Estimate(*map(float, st.mean_se(values)))


def percent(mean, se=math.nan):
    """A ratio, shown in percent."""
    return Estimate(float(mean), float(se), 100.0, "%")


@dataclass(frozen=True)
class Table:
    """Rows of cells: Estimates or text. `name` names its CSV file, where estimates are two columns each."""

    name: str
    title: str
    header: tuple
    rows: list

    def write_csv(self, folder):
        """Write FOLDER/name.csv: means and standard errors as they are, without scale and unit."""
        numeric = [any(isinstance(row[at], Estimate) for row in self.rows) for at in range(len(self.header))]
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        pairs = [[name, f"{name} (se)"] if is_number else [name] for name, is_number in zip(self.header, numeric)]
        writer.writerow([name for pair in pairs for name in pair])
        for row in self.rows:
            cells = [_csv_cells(cell, is_number) for cell, is_number in zip(row, numeric)]
            writer.writerow([cell for pair in cells for cell in pair])
        files.write(Path(folder) / f"{self.name}.csv", stream.getvalue())


def _csv_cells(cell, is_number):
    if isinstance(cell, Estimate):
        return [f"{cell.mean:.9g}", f"{cell.se:.9g}"]
    return [cell, ""] if is_number else [cell]


@dataclass(frozen=True)
class Picture:
    """A drawn figure, by a matplotlib Figure: embedded, and written as NAME.png."""

    name: str
    caption: str
    figure: object

    def png(self):
        """Its bytes."""
        stream = io.BytesIO()
        self.figure.savefig(stream, format="png", dpi=120, facecolor="white", metadata={"Software": None})
        return stream.getvalue()


@dataclass
class Section:
    """A part of the report."""

    title: str
    text: str  # what it shows, and where it departs from the paper
    pictures: list = field(default_factory=list)
    tables: list = field(default_factory=list)
    comparisons: list = field(default_factory=list)  # SceneFindings, shown whole but folded away


def write(sections, paper, file, program):
    """Write pictures and CSV files beside the report, and the report itself."""
    folder = Path(file).parent
    findings = [scene for section in sections for scene in section.comparisons]
    views, shared = report.scene_views(findings, "its study, a family of its own")
    view_of = {id(scene): view for scene, view in zip(findings, views)}
    parts = []
    for section in sections:
        pictures = []
        for picture in section.pictures:
            data = picture.png()
            files.write(folder / f"{picture.name}.png", data)
            pictures.append((picture.name, picture.caption, base64.b64encode(data).decode()))
        for table in section.tables:
            table.write_csv(folder)
        parts.append(
            {
                "title": section.title,
                "text": section.text,
                "pictures": pictures,
                "tables": [
                    (table.title, table.header, [[str(cell) for cell in row] for row in table.rows])
                    for table in section.tables
                ],
                "scenes": [view_of[id(scene)] for scene in section.comparisons],
            }
        )
    size = paper.size
    provenance = report.provenance(program, paper.code, paper.devices.values()) + [
        ("size, frames, seeds", f"{size.size[0]}x{size.size[1]}, {size.frames}, {size.seeds} ({size.name})"),
        (
            "reference",
            f"{size.reference_frames} frames of {Path(size.reference_graph).name} in {size.reference_batches} batches; "
            f"of each frame of figure 7 and motion {size.motion_reference_frames}",
        ),
    ]
    text = report.template("paper.html.j2").render(
        title="ReSTIR PG: the paper's evaluation",
        sections=parts,
        failures=paper.failures,
        provenance=provenance,
        **shared,
    )
    files.write(file, text)
