"""Exceptions. Their messages are those of the command line: what was found, where, and what is allowed."""

from __future__ import annotations

from typing import Any

__all__ = ["CaseError", "EngineError", "Error", "GasError", "OutOfMemoryError", "PackageError", "ResultsError", "RunError"]


class Error(Exception):
    """Base class of all errors of the package."""


class GasError(Error, ValueError):
    """Refused gas, or an engine that cannot start or continue with it."""


class OutOfMemoryError(GasError, MemoryError):
    """Gas or engine that needs more memory than is free."""


class EngineError(Error, RuntimeError):
    """Engine that is at work in another thread, or was interrupted in the middle of a step."""


class CaseError(Error, ValueError):
    """Refused case.

    Attributes
    ----------
    key : str or None
        Dotted key that is refused, such as ``gas.restitution``; elements of lists are counted from 1.
    line, column : int or None
        Place of the key in the file, from 1.
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
    """Failed run."""


class ResultsError(Error, ValueError):
    """Results folder, or file, that cannot be written or read."""


class PackageError(Error, ImportError):
    """Missing optional package; ``name`` is its name."""
