# SPDX-License-Identifier: Apache-2.0
"""What a sensor states: its values by name, and a summary of them in a few lines."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

from mtfkit import _core, quantities
from mtfkit.errors import UsageError

#: A line of a summary ends here, and a longer value of it is left to `text`.
_WIDTH, _LONGEST = 110, 32


def value_of(file: _core.SensorFile, name: str) -> Any:
    """`Sensor.__getitem__`."""
    stated = file.stated(name)
    return tomllib.loads(f"value = {stated}")["value"] if stated else None


def parts(file: _core.SensorFile) -> list[str]:
    """Tables and labels of components that can be written behind a dot."""
    names = [name.rpartition(".")[0] for name in file.parameters()]
    return list(dict.fromkeys(name for name in names if name.isidentifier()))


def part(file: _core.SensorFile, name: str) -> Part:
    """The values of a table or a component. Raises AttributeError that lists what there is."""
    if name not in parts(file):
        raise AttributeError(f"the sensor has no table or component {quantities.shown(name)}; it has {', '.join(parts(file))}")
    return Part(file, name)


class Part:
    """The values of one table or component of a sensor: `sensor.frame.pitch`."""

    __slots__ = ("_file", "_name")

    def __init__(self, file: _core.SensorFile, name: str) -> None:
        self._file = file
        self._name = name

    def __getattr__(self, key: str) -> Any:
        if key.startswith("_"):
            raise AttributeError(key)
        try:
            return value_of(self._file, f"{self._name}.{key}")
        except UsageError as error:
            raise AttributeError(str(error)) from None

    def __dir__(self) -> list[str]:
        start = f"{self._name}."
        return [name.removeprefix(start) for name in self._file.parameters() if name.startswith(start) and "[" not in name]

    def __repr__(self) -> str:
        values = {key: getattr(self, key) for key in dir(self)}
        return f"{self._name}({', '.join(f'{key}={quantities.shown(value)}' for key, value in values.items() if value is not None)})"


def _shown(values: Mapping[str, Any]) -> str:
    """Short values of a table; of { value = ..., fit = ... } the number."""
    said = []
    for key, value in values.items():
        value = value.get("value", value) if isinstance(value, Mapping) else value
        if key not in ("kind", "label") and len(text := quantities.toml(value, key)) <= _LONGEST:
            said.append(f"{key} = {text}")
    return ", ".join(said)


def _component(values: Mapping[str, Any]) -> str:
    said = _shown(values)
    return f"{values.get('label', values['kind'])} ({said})" if said else str(values.get("label", values["kind"]))


def _cut(line: str) -> str:
    return line if len(line) <= _WIDTH else f"{line[:_WIDTH - 4]} ..."


def summary(file: _core.SensorFile, name: str, functions: list[str]) -> str:
    """The sensor in a few lines, of which `text` has all: geometry and optics, its components, its other tables."""
    tables = tomllib.loads(file.text)
    lines = [f"<Sensor {name!r}"]
    for key in ("frame", "optics", "band"):
        if key in tables:
            lines.append(f"  {key}: {_shown(tables.pop(key))}")
    for key in ("presample", "readout", "postsample"):
        components = [_component(values) for values in tables.pop(key, [])] + (functions if key == "presample" else [])
        if components:
            lines.append(f"  {key}: {', '.join(components)}")
    others = [key for key, value in tables.items() if isinstance(value, (dict, list))]
    if others:
        lines.append(f"  and {', '.join(others)}")
    return "\n".join(map(_cut, lines)) + ">"
