"""Engines that advance a gas, and observers of their collisions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native, given
from .errors import GasError
from .gas import Gas, HasParticles, numbers, optional_number

__all__ = ["COLLISION", "EventDriven", "ImpactParameters", "MonteCarlo", "impact_parameters"]

COLLISION = np.dtype(
    [
        ("time", np.float64),
        ("position", np.float64, 3),
        ("relative_velocity", np.float64, 3),
        ("line", np.float64, 3),
        ("reduced_mass", np.float64),
        ("restitution", np.float64),
        ("weight", np.float64),
        ("pair", np.uint32, 2),
        ("species", np.uint32, 2),
    ]
)
"""Type of one collision, as observers receive it.

=====================  ==============================================================================================
``time``               time of the collision [time]
``position``           position of the first partner [length], perhaps in another image of a periodic box
``relative_velocity``  velocity of the first partner less that of the second, before the collision [length/time]
``line``               line of centres, from the second to the first partner, of the length of their distance [length]
``reduced_mass``       m1 m2/(m1 + m2)
``restitution``        coefficient of normal restitution that acted
``weight``             number of physical collisions: 1 in exact dynamics
``pair``               indices of the partners; 2^32 - 1 where equal particles are not distinguished
``species``            species of the partners, from 0
=====================  ==============================================================================================

