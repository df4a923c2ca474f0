"""Gases: particles, box and contact laws, and the state at one time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native, given
from .errors import GasError

__all__ = ["DeltaModel", "Gas", "Restitution", "ThresholdModel", "Viscoelastic", "Wall"]

AXES = {"x": 0, "y": 1}


@dataclass(frozen=True)
class Wall:
    """Plane wall at a face of the box.

    Parameters
    ----------
    restitution : float
        Normal velocity after a contact over that before, 0 to 1.
    slip : float
        Tangential velocity of the contact after it over that before, -1 to 1.
    temperature : float, optional
        Temperature of a diffuse wall, which particles leave with the flux of a Maxwellian [energy].
    sliding : (float, float)
        Velocity of the wall along itself [length/time].
    vibration : (float, float), optional
        Amplitude [length] and period [time] of the vibration of the wall.
    """

    restitution: float = 1.0
    slip: float = 1.0
    temperature: float | None = None
    sliding: tuple[float, float] = (0.0, 0.0)
    vibration: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name in ("restitution", "slip"):
            object.__setattr__(self, name, given.number(f"{name} of a wall", getattr(self, name)))
        if self.temperature is not None:
            object.__setattr__(self, "temperature", given.number("temperature of a wall", self.temperature))
        object.__setattr__(self, "sliding", given.pair("sliding of a wall", self.sliding))
        if self.vibration is not None:
            object.__setattr__(self, "vibration", given.pair("vibration of a wall", self.vibration))


@dataclass(frozen=True)
class DeltaModel:
    """Contacts that dissipate and heat: a normal approach speed g becomes ``coefficient * g + 2 * delta``.

    Brito, Risso & Soto, Physical Review E 87, 022209 (2013).

    Parameters
    ----------
    coefficient : float
        Share of the approach speed that is kept, 0 to 1.
    delta : float
        Speed Delta [length/time]; a contact adds twice this to the normal speed of separation.
    """

    coefficient: float
    delta: float

    def __post_init__(self) -> None:
        checked(self, "coefficient", "delta")


@dataclass(frozen=True)
class ThresholdModel:
    """Contacts that dissipate above a threshold of the normal approach speed alone; slower ones are elastic.

    Ben-Naim, Chen, Doolen & Redner, Physical Review Letters 83, 4069 (1999).

    Parameters
    ----------
    coefficient : float
        Share of the approach speed that is kept, 0 to 1.
    elastic_below : float
        Threshold of the approach speed [length/time].
    """

    coefficient: float
    elastic_below: float

    def __post_init__(self) -> None:
        checked(self, "coefficient", "elastic_below")


@dataclass(frozen=True)
class Viscoelastic:
    """Restitution of viscoelastic spheres, which falls with the approach speed.

    Parameters
    ----------
    strength : float
        Strength of the dissipation [speed^(-1/10)].
    """

    strength: float

    def __post_init__(self) -> None:
        checked(self, "strength")


Restitution = DeltaModel | ThresholdModel | Viscoelastic
"""Laws of normal restitution, in place of a constant coefficient."""


def checked(law: Any, *names: str) -> None:
    """Makes attributes of a frozen law numbers."""
    for name in names:
        object.__setattr__(law, name, given.number(name, getattr(law, name)))


def numbers(data: bytearray, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Wraps bytes as a read-only array of numbers, without a copy; the caller must own the bytes."""
    array = np.frombuffer(data, dtype=np.float64).reshape(shape)
    array.setflags(write=False)
    return array


