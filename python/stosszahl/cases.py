"""Cases: what the command line runs, from Python."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import _native
from .errors import CaseError
from .results import Results

__all__ = ["Case", "check", "report", "run", "schema", "sweep"]

Path_ = str | os.PathLike[str]
Progress = Callable[[float, int], Any]


@dataclass(frozen=True)
class Case:
    """A case: a TOML file, or its text, with keys that are set from outside.

    Parameters
    ----------
    path : path
        The file. With `text` it need not exist: it stands in messages, and start files are looked for beside it.
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
            return cls(Path(f"{name}.toml"), _native.toml_of_json(json.dumps(source)))
        return cls(Path(source))

    def set(
        self,
        keys: Mapping[str, Any] | None = None,
        *,
        replicas: int | None = None,
        seed: int | None = None,
        until: float | None = None,
    ) -> Case:
        """The case with dotted keys set, such as ``{"gas.restitution": 0.9, "species.1.number": 4000}``."""
        further = {"replicas": replicas, "seed": seed, "run.until": until}
        given = {**(keys or {}), **{key: value for key, value in further.items() if value is not None}}
        return Case(self.path, self.text, self.overrides + [f"{key}={toml(value)}" for key, value in given.items()])

    def swept(self, over: Mapping[str, Sequence[Any]]) -> Case:
        """The case with a sweep over dotted keys: all combinations of the values."""
        text = self.text
        if text is None:
            try:
                text = self.path.read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError):
                _native.check(self, None)  # says what is wrong
                raise
        block = "".join(f"{json.dumps(key)} = {toml(list(values))}\n" for key, values in over.items())
        return Case(self.path, f"{text.rstrip()}\n\n[[sweep]]\n{block}", self.overrides)


def toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, (list, tuple)) or hasattr(value, "tolist") and not hasattr(value, "__float__"):
        return "[" + ", ".join(toml(one) for one in value) + "]"
    if hasattr(value, "tolist"):
        return toml(value.tolist())
    if isinstance(value, (int, float)):
        return repr(value)
    raise CaseError(f"{value!r} has no place in a case; allowed: numbers, words, true and false, lists and dictionaries")


def schema() -> dict[str, Any]:
    """The JSON Schema of case files."""
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
    """What a case means before it is run, for each point of its sweep.

    Parameters are those of :func:`run`.

    Returns
    -------
    list of dict
        ``title``, ``point``, ``derived`` (name, value, unit), ``engines``, ``measures``, ``replicas``, ``bytes`` of memory,
        ``seconds`` on these threads, ``costs`` of each engine, ``warnings``.

    Raises
    ------
    CaseError
        Says file, line and key that are to blame, and what is allowed.
    """
    whole = Case.of(case).set(keys, replicas=replicas, seed=seed, until=until)
    points: list[dict[str, Any]] = json.loads(_native.check(whole, threads))
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
    force_memory: bool = False,
) -> Results:
    """Runs a case, writes its folder with tables and report, and returns the results.

    The folder is that of the command line: the same case and seed give the same tables, whatever the number of threads. Other
    threads of Python run meanwhile. Ctrl-C stops the run within about a second, at a checkpoint; with ``resume=True`` it goes
    on from there to the same tables.

    Parameters
    ----------
    case : Case, path or dict
        A case file, or its tables as a dictionary.
    keys : dict, optional
        Dotted keys to set, as by ``--set``: ``{"gas.restitution": 0.9}``.
    out : path, optional
        The results folder; ``results/NAME`` of the case by default.
    replicas, seed, until : optional
        In place of the case's.
    threads : int, optional
        All cores by default.
    progress : bool or callable
        A line on standard error, or nothing, or a function of the share that is done and the collisions so far. An
        exception in it stops the run.
    resume : bool
        Goes on from the checkpoints of a run that was stopped.
    force : bool
        Replaces an existing folder.
    force_memory : bool
        Starts even if the case needs more memory than is free.

    Raises
    ------
    CaseError, ResultsError, RunError
        With the messages of the command line.
    KeyboardInterrupt
        After Ctrl-C, when the checkpoint is written.
    """
    whole = Case.of(case).set(keys, replicas=replicas, seed=seed, until=until)
    if resume and force:
        raise CaseError("resume and force; allowed: one of them")
    tell = Line(whole.path.stem) if progress is True else progress or None
    hear = None
    if tell is not None:

        def hear(share: float, collisions: int, notes: list[str]) -> None:
            for note in notes:
                print(note, file=sys.stderr)
            tell(share, collisions)

    existing = "resume" if resume else "force" if force else "refuse"
    try:
        folder, _ = _native.run(
            whole, out=out, existing=existing, threads=threads, force_memory=force_memory, progress=hear
        )
    except KeyboardInterrupt:
        raise KeyboardInterrupt("stopped; run(..., resume=True) goes on from the checkpoints") from None
    finally:
        if isinstance(tell, Line):
            tell.end()
    return Results(folder)


def sweep(
    case: Case | Path_ | Mapping[str, Any],
    over: Mapping[str, Sequence[Any]],
    keys: Mapping[str, Any] | None = None,
    **options: Any,
) -> Results:
    """Runs all combinations of values of some keys: ``sweep("cases/quick.toml", {"gas.restitution": [0.8, 0.9]})``.

    Parameters
    ----------
    over : dict
        Dotted keys, each with the list of its values.
    options
        Those of :func:`run`.

    Returns
    -------
    Results
        With ``points``, and tables over all of them.
    """
    return run(Case.of(case).swept(over), keys, **options)


def report(folder: Path_) -> Path:
    """Writes ``report.html`` of a folder anew from its tables, and returns its path."""
    return Path(_native.report(folder))


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
