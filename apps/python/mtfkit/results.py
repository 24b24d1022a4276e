# SPDX-License-Identifier: Apache-2.0
"""What results have in common: text and tables for notebooks, libraries that are imported when they are asked for."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from mtfkit.errors import Error, UsageError
from mtfkit.quantities import shown

Made = TypeVar("Made")


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


class Text(str):
    """A text of several lines; notebooks show it as it is laid out."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        return f"<pre>{_escaped(self)}</pre>"


def timed(call: Callable[..., Made], *arguments: Any) -> tuple[Made, float]:
    """What the call gives, and its wall time in seconds."""
    start = time.perf_counter()
    made = call(*arguments)
    return made, time.perf_counter() - start


def same(a: Any, b: Any) -> bool:
    """Whether two values are the same, arrays by type and value, NaN being NaN."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and bool(np.array_equal(a, b, equal_nan=a.dtype.kind in "fc"))
    if isinstance(a, float):
        return a == b or (a != a and b != b)
    if isinstance(a, Mapping):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, (list, tuple)):
        return len(a) == len(b) and all(same(one, other) for one, other in zip(a, b))
    return bool(a == b)


class ByValue:
    """A result: two are equal when their values are, arrays too; wall times do not count."""

    __slots__ = ()

    def _values(self) -> Any:
        return {name: value for name, value in vars(self).items() if name != "seconds"}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ByValue) or type(other) is not type(self):
            return NotImplemented
        return same(self._values(), other._values())

    def __hash__(self) -> int:
        values = self._values()
        return hash(tuple("nan" if value != value else value for value in values.values()))


class MissingLibrary(Error, ImportError):
    """A library that mtfkit imports only when it is asked for is not installed."""


def wanted(library: str, package: str, what: str) -> Any:
    """The library, or an error that says what to install."""
    try:
        return importlib.import_module(library)
    except ImportError as missing:
        raise MissingLibrary(f"{what} needs {library.partition('.')[0]}; install {package}") from missing


def pandas(what: str) -> Any:
    """The module pandas."""
    return wanted("pandas", "python3-pandas", what)


def xarray(what: str) -> Any:
    """The module xarray."""
    return wanted("xarray", "python3-xarray", what)


def axes_for(what: str, axes: Any) -> Any:
    """The axes of matplotlib that a `plot` was given, or new ones. Raises UsageError for what is none, and
    MissingLibrary where there is no matplotlib."""
    if axes is not None and not hasattr(axes, "imshow"):
        raise UsageError(f"axes: {shown(axes)} is no axes of matplotlib; leave it out for new ones")
    return axes if axes is not None else wanted("matplotlib.pyplot", "python3-matplotlib", what).subplots()[1]


def plot_mtf(axes: Any, frequency: Any, mtf: Any, sd: Any, unit: str, label: str) -> Any:
    """An MTF with a band of one standard deviation on each side."""
    line, = axes.plot(frequency, mtf, label=label)
    axes.fill_between(frequency, mtf - sd, mtf + sd, color=line.get_color(), alpha=0.3, linewidth=0)
    axes.set(xlabel=f"frequency [{unit}]", ylabel="MTF")
    return axes


def html_table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table for notebooks."""
    def cells(tag: str, row: Sequence[object]) -> str:
        return "".join(f"<{tag}>{_escaped(f'{c:.6g}' if isinstance(c, float) else str(c))}</{tag}>" for c in row)
    body = "".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return f"<table><thead><tr>{cells('th', header)}</tr></thead><tbody>{body}</tbody></table>"
