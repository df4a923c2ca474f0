"""Trajectories, and their files for other programs: OVITO, ASE, freud, HOOMD-blue, MDAnalysis."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from . import given
from .engines import Engine
from .errors import ResultsError
from .gas import Gas
from .results import Results
from .snapshots import ARRAYS, Snapshot, snapshot_of
from .writing import optional, replacing, writer_of

__all__ = ["Trajectory", "trajectory"]


class Trajectory(Sequence[Snapshot]):
    """Sequence of snapshots in order of time.

    Parameters
    ----------
    snapshots : iterable of Snapshot or Gas
        Snapshots, in order of time.
    """

    def __init__(self, snapshots: Iterable[Snapshot | Gas]) -> None:
        self._all = [snapshot_of(one) for one in iterated("snapshots", snapshots)]

    def __len__(self) -> int:
        return len(self._all)

    @overload
    def __getitem__(self, index: int) -> Snapshot: ...
    @overload
    def __getitem__(self, index: slice) -> Trajectory: ...
    def __getitem__(self, index: int | slice) -> Snapshot | Trajectory:
        found = self._all[index]
        return Trajectory(found) if isinstance(found, list) else found

    def __iter__(self) -> Iterator[Snapshot]:
        return iter(self._all)

    def __repr__(self) -> str:
        span = f", times {self._all[0].time:g} to {self._all[-1].time:g}" if self._all else ""
        return f"<Trajectory of {len(self)} snapshots{span}>"

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Writes a file; its ending decides the format.

        ==========  =========================================================  =======================
        ending      format                                                     needs
        ==========  =========================================================  =======================
        ``.xyz``    extended XYZ: OVITO, ASE
        ``.dump``   text dump of LAMMPS: LAMMPS, OVITO, MDAnalysis
        ``.npz``    NumPy arrays: time, box, positions, velocities, ...
        ``.gsd``    GSD, schema hoomd: HOOMD-blue, OVITO, freud                ``gsd``
        ``.h5``     H5MD: MDAnalysis, pyh5md                                   ``h5py``
        ==========  =========================================================  =======================

        In the plane the box has a thickness of one for programs that need one, and is not periodic across it.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ResultsError
            There is no snapshot, the ending is unknown, snapshots differ in a quantity that is constant in the format, or the file
            cannot be written.
        PackageError
            The package that the format needs is not installed.
        """
        path = given.path("path", path, ResultsError)
        write = writer_of(WRITERS, path)
        if not self._all:
            raise ResultsError(f"{path}: there is no snapshot to write; allowed: one or more")
        if write is not write_npz:
            require_positions(path, self._all)
        with replacing(path) as partial:
            write(partial, self._all)
        return path


def trajectory(
    source: Engine | Results, times: Iterable[float] | None = None, engine: str | None = None, replica: int = 0
) -> Trajectory:
    """Returns the trajectory of an engine, which is advanced, or of one engine and replica of a results folder.

    Parameters
    ----------
    source : EventDriven, MonteCarlo or Results
        Engine to advance, or results of a run with snapshots.
    times : iterable of float
        Times of the snapshots [time]; for an engine only.
    engine : str, optional
        Engine of the results; by default the first that has snapshots.
    replica : int
        Number of the replica of the results, from 0.
    """
    if isinstance(source, Results):
        if times is not None:
            raise ResultsError("times of snapshots that are there already; allowed: none, and the case says when they are taken")
        names = list(dict.fromkeys(one.engine for one in source.snapshots))
        if not names or engine not in (None, *names):
            whose = f" of {engine!r}" if engine else ""
            raise ResultsError(f"{source.folder}: no snapshots{whose}; there are some of: {', '.join(names) or 'none'}")
        own = [one for one in source.snapshots if one.engine == (engine or names[0])]
        replicas = list(dict.fromkeys(one.replica for one in own))
        if replica not in replicas:
            raise ResultsError(f"{source.folder}: no snapshots of replica {replica}; there are some of: {', '.join(map(str, replicas))}")
        return Trajectory(one for one in own if one.replica == replica)
    if not isinstance(source, Engine):
        raise ResultsError(f"a trajectory of {source!r}; allowed: an engine, or Results")
    if times is None:
        raise ResultsError("a trajectory of an engine without times; allowed: times=[...]")
    moments = given.vectors("times", times if isinstance(times, np.ndarray) else [*iterated("times", times)], (None,)).tolist()

    def states() -> Iterator[Gas]:
        for time in moments:
            source.advance(time)
            yield source.state()

    return Trajectory(states())


