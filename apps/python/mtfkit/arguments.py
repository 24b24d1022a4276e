# SPDX-License-Identifier: Apache-2.0
"""Arguments of public functions are what their annotations say; an error says which is not, what it got, what to pass."""

from __future__ import annotations

import functools
import importlib
import inspect
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar, cast

import numpy as np

from mtfkit.errors import UsageError
from mtfkit.quantities import shown

Function = TypeVar("Function", bound=Callable[..., Any])


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and "\0" not in value


def _is_path(value: Any) -> bool:
    return isinstance(value, os.PathLike) and _is_text(os.fspath(value))


def _is_whole(value: Any) -> bool:
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool) and abs(int(value)) < 1 << 63


def _is_number(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim == 0 and value.dtype.kind in "iuf"
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _is_list(value: Any) -> bool:
    return isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, (str, bytes))


def _are_texts(value: Any) -> bool:
    return (isinstance(value, Iterable) and not isinstance(value, (str, bytes, np.ndarray))
            and (not isinstance(value, Sequence) or all(map(_is_text, value))))


def _is_by_name(value: Any) -> bool:
    return isinstance(value, Mapping) and all(isinstance(key, str) for key in value)


def _is(module: str, name: str) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, getattr(importlib.import_module(f"mtfkit.{module}"), name))


#: What values of an annotation are, and the words for it. An annotation with a part that is not here is not looked at: the
#: function itself knows more of it.
_RULES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "None": (lambda value: value is None, "None"),
    "str": (_is_text, "a text"),
    "os.PathLike[str]": (_is_path, "a path"),
    "int": (_is_whole, "a whole number"),
    "float": (_is_number, "a number"),
    "bool": (lambda value: isinstance(value, (bool, np.bool_)), "True or False"),
    "Iterable[str]": (_are_texts, "a list of texts"),
    "Sequence[str]": (lambda value: _is_list(value) and _are_texts(value), "a list of texts"),
    "Sequence[float]": (lambda value: _is_list(value) and all(map(_is_number, value)), "a list of numbers"),
    "Iterable[int]": (lambda value: isinstance(value, Iterable) and not isinstance(value, (str, bytes)), "range(5) or a list of numbers"),
    "tuple[float, float]": (lambda value: _is_list(value) and len(value) == 2 and all(map(_is_number, value)), "(low, high)"),
    "tuple[int, int]": (lambda value: _is_list(value) and len(value) == 2 and all(map(_is_whole, value)), "a pair of whole numbers"),
    "tuple[int, int, int, int]": (lambda value: _is_list(value) and len(value) == 4 and all(map(_is_whole, value)),
                                  "(x, y, width, height) in pixels"),
    "Mapping[str, object]": (_is_by_name, "a dictionary by name"),
    "Mapping[str, npt.ArrayLike]": (_is_by_name, "a dictionary of planes by name"),
    "Mapping[str, Any]": (_is_by_name, "a dictionary by name"),
    "Table": (_is_by_name, "a dictionary of its keys"),
    "Callable[[Any, Any], Any]": (callable, "a function of (fx, fy)"),
    "Sensor": (_is("sensors", "Sensor"), "a Sensor, such as mtfkit.Sensor.load(file)"),
    "Heat": (_is("scenes", "Heat"), "a Heat"),
}


def require(value: Any, annotation: str, name: str) -> None:
    """Raises UsageError for a value that is not what the annotation says."""
    rules = [_RULES.get(part) for part in annotation.split(" | ")]
    if None in rules or any(rule is not None and rule[0](value) for rule in rules):
        return
    parts = annotation.split(" | ")
    if "os.PathLike[str]" in parts and "str" in parts:  # both are names of files
        words = {"str": (_is_text, "a name of a file")}
        rules = [words.get(part, rule) for part, rule in zip(parts, rules) if part != "os.PathLike[str]"]
    allowed = [rule[1] for rule in rules if rule is not None and rule[1] != "None"]
    article = "is no" if allowed[0].startswith("a ") else "is not"
    first = allowed[0].removeprefix("a ")
    more = "; None is the default" if "None" in parts and value is not None else ""
    raise UsageError(f"{name}: {shown(value)} {article} {' or '.join([first, *allowed[1:]])}{more}")


def checked(function: Function) -> Function:
    """The function with its arguments looked at first. Wrong names and numbers of arguments are Python's to tell of."""
    signature = inspect.signature(function)
    annotations = {name: str(parameter.annotation) for name, parameter in signature.parameters.items()
                   if parameter.annotation is not parameter.empty and parameter.kind is not parameter.VAR_KEYWORD}

    @functools.wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        try:
            given = signature.bind(*arguments, **named).arguments
        except TypeError:
            return function(*arguments, **named)
        for name, value in given.items():
            if name in annotations:
                require(value, annotations[name], name)
        return function(*arguments, **named)

    return cast(Function, call)
