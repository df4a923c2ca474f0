"""Engines that run a gas, and what observes their collisions."""

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
"""One collision, as observers receive them.

=====================  ==============================================================================================
``time``               when [time]
``position``           where the first partner was [length], perhaps in another image of a periodic box
``relative_velocity``  of the first partner to the second, before [length/time]
``line``               line of centres, from the second to the first, of the length of their distance [length]
``reduced_mass``       m1 m2/(m1 + m2)
``restitution``        coefficient of normal restitution that acted
``weight``             physical collisions that it stands for: 1 in exact dynamics
``pair``               indices of the partners; 2^32 - 1 where equal particles are not distinguished
``species``            their species
=====================  ==============================================================================================

In the plane the third component of vectors is zero.
"""

Observer = Callable[[NDArray[np.void]], Any]


class ImpactParameters:
    """Observes impact parameters b/d in Rust, at no cost in Python.

    Under molecular chaos u = (b/d)^(dimension - 1) is uniform.

    Parameters
    ----------
    dimension : int
        2 for disks, 3 for spheres.
    bins : int
        Bins of equal width of u.
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
        """Pair collisions seen."""
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
        """Its standard error, if collisions are independent; those of one clustered gas are not."""
        return self._handle.slope_error()


def gas_of(start: Any) -> Gas:
    if isinstance(start, Gas):
        return start
    raise GasError(f"the start is {start!r}; allowed: a Gas, such as that of EventDriven.state()")


class Engine(HasParticles):
    """A gas under way. :class:`EventDriven` and :class:`MonteCarlo` are engines."""

    _handle: _native.Engine

    def __init__(self, gas: Gas, handle: _native.Engine) -> None:
        self._gas = gas
        self._handle = handle
        self.dimension = gas.dimension

    def advance(self, until: float, observer: Observer | ImpactParameters | None = None, *, batch: int = 4096) -> None:
        """Advances to a time.

        Other threads of Python run meanwhile. Ctrl-C stops it between two collisions or steps: the engine then stands at a
        time before `until`, and the same call goes on to the same bytes as without the stop. A second Ctrl-C, a second later or
        more, breaks off a step that takes long; the engine has no state then.

        Parameters
        ----------
        until : float
            The time [time]: the present or later, and finite.
        observer : callable or ImpactParameters, optional
            Is called with all collisions until then, in order, in arrays of the type :data:`COLLISION` that cannot be
            written to. It runs in this thread while the engine works on the next batch in another. An exception in it stops the engine
            as Ctrl-C does, when that batch is full or `until` is reached: always at the same time.
        batch : int
            Collisions in an array; the last has what is left.

        Raises
        ------
        GasError
            The time is past or infinite, or so far that the gas would need years; or it cannot go on, as in inelastic collapse.
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
        """The gas as it is now: another engine can start from it, and it can be pickled."""
        return Gas(self._gas._description, handle=self._handle.state())

    @property
    def time(self) -> float:
        """The present time [time]."""
        return self._handle.time()

    @property
    def box(self) -> tuple[float, ...]:
        """Sides of the box [length]; empty without positions."""
        return self._gas.box

    @property
    def collisions(self) -> int:
        """Pair collisions so far, of simulators where those collide."""
        return self._handle.work()[0]

    @property
    def work(self) -> dict[str, float]:
        """Named counts of work, such as predictions per collision. They do not depend on the machine."""
        return self._handle.work()[1]

    @property
    def boundaries(self) -> dict[str, dict[str, Any]]:
        """What each wall or opening has given so far: ``particles`` that touched it (negative where they left), ``momentum`` (3,) and ``energy``."""
        return {
            name: {"particles": particles, "momentum": np.array(momentum), "energy": energy}
            for name, particles, momentum, energy in self._handle.boundaries()
        }

    def kick(self, changes: ArrayLike) -> None:
        """Adds to all velocities [length/time], shape (number, dimension)."""
        changes = given.vectors("changes", changes, (len(self), self.dimension))
        if not np.isfinite(changes).all():
            raise GasError("changes of velocities are not finite; allowed: finite numbers")
        self._handle.kick(changes.tobytes())

    def scale_velocities(self, factor: float) -> None:
        """Multiplies all velocities with a positive factor."""
        self._handle.scale_velocities(given.number("factor", factor))

    def follow_displacements(self) -> bool:
        """Measures displacements from now on; False if this engine cannot."""
        return self._handle.follow_displacements()

    @property
    def displacements(self) -> NDArray[np.float64] | None:
        """How far each particle has come since then, across the edges of the box [length], shape (number, dimension)."""
        data = self._handle.displacements()
        return None if data is None else numbers(data, (-1, self.dimension))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {len(self)} particles at time {self.time:g}, {self.collisions} collisions>"


class EventDriven(Engine):
    """Exact event-driven dynamics of a gas of disks.

    Parameters
    ----------
    gas : Gas
        The start.

    Raises
    ------
    GasError
        The gas has no positions, or open faces, or disks that overlap.
    """

    def __init__(self, gas: Gas) -> None:
        super().__init__(gas, _native.Engine.event_driven(gas_of(gas)._handle))

    def equilibrate(self, collisions_per_particle: float) -> None:
        """Runs elastically until each disk has collided so often, then restores temperature and time.

        After Ctrl-C the gas is as it was.
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
            The start, such as ``EventDriven.state()``.
        scheme : str
            Which pairs collide, and how often: ``"collisionless"``, ``"boltzmann"``, ``"free-volume"``, ``"enskog"``,
            ``"esmc"``, ``"stochastic-disks"`` or ``"contact-point"``; see ``docs/engines.md``.
        cell_size : float, optional
            Smallest side of a cell [length].
        steps_per_cell_crossing : float, optional
            Time steps in a mean free time, and in which the fastest particle crosses a cell.
        max_contact_value : float, optional
            Limit on the factor by which density raises the collision rate.
        stiffness : float, optional
            Of stochastic disks.
        partner_radius : float, optional
            Of contact-point: radius around the point of contact from which partners are drawn [length].
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