def iterated(name: str, values: Any) -> Iterable[Any]:
    if isinstance(values, Iterable) and not isinstance(values, str | bytes):
        return values
    raise ResultsError(f"{name} are {values!r}; allowed: a list of numbers")


def require_positions(path: Path, all_: Iterable[Snapshot]) -> None:
    """Refuses gases without positions, which most formats cannot hold."""
    if any(one.positions is None for one in all_):
        raise ResultsError(f"{path}: particles have no positions; allowed: formats that need none, .npz")


PROPERTIES = {
    "velocities": "velo:R:3",
    "radii": "radius:R:1",
    "masses": "mass:R:1",
    "spins": "angular_velocity:R:3",
    # Type for OVITO, and an array for ASE; both take "species" for names of elements.
    "species": "type:I:1",
    "weights": "weight:R:1",
}
"""Properties of extended XYZ, by the name of the array."""


def named_columns(one: Snapshot, names: dict[str, str]) -> tuple[list[str], list[list[Any]]]:
    """Names and columns of the arrays of a snapshot that a format names."""
    named = [(names[name], array) for name, array in one.arrays().items() if name in names]
    return [name for name, _ in named], [column for _, array in named for column in np.atleast_2d(array.T).tolist()]


def write_xyz(path: Path, all_: list[Snapshot]) -> None:
    with open(path, "w", encoding="utf-8") as file:
        for one in all_:
            x, y, z = one.box
            names, own = named_columns(one, PROPERTIES)
            properties = ":".join(["id:I:1:pos:R:3", *names])
            columns = [np.arange(len(one)).tolist(), *one.arrays()["positions"].T.tolist(), *own]
            pbc = " ".join("T" if is_ else "F" for is_ in one.periodic)
            engine = f" Engine={one.engine}" if one.engine else ""
            slid = repr(one.shear_offset) if one.shear_offset else "0"
            file.write(f"{len(one)}\nLattice=\"{x!r} 0 0 {slid} {y!r} 0 0 0 {z!r}\" Properties={properties} pbc=\"{pbc}\" Time={one.time!r}{engine}\n")
            file.writelines(" ".join(map(repr, row)) + "\n" for row in zip(*columns))


DUMPED = {
    "velocities": "vx vy vz",
    "radii": "radius",
    "masses": "mass",
    "spins": "omegax omegay omegaz",
    "weights": "weight",
}
"""Columns of a dump of LAMMPS, by the name of the array."""


def tilt_of(one: Snapshot) -> float:
    """Tilt of the cell of a snapshot along x, at most half its width [length]; 0 without a shear flow."""
    width = one.box[0]
    return float(one.shear_offset - width * np.round(one.shear_offset / width))


def in_cell(one: Snapshot) -> NDArray[np.float64]:
    """Positions in the tilted cell of a snapshot, whose corner is at the origin [length]."""
    positions, tilt = one.arrays()["positions"], tilt_of(one)
    if not tilt:
        return positions
    moved = positions.copy()
    moved[:, 0] -= one.box[0] * np.floor((moved[:, 0] - tilt * moved[:, 1] / one.box[1]) / one.box[0])
    return moved


def write_dump(path: Path, all_: list[Snapshot]) -> None:
    with open(path, "w", encoding="utf-8") as file:
        for step, one in enumerate(all_):
            # Types of LAMMPS are counted from 1.
            types = np.ones(len(one), int) if one.species is None else one.species + 1
            names, own = named_columns(one, DUMPED)
            columns = [np.arange(1, len(one) + 1).tolist(), types.tolist(), *in_cell(one).T.tolist(), *own]
            atoms = " ".join(["id type x y z", *names])
            faces = " ".join("pp" if is_ else "ff" for is_ in one.periodic)
            bounds = "".join(f"0 {side!r}\n" for side in one.box)
            if tilt := tilt_of(one):
                x, y, z = one.box
                faces = f"xy xz yz {faces}"
                bounds = f"{min(tilt, 0.0)!r} {x + max(tilt, 0.0)!r} {tilt!r}\n0 {y!r} 0\n0 {z!r} 0\n"
            head = f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(one)}\n"
            file.write(f"{head}ITEM: BOX BOUNDS {faces}\n{bounds}ITEM: ATOMS {atoms}\n")
            file.writelines(" ".join(map(repr, row)) + "\n" for row in zip(*columns))


def alike(all_: list[Snapshot], what: str, of: Callable[[Snapshot], Any]) -> None:
    if any(not np.array_equal(of(one), of(all_[0])) for one in all_):
        raise ResultsError(f"snapshots differ in {what}; allowed in this format: the same in all of them")


