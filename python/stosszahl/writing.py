"""Atomic writing of files, and optional packages for their formats."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from .errors import PackageError, ResultsError

Writer = TypeVar("Writer", bound=Callable[..., Any])


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yields a partial file that replaces `path` at the end; after an error it is removed, and `path` is unchanged."""
    partial = path.with_name(f".partial-{path.name}")
    try:
        # Default permissions, because some packages create files that only the owner can read.
        partial.touch()
        yield partial
        os.replace(partial, path)
    except OSError as error:
        raise ResultsError(f"{path}: cannot be written: {error}; allowed: a file in a folder that exists and can be written to") from error
    finally:
        partial.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Writes a text atomically: whole or not at all."""
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")


def writer_of(writers: Mapping[str, Writer], path: Path) -> Writer:
    """Returns the writer of the format that the ending names."""
    if path.suffix not in writers:
        raise ResultsError(f"{path}: no format has the ending {path.suffix!r}; allowed: {', '.join(writers)}")
    return writers[path.suffix]


def optional(module: str, what: str) -> Any:
    """Imports a module of an optional package, which the first part of its name names."""
    package = module.partition(".")[0]
    try:
        return importlib.import_module(module)
    except ImportError as error:
        text = f"{what} need the package {package}: {error}; pip install {package}, or pip install 'stosszahl[formats]'"
        raise PackageError(text, name=package) from error
