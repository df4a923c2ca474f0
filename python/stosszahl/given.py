"""Checks of arguments: numbers, vectors and paths of the right type, or an exception that says what is allowed."""

from __future__ import annotations

import os
from collections.abc import Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import CaseError, Error, GasError

Refusal = type[CaseError] | type[Error]


def scalar(value: Any) -> Any:
    """Unpacks the element of an array without axes; returns other values unchanged."""
    return value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value


def number(name: str, value: Any, refusal: Refusal = GasError) -> float:
    """Checks a real number of Python or NumPy; truth values are refused."""
    value = scalar(value)
    if isinstance(value, Real) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            pass
    raise refusal(f"{name} is {value!r}; allowed: a number")


def whole(name: str, value: Any, least: int = 0, most: int = 2**64 - 1, refusal: Refusal = GasError) -> int:
    """Checks a whole number in a range; a floating-point number without a fraction is one."""
    value = scalar(value)
    is_number = isinstance(value, Integral | float | np.floating) and not isinstance(value, bool)
    found: Any = value if is_number else None
    if is_number and least <= found <= most and int(found) == found:
        return int(found)
    raise refusal(f"{name} is {value!r}; allowed: whole numbers from {least}" + ("" if most == 2**64 - 1 else f" to {most}"))


def pair(name: str, values: Any) -> tuple[float, float]:
    """Checks a pair of numbers."""
    try:
        first, second = values
    except (TypeError, ValueError):
        raise GasError(f"{name} is {values!r}; allowed: two numbers") from None
    return number(name, first), number(name, second)


def vectors(name: str, values: Any, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    """Checks an array of real numbers of a shape, in which ``None`` stands for any number."""
    if np.ma.is_masked(values):
        raise GasError(f"{name} has masked entries; allowed: an array without, such as name.compressed()")
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise GasError(f"{name} is no array: {error}; allowed: an array of real numbers") from None
    if array.dtype.kind not in "iuf":
        raise GasError(f"{name} has the type {array.dtype}; allowed: real numbers")
    fits = array.ndim == len(shape) and all(want in (None, found) for want, found in zip(shape, array.shape))
    if not fits:
        wanted = ", ".join("any" if side is None else str(side) for side in shape)
        raise GasError(f"{name} has the shape {array.shape}; allowed: ({wanted})")
    return np.ascontiguousarray(array, dtype=np.float64)


def path(name: str, value: Any, refusal: Refusal = CaseError) -> Path:
    """Checks a path: text, or a path object."""
    if isinstance(value, str | os.PathLike):
        return Path(value)
    raise refusal(f"{name} is {value!r}; allowed: a path")


def plain(value: Any) -> Any:
    """Converts a value of a case to plain Python: numbers, words, true and false, lists and dictionaries."""
    if np.ma.isMaskedArray(value) and not np.ma.is_masked(value):
        value = np.asarray(value)
    if isinstance(value, np.ndarray | np.generic) and not np.ma.is_masked(value):
        value = value.tolist()
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {key_of(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple | range):
        return [plain(one) for one in value]
    raise CaseError(f"{value!r} has no place in a case; allowed: numbers, words, true and false, lists and dictionaries")


def key_of(key: Any) -> str:
    """Checks a key of a case."""
    if isinstance(key, str):
        return key
    raise CaseError(f"the key {key!r} has no place in a case; allowed: words")