def stacked(all_: list[Snapshot]) -> dict[str, Any]:
    """Stacks all snapshots to arrays with the time as first axis; the number of particles must be constant."""
    alike(all_, "the number of particles", len)
    arrays: dict[str, Any] = {
        "time": np.array([one.time for one in all_]),
        "box": np.array([one.box for one in all_]),
        "periodic": np.array(all_[0].periodic),
        "shear_offset": np.array([one.shear_offset for one in all_]),
    }
    for name in ARRAYS:
        own = [getattr(one, name) for one in all_]
        known = next((array for array in own if array is not None), None)
        if known is not None:
            # Defaults in snapshots without the array: particles without spin, of the first species, or of equal weight.
            arrays[name] = np.array([MISSING.get(name, np.nan) + np.zeros_like(known) if array is None else array for array in own])
    return arrays


MISSING = {"spins": 0, "species": 0, "weights": 1}
"""Values of quantities that a snapshot leaves out."""


def write_npz(path: Path, all_: list[Snapshot]) -> None:
    with open(path, "wb") as file:
        np.savez_compressed(file, **stacked(all_))


def write_gsd(path: Path, all_: list[Snapshot]) -> None:
    hoomd = optional("gsd.hoomd", "files .gsd")
    with hoomd.open(name=str(path), mode="w") as file:
        for step, one in enumerate(all_):
            frame = hoomd.Frame()
            sides, positions, tilt = np.array(one.box), in_cell(one), tilt_of(one)
            flat = not np.any(positions[:, 2]) and not one.periodic[2]
            frame.configuration.step = step
            frame.configuration.dimensions = 2 if flat else 3
            frame.configuration.box = [*sides[:2], 0.0 if flat else sides[2], tilt / sides[1], 0, 0]
            frame.particles.N = len(one)
            # Shift to the box of HOOMD, which is centred at the origin.
            frame.particles.position = positions - 0.5 * (sides * [1, 1, 0 if flat else 1] + [tilt, 0, 0])
            if one.velocities is not None:
                frame.particles.velocity = one.velocities
            if one.radii is not None:
                frame.particles.diameter = 2.0 * one.radii
            if one.masses is not None:
                frame.particles.mass = one.masses
            if one.species is not None:
                frame.particles.types = [str(number) for number in range(one.species.max() + 1)]
                frame.particles.typeid = one.species
            frame.log["time"] = np.array([one.time])
            # HOOMD takes all axes to be periodic.
            frame.log["periodic"] = np.array(one.periodic, dtype=np.uint8)
            if one.spins is not None:
                frame.log["particles/angular_velocity"] = one.spins
            if one.weights is not None:
                frame.log["particles/weight"] = one.weights
            file.append(frame)


def write_h5md(path: Path, all_: list[Snapshot]) -> None:
    from . import __version__

    h5py = optional("h5py", "files .h5")
    arrays = stacked(all_)
    # Arrays that must be equal in all snapshots, and are written once.
    constant = {"radii": "radius", "masses": "mass", "species": "species"}
    for name in constant:
        if name in arrays:
            alike(all_, name, attrgetter(name))
    steps = np.arange(len(all_))
    with h5py.File(path, "w") as file:
        head = file.create_group("h5md")
        head.attrs["version"] = np.array([1, 1])
        head.create_group("author").attrs["name"] = "stosszahl"
        creator = head.create_group("creator")
        creator.attrs["name"], creator.attrs["version"] = "stosszahl", __version__
        group = file.create_group("particles/all")
        first = None

        def series(place: Any, name: str, values: NDArray[Any]) -> None:
            nonlocal first
            element = place.create_group(name)
            element["value"] = values
            if first is None:
                element["step"], element["time"], first = steps, arrays["time"], element
            else:
                element["step"], element["time"] = first["step"], first["time"]

        moving = {"positions": "position", "velocities": "velocity", "spins": "angular_velocity", "weights": "weight"}
        for name, element in moving.items():
            if name in arrays:
                series(group, element, arrays[name])
        for name, element in constant.items():
            if name in arrays:
                group[element] = arrays[name][0]
        box = group.create_group("box")
        box.attrs["dimension"] = 3
        box.attrs["boundary"] = np.array(["periodic" if is_ else "none" for is_ in all_[0].periodic], dtype="S")
        edges = arrays["box"]
        if np.any(arrays["shear_offset"]):
            edges = edges[:, :, None] * np.eye(3)
            edges[:, 1, 0] = arrays["shear_offset"]
        series(box, "edges", edges)


WRITERS = {".xyz": write_xyz, ".dump": write_dump, ".npz": write_npz, ".gsd": write_gsd, ".h5": write_h5md}
