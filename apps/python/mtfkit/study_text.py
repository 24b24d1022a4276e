# SPDX-License-Identifier: Apache-2.0
"""The text of a study file from keywords, and the folder of a study that is complete in itself."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities
from mtfkit.arguments import require
from mtfkit.errors import DataError, UsageError
from mtfkit.messages import in_arguments, reworded

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from mtfkit.sensors import Sensor

_AXIS_KEYS = ("parameter", "name", "values", "from", "to", "count", "scale")
_RANGE = '{"from": "100 mm", "to": "200 mm", "count": 11}'


@dataclass(frozen=True)
class StudyParts:
    """The text of a study, the sensors that it names by their places, and what its messages call its tables."""

    text: str
    sensors: tuple[Sensor, ...]
    files: tuple[str, ...]  # that axes name
    names: tuple[tuple[str, str], ...]

    def in_words(self, text: str, folder: str) -> str:
        """A message with the caller's words: axes["frame.pitch"] in place of axis[1]."""
        files = {"study.toml": "study", sensor_name("study", 0): "sensor"}
        text = re.sub(r"(?m)^study: (error: )?", "", in_arguments(text, folder, files))
        text = text.replace("write [metrics] with list = [", "write metrics=[")
        for table, argument in self.names:
            text = re.sub(rf"(?<![\w.]){re.escape(table)}(?!\w)", argument.replace("\\", r"\\"), text)
        return text

    def about_arguments(self, folder: str) -> AbstractContextManager[None]:
        """Errors from within in these words."""
        return reworded(lambda text: self.in_words(text, folder))


def sensor_name(stem: str, index: int) -> str:
    """The name of a sensor file beside a study."""
    return f"{stem}_sensor.toml" if index == 0 else f"{stem}_sensor_{index}.toml"


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)


def _table(given: Any, what: str) -> Mapping[str, Any]:
    if given is None:
        return {}
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise UsageError(f"{what}: {quantities.shown(given)} is no dictionary of its keys")
    return given


def _texts(given: Any, what: str, example: str) -> list[str]:
    if isinstance(given, str) or not isinstance(given, Sequence) or not all(isinstance(text, str) for text in given):
        raise UsageError(f"{what}: {quantities.shown(given)} is no list of texts; write [\"{example}\"]")
    return list(given)


def _values(given: Any, what: str) -> list[Any]:
    """The values of an axis: a list, or (numbers, unit)."""
    unit = None
    if isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str) and not isinstance(given[0], str):
        given, unit = given
    if isinstance(given, (np.ndarray, range)):
        given = np.asarray(given).tolist()
    if not isinstance(given, list):
        raise UsageError(f"{what}: {quantities.shown(given)} is no list of values; give a list such as [\"100 mm\", \"200 mm\"], ([100, 200], "
                         f"\"mm\"), or a range {_RANGE}")
    return given if unit is None else [(value, unit) for value in given]


def _named_tables(given: Any, what: str, example: str) -> list[tuple[str, Mapping[str, Any]]]:
    """Tables by what messages call them: of a dictionary by parameter, or of a list of tables with `parameter`."""
    if isinstance(given, Mapping):
        named = []
        for name, table in given.items():
            if not isinstance(name, str):
                raise UsageError(f"{what}: {quantities.shown(name)} is no name of a parameter, such as \"frame.pitch\"")
            place = f"{what}[{json.dumps(name, ensure_ascii=False)}]"
            fields = _table(table, place) if isinstance(table, Mapping) else {"values": table} if what == "axes" else None
            if fields is None:
                raise UsageError(f"{place}: {quantities.shown(table)} is no dictionary; write {example}")
            named.append((place, fields if "parameter" in fields or "name" in fields else {"parameter": name, **fields}))
        return named
    if isinstance(given, (list, tuple)) and all(isinstance(table, Mapping) and all(isinstance(key, str) for key in table)
                                                for table in given):
        return [(f"{what}[{index}]", table) for index, table in enumerate(given)]
    raise UsageError(f"{what}: {quantities.shown(given)} is no dictionary by parameter, and no list of dictionaries with `parameter`; write "
                     f"{example}")


