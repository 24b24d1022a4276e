# SPDX-License-Identifier: Apache-2.0
"""What the text of a sensor is made of: tables, components, and tables that stand for functions."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Union

from mtfkit import _core, quantities
from mtfkit.components import Component
from mtfkit.custom import Custom, General, Sampled
from mtfkit.errors import UsageError

#: A component: its kind alone, a dictionary with `kind`, or an object such as mtfkit.Jitter(rms="20 urad").
ComponentLike = Union[str, Mapping[str, Any], Component, Custom, Sampled, General]


def table_lines(name: str, table: Mapping[str, Any]) -> list[str]:
    """A table of the sensor file."""
    return [f"[{name}]", *(f"{key} = {quantities.toml(value, f'{name}.{key}')}" for key, value in table.items()), ""]


def component_lines(stage: str, index: int, given: ComponentLike) -> list[str]:
    """A component of one of the lists."""
    what = f"{stage}[{index}]"
    if isinstance(given, str):
        fields: Mapping[str, Any] = {"kind": given}
    elif isinstance(given, Component):
        fields = given.fields()
    elif isinstance(given, Mapping):
        fields = given
    else:
        raise UsageError(f"{what}: {given!r} is no component; give its kind, a dictionary with kind, or an object such "
                         "as mtfkit.Jitter(rms=\"20 urad\")")
    if "kind" not in fields:
        raise UsageError(f"{what}: the dictionary has no kind")
    return [f"[[{stage}]]", *(f"{key} = {quantities.toml(value, f'{what}.{key}')}" for key, value in fields.items()), ""]


class Tables:
    """Data of components made of functions: tables in a folder of their own, and what they err by."""

    def __init__(self, csv: Mapping[str, str] | None = None, error: float = 0.0,
                 functions: tuple[General, ...] = ()) -> None:
        self.csv: dict[str, str] = {}
        self.error = error
        self.functions = functions
        self._folder: Any = None  # made with the first table
        for name, text in (csv or {}).items():
            self._write(name, text)

    @property
    def place(self) -> str:
        """The folder that the text of the sensor names; "" where it names none."""
        return self.folder if self.csv else ""

    def moved(self, text: str, place: str) -> str:
        """The text of a sensor whose tables were in that place."""
        return text.replace(place, self.folder) if place else text

    def __reduce__(self) -> tuple[Any, ...]:
        return Tables, (self.csv, self.error, self.functions)

    @property
    def folder(self) -> str:
        """Where the tables lie."""
        if self._folder is None:
            import tempfile

            self._folder = tempfile.TemporaryDirectory(prefix="mtfkit-sensor-")
        return str(self._folder.name)

    def _write(self, name: str, text: str) -> None:
        self.csv[name] = text
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            file.write(text)

    def copy(self) -> Tables:
        """The same in another folder."""
        return Tables(self.csv, self.error, self.functions)

    def add(self, stage: str, component: Custom | Sampled | General) -> list[str]:
        """Keeps the data of a component; the lines of the sensor file that stand for it."""
        if isinstance(component, General):
            if stage != "presample":
                raise UsageError(f"{stage}: a component made of a general function stands in presample")
            self.functions += (component,)
            return []
        if isinstance(component, Sampled):
            if stage != "presample":
                raise UsageError(f"{stage}: samples of a point spread function stand in presample")
            self.error += component.error
            return [component.lines(stage)]
        lines = [f"# a function of Python by a table that is within {component.error:.2g} of it"]
        for label, axis, text in component.tables():
            name = f"{label}.csv"
            if name in self.csv and self.csv[name] != text:
                raise UsageError(f"{stage}: two components made of functions are called {component.label!r}; give one "
                                 "another label")
            self._write(name, text)
            lines += [f"[[{stage}]]", 'kind = "curve"', f'label = "{label}"', f'file = "{self.folder}/{name}"',
                      f'axis = "{axis}"', ""]
        self.error += component.error
        return lines

    def write_beside(self, path: str, text: str) -> str:
        """Writes the tables beside a sensor file; the text of that file."""
        if self.functions:
            raise self.functions[0].refusal("save")
        stem, folder = os.path.splitext(os.path.basename(path))[0], os.path.dirname(path)
        for name, table in self.csv.items():
            for place in (self.folder, os.path.relpath(self.folder, os.path.abspath(folder))):
                text = text.replace(f'"{place}/{name}"', f'"{stem}_{name}"')
            _core.write_text(os.path.join(folder, f"{stem}_{name}"), table)
        return text


def write_sensor(file: _core.SensorFile, tables: Tables | None, path: str) -> None:
    """`Sensor.save`."""
    text, own = file.text, 0 if tables is None else len(tables.csv)
    if len(file.files) > 1 + own and os.path.dirname(os.path.abspath(path)) != os.path.dirname(os.path.abspath(file.file)):
        text = file.canonical(os.path.abspath(path))
    _core.write_text(path, text if tables is None else tables.write_beside(path, text))
