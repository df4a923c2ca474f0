"""Figures of tables with matplotlib, in the style of the report."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import _native

COLOURS = ["#0060a8", "#c8500a", "#00835f", "#a2438a", "#7a6a00", "#4a4fb0", "#b3123c", "#6b6b6b"]
SHADES = ["#440154", "#443a83", "#31688e", "#21918c", "#35a55f", "#86b31c", "#d59b00"]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "h"]
ENGINES = dict(_native.engines())
PANELS = 9
STYLE: Any = {
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e6ea",
    "axes.edgecolor": "#57606a",
    "legend.frameon": False,
    "font.size": 10,
}


def draw(table: pd.DataFrame, figure: dict[str, Any], columns: list[dict[str, str]]) -> Figure:
    """Draws a figure of a table by the description in the manifest."""
    roles = {column["name"]: column["role"] for column in columns}
    panels = list(groups(table, figure["panels"]))[:PANELS]
    across = min(3, len(panels)) or 1
    down = -(-len(panels) // across) or 1
    with plt.rc_context(STYLE):
        drawn, axes = plt.subplots(down, across, figsize=(2.4 + 3.4 * across, 0.8 + 3.0 * down), squeeze=False, layout="constrained")
        for place, (keys, rows) in zip(axes.flat, panels):
            if figure["mark"] == "map":
                mapped(drawn, place, rows, figure, roles)
            else:
                curves(place, rows, figure, roles)
            place.set_title(title(figure["panels"], keys), fontsize=9)
            scale(place, figure)
        for place in axes.flat[len(panels) :]:
            place.set_visible(False)
        for place in axes[:, 0]:
            place.set_ylabel(figure["y"]["label"])
        for place in axes[-1]:
            place.set_xlabel(figure["x"]["label"])
        if panels and figure["mark"] != "map" and axes.flat[0].get_legend_handles_labels()[0]:
            axes.flat[0].legend(fontsize=8)
        drawn.suptitle(figure["title"], fontsize=11)
    return drawn


def groups(table: pd.DataFrame, names: list[str]) -> Iterator[tuple[Any, pd.DataFrame]]:
    """Groups rows that agree in some columns, in the order in which groups occur."""
    names = [name for name in names if name in table.columns]
    if not names:
        yield (), table
        return
    yield from table.groupby(names, sort=False, dropna=False)


def title(names: list[str], keys: Any) -> str:
    """Title of a group from its keys: ``ED (exact), window 0 to 1``."""
    words: list[str] = []
    for name, key in zip(names, keys if isinstance(keys, tuple) else (keys,)):
        of, _, end = name.rpartition("_")
        if name.startswith("engine"):
            words.insert(0, ENGINES.get(key, str(key)))
        elif end in ("end", "high") and words:
            words[-1] += f" to {show(key)}"
        else:
            words.append(f"{(of if end in ('start', 'low') else name).replace('_', ' ')} {show(key)}")
    return ", ".join(words)


def show(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, (int, float, np.number)) else str(value)


def curves(place: Axes, rows: pd.DataFrame, figure: dict[str, Any], roles: dict[str, str]) -> None:
    x, y = figure["x"]["column"], figure["y"]["column"]
    after = list(roles)[list(roles).index(y) + 1 :]
    further = {roles[name]: name for name in reversed(after[: 3]) if roles[name] in ("standard-error", "theory") and name.startswith(y)}
    fresh = count()
    engines = [name for name in figure["curves"] if name.startswith("engine")]
    for keys, part in groups(rows, figure["curves"]):
        keys = keys if isinstance(keys, tuple) else (keys,)
        named = [key for name, key in zip(figure["curves"], keys) if name in engines]
        other = [key for key in named if key != "ed"] or named
        if other and other[0] in ENGINES:
            number = list(ENGINES).index(other[0])
            colour, marker = COLOURS[number], MARKERS[number]
        else:
            number = next(fresh)
            colour, marker = SHADES[number % len(SHADES)], MARKERS[number % len(MARKERS)]
        label = title(figure["curves"], keys)
        if figure["mark"] == "bars":
            edges = bin_edges(part, x)
            place.stairs(part[y], edges, color=colour, label=label)
            if "standard-error" in further:
                middle = 0.5 * (edges[1:] + edges[:-1])
                place.errorbar(middle, part[y], part[further["standard-error"]], color=colour, fmt="none", lw=1)
        else:
            error = part[further["standard-error"]] if "standard-error" in further else None
            line = "-" if figure["mark"] == "line" else "none"
            place.errorbar(part[x], part[y], error, color=colour, marker=marker, ms=3.5, lw=1, ls=line, label=label)
        if "theory" in further and part[further["theory"]].notna().any():
            place.plot(part[x], part[further["theory"]], color=colour, ls="--", lw=1)
    for line in figure["lines"]:
        place.axhline(line["y"], color="#57606a", lw=1, ls=":", label=line["label"])


def bin_edges(part: pd.DataFrame, low: str) -> np.ndarray:
    high = part.columns[list(part.columns).index(low) + 1]
    return np.append(part[low].to_numpy(), part[high].to_numpy()[-1])


def mapped(drawn: Figure, place: Axes, rows: pd.DataFrame, figure: dict[str, Any], roles: dict[str, str]) -> None:
    colour = (figure.get("colour") or {}).get("column") or next(name for name, role in roles.items() if role == "value")
    grid = rows.pivot(index=figure["y"]["column"], columns=figure["x"]["column"], values=colour)
    shown = place.pcolormesh(grid.columns, grid.index, grid.to_numpy(), shading="nearest", rasterized=True)
    place.set_aspect("equal")
    place.grid(False)
    drawn.colorbar(shown, ax=place, label=(figure.get("colour") or {}).get("label", colour))


def scale(place: Axes, figure: dict[str, Any]) -> None:
    for axis, set_scale in (("x", place.set_xscale), ("y", place.set_yscale)):
        if figure[axis]["scale"] == "logarithmic":
            set_scale("log", nonpositive="mask")
