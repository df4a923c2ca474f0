"""Results: tables, verdicts, snapshots and figures from the folder of a run."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from . import _native, given
from .errors import ResultsError
from .paper import PaperFigure, draw
from .snapshots import READERS, Snapshot, read_snapshot
from .writing import optional

if TYPE_CHECKING:
    import pyarrow
    from matplotlib.figure import Figure

__all__ = ["Results", "Verdict"]


@dataclass(frozen=True)
class Verdict:
    """Verdict in words; ``kind`` is agree, differ, undecided, void, warning or note."""

    kind: str
    topic: str
    sentence: str

    def __str__(self) -> str:
        return f"{self.kind:<10} {self.sentence}"


class Tables(Mapping[str, pd.DataFrame]):
    """Tables by name, each read at its first access."""

    def __init__(self, results: Results) -> None:
        self._results = results
        self._read: dict[str, pd.DataFrame] = {}

    def __getitem__(self, name: str) -> pd.DataFrame:
        if name not in self._read:
            self._read[name] = self._results._table(name)
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._results._entries)

    def __len__(self) -> int:
        return len(self._results._entries)

    def __repr__(self) -> str:
        return f"<tables {', '.join(self)}>"


class Results:
    """Results folder of one run, or of a sweep.

    Parameters
    ----------
    folder : path
        Folder that ``stosszahl run`` or :func:`stosszahl.run` has written.

    Attributes
    ----------
    folder : Path
        Path of the folder.
    tables : mapping of str to DataFrame
        Tables by name; ``results["energy"]`` is ``results.tables["energy"]``. Tables of a sweep have the rows of all points, with
        the values of the point in front. ``DataFrame.attrs`` has the description and the units of a table.
    points : dict of str to Results
        Points of a sweep, by name; empty for one run.
    changed : list of str
        Files that have changed since the run.

    Raises
    ------
    ResultsError
        There is no finished run, or a file is missing or damaged.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = given.path("folder", folder, ResultsError)
        self.points: dict[str, Results] = {}
        self._values: dict[str, dict[str, Any]] = {}
        self.changed: list[str] = []
        index = _native.sweep(self.folder)
        if index is None:
            text, self.changed = _native.manifest(self.folder)
            self.manifest: dict[str, Any] = json.loads(text)
            first = self
        else:
            self.manifest = json.loads(index)
            for point in self.manifest["points"]:
                self.points[point["name"]] = Results(self.folder / point["name"])
                self._values[point["name"]] = point["values"]
            first = next(iter(self.points.values()))
        self._entries: dict[str, dict[str, Any]] = (
            {entry["name"]: entry for entry in self.manifest["tables"]} if first is self else first._entries
        )
        self.tables = Tables(self)

    @property
    def is_sweep(self) -> bool:
        """True if the results are those of a sweep, with points."""
        return bool(self.points)

    @property
    def title(self) -> str:
        """Title of the case."""
        return str(self.manifest["title"])

    @property
    def case(self) -> dict[str, Any]:
        """Case as it was run, with all defaults; of a sweep, the case of the first point."""
        return next(iter(self.points.values())).case if self.points else self.manifest["case"]

    @property
    def verdicts(self) -> list[Verdict]:
        """Verdicts, the most important first; of a sweep, the verdicts of all points."""
        if self.points:
            return [verdict for point in self.points.values() for verdict in point.verdicts]
        return [Verdict(one["kind"], one["topic"], one["sentence"]) for one in self.manifest["verdicts"]]

    @property
    def warnings(self) -> list[str]:
        """Warnings about the case and its run; of a sweep, the warnings of all points."""
        if self.points:
            return [text for point in self.points.values() for text in point.warnings]
        return list(self.manifest["warnings"])

    @property
    def derived(self) -> dict[str, float]:
        """Quantities that follow from the case, such as the mean free path, by name, in the units of the case."""
        self._refuse_sweep("derived")
        return {one["name"]: float("nan") if one["value"] is None else one["value"] for one in self.manifest["derived"]}

    @property
    def report(self) -> Path:
        """Path of the report page of the run."""
        return self.folder / "report.html"

    def __getitem__(self, name: str) -> pd.DataFrame:
        return self.tables[name]

    def columns(self, name: str) -> pd.DataFrame:
        """Unit, meaning and role of each column of a table, by name of the column."""
        columns = pd.DataFrame(self._entry(name)["columns"]).set_index("name")
        return columns[["unit", "meaning", "role"]]

    def arrow(self, name: str) -> pyarrow.Table:
        """Table as a table of Arrow, without a copy of numeric columns; fields have unit, meaning and role as metadata.

        Polars reads it, ``polars.from_arrow(results.arrow("energy"))``, and so do DuckDB and Parquet files.

        Raises
        ------
        PackageError
            ``pyarrow`` is not installed.
        """
        arrow = optional("pyarrow", "tables of Arrow")
        frame, about = self.tables[name], self.columns(name).to_dict("index")
        table = arrow.Table.from_pandas(frame, preserve_index=False)
        fields = [field.with_metadata(about[field.name]) if field.name in about else field for field in table.schema]
        return table.cast(arrow.schema(fields, metadata={"about": frame.attrs["about"]}))

    def figure(self, name: str, number: int = 0) -> Figure:
        """Figure of a table, as in the report: estimates with error bars against time, dashed theory, histograms, maps.

        Parameters
        ----------
        name : str
            Name of the table.
        number : int
            Number of the figure of the table, from 0.
        """
        from . import figures as matplotlib_figures

        self._refuse_sweep("figure")
        figures = self._entry(name)["figures"]
        number = given.whole("number of the figure", number, refusal=ResultsError)
        if not number < len(figures):
            raise ResultsError(f"table {name} has {len(figures)} figures; found number {number}; allowed: below that, from 0")
        return matplotlib_figures.draw(self.tables[name], figures[number], self._entry(name)["columns"])

    @property
    def paper_figures(self) -> dict[str, str]:
        """Figures for papers by name, each with its title; of a sweep, those over its points."""
        return dict(_native.print_names(self.folder))

    def paper_figure(self, name: str, columns: int = 1, *, width: float | None = None) -> PaperFigure:
        """Figure as a vector file for a paper: the same as ``stosszahl figure``, and not drawn by matplotlib.

        Parameters
        ----------
        name : str
            Name of the figure, one of :attr:`paper_figures`.
        columns : int
            Columns of the journal that the figure takes: 86 mm for 1, 178 mm for 2.
        width : float, optional
            Width in millimetres, from 60 to 400, in place of that of columns.

        Raises
        ------
        ResultsError
            There is no such figure, or the width is not allowed.
        """
        return draw(self.folder, name, columns, width)

    @cached_property
    def snapshots(self) -> list[Snapshot]:
        """Snapshots, in the order of the manifest: by engine, then by replica, then by time."""
        self._refuse_sweep("snapshots")
        # Of files of one snapshot in several formats, the one with all digits.
        best: dict[Path, tuple[int, Mapping[str, Any]]] = {}
        for about in self.manifest["snapshots"]:
            file = Path(about["file"])
            rank = list(READERS).index(file.suffix)
            if rank < best.get(file.with_suffix(""), (len(READERS), about))[0]:
                best[file.with_suffix("")] = rank, about
        return [read_snapshot(self.folder / one["file"], one) for _, one in best.values()]

    def __repr__(self) -> str:
        what = f"sweep of {len(self.points)} points" if self.points else f"{len(self._entries)} tables"
        return f"<Results {str(self.folder)!r}: {self.title}, {what}>"

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><td>{one.kind}</td><td>{html.escape(one.sentence)}</td></tr>" for one in self.verdicts)
        return f"<b>{html.escape(self.title)}</b><table>{rows}</table>"

    def _refuse_sweep(self, what: str) -> None:
        if self.points:
            raise ResultsError(f"{self.folder}: {what} of a sweep; allowed: of one of its points, such as points[{next(iter(self.points))!r}]")

    def _entry(self, name: str) -> dict[str, Any]:
        if name not in self._entries:
            raise ResultsError(f"{self.folder}: no table {name}; the tables are {', '.join(self._entries)}")
        return self._entries[name]

    def _table(self, name: str) -> pd.DataFrame:
        entry = self._entry(name)
        if self.points:
            parts = [point.tables[name].assign(**self._values[key]) for key, point in self.points.items()]
            swept = list(next(iter(self._values.values())))
            table = pd.concat(parts, ignore_index=True)
            table = table[swept + [column for column in table.columns if column not in swept]]
        else:
            words = {column["name"]: str for column in entry["columns"] if column["unit"] == ""}
            table = pd.read_csv(self.folder / f"{name}.csv", dtype=words, keep_default_na=False, na_values=[""])
            for name in words:
                # Removal of the apostrophe that protects words from spreadsheets, which would read a formula.
                table[name] = table[name].astype(object).str.replace(r"^'(?='*[=+\-@\t\r])", "", regex=True)
        table.attrs = {"about": entry["about"], "units": {column["name"]: column["unit"] for column in entry["columns"]}}
        return table
