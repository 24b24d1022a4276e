# SPDX-License-Identifier: Apache-2.0
"""Prints mtfkit/components.pyi: the classes of components with their parameters, from the field tables of the toolkit.

Run it with mtfkit on PYTHONPATH after a component or one of its parameters was added; the tests hold the file to it.
"""

from mtfkit import components

HEAD = '''# SPDX-License-Identifier: Apache-2.0
# Printed by tests/python/component_stub.py from the field tables of the toolkit.
from collections.abc import Mapping
from typing import Any

from mtfkit.quantities import Value

class Component:
    kind: str
    stages: tuple[str, ...]
    parameters: tuple[Mapping[str, Any], ...]
    def __init__(self, *positional: Value, **values: Value) -> None: ...
    def fields(self) -> dict[str, Any]: ...
    def __getattr__(self, name: str) -> Any: ...
    def __setattr__(self, name: str, value: object) -> None: ...
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, tuple[str, dict[str, Any]]]: ...

def class_name(kind: str) -> str: ...
def kinds() -> dict[str, Any]: ...
def classes() -> dict[str, type[Component]]: ...
def component(kind: str, values: Mapping[str, Any] | None = ...) -> Component: ...
def __getattr__(name: str) -> type[Component]: ...
def __dir__() -> list[str]: ...
'''


def stub_of(made):
    """The lines of one class, wrapped."""
    first = made._first()
    lines, line = [], "    def __init__(self, *" if first is None else f"    def __init__(self, {first}: Value = ..., *"
    for name in made._names():
        if name == first:
            continue
        part = f", {name}: Value = ..."
        if len(line) + len(part) > 118:
            lines.append(line + ",")
            line, part = " " * 17, part[2:]
        line += part
    return "\n".join([f"class {made.__name__}(Component):", *lines, line + ") -> None: ..."])


def text():
    """The whole file."""
    return HEAD + "\n" + "\n\n".join(stub_of(made) for _, made in sorted(components.classes().items())) + "\n"


if __name__ == "__main__":
    print(text(), end="")
