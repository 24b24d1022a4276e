# SPDX-License-Identifier: Apache-2.0
"""A class for every kind of component, made from the field tables that read sensor files: Jitter(rms="20 urad")."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

from mtfkit import _core, quantities
from mtfkit.arguments import checked
from mtfkit.errors import UsageError

#: Names of the classes, by kind; made when one is asked for.
_classes: dict[str, type[Component]] = {}


class Component:
    """A component of a sensor: its kind and its values. Two are equal when their values are."""

    kind = ""
    stages: tuple[str, ...] = ()
    parameters: tuple[Mapping[str, Any], ...] = ()
    __slots__ = ("_values",)
    _values: dict[str, Any]

    def __init__(self, *positional: quantities.Value, **values: quantities.Value) -> None:
        object.__setattr__(self, "_values", {})
        known = self._names()
        if positional:
            first = self._first()
            if first is None or len(positional) > 1 or first in values:
                by_name = f"{first or known[0]}={quantities.shown(positional[0])}"
                raise UsageError(f"{type(self).__name__}: has several values; write each with its name, such as {by_name}; it has "
                                 f"{', '.join(known)}")
            values = {first: positional[0], **values}
        for name in values:
            if name not in known:
                raise UsageError(f"{type(self).__name__}: has no {name!r}; it has {', '.join(known)}")
        missing = [p["name"] for p in self.parameters if p["presence"] == "required" and not any(
            name in values for name in (p["name"], f"{p['name']}_x", f"{p['name']}_y"))]
        if missing:
            raise UsageError(f"{type(self).__name__}: needs {', '.join(missing)}")
        object.__setattr__(self, "_values", {name: value for name, value in values.items() if value is not None})

    @classmethod
    def _first(cls) -> str | None:
        """The parameter that needs no name, the only one that is required: Jitter("20 urad")."""
        required = [p["name"] for p in cls.parameters if p["presence"] == "required"]
        return required[0] if len(required) == 1 else None

    @classmethod
    def _names(cls) -> list[str]:
        names: list[str] = []
        for parameter in cls.parameters:
            names.append(parameter["name"])
            if parameter["type"] == "size":
                names += [f"{parameter['name']}_x", f"{parameter['name']}_y"]
        return [*names, "label"]

    def fields(self) -> dict[str, Any]:
        """Kind and values, as a table of the sensor file."""
        return {"kind": self.kind, **self._values}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._values[name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__} was not given {name!r}") from None

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a component never changes; make another one")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Component):
            return NotImplemented
        return bool(self.fields() == other.fields())

    def __hash__(self) -> int:
        return hash((self.kind, repr(sorted(self._values.items()))))

    def __reduce__(self) -> tuple[Any, tuple[str, dict[str, Any]]]:
        return component, (self.kind, self._values)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self._values.items())})"


def class_name(kind: str) -> str:
    """RcHighpass for rc_highpass."""
    return "".join(word.capitalize() for word in kind.split("_"))


def _doc_of(kind: Mapping[str, Any]) -> str:
    lines = [kind["doc"], "", f"Stands in {', '.join(kind['stages'])}.", ""]
    for p in kind["parameters"]:
        facts = ", ".join(text for text in (
            p["presence"], p["unit"], p["range"], f"default {p['default']}" if p["default"] else "") if text)
        lines.append(f"{p['name']}: {p['doc']} ({facts}); for example {p['example']}")
    return "\n".join([*lines, "", kind["notes"]]).rstrip() + "\n\nRaises UsageError for other names and missing values."


def _signature_of(cls: type[Component]) -> inspect.Signature:
    parameters = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    names = sorted(cls._names(), key=lambda name: name != cls._first())  # in their order behind the one that needs no name
    for name in names:
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD if name == cls._first() else inspect.Parameter.KEYWORD_ONLY
        parameters.append(inspect.Parameter(name, kind, default=None))
    return inspect.Signature(parameters)


def _make(kind: Mapping[str, Any]) -> type[Component]:
    def __init__(self: Component, *positional: quantities.Value, **values: quantities.Value) -> None:
        Component.__init__(self, *positional, **values)

    made = type(class_name(kind["kind"]), (Component,), {
        "__slots__": (), "__module__": __name__, "__doc__": _doc_of(kind), "__init__": __init__, "kind": kind["kind"],
        "stages": tuple(kind["stages"]), "parameters": tuple(kind["parameters"])})
    __init__.__signature__ = _signature_of(made)  # type: ignore[attr-defined]
    __init__.__doc__ = "Values are texts with a unit, (number, unit), or plain numbers; None stands for the default."
    return made


def classes() -> dict[str, type[Component]]:
    """The class of every kind, by the name of the class."""
    if not _classes:
        for kind in _core.kinds()["components"]:
            made = _make(kind)
            _classes[made.__name__] = made
    return _classes


def kinds() -> dict[str, Any]:
    """All that a sensor file may hold, as data: "components" and "tables", each with its parameters, units, ranges and
    docs, as `mtf config kinds` prints them."""
    return _core.kinds()


@checked
def component(kind: str, values: Mapping[str, Any] | None = None) -> Component:
    """The component of that kind with these values. Raises UsageError for an unknown kind."""
    try:
        return classes()[class_name(kind)](**(values or {}))
    except KeyError:
        raise UsageError(f"there is no component {kind!r}; there are "
                         f"{', '.join(made.kind for made in classes().values())}") from None


def __getattr__(name: str) -> type[Component]:
    if not name.startswith("_") and name in classes():
        return classes()[name]
    raise AttributeError(f"module 'mtfkit' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({"Component", "class_name", "classes", "component", "kinds", *classes()})
