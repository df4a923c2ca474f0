"""Snapshots: all particles at one time, and their files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from .errors import ResultsError
from .gas import Gas
from .writing import optional

__all__ = ["Snapshot"]

ARRAYS = ("positions", "velocities", "radii", "masses", "spins", "species", "weights")


@dataclass(frozen=True)
class Snapshot:
    """All particles at one time, in the units of the case.

    Arrays that the case does not ask for are None.

    Attributes
    ----------
    engine : str
        Name of the engine.
    time : float
        Time of the snapshot, in the unit of time of the case, as in tables.
    box : tuple of three floats
        Sides of the box [length]; in the plane the third is a thickness for programs that need one.
    periodic : tuple of three bools
        Periodicity of the box, by axis.
    positions, velocities : ndarray or None
        Positions [length] and velocities [length/time], shape (number, 3); in the plane the third component is zero. Gases without
        positions have None.
    radii, masses : ndarray or None
        Radii [length] and masses, shape (number,).
    spins : ndarray or None
        Angular velocities [1/time], shape (number, 3); None for particles that do not spin.
    species : ndarray or None
        Numbers of the species, from 0, shape (number,); None if there is one species.
    weights : ndarray or None
        Number of particles for each simulator, shape (number,); None if all weights are equal.
    replica : int
        Number of the replica, from 0.
    shear_offset : float
        Displacement of the box above along x in a shear flow, from 0 to the width of the box [length].
    """

    engine: str
    time: float
    box: tuple[float, ...]
    periodic: tuple[bool, ...]
    positions: NDArray[np.float64] | None
    velocities: NDArray[np.float64] | None
    radii: NDArray[np.float64] | None
    masses: NDArray[np.float64] | None
    spins: NDArray[np.float64] | None = None
    species: NDArray[np.int64] | None = None
    weights: NDArray[np.float64] | None = None
    replica: int = 0
    shear_offset: float = 0.0

    def __len__(self) -> int:
        return next((len(array) for array in self.arrays().values()), 0)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays that are not None, by name."""
        all_ = {name: getattr(self, name) for name in ARRAYS}
        return {name: array for name, array in all_.items() if array is not None}