class HasParticles:
    """Columns of all particles, in the order of their indices.

    Arrays are read-only copies, made at each access.
    """

    _handle: _native.Gas | _native.Engine
    dimension: int

    def __len__(self) -> int:
        return self._handle.count()

    def _vectors(self, name: str) -> NDArray[np.float64]:
        return numbers(self._handle.column(name), (-1, self.dimension))

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions [length], shape (number, 2), inside the box."""
        if self.dimension == 3:
            raise GasError("positions of spheres without positions; use Gas.disks, or a case for spheres in a box")
        return self._vectors("positions")

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities [length/time], shape (number, dimension)."""
        return self._vectors("velocities")

    @property
    def spins(self) -> NDArray[np.float64]:
        """Angular velocities [1/time], shape (number,) for disks; zero for smooth particles."""
        shape = (-1,) if self.dimension == 2 else (-1, 3)
        return numbers(self._handle.column("spins"), shape)

    @property
    def radii(self) -> NDArray[np.float64]:
        """Radii [length], shape (number,)."""
        return numbers(self._handle.column("radii"), (-1,))

    @property
    def masses(self) -> NDArray[np.float64]:
        """Masses, shape (number,)."""
        return numbers(self._handle.column("masses"), (-1,))

    @property
    def weights(self) -> NDArray[np.float64]:
        """Number of particles for each simulator, shape (number,); 1 in exact dynamics."""
        return numbers(self._handle.column("weights"), (-1,))

    @property
    def species(self) -> NDArray[np.int64]:
        """Numbers of the species, from 0, shape (number,)."""
        return np.frombuffer(self._handle.column("species"), dtype=np.int64)

    @property
    def temperature(self) -> float:
        """Granular temperature T = <m v^2>/dimension [energy]."""
        return self._handle.temperature()