In the plane the third component of vectors is zero.
"""

Observer = Callable[[NDArray[np.void]], Any]


class ImpactParameters:
    """Observer of impact parameters b/d that runs in Rust, at no cost in Python.

    Under molecular chaos u = (b/d)^(dimension - 1) is uniform.

    Parameters
    ----------
    dimension : int
        2 for disks, 3 for spheres.
    bins : int
        Number of bins of u, of equal width.
    """

    def __init__(self, dimension: int = 2, bins: int = 20) -> None:
        self.dimension = given.whole("dimension", dimension, 2, 3)
        self._handle = _native.ImpactParameters(self.dimension, given.whole("bins", bins, 1, 10**6))

    def __len__(self) -> int:
        return self.collisions

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        slope = "" if self.slope is None else f", slope {self.slope:.4g}"
        return f"<ImpactParameters of {self.collisions} collisions{slope}>"

    @property
    def collisions(self) -> int:
        """Number of pair collisions seen."""
        return self._handle.collisions()

    @property
    def densities(self) -> NDArray[np.float64]:
        """Probability density of u in each bin, shape (bins,); 1 under molecular chaos."""
        return np.array(self._handle.densities())

    @property
    def slope(self) -> float | None:
        """Slope s of P(u) = 1 + s (u - 1/2): positive where grazing collisions are in excess. None without collisions."""
        return self._handle.slope()

    @property
    def slope_error(self) -> float | None:
        """Standard error of the slope if collisions are independent; those of one clustered gas are not."""
        return self._handle.slope_error()


def gas_of(start: Any) -> Gas:
    if isinstance(start, Gas):
        return start
    raise GasError(f"the start is {start!r}; allowed: a Gas, such as that of EventDriven.state()")


class Engine(HasParticles):
    """Engine with its gas: the common interface of :class:`EventDriven` and :class:`MonteCarlo`."""

    _handle: _native.Engine

    def __init__(self, gas: Gas, handle: _native.Engine) -> None:
        self._gas = gas
        self._handle = handle
        self.dimension = gas.dimension

    def advance(self, until: float, observer: Observer | ImpactParameters | None = None, *, batch: int = 4096) -> None:
        """Advances to a time.

        Other threads of Python run meanwhile. Ctrl-C stops it between two collisions or steps: the engine is then at a time
        before `until`, and the same call continues to the bytes of an advance without a stop. A second Ctrl-C, a second later or
        more, breaks off a long step; the engine then has no state.

        Parameters
        ----------
        until : float
            End time [time]: finite, and not before the current time.
        observer : callable or ImpactParameters, optional
            Function that receives all collisions in order, in read-only arrays of the type :data:`COLLISION`. It runs in this
            thread while the engine computes the next batch in another. An exception in it stops the engine as Ctrl-C does, when
            that batch is full or `until` is reached, so at a reproducible time.
        batch : int
            Number of collisions in an array; the last array may have fewer.

        Raises
        ------
        GasError
            The time is past or infinite, or so far that the gas would need years; or the gas cannot continue, as in inelastic
            collapse.
        """
        until, batch = given.number("until", until), given.whole("batch", batch, 1, 2**32)
        if observer is None:
            self._handle.advance(until, None, batch)
        elif isinstance(observer, ImpactParameters):
            self._handle.advance(until, observer._handle, batch)
        elif callable(observer):
            self._handle.advance(until, lambda data: observer(np.frombuffer(data, dtype=COLLISION)), batch)
        else:
            raise GasError(f"observer is {observer!r}; allowed: a function of an array of collisions, or ImpactParameters")

    def state(self) -> Gas:
        """Current gas, from which another engine can start, and which can be pickled."""
        return Gas(self._gas._description, handle=self._handle.state())

    @property
    def time(self) -> float:
        """Current time [time]."""
        return self._handle.time()

    @property
    def box(self) -> tuple[float, ...]:
        """Sides of the box [length]; empty without positions."""
        return self._gas.box

    @property
    def collisions(self) -> int:
        """Number of pair collisions so far; of simulators where simulators collide."""
        return self._handle.work()[0]

    @property
    def work(self) -> dict[str, float]:
        """Counts of work by name, such as predictions per collision; they do not depend on the machine."""
        return self._handle.work()[1]

    @property
    def boundaries(self) -> dict[str, dict[str, Any]]:
        """Transfer from each wall or opening to the gas so far, by its name.

        ``particles`` is the number that touched it (negative where they left), ``momentum`` has the shape (3,), and ``energy``
        is a number.
        """
        return {
            name: {"particles": particles, "momentum": np.array(momentum), "energy": energy}
            for name, particles, momentum, energy in self._handle.boundaries()
        }

    def kick(self, changes: ArrayLike) -> None:
        """Adds changes to all velocities [length/time], shape (number, dimension)."""
        changes = given.vectors("changes", changes, (len(self), self.dimension))
        if not np.isfinite(changes).all():
            raise GasError("changes of velocities are not finite; allowed: finite numbers")
        self._handle.kick(changes.tobytes())

    def scale_velocities(self, factor: float) -> None:
        """Multiplies all velocities by a positive factor."""
        self._handle.scale_velocities(given.number("factor", factor))

    def track_displacements(self) -> bool:
        """Starts to measure displacements; returns False if this engine cannot."""
        return self._handle.track_displacements()

    @property
    def displacements(self) -> NDArray[np.float64] | None:
        """Displacements since :meth:`track_displacements` [length], shape (number, dimension), across the edges of the box."""
        data = self._handle.displacements()
        return None if data is None else numbers(data, (-1, self.dimension))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {len(self)} particles at time {self.time:g}, {self.collisions} collisions>"


class EventDriven(Engine):
    """Exact event-driven dynamics of a gas of disks.

    Parameters
    ----------
    gas : Gas
        Initial state.

    Raises
    ------
    GasError
        The gas has no positions, or open faces, or disks that overlap.
    """

    def __init__(self, gas: Gas) -> None:
        super().__init__(gas, _native.Engine.event_driven(gas_of(gas)._handle))

    def equilibrate(self, collisions_per_particle: float) -> None:
        """Runs elastic collisions, `collisions_per_particle` for each disk, then restores temperature and time.

        After Ctrl-C the gas is unchanged.
        """
        collisions_per_particle = given.number("collisions_per_particle", collisions_per_particle)
        if not 0.0 <= collisions_per_particle < 1e12:
            raise GasError(f"collisions per particle are {collisions_per_particle}; allowed: 0 to 1e12")
        self._handle.equilibrate(collisions_per_particle)


class MonteCarlo(Engine):
    """Direct simulation Monte Carlo of a gas without positions, such as :meth:`Gas.spheres`.

    Gases in a box start by :meth:`from_state`.
    """

    def __init__(self, gas: Gas) -> None:
        super().__init__(gas, _native.Engine.without_positions(gas_of(gas)._handle))

    @classmethod
    def from_state(
        cls,
        gas: Gas,
        scheme: str = "contact-point",
        *,
        cell_size: float | None = None,
        steps_per_cell_crossing: float | None = None,
        max_contact_value: float | None = None,
        stiffness: float | None = None,
        partner_radius: float | None = None,
    ) -> MonteCarlo:
        """Starts from the microstate of a gas in a box, with one simulator for each particle.

        Parameters
        ----------
        gas : Gas
            Initial state, such as ``EventDriven.state()``.
        scheme : str
            Scheme of pair selection and collision rate: ``"collisionless"``, ``"boltzmann"``, ``"free-volume"``, ``"enskog"``,
            ``"esmc"``, ``"stochastic-disks"`` or ``"contact-point"``; see ``docs/engines.md``.
        cell_size : float, optional
            Smallest side of a cell [length].
        steps_per_cell_crossing : float, optional
            Number of time steps in a mean free time, and in the time in which the fastest particle crosses a cell.
        max_contact_value : float, optional
            Limit on the factor by which density raises the collision rate.
        stiffness : float, optional
            Stiffness of stochastic disks: collision rate of overlapping disks, over the rate at which a dilute gas has Enskog's
            collision rate.
        partner_radius : float, optional
            Radius around the point of contact from which ``"contact-point"`` draws partners [length].
        """
        engine = cls.__new__(cls)
        if not isinstance(scheme, str):
            raise GasError(f"scheme is {scheme!r}; allowed: its name")
        handle = _native.Engine.in_cells(
            gas_of(gas)._handle,
            scheme,
            cell_size=optional_number("cell_size", cell_size),
            steps_per_cell_crossing=optional_number("steps_per_cell_crossing", steps_per_cell_crossing),
            max_contact_value=optional_number("max_contact_value", max_contact_value),
            stiffness=optional_number("stiffness", stiffness),
            partner_radius=optional_number("partner_radius", partner_radius),
        )
        Engine.__init__(engine, gas, handle)
        return engine


def impact_parameters(collisions: NDArray[np.void]) -> NDArray[np.float64]:
    """Impact parameters b/d of collisions, from 0 (central) to 1 (grazing), shape (number,)."""
    relative, line = collisions["relative_velocity"], collisions["line"]
    along = np.einsum("ij,ij->i", relative, line) / np.einsum("ij,ij->i", line, line)
    across = relative - line * along[:, None]
    square = np.einsum("ij,ij->i", across, across) / np.einsum("ij,ij->i", relative, relative)
    b: NDArray[np.float64] = np.sqrt(np.minimum(square, 1.0))
    return b