def study_parts(sensor: Sensor, *, name: str, axes: Any, links: Any, constraints: Any, objectives: Any, metrics: Any,
                conditions: Any, sampling: Any, as_built: Any, draws: int | None, seed: int,
                tolerance: float | None) -> StudyParts:
    """The study of these keywords. Raises UsageError for what cannot stand in a study file."""
    from mtfkit.sensors import Sensor

    sensors = [sensor]
    said: list[tuple[str, str]] = [("metrics.list", "metrics"), ("yield.draws", "draws")]
    lines, files = ["schema = 1"], list[str]()
    for key, value, annotation in (("name", name, "str"), ("seed", seed, "int"), ("draws", draws, "int | None"),
                                   ("tolerance", tolerance, "float | None")):
        require(value, annotation, key)
    if name:
        lines.append(f"name = {quantities.toml(name, 'name')}")
    lines.append(f"sensor = {json.dumps(sensor_name('study', 0))}")
    if tolerance is not None:
        lines.append(f"tolerance = {quantities.toml(tolerance, 'tolerance')}")
    if seed != 0:
        lines.append(f"seed = {quantities.toml(seed, 'seed')}")
    for key, goals, example in (("constraints", constraints, "niirs_giqe5 > 5"),
                                ("objectives", objectives, "maximize niirs_giqe5")):
        if texts := _texts(goals, key, example):
            lines.append(f"{key} = {quantities.toml(texts, key)}")
    if isinstance(axes, (Mapping, list, tuple)) and not axes:
        raise UsageError(f'axes: is empty; name what varies, as {{"frame.pitch": {_RANGE}}}')
    for index, (place, fields) in enumerate(_named_tables(axes, "axes", f'{{"frame.pitch": {_RANGE}}}')):
        said.append((f"axis[{index}]", place))
        lines += ["", "[[axis]]"]
        for key, value in fields.items():
            if key not in _AXIS_KEYS:
                raise UsageError(f"{place}: has the key {key!r}; it may have {', '.join(_AXIS_KEYS)}")
            if key == "values":
                value = list(_values(value, place))
                for at, one in enumerate(value):
                    if isinstance(one, os.PathLike) or (isinstance(one, str) and "." in one and os.path.isfile(one)):
                        value[at] = os.path.abspath(one)
                        files.append(value[at])
                    elif isinstance(one, Sensor):
                        value[at] = sensor_name("study", len(sensors))
                        sensors.append(one)
            lines.append(f"{key} = {quantities.toml(value, f'{place}.{key}')}")
    for index, (place, fields) in enumerate(_named_tables({} if as_built is None else as_built, "as_built", '{"optics.obscuration": {"sd": 0.01}}')):
        said.append((f"as_built[{index}]", place))
        lines += ["", "[[as_built]]", *(f"{_key(key)} = {quantities.toml(value, f'{place}.{key}')}"
                                        for key, value in fields.items())]
    tables = {"sampling": _table(sampling, "sampling"), "links": _table(links, "links"),
              "metrics": {"list": chosen} if (chosen := _texts(metrics, "metrics", "niirs_giqe5")) else {},
              "conditions": _table(conditions, "conditions"), "yield": {} if draws is None else {"draws": draws}}
    for what, table in tables.items():
        if table:
            lines += ["", f"[{what}]", *(f"{_key(key)} = {quantities.toml(value, f'{what}.{key}')}"
                                         for key, value in table.items())]
    for each in sensors:
        if each._functions:
            raise each._functions[0].refusal("Study")
    return StudyParts("\n".join(lines) + "\n", tuple(sensors), tuple(files), tuple(said))


def _copied(file: str, folder: str, name: str) -> None:
    try:
        with open(file, "rb") as source:
            content = source.read()
        with open(os.path.join(folder, name), "wb") as copy:
            copy.write(content)
    except OSError as error:
        raise DataError(f"{file}: cannot be copied to {folder}: {error.strerror}") from None


def write_study(parts: StudyParts, folder: str, stem: str, *, own_files: bool, file: str = "study.toml") -> None:
    """Writes a study and its sensor files into a folder. With `own_files` all that they name goes there too, so that a
    sweep can take it with it; else it is named where it lies."""
    text = parts.text
    for index in range(len(parts.sensors)):
        text = text.replace(json.dumps(sensor_name("study", index)), json.dumps(sensor_name(stem, index)))
    copies: dict[str, str] = {}  # name in the folder by file

    def beside(text: str, named: Iterable[str]) -> str:
        for source in named:
            if own_files and os.path.relpath(source, folder).startswith(".."):
                if source not in copies:
                    copies[source] = f"{stem}_{len(copies) + 1}_{os.path.basename(source)}"
                    _copied(source, folder, copies[source])
                text = text.replace(quantities.toml(source, "file"), quantities.toml(copies[source], "file"))
        return text

    os.makedirs(folder, exist_ok=True)
    for index, sensor in enumerate(parts.sensors):
        path = os.path.join(folder, sensor_name(stem, index))
        named = [os.path.normpath(os.path.abspath(name)) for name in sensor._file.files[1:]]
        _core.write_text(path, beside(sensor._file.canonical(path) if named else sensor.text, named))
    _core.write_text(os.path.join(folder, file), beside(text, parts.files))


def write_copies(files: Sequence[tuple[str, bytes]], folder: str, study: str) -> None:
    """Writes the files of a study, the first one being the study itself, into a folder."""
    for number, (name, content) in enumerate(files):
        path = os.path.join(folder, study if number == 0 else name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as copy:
            copy.write(content)