class Gas(HasParticles):
    """Gas: its physics, and all particles at one time; the input and output of engines.

    Gases are made by :meth:`disks` or :meth:`spheres`, and can be pickled, copied and sent to other processes.

    Units: the first diameter, the first mass and the temperature of the start are one unless set otherwise; times are
    then in d sqrt(m/T).
    """

    _handle: _native.Gas

    def __init__(
        self, description: Mapping[str, Any], start: Mapping[str, Any] | None = None, *, handle: _native.Gas | None = None
    ) -> None:
        self._description = dict(description)
        self._handle = handle if handle is not None else _native.Gas(self._description, start)
        self.dimension: int = self._description["dimension"]

    @classmethod
    def disks(
        cls,
        number: int,
        *,
        packing_fraction: float | None = None,
        box_size: tuple[float, float] | None = None,
        restitution: float | Restitution = 1.0,
        tangential_restitution: float | None = None,
        species: Sequence[tuple[int, float, float]] = (),
        walls: Mapping[str, tuple[Wall | str, Wall | str]] | None = None,
        gravity: tuple[float, float] | None = None,
        shear_rate: float | None = None,
        contact_time: float = 0.0,
        temperature: float = 1.0,
        seed: int = 1,
        replica: int = 0,
        positions: ArrayLike | None = None,
        velocities: ArrayLike | None = None,
        spins: ArrayLike | None = None,
    ) -> Gas:
        """Hard disks of radius 0.5 and mass 1 at random places, with Maxwellian velocities.

        From packing 0.45 on the disks are placed on a lattice, to be melted by :meth:`EventDriven.equilibrate`.

        Parameters
        ----------
        number : int
            Number of disks of the first species.
        packing_fraction : float, optional
            Covered share of a square box; 0.1 unless this or a box size is given.
        box_size : (float, float), optional
            Sides of the box [length].
        restitution : float, Viscoelastic, DeltaModel or ThresholdModel
            Coefficient of normal restitution, 0 to 1, or a law.
        tangential_restitution : float, optional
            Coefficient of tangential restitution, -1 (smooth) to 1 (perfectly rough); with it disks spin.
        species : sequence of (number, radius, mass)
            Further species of disks.
        walls : dict, optional
            Faces by axis, lower and upper: ``{"y": (Wall(), Wall(temperature=2))}``. The word ``"open"`` in place of a wall
            lets particles out (Monte Carlo only).
        gravity : (float, float), optional
            Uniform acceleration [length/time^2].
        shear_rate : float, optional
            Rate a of a uniform shear flow u = (a y, 0) between Lees-Edwards boundaries [1/time], not zero. Velocities and the
            temperature are then peculiar: relative to the flow. The box is periodic and without gravity.
        contact_time : float
            Duration of a contact in exact dynamics [time]: contacts of disks within this time after their last contact are
            elastic, which prevents inelastic collapse (TC model; Luding & McNamara, Granular Matter 1, 113 (1998)).
        temperature : float
            Granular temperature of the start [energy].
        seed, replica : int
            Seed and number of the replica; equal numbers give equal bytes.
        positions, velocities : array_like, optional
            Custom initial positions [length] and velocities [length/time], shapes (number, 2); they need `box_size`. Along periodic
            axes positions are wrapped into the box; between walls they must be inside. Disks of several species come one species
            after the other. Engines refuse disks that overlap.
        spins : array_like, optional
            Custom initial angular velocities [1/time], shape (number,).

        Raises
        ------
        GasError
            A number is out of range, or disks find no place.
        """
        description = describe(
            2, number, species, packing_fraction, restitution, temperature, seed, replica,
            box_size=None if box_size is None else given.pair("box_size", box_size),
            tangential_restitution=optional_number("tangential_restitution", tangential_restitution),
            walls=[(axis_of(axis), faces_of(axis, faces)) for axis, faces in walls_of(walls).items()],
            gravity=None if gravity is None else given.pair("gravity", gravity),
            shear_rate=optional_number("shear_rate", shear_rate),
            contact_time=given.number("contact_time", contact_time),
        )
        if positions is None:
            if velocities is not None or spins is not None:
                raise GasError("velocities or spins without positions; allowed: positions, box_size and these, or none of them")
            return cls(description)
        if box_size is None:
            raise GasError("positions without a box; allowed: box_size=(x, y) beside them")
        places = given.vectors("positions", positions, (None, 2))
        count = counted(description)
        if len(places) != count:
            raise GasError(f"positions are {len(places)} in a gas of {count} disks; allowed: one for each disk")
        moves = given.vectors("velocities", np.zeros_like(places) if velocities is None else velocities, (count, 2))
        turns = given.vectors("spins", np.zeros(count) if spins is None else spins, (count,))
        box = description["box_size"]
        periodic = [all(face == "periodic" for face in dict(description["walls"]).get(axis, ["periodic"])) for axis in (0, 1)]
        return cls(description, start_of(0.0, (*box, 0.0), (*periodic, True), places, moves, turns, np.ones(count)))

    @classmethod
    def spheres(
        cls,
        number: int,
        *,
        packing_fraction: float | None = None,
        restitution: float | Restitution = 1.0,
        species: Sequence[tuple[int, float, float]] = (),
        temperature: float = 1.0,
        seed: int = 1,
        replica: int = 0,
    ) -> Gas:
        """Hard spheres without positions, for :class:`MonteCarlo`, which draws their velocities.

        Parameters are those of :meth:`disks`.
        """
        return cls(describe(3, number, species, packing_fraction, restitution, temperature, seed, replica))

    def with_velocities(self, velocities: ArrayLike) -> Gas:
        """This gas with custom velocities [length/time], shape (number, dimension)."""
        moves = given.vectors("velocities", velocities, (len(self), self.dimension))
        return Gas(self._described(), {**self._start(), "velocities": moves.tobytes()})

    @property
    def time(self) -> float:
        """Time of the state [time]."""
        return self._handle.frame()[0]

    @property
    def box(self) -> tuple[float, ...]:
        """Sides of the box [length]; empty without positions."""
        lengths = self._handle.frame()[1]
        return tuple(lengths[: self.dimension]) if lengths[0] > 0.0 else ()

    @property
    def periodic(self) -> tuple[bool, ...]:
        """Periodicity of the box, by axis."""
        return tuple(self._handle.frame()[2][: self.dimension])

    @property
    def volume(self) -> float:
        """Volume of the box [length^3]; in the plane its area [length^2]."""
        return self._handle.volume()

    @property
    def shear_offset(self) -> float:
        """Displacement of the box above along x in a shear flow, from 0 to the width of the box [length]; 0 without a flow."""
        return self._handle.shear_offset()

    @property
    def haff_time(self) -> float | None:
        """Haff's cooling time t0 = 2 D/((1 - r^2) w) [time], w Enskog's collision rate per particle.

        Infinite if nothing is lost; ``None`` for gases of several species, with another law or in a shear flow. Brilliantov & Pöschel,
        *Kinetic Theory of Granular Gases* (Oxford 2004).
        """
        return self._handle.haff_time()

    def __repr__(self) -> str:
        kind = "disks" if self.dimension == 2 else "spheres"
        return f"<Gas of {len(self)} {kind} at time {self.time:g}, temperature {self.temperature:.4g}>"

    def _start(self) -> dict[str, Any]:
        time, lengths, periodic = self._handle.frame()
        columns = {name: bytes(self._handle.column(name)) for name in ("positions", "velocities", "spins", "weights")}
        return {"time": time, "lengths": lengths, "periodic": periodic, **columns}

    def __reduce__(self) -> tuple[type[Gas], tuple[dict[str, Any], dict[str, Any]]]:
        return Gas, (self._described(), self._start())

    def _described(self) -> dict[str, Any]:
        """Description with the current number of particles of each species; some may have left through open faces."""
        first, *further = np.bincount(self.species, minlength=1 + len(self._description["species"])).tolist()
        species = [(count, *one[1:]) for count, one in zip(further, self._description["species"])]
        return {**self._description, "number": first, "species": species}


