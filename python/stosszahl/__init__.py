"""Granular gases by exact event-driven dynamics and by Monte Carlo, from one initial state.

Three levels:

- *engines*: :class:`Gas`, :class:`EventDriven`, :class:`MonteCarlo`, and observers of collisions;
- *cases*: :func:`check`, :func:`run` and :func:`sweep` of case files, as the command line does them;
- *results*: :class:`Results` of a folder, with tables, verdicts, snapshots and figures.

>>> import stosszahl
>>> gas = stosszahl.Gas.disks(200, packing_fraction=0.25, restitution=0.9, seed=1)
>>> exact = stosszahl.EventDriven(gas)
>>> exact.equilibrate(10)
>>> chaos = stosszahl.MonteCarlo.from_state(exact.state())  # the same microstate
>>> impact = stosszahl.ImpactParameters()
>>> exact.advance(10, impact)
>>> chaos.advance(10)
>>> impact.collisions > 1000 and exact.temperature < 1
True
"""

from importlib.metadata import version as _version

from .cases import Case, bundled_cases, check, report, run, schema, sweep
from .engines import COLLISION, EventDriven, ImpactParameters, MonteCarlo, impact_parameters
from .errors import CaseError, EngineError, Error, GasError, OutOfMemoryError, PackageError, ResultsError, RunError
from .files import Trajectory, trajectory
from .gas import DeltaModel, Gas, ThresholdModel, Viscoelastic, Wall
from .log import CollisionLog
from .paper import PaperFigure
from .paraview import write_fields, write_particles
from .results import Results, Verdict
from .snapshots import Snapshot

__version__ = _version("stosszahl")

__all__ = [
    "COLLISION",
    "Case",
    "CaseError",
    "CollisionLog",
    "DeltaModel",
    "EngineError",
    "Error",
    "EventDriven",
    "Gas",
    "GasError",
    "ImpactParameters",
    "MonteCarlo",
    "OutOfMemoryError",
    "PackageError",
    "PaperFigure",
    "Results",
    "ResultsError",
    "RunError",
    "Snapshot",
    "ThresholdModel",
    "Trajectory",
    "Verdict",
    "Viscoelastic",
    "Wall",
    "bundled_cases",
    "check",
    "impact_parameters",
    "report",
    "run",
    "schema",
    "sweep",
    "trajectory",
    "write_fields",
    "write_particles",
]
