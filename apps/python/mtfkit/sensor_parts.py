# SPDX-License-Identifier: Apache-2.0
"""What the text of a sensor is made of: tables and components."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Union

from mtfkit import _core, quantities
from mtfkit.components import Component
from mtfkit.custom import Custom, General, Sampled
from mtfkit.errors import UsageError

#: A component: its kind alone, a dictionary with `kind`, or an object such as mtfkit.Jitter(rms="20 urad").
ComponentLike = Union[str, Mapping[str, Any], Component, Custom, Sampled, General]


def table_lines(name: str, table: Mapping[str, Any]) -> list[str]:
    """A table of the sensor file. Raises UsageError for what is no dictionary."""
    if not isinstance(table, Mapping):
        raise UsageError(f"{name}: {table!r} is no table; give a dictionary of its keys")
    return [f"[{name}]", *(f"{key} = {quantities.toml(value, f'{name}.{key}')}" for key, value in table.items()), ""]


def component_lines(stage: str, index: int, given: ComponentLike) -> list[str]:
    """A component of one of the lists."""
    what = f"{stage}[{index}]"
    if isinstance(given, (Custom, Sampled, General)):
        return [given.lines(stage)]
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


@dataclass(frozen=True)
class Functions:
    """What components made of functions bring with them that the text of a sensor does not hold."""

    general: tuple[General, ...] = ()
    error: float = 0.0  #: of tables and samples in place of functions, absolute, in the OTF

    def with_one(self, stage: str, component: Custom | Sampled | General) -> Functions:
        """And those of one more component. Raises UsageError for a list where it does not stand."""
        if stage != "presample" and not isinstance(component, Custom):
            what = ("samples of a point spread function stand" if isinstance(component, Sampled) else
                    "a component made of a general function stands")
            raise UsageError(f"{stage}: {what} in presample")
        if isinstance(component, General):
            return Functions((*self.general, component), self.error)
        return Functions(self.general, self.error + component.error)


def write_sensor(file: _core.SensorFile, functions: Functions, path: str) -> None:
    """`Sensor.save`."""
    if functions.general:
        raise functions.general[0].refusal("save")
    text = file.text
    if len(file.files) > 1 and os.path.dirname(os.path.abspath(path)) != os.path.dirname(os.path.abspath(file.file)):
        text = file.canonical(os.path.abspath(path))
    _core.write_text(path, text)
