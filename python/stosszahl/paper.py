"""Figures for papers: vector files of the width of one or two columns of a journal."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass, field
from pathlib import Path

from . import _native, given
from .errors import ResultsError

__all__ = ["PaperFigure"]


@dataclass(frozen=True)
class PaperFigure:
    """Figure of a results folder, drawn for a paper; a notebook shows it.

    Text has 8 points at any width, and curves are told apart without colour. PDF has its fonts embedded, SVG has text as outlines; neither
    needs a font of the system.

    Attributes
    ----------
    name, title : str
        Name of the figure, as of its file in ``figures``, and its title.
    width, height : float
        Size in millimetres.
    svg : str
        Drawing as SVG.
    pdf : bytes
        Drawing as a PDF document of one page.
    """

    name: str
    title: str
    width: float
    height: float
    svg: str = field(repr=False)
    pdf: bytes = field(repr=False)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the figure in the format that the ending of the path names, ``.svg`` or ``.pdf``, and returns the path.

        A file that exists is replaced.

        Raises
        ------
        ResultsError
            The ending is another one.
        OSError
            The file cannot be written.
        """
        path = given.path("path", path, ResultsError)
        contents = {".svg": self.svg.encode(), ".pdf": self.pdf}.get(path.suffix)
        if contents is None:
            raise ResultsError(f"path {path}; allowed: a file that ends in .svg or .pdf")
        path.write_bytes(contents)
        return path

    def _repr_svg_(self) -> str:
        return self.svg


def draw(folder: Path, name: str, columns: int, width: float | None) -> PaperFigure:
    """Draws a figure of a folder, with the width of columns unless one is given."""
    of_columns, _ = _native.print_widths()
    columns = given.whole("number of columns", columns, 1, 2, ResultsError)
    millimetres = of_columns[columns - 1] if width is None else given.number("width", width, refusal=ResultsError)
    title, size, svg, pdf, missing = _native.print_drawing(folder, str(name), millimetres)
    if missing:
        warnings.warn(f"{name}: the fonts have no {missing}; an empty box is drawn for each", stacklevel=3)
    return PaperFigure(str(name), title, size[0], size[1], svg, pdf)
