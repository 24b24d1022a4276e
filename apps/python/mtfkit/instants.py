# SPDX-License-Identifier: Apache-2.0
"""Times of scenes: texts, datetimes and a time of day as the UTC instants that scene files have."""

from __future__ import annotations

import datetime
import re
import tomllib
from typing import Any, Union

import numpy as np

from mtfkit import _core, quantities
from mtfkit.errors import UsageError

#: "12:30" (within the run of the scene), ISO 8601 text, or an object of datetime, numpy or pandas; UTC without an offset.
Instant = Union[str, datetime.datetime, datetime.time, np.datetime64]

_ALLOWED = ("give a time of day \"12:30\" within the scene's run, ISO 8601 text such as \"2026-06-21T11:40:00Z\", a datetime, a "
            "numpy.datetime64 or a pandas.Timestamp; without an offset it is UTC")


def _utc(given: datetime.datetime) -> datetime.datetime:
    utc = datetime.timezone.utc
    return given.replace(tzinfo=utc) if given.tzinfo is None else given.astimezone(utc)


def _text(given: datetime.datetime) -> str:
    second = f"{given:%S}" if given.microsecond == 0 else f"{given:%S.%f}"
    return f"{given.year:04d}-{given:%m-%dT%H:%M}:{second}Z"


def _span(scene: str) -> tuple[datetime.datetime, datetime.datetime] | None:
    """Start and end of the run of a scene file; None where it states none."""
    try:
        time = tomllib.loads(_core.read_text(scene)).get("time", {})
        start, end = (value if isinstance(value, datetime.datetime) else datetime.datetime.fromisoformat(str(value))
                      for value in (time["start"], time["end"]))
    except (AttributeError, KeyError, TypeError, ValueError):  # also a file with mistakes, which its reader tells of
        return None
    return _utc(start), _utc(end)


def _on_its_day(given: datetime.time, at: object, scene: str) -> datetime.datetime:
    """The first instant of the scene's run with that time of day."""
    span = _span(scene)
    if span is None:
        raise UsageError(f"at: {quantities.shown(at)} has no day, and the scene file no start and end in [time]; {_ALLOWED}")
    start, end = span
    instant = datetime.datetime.combine(start.date(), given.replace(tzinfo=given.tzinfo or datetime.timezone.utc))
    instant = _utc(instant)
    while instant < start:
        instant += datetime.timedelta(days=1)
    if instant > end:
        raise UsageError(f"at: {quantities.shown(at)} does not occur between {_text(start)} and {_text(end)}, the run of the "
                         "scene; give the day, too")
    return instant


def instant_text(at: Instant | None, scene: str) -> str:
    """The instant as scene files have it; "" for none. Raises UsageError."""
    if at is None:
        return ""
    given: Any = at
    if isinstance(given, np.datetime64):
        given = None if np.isnat(given) else given.astype("datetime64[us]").item()
    elif isinstance(given, str):
        text = given.strip()
        try:
            if re.fullmatch(r"\d\d?:\d\d(:\d\d(\.\d+)?)?Z?", text):
                given = datetime.time.fromisoformat(f"0{text}".removesuffix("Z")[text.index(":") - 1:])
            else:
                given = datetime.datetime.fromisoformat(text) if ":" in text else None
        except ValueError:
            given = None
    if isinstance(given, datetime.time):
        return _text(_on_its_day(given, at, scene))
    if not isinstance(given, datetime.datetime) or given != given:  # NaT is a datetime that equals nothing
        raise UsageError(f"at: {quantities.shown(at)} is no time; {_ALLOWED}")
    return _text(_utc(given))
