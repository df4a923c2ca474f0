"""Particles and fields as VTK files for ParaView: one file for each time, and a ``.pvd`` collection."""

from __future__ import annotations

import base64
import os
import struct
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from . import given
from .errors import ResultsError
from .gas import Gas
from .results import Results
from .snapshots import Snapshot, snapshot_of
from .writing import write_text

__all__ = ["write_fields", "write_particles"]

TYPES = {"f": ("Float64", "<f8"), "i": ("Int64", "<i8"), "u": ("UInt8", "u1")}
COLUMNS = {
    "velocities": "velocity",
    "radii": "diameter",
    "masses": "mass",
    "species": "species",
    "spins": "angular_velocity",
    "weights": "weight",
}
"""Names of the arrays in files, by quantity."""
VERTEX = 1
"""VTK cell type of a single point."""


def write_particles(frames: Iterable[Snapshot | Gas], folder: str | os.PathLike[str], name: str = "particles") -> Path:
    """Writes particles for ParaView: one ``.vtu`` of points for each snapshot, and a ``.pvd`` in time.

    Points have the arrays ``id``, ``velocity``, ``diameter`` and ``mass``. They also have ``angular_velocity``, ``species`` and
    ``weight`` where particles differ in them. In ParaView the filter *Glyph* with spheres, the scale array ``diameter`` and the scale
    factor 1 shows particles in their size. Snapshots may differ in their number of particles; each is written as soon as it is made.

    Parameters
    ----------
    frames : Trajectory, or iterable of Snapshot or Gas
        Snapshots in order of time.
    folder : path
        Folder of the files; it is made if it does not exist.
    name : str
        Start of the names of the files ``NAME-0.vtu``, ... and ``NAME.pvd``.

    Returns
    -------
    Path
        Path of the ``.pvd`` file. Times in it are those of the snapshots.

    Raises
    ------
    ResultsError
        There is no snapshot, or a file cannot be written.
    """
    return write_series(folder, name, ".vtu", ((one.time, points(one)) for one in placed(given.path("folder", folder, ResultsError) / name, frames)))


def write_fields(results: Results, folder: str | os.PathLike[str], engine: str | None = None) -> Path:
    """Writes the fields of a flow (``fields.csv``) for ParaView: one ``.vti`` image for each window, and ``fields.pvd`` in time.

    Parameters
    ----------
    results : Results
        Results of a flow with the measure ``fields``.
    folder : path
        Folder of the files; it is made if it does not exist.
    engine : str, optional
        Name of the engine; by default the first of the table.

    Returns
    -------
    Path
        Path of the ``.pvd`` file. Times in it are the middles of windows, in the unit of time of the case.

    Raises
    ------
    ResultsError
        There are no fields, or none of this engine, or a file cannot be written.
    """
    table = results["fields"]
    engine = table["engine"].iloc[0] if engine is None else engine
    rows = table[table["engine"] == engine]
    if rows.empty:
        raise ResultsError(f"{results.folder}: no fields of {engine!r}; there are some of: {', '.join(table['engine'].unique())}")
    # Groups by both ends, because the window of the steady state may share its end with a listed window.
    windows: list[tuple[Any, pd.DataFrame]] = list(rows.groupby(["window_start", "window_end"]))
    windows.sort(key=lambda one: sum(one[0]))
    images = ((0.5 * float(start + end), image(results, window)) for (start, end), window in windows)
    return write_series(folder, "fields", ".vti", images, f"fields-{engine}")


def write_series(folder: str | os.PathLike[str], name: str, ending: str, texts: Iterable[tuple[float, str]], stem: str | None = None) -> Path:
    """Writes files ``STEM-0``, ... as they are made, and finally ``NAME.pvd`` with their times."""
    folder = given.path("folder", folder, ResultsError)
    collection = folder / f"{name}.pvd"
    sets = []
    for number, (time, text) in enumerate(texts):
        make_folder(folder)
        file = f"{stem or name}-{number}{ending}"
        write_text(folder / file, text)
        sets.append(f'<DataSet timestep="{time!r}" file={quoteattr(file)}/>\n')
    if not sets:
        raise ResultsError(f"{collection}: there is no snapshot to write; allowed: one or more")
    write_text(collection, document("Collection", "".join(sets)))
    return collection


