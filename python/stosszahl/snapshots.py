"""Snapshots: all particles at one time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from .gas import Gas

__all__ = ["Snapshot"]


@dataclass(frozen=True)
class Snapshot:
    """All particles at one time, in the units of the case.

    Attributes
    ----------
    engine : str
        Name of the engine.
    time : float
        In the unit of time of the case, as tables have it.
    box : tuple of three floats
        Sides of the box [length]; in the plane the third is a thickness for programs that want one.
    periodic : tuple of three bools
        Whether the box is periodic, by axis.
    positions, velocities : ndarray
        [length], [length/time], shape (number, 3); in the plane the third component is zero.
    radii, masses : ndarray
        Shape (number,).
    spins : ndarray or None
        Angular velocities [1/time], shape (number, 3); none for grains that do not spin.
    species : ndarray or None
        Numbers of the species, from 0, shape (number,); none where all are of one.
    """

    engine: str
    time: float
    box: tuple[float, ...]
    periodic: tuple[bool, ...]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    radii: NDArray[np.float64]
    masses: NDArray[np.float64]
    spins: NDArray[np.float64] | None = None
    species: NDArray[np.int64] | None = None

    def __len__(self) -> int:
        return len(self.positions)


def snapshot_of(gas: Gas | Snapshot) -> Snapshot:
    """A gas of disks as a snapshot."""
    if isinstance(gas, Snapshot):
        return gas
    flat = np.zeros(len(gas))
    spins, species = gas.spins, gas.species
    turns = gas._description["tangential_restitution"] is not None or np.any(spins)
    return Snapshot(
        engine="",
        time=gas.time,
        box=(*gas.box, 1.0),
        periodic=(*gas.periodic, False),
        positions=np.column_stack([gas.positions, flat]),
        velocities=np.column_stack([gas.velocities, flat]),
        radii=np.asarray(gas.radii),
        masses=np.asarray(gas.masses),
        spins=np.column_stack([flat, flat, spins]) if turns else None,
        species=species if np.any(species) else None,
    )


def read_snapshot(path: Path, engine: str, time: float) -> Snapshot:
    """Reads a snapshot in extended XYZ."""
    with open(path, encoding="utf-8") as file:
        number, header = int(file.readline()), file.readline()
        names, widths = columns_of(field(header, "Properties"))
        rows = pd.read_csv(file, sep=" ", header=None, nrows=number).to_numpy(dtype=np.float64).reshape(number, -1)
    starts = np.cumsum([0, *widths])
    parts = {name: rows[:, start : start + width] for name, start, width in zip(names, starts, widths)}
    lattice = np.array(field(header, "Lattice").split(), dtype=np.float64)
    periodic = (field(header, "pbc") or "T T T").split()
    return Snapshot(
        engine=engine,
        time=time,
        box=tuple(lattice[[0, 4, 8]].tolist()),
        periodic=tuple(one == "T" for one in periodic),
        positions=parts["pos"],
        velocities=parts["velo"],
        radii=parts["radius"][:, 0],
        masses=parts["mass"][:, 0],
        spins=parts.get("angular_velocity"),
        species=parts["type"][:, 0].astype(np.int64) if "type" in parts else None,
    )


def field(header: str, name: str) -> str:
    """The value of a key of the second line of an extended XYZ file; empty if it is not there."""
    _, found, rest = f" {header}".partition(f" {name}=")
    if not found:
        return ""
    return rest[1:].split('"', 1)[0] if rest.startswith('"') else rest.split(maxsplit=1)[0]


def columns_of(properties: str) -> tuple[list[str], list[int]]:
    """Names and widths of the columns of an extended XYZ file."""
    parts = properties.split(":")
    return parts[::3], [int(width) for width in parts[2::3]]
