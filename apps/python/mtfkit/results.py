# SPDX-License-Identifier: Apache-2.0
"""What results have in common: text and tables for notebooks, libraries that are imported when they are asked for."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

from mtfkit.errors import Error

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


class MissingLibrary(Error, ImportError):
    """A library that mtfkit imports only when it is asked for is not installed."""


def wanted(library: str, package: str, what: str) -> Any:
    """The library, or an error that says what to install."""
    try:
        return importlib.import_module(library)
    except ImportError as missing:
        raise MissingLibrary(f"{what} needs {library}; install {package}") from missing


def pandas(what: str) -> Any:
    """The module pandas."""
    return wanted("pandas", "python3-pandas", what)


def xarray(what: str) -> Any:
    """The module xarray."""
    return wanted("xarray", "python3-xarray", what)


def html_table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table for notebooks."""
    def cells(tag: str, row: Sequence[object]) -> str:
        return "".join(f"<{tag}>{_escaped(f'{c:.6g}' if isinstance(c, float) else str(c))}</{tag}>" for c in row)
    body = "".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return f"<table><thead><tr>{cells('th', header)}</tr></thead><tbody>{body}</tbody></table>"