def make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultsError(f"{folder}: cannot be made: {error}; allowed: a folder") from error


def placed(path: Path, frames: Iterable[Snapshot | Gas]) -> Iterator[Snapshot]:
    """Yields snapshots, and refuses those without positions."""
    for one in map(snapshot_of, frames):
        if one.positions is None:
            raise ResultsError(f"{path}.pvd: particles have no positions; allowed: a gas in a box")
        yield one


def points(one: Snapshot) -> str:
    """Formats particles as an unstructured grid of cells of a single point."""
    number = np.arange(len(one))
    columns: dict[str, ArrayLike] = {"id": number}
    known = one.arrays()
    for name, column in COLUMNS.items():
        if name in known:
            columns[column] = 2.0 * known[name] if name == "radii" else known[name]
    cells: dict[str, ArrayLike] = {"connectivity": number, "offsets": number + 1, "types": np.full(len(one), VERTEX, dtype=np.uint8)}
    piece = (
        f'<Piece NumberOfPoints="{len(one)}" NumberOfCells="{len(one)}">\n<Points>\n{data_array("points", one.arrays()["positions"])}</Points>\n'
        f"<Cells>\n{data_arrays(cells)}</Cells>\n<PointData>\n{data_arrays(columns)}</PointData>\n</Piece>\n"
    )
    whole: dict[str, ArrayLike] = {"TimeValue": [one.time], "box": [one.box], "periodic": [[int(is_) for is_ in one.periodic]]}
    about = data_arrays(whole, ' NumberOfTuples="1"')
    return document("UnstructuredGrid", f"<FieldData>\n{about}</FieldData>\n{piece}")


def image(results: Results, window: pd.DataFrame) -> str:
    """Formats the fields of a window as an image of cells."""
    keys = ["engine", "window_start", "window_end", "x", "y"]
    names = [name for name in window.columns if name not in keys and window[name].dtype.kind in "fi"]
    x, y = np.unique(window["x"]).tolist(), np.unique(window["y"]).tolist()
    if len(window) != len(x) * len(y):
        raise ResultsError(f"{results.folder}: {len(window)} rows of fields for {len(x)} x {len(y)} cells; allowed: one each")
    steps = [side[1] - side[0] if len(side) > 1 else 1.0 for side in (x, y)]
    window = window.sort_values(["y", "x"])
    extent = f'Extent="0 {len(x)} 0 {len(y)} 0 0"'
    place = f'Origin="{x[0] - 0.5 * steps[0]!r} {y[0] - 0.5 * steps[1]!r} 0" Spacing="{steps[0]!r} {steps[1]!r} 1"'
    arrays = data_arrays({name: window[name].to_numpy(dtype=float) for name in names})
    return document("ImageData", f"<Piece {extent}>\n<CellData>\n{arrays}</CellData>\n</Piece>\n", f" Whole{extent} {place}")


def document(kind: str, content: str, attributes: str = "") -> str:
    """Formats a file of VTK's XML format."""
    head = f'<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
    return f'<?xml version="1.0"?>\n{head}\n<{kind}{attributes}>\n{content}</{kind}>\n</VTKFile>\n'


def data_arrays(columns: Mapping[str, ArrayLike], attributes: str = "") -> str:
    return "".join(data_array(name, values, attributes) for name, values in columns.items())


def data_array(name: str, values: ArrayLike, attributes: str = "") -> str:
    """Formats numbers, or rows of numbers, in base64 with a leading count of bytes."""
    array = np.asarray(values)
    kind, code = TYPES[array.dtype.kind]
    if array.ndim == 2:
        attributes += f' NumberOfComponents="{array.shape[1]}"'
    data = array.astype(code).tobytes()
    text = base64.b64encode(struct.pack("<Q", len(data)) + data).decode("ascii")
    return f'<DataArray type="{kind}" Name={quoteattr(name)} format="binary"{attributes}>{text}</DataArray>\n'
