"""Exceptions. Their messages are those of the command line: what was found, where, and what is allowed."""

from __future__ import annotations

from typing import Any

__all__ = ["CaseError", "EngineError", "Error", "GasError", "OutOfMemoryError", "PackageError", "ResultsError", "RunError"]


class Error(Exception):
    """Whatever the package refuses, or cannot do."""


class GasError(Error, ValueError):
    """A gas that cannot be, or an engine that cannot start or go on with it."""


class OutOfMemoryError(GasError, MemoryError):
    """A gas or an engine that needs more memory than is free."""


class EngineError(Error, RuntimeError):
    """An engine that is at work, or was interrupted in the middle of a step."""


class CaseError(Error, ValueError):
    """A case that is refused.

    Attributes
    ----------
    key : str or None
        The dotted key that is to blame, such as ``gas.restitution``; elements of lists are counted from 1.
    line, column : int or None
        Where it is written, from 1.
    """

    def __init__(self, message: str, key: str | None = None, place: tuple[int, int] | None = None) -> None:
        super().__init__(message)
        self.key = key
        self.line: int | None = place[0] if place else None
        self.column: int | None = place[1] if place else None

    def __reduce__(self) -> tuple[type[CaseError], tuple[Any, str | None, tuple[int, int | None] | None]]:
        place = None if self.line is None else (self.line, self.column)
        return type(self), (self.args[0], self.key, place)


class RunError(Error, RuntimeError):
    """A run that failed."""


class ResultsError(Error, ValueError):
    """A results folder that cannot be written or read."""


class PackageError(Error, ImportError):
    """A package that is needed here and is not installed; ``name`` is that of the package."""
