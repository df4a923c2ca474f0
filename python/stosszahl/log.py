"""Logs of collisions, and their files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import given
from .engines import COLLISION, impact_parameters
from .errors import ResultsError
from .writing import optional, replacing, writer_of

__all__ = ["CollisionLog"]

ROWS = 2**17
"""Number of collisions converted to columns at a time, so that a long log needs little further memory."""
ANONYMOUS = 2**32 - 1
"""Index in place of a partner where equal particles are not distinguished."""


class CollisionLog:
    """Observer that keeps collisions, up to a largest number.

    Parameters
    ----------
    most : int
        Largest number of collisions that are kept; later ones are only counted. A collision takes 120 bytes.
    """

    def __init__(self, most: int = 1_000_000) -> None:
        self.most = given.whole("most", most)
        self.seen = 0
        self._parts: list[NDArray[np.void]] = []

    def __len__(self) -> int:
        return min(self.seen, self.most)

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        return f"<CollisionLog of {len(self)} collisions, {self.seen} seen>"

    def __call__(self, batch: NDArray[np.void]) -> None:
        room = self.most - min(self.seen, self.most)
        if room > 0:
            self._parts.append(batch[:room].copy())
        self.seen += len(batch)

    @property
    def collisions(self) -> NDArray[np.void]:
        """Kept collisions, in order, as an array of the type :data:`COLLISION`."""
        return np.concatenate(self._parts) if self._parts else np.empty(0, dtype=COLLISION)

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Writes the kept collisions; the ending of the file decides the format.

        ============  ==============================================================================  ===========
        ending        holds                                                                           needs
        ============  ==============================================================================  ===========
        ``.npz``      one array for each field of :data:`COLLISION`, ``impact_parameter`` b/d,
                      ``relative_speed``, ``normal_speed`` (of approach), and the number ``seen``
        ``.parquet``  equal content in columns of numbers, by time: ``first`` and ``second``          ``pyarrow``
                      for the pair, ``x``, ``y``, ``z`` for vectors; ``seen`` is metadata
        ============  ==============================================================================  ===========

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ResultsError
            The ending is not known, or the file cannot be written.
        PackageError
            The package that the format needs is not installed.
        """
        path = given.path("path", path, ResultsError)
        write = writer_of(WRITERS, path)
        with replacing(path) as partial:
            write(partial, self)
        return path


def derived(collisions: NDArray[np.void]) -> dict[str, NDArray[np.float64]]:
    """Computes impact parameter b/d, relative speed, and normal approach speed."""
    relative, line = collisions["relative_velocity"], collisions["line"]
    along = np.einsum("ij,ij->i", relative, line) / np.linalg.norm(line, axis=1)
    return {
        "impact_parameter": impact_parameters(collisions),
        "relative_speed": np.linalg.norm(relative, axis=1),
        "normal_speed": -along,
    }


def write_npz(path: Path, log: CollisionLog) -> None:
    all_ = log.collisions
    columns: dict[str, Any] = {name: all_[name] for name in COLLISION.names or ()} | derived(all_)
    with open(path, "wb") as file:
        np.savez_compressed(file, seen=log.seen, **columns)


def flat(collisions: NDArray[np.void]) -> dict[str, NDArray[Any]]:
    """Converts collisions to columns of single numbers, as programs for tables need them."""
    pairs = {"first": collisions["pair"][:, 0], "second": collisions["pair"][:, 1]}
    kinds = {f"{which}_species": collisions["species"][:, number] for number, which in enumerate(pairs)}
    vectors = {
        f"{name}_{axis}": collisions[name][:, number]
        for name in ("position", "relative_velocity", "line")
        for number, axis in enumerate("xyz")
    }
    scalars = {name: collisions[name] for name in ("reduced_mass", "restitution", "weight")}
    return {"time": collisions["time"], **pairs, **derived(collisions), **kinds, **vectors, **scalars}


def write_parquet(path: Path, log: CollisionLog) -> None:
    arrow, parquet = optional("pyarrow", "files .parquet"), optional("pyarrow.parquet", "files .parquet")
    all_, file = log.collisions, None
    try:
        for start in range(0, max(len(all_), 1), ROWS):
            columns = flat(all_[start : start + ROWS])
            missing = {name: columns[name] == ANONYMOUS for name in ("first", "second")}
            table = arrow.table({name: arrow.array(column, mask=missing.get(name)) for name, column in columns.items()})
            table = table.replace_schema_metadata({"creator": "stosszahl", "seen": str(log.seen), "most": str(log.most)})
            file = file or parquet.ParquetWriter(path, table.schema, compression="zstd")
            file.write_table(table)
    finally:
        if file is not None:
            file.close()


WRITERS = {".npz": write_npz, ".parquet": write_parquet}