def snapshot_of(gas: Gas | Snapshot) -> Snapshot:
    """Converts a gas to a snapshot."""
    if isinstance(gas, Snapshot):
        return gas
    if not isinstance(gas, Gas):
        raise ResultsError(f"{gas!r} is no snapshot; allowed: a Snapshot, or a Gas such as that of engine.state()")
    spins, species, weights = gas.spins, gas.species, gas.weights
    turns = gas._description["tangential_restitution"] is not None or np.any(spins)
    in_plane = gas.dimension == 2
    flat = np.zeros(len(gas))

    def in_space(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.column_stack([vectors, flat]) if in_plane else np.asarray(vectors)

    return Snapshot(
        engine="",
        time=gas.time,
        box=(*gas.box, 1.0) if gas.box and in_plane else gas.box,
        periodic=(*gas.periodic, False) if gas.box and in_plane else gas.periodic,
        positions=in_space(gas.positions) if gas.box else None,
        velocities=in_space(gas.velocities),
        radii=np.asarray(gas.radii),
        masses=np.asarray(gas.masses),
        spins=(np.column_stack([flat, flat, spins]) if in_plane else spins) if turns else None,
        species=species if np.any(species) else None,
        weights=weights if np.any(weights != weights[:1]) else None,
        shear_offset=gas.shear_offset,
    )


def read_snapshot(path: Path, about: Mapping[str, Any]) -> Snapshot:
    """Reads a snapshot of a manifest: extended XYZ, a dump of LAMMPS, GSD, H5MD, or CSV of a gas without positions."""
    engine, time, replica = about["engine"], about["time"], about.get("replica", 0)
    box, shear_offset, periodic, parts = READERS[path.suffix](path)
    kinds = parts.get("type")
    return Snapshot(
        engine=engine,
        time=time,
        replica=replica,
        box=box,
        periodic=periodic,
        positions=parts.get("pos"),
        velocities=parts.get("velo"),
        radii=parts.get("radius"),
        masses=parts.get("mass"),
        spins=parts.get("angular_velocity"),
        species=None if kinds is None else kinds.astype(np.int64),
        weights=parts.get("weight"),
        shear_offset=shear_offset,
    )


Contents = tuple[tuple[float, ...], float, tuple[bool, ...], dict[str, NDArray[np.float64]]]
"""Box, displacement of the box above, periodicity by axis, and columns by their names in extended XYZ."""


def read_xyz(path: Path) -> Contents:
    """Reads extended XYZ."""
    with open(path, encoding="utf-8") as file:
        number, header = int(file.readline()), file.readline()
        names, widths = columns_of(field(header, "Properties"))
        rows = pd.read_csv(file, sep=" ", header=None, nrows=number).to_numpy(dtype=np.float64).reshape(number, -1)
    starts = np.cumsum([0, *widths])
    parts = {name: rows[:, start] if width == 1 else rows[:, start : start + width] for name, start, width in zip(names, starts, widths)}
    lattice = np.array(field(header, "Lattice").split(), dtype=np.float64)
    periodic = (field(header, "pbc") or "T T T").split()
    return tuple(lattice[[0, 4, 8]].tolist()), float(lattice[3]), tuple(one == "T" for one in periodic), parts


def read_csv(path: Path) -> Contents:
    """Reads CSV of a gas without positions."""
    table = pd.read_csv(path, dtype=np.float64)
    names = {"velocity": "velo", "species": "type"}
    parts: dict[str, NDArray[np.float64]] = {}
    for name in table.columns:
        quantity, is_vector = name.removesuffix("_x"), name.endswith("_x")
        if is_vector:
            parts[names.get(quantity, quantity)] = table[[f"{quantity}_{axis}" for axis in "xyz"]].to_numpy()
        elif not name.endswith(("_y", "_z")):
            parts[names.get(name, name)] = table[name].to_numpy()
    return (), 0.0, (), parts


def read_dump(path: Path) -> Contents:
    """Reads a text dump of LAMMPS as runs write it."""
    with open(path, encoding="utf-8") as file:
        bounds = np.zeros((3, 3))
        faces: list[str] = []
        columns: list[str] = []
        while not columns:
            item = file.readline().split()[1:]
            if item[:2] == ["BOX", "BOUNDS"]:
                faces = item[-3:]
                for axis in range(3):
                    row = np.array(file.readline().split(), dtype=np.float64)
                    bounds[axis, : len(row)] = row
            elif item[0] == "ATOMS":
                columns = item[1:]
            else:
                file.readline()
        rows = pd.read_csv(file, sep=" ", names=columns, dtype=np.float64)
    tilt = bounds[0, 2]
    bounds[0, :2] -= min(tilt, 0.0), max(tilt, 0.0)
    sides = bounds[:, 1] - bounds[:, 0]
    vectors = {"pos": "xyz", "velo": ("vx", "vy", "vz"), "angular_velocity": ("omegax", "omegay", "omegaz")}
    parts = {name: rows[list(names)].to_numpy() for name, names in vectors.items() if names[0] in rows}
    parts |= {name: rows[name].to_numpy() for name in ("radius", "mass", "weight") if name in rows}
    # Types of LAMMPS are counted from 1, and one type tells nothing.
    if (rows["type"] > 1).any():
        parts["type"] = rows["type"].to_numpy() - 1
    return tuple(sides.tolist()), float(tilt % sides[0]), tuple(one == "pp" for one in faces), parts


def read_gsd(path: Path) -> Contents:
    """Reads GSD as runs write it, in single precision."""
    hoomd = optional("gsd.hoomd", "files .gsd")
    with hoomd.open(name=str(path), mode="r") as file:
        frame = file[0]
    sides, (xy, _, _) = frame.configuration.box[:3].astype(np.float64), frame.configuration.box[3:].astype(np.float64)
    tilt, particles, flat = xy * sides[1], frame.particles, frame.configuration.dimensions == 2
    parts = {"pos": particles.position + 0.5 * (sides + [tilt, 0, 0])}
    # A quantity that the file leaves out has its default in all particles: a velocity of zero is that of no gas.
    if np.any(particles.velocity):
        parts["velo"] = particles.velocity
    parts |= {"radius": 0.5 * particles.diameter, "mass": particles.mass}
    if np.any(particles.typeid):
        parts["type"] = particles.typeid
    parts |= {name.removeprefix("particles/"): array for name, array in frame.log.items() if name.startswith("particles/")}
    if flat:
        sides[2] = particles.diameter.mean()
    periodic = tuple(bool(one) for one in frame.log["periodic"])
    exact = {name: np.asarray(array, dtype=np.float64) for name, array in parts.items()}
    return tuple(sides.tolist()), float(tilt % sides[0]), periodic, exact


def read_h5md(path: Path) -> Contents:
    """Reads H5MD as runs write it."""
    h5py = optional("h5py", "files .h5")
    names = {"position": "pos", "velocity": "velo", "species": "type"}
    with h5py.File(path, "r") as file:
        group = file["particles/all"]
        elements = {name: element for name, element in group.items() if name != "box"}
        arrays = {name: element["value"][0] if "value" in element else element[:] for name, element in elements.items()}
        edges, boundary = group["box/edges/value"][0], group["box"].attrs["boundary"]
    lattice = edges if edges.ndim == 2 else np.diag(edges)
    periodic = tuple(bytes(one) == b"periodic" for one in boundary)
    parts = {names.get(name, name): np.asarray(array, dtype=np.float64) for name, array in arrays.items()}
    sides = np.diag(lattice)
    return tuple(sides.tolist()), float(lattice[1, 0] % sides[0]), periodic, parts


READERS = {".csv": read_csv, ".xyz": read_xyz, ".dump": read_dump, ".h5": read_h5md, ".gsd": read_gsd}
"""Readers of the snapshots of runs, by the ending, those with all digits first."""


def field(header: str, name: str) -> str:
    """Returns the value of a key in the second line of an extended XYZ file; empty if the key is absent."""
    _, found, rest = f" {header}".partition(f" {name}=")
    if not found:
        return ""
    return rest[1:].split('"', 1)[0] if rest.startswith('"') else rest.split(maxsplit=1)[0]


def columns_of(properties: str) -> tuple[list[str], list[int]]:
    """Splits the property list of an extended XYZ file into names and widths of columns."""
    parts = properties.split(":")
    return parts[::3], [int(width) for width in parts[2::3]]