def describe(
    dimension: int,
    number: float,
    species: Iterable[Iterable[float]],
    packing_fraction: float | None,
    restitution: float | Restitution,
    temperature: float,
    seed: int,
    replica: int,
    **further: Any,
) -> dict[str, Any]:
    """Description from which :class:`_native.Gas` is made, with checked numbers."""
    is_law = isinstance(restitution, (DeltaModel, ThresholdModel, Viscoelastic))
    return {
        "dimension": dimension,
        "number": given.whole("number", number),
        "species": species_of(species),
        "packing_fraction": optional_number("packing_fraction", packing_fraction),
        "box_size": None,
        "restitution": restitution if is_law else given.number("restitution", restitution),
        "tangential_restitution": None,
        "walls": [],
        "gravity": None,
        "shear_rate": None,
        "contact_time": 0.0,
        "temperature": given.number("temperature", temperature),
        "seed": given.whole("seed", seed),
        "replica": given.whole("replica", replica),
        **further,
    }


def optional_number(name: str, value: Any) -> float | None:
    return None if value is None else given.number(name, value)


def species_of(species: Iterable[Iterable[float]]) -> list[tuple[int, float, float]]:
    try:
        rows = [(count, radius, mass) for count, radius, mass in species]
    except (TypeError, ValueError):
        raise GasError(f"species are {species!r}; allowed: a list of (number, radius, mass)") from None
    return [
        (given.whole("number of a species", count), given.number("radius", radius), given.number("mass", mass))
        for count, radius, mass in rows
    ]


def counted(description: Mapping[str, Any]) -> int:
    """Number of particles of all species."""
    further: list[tuple[int, float, float]] = description["species"]
    return int(description["number"]) + sum(count for count, *_ in further)


def walls_of(walls: Any) -> Mapping[str, Sequence[Wall | str]]:
    if walls is None or isinstance(walls, Mapping):
        return walls or {}
    raise GasError(f"walls are {walls!r}; allowed: a dictionary of faces by axis, such as {{'y': (Wall(), Wall())}}")


def axis_of(name: str) -> int:
    if name not in AXES:
        raise GasError(f"walls along {name!r}; allowed: 'x' and 'y'")
    return AXES[name]


def faces_of(axis: str, faces: Sequence[Wall | str]) -> list[Wall | str]:
    faces = [*faces] if isinstance(faces, Sequence) and not isinstance(faces, str) else [faces]
    if len(faces) != 2 or not all(isinstance(face, Wall) or face in ("open", "periodic") for face in faces):
        raise GasError(f"walls along {axis}: {faces}; allowed: a lower and an upper one, each a Wall, 'open' or 'periodic'")
    return faces


def start_of(
    time: float,
    lengths: Sequence[float],
    periodic: Sequence[bool],
    positions: NDArray[np.float64],
    velocities: NDArray[np.float64],
    spins: NDArray[np.float64],
    weights: NDArray[np.float64],
) -> dict[str, Any]:
    columns = {"positions": positions, "velocities": velocities, "spins": spins, "weights": weights}
    frame = {"time": time, "lengths": lengths, "periodic": periodic}
    return {**frame, **{name: column.tobytes() for name, column in columns.items()}}
