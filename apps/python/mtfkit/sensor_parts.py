# SPDX-License-Identifier: Apache-2.0
"""What the text of a sensor is made of: tables, components, and tables that stand for functions."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Union

from mtfkit import _core, quantities
from mtfkit.components import Component
from mtfkit.custom import Custom, General
from mtfkit.errors import UsageError

#: A component: its kind alone, a dictionary with `kind`, or an object such as mtfkit.Jitter(rms="20 urad").
ComponentLike = Union[str, Mapping[str, Any], Component, Custom, General]


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
    """Tables of components made of functions: their files, where the toolkit reads them, and what they err by."""

    def __init__(self, csv: Mapping[str, str] | None = None, error: float = 0.0) -> None:
        import tempfile

        self.csv: dict[str, str] = {}
        self.error = error
        self.functions: tuple[General, ...] = ()
        self._folder = tempfile.TemporaryDirectory(prefix="mtfkit-sensor-")
        self.file = os.path.join(self._folder.name, "sensor.toml")
        for name, text in (csv or {}).items():
            self._write(name, text)

    def _write(self, name: str, text: str) -> None:
        self.csv[name] = text
        with open(os.path.join(self._folder.name, name), "w", encoding="utf-8") as file:
            file.write(text)

    def add(self, stage: str, component: Custom) -> list[str]:
        """Keeps the tables of a component; the lines of the sensor file that stand for it."""
        lines = []
        for label, axis, text in component.tables():
            name = f"{label}.csv"
            if name in self.csv and self.csv[name] != text:
                raise UsageError(f"{stage}: two components made of functions are called {component.label!r}; give one "
                                 "another label")
            self._write(name, text)
            lines += [f"[[{stage}]]", 'kind = "curve"', f'label = "{label}"', f'file = "{name}"', f'axis = "{axis}"', ""]
        self.error += component.error
        return lines

    def write_beside(self, path: str, text: str) -> str:
        """Writes the tables beside a sensor file; the text of that file."""
        if self.functions:
            raise UsageError(f"save: {self.functions[0].label} is a general function, which no file can state")
        stem, folder = os.path.splitext(os.path.basename(path))[0], os.path.dirname(path)
        for name, table in self.csv.items():
            text = text.replace(f'file = "{name}"', f'file = "{stem}_{name}"')
            _core.write_text(os.path.join(folder, f"{stem}_{name}"), table)
        return text
