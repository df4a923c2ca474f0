"""Cases of the command line, from Python: check, run, sweep and report."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import _native, given
from .errors import CaseError, ResultsError, RunError
from .results import Results

__all__ = ["Case", "bundled_cases", "check", "report", "run", "schema", "sweep"]

Path_ = str | os.PathLike[str]
Progress = Callable[[float, int], Any]


@dataclass(frozen=True)
class Case:
    """A case: a TOML file, or its text, with keys that are set from outside.

    Parameters
    ----------
    path : path
        The file, or the name of a case that comes with the package, such as ``"quick"``. With `text` it need not exist: it
        appears in messages, and its folder is that of start files.
    text : str, optional
        TOML, in place of the contents of the file.
    overrides : sequence of str
        ``key=value`` as for ``--set``.
    """

    path: Path
    text: str | None = None
    overrides: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, source: Case | Path_ | Mapping[str, Any], name: str = "case") -> Case:
        """A case from a path, from a dictionary with the tables of a case file, or from a case."""
        if isinstance(source, Case):
            return source
        if isinstance(source, Mapping):
            return cls(Path(f"{name}.toml"), _native.toml_of_json(json.dumps(given.plain(source))))
        return cls(given.path("case", source))

    def set(
        self,
        keys: Mapping[str, Any] | None = None,
        *,
        replicas: int | None = None,
        seed: int | None = None,
        until: float | None = None,
    ) -> Case:
        """This case with dotted keys set, such as ``{"gas.restitution": 0.9, "species.1.number": 4000}``."""
        further = {"replicas": replicas, "seed": seed, "run.until": until}
        if not isinstance(keys, Mapping | None):
            raise CaseError(f"keys are {keys!r}; allowed: a dictionary of dotted keys")
        all_ = {**(keys or {}), **{key: value for key, value in further.items() if value is not None}}
        return Case(self.path, self.text, self.overrides + [f"{given.key_of(key)}={toml(value)}" for key, value in all_.items()])

    def swept(self, over: Mapping[str, Sequence[Any]]) -> Case:
        """This case with a sweep over dotted keys: all combinations of the values."""
        text = _native.case_text(self.path) if self.text is None else self.text
        block = "".join(f"{json.dumps(key)} = {toml(listed(key, values))}\n" for key, values in mapped(over).items())
        return Case(self.path, f"{text.rstrip()}\n\n[[sweep]]\n{block}", self.overrides)


def mapped(over: Any) -> Mapping[str, Any]:
    if isinstance(over, Mapping):
        return over
    raise CaseError(f"a sweep over {over!r}; allowed: a dictionary of dotted keys, each with the list of its values")


def listed(key: str, values: Any) -> list[Any]:
    """Values of a key in a sweep, as a list."""
    values = given.plain(values)
    if isinstance(values, list):
        return values
    raise CaseError(f"a sweep of {key} over {values!r}; allowed: the list of its values")


def toml(value: Any) -> str:
    """Formats a value as TOML."""
    value = given.plain(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml(one) for one in value) + "]"
    return repr(value)


def bundled_cases() -> dict[str, str]:
    """Names of the cases that come with the package, each with the question that it answers: ``run("quick")`` runs one."""
    return dict(_native.bundled())


def threads_of(threads: int | None) -> int | None:
    return None if threads is None else given.whole("threads", threads, 0, 2**32, RunError)


def schema() -> dict[str, Any]:
    """JSON Schema of case files."""
    schema: dict[str, Any] = json.loads(_native.schema())
    return schema


def check(
    case: Case | Path_ | Mapping[str, Any],
    keys: Mapping[str, Any] | None = None,
    *,
    replicas: int | None = None,
    seed: int | None = None,
    until: float | None = None,
    threads: int | None = None,
) -> list[dict[str, Any]]:
    """Checks a case without running it: derived quantities, cost and warnings of each point of its sweep.

    Parameters are those of :func:`run`.

    Returns
    -------
    list of dict
        ``title``, ``point``, ``derived`` (name, value, unit), ``engines``, ``measures``, ``replicas``, ``bytes`` of memory,
        ``seconds`` on these threads, ``costs`` of each engine, ``warnings``.

    Raises
    ------
    CaseError
        The case is refused; the message names file, line, key and allowed values.
    """
    whole = Case.of(case).set(keys, replicas=replicas, seed=seed, until=until)
    points: list[dict[str, Any]] = json.loads(_native.check(whole, threads_of(threads)))
    return points


def run(
    case: Case | Path_ | Mapping[str, Any],
    keys: Mapping[str, Any] | None = None,
    *,
    out: Path_ | None = None,
    replicas: int | None = None,
    seed: int | None = None,
    until: float | None = None,
    threads: int | None = None,
    progress: bool | Progress = True,
    resume: bool = False,
    force: bool = False,
    ignore_memory_limit: bool = False,
) -> Results:
    """Runs a case, writes its folder with tables and report, and returns the results.

    The folder is that of the command line: tables depend on the case and the seed, not on the number of threads. Other threads of
    Python run meanwhile. Ctrl-C stops the run within about a second, at a checkpoint; with ``resume=True`` it resumes from there
    to the same tables.

    Parameters
    ----------
    case : Case, path or dict
        A case file, the name of a case of :func:`bundled_cases`, or the tables of a case as a dictionary.
    keys : dict, optional
        Dotted keys to set, as by ``--set``: ``{"gas.restitution": 0.9}``. A key that the case sweeps is then no longer swept, with
        a warning.
    out : path, optional
        The results folder; ``results/NAME`` of the case by default.
    replicas, seed, until : optional
        Values in place of those of the case.
    threads : int, optional
        Number of threads; all cores by default.
    progress : bool or callable
        True for a line on standard error, False for nothing, or a function of the share that is done and the collisions so far.
        An exception in it stops the run.
    resume : bool
        True to resume from the checkpoints of a stopped run.
    force : bool
        True to replace an existing folder.
    ignore_memory_limit : bool
        True to start even if the case needs more memory than is free.

    Raises
    ------
    CaseError, ResultsError, RunError
        The case, the folder or the run fails, with the message of the command line.
    KeyboardInterrupt
        The run was stopped by Ctrl-C; its checkpoint is written.
    """
    whole = Case.of(case).set(keys, replicas=replicas, seed=seed, until=until)
    if resume and force:
        raise CaseError("resume and force; allowed: one of them")
    tell = Line(whole.path.stem) if progress is True else progress or None
    if not (tell is None or callable(tell)):
        raise RunError(f"progress is {progress!r}; allowed: True, False, or a function of the share done and the collisions so far")
    folder = None if out is None else given.path("out", out, RunError)
    hear = None
    if tell is not None:

        def hear(share: float, collisions: int, notes: list[str]) -> None:
            for note in notes:
                print(note, file=sys.stderr)
            tell(share, collisions)

    existing = "resume" if resume else "force" if force else "refuse"
    try:
        written, _ = _native.run(
            whole, out=folder, existing=existing, threads=threads_of(threads), ignore_memory_limit=ignore_memory_limit, progress=hear
        )
    except KeyboardInterrupt:
        raise KeyboardInterrupt("stopped; run(..., resume=True) goes on from the checkpoints") from None
    finally:
        if isinstance(tell, Line):
            tell.end()
    return Results(written)


def sweep(
    case: Case | Path_ | Mapping[str, Any],
    over: Mapping[str, Sequence[Any]],
    keys: Mapping[str, Any] | None = None,
    **options: Any,
) -> Results:
    """Runs all combinations of values of some keys: ``sweep("quick", {"gas.restitution": [0.8, 0.9]})``.

    Parameters
    ----------
    over : dict
        Dotted keys, each with the list of its values.
    options
        Options of :func:`run`.

    Returns
    -------
    Results
        Results with ``points``, and tables over all points.
    """
    return run(Case.of(case).swept(over), keys, **options)


def report(folder: Path_) -> Path:
    """Rebuilds ``report.html`` of a folder from its tables, and returns its path."""
    return Path(_native.report(given.path("folder", folder, ResultsError)))


class Line:
    """Progress on standard error: one line on a terminal or in a notebook, elsewhere a line every ten seconds."""

    WIDTH = 40

    def __init__(self, name: str) -> None:
        self.name, self.began = name, time.monotonic()
        self.redraws = sys.stderr.isatty() or "ipykernel" in sys.modules
        self.shown = self.began
        self.open = False

    def __call__(self, share: float, collisions: int) -> None:
        now = time.monotonic()
        if now - self.shown < (0.1 if self.redraws else 10.0):
            return
        self.shown = now
        bar = "#" * round(share * self.WIDTH)
        text = f"{self.name} [{bar:<{self.WIDTH}}] {100 * share:3.0f} %, {collisions:.2e} collisions, {now - self.began:.0f} s"
        print(f"\r{text}" if self.redraws else text, end="" if self.redraws else "\n", file=sys.stderr, flush=True)
        self.open = self.redraws

    def end(self) -> None:
        if self.open:
            print(file=sys.stderr)
