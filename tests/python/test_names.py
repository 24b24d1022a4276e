# SPDX-License-Identifier: Apache-2.0
"""Public names: each has a docstring, the stub of components is that of the field tables, examples run."""

import doctest
import importlib
import inspect
import pkgutil
from pathlib import Path

import component_stub
import pytest
from conftest import ROOT

import mtfkit as mk

PACKAGE = Path(mk.__file__).parent
MODULES = [importlib.import_module(f"mtfkit.{info.name}") for info in pkgutil.iter_modules([str(PACKAGE)])
           if info.name != "_core"]


def documented(owner, name, value):
    if name.startswith("_") or not (inspect.isclass(value) or inspect.isroutine(value) or isinstance(value, property)):
        return True
    text = value.fget.__doc__ if isinstance(value, property) else value.__doc__
    return bool(text and text.strip())


def test_every_public_name_has_a_docstring():
    missing = []
    for name in mk.__all__:
        value = getattr(mk, name)
        if not documented(mk, name, value):
            missing.append(name)
        if inspect.isclass(value) and value.__module__.startswith("mtfkit"):
            missing += [f"{name}.{member}" for member, inner in vars(value).items() if not documented(value, member, inner)]
        if inspect.ismodule(value):
            missing += [f"{name}.{member}" for member, inner in vars(value).items()
                        if getattr(inner, "__module__", "") == value.__name__ and not documented(value, member, inner)]
    assert not missing


def test_dir_shows_public_names_only():
    assert set(dir(mk)) == {*mk.__all__, *mk.components.classes()}
    assert {"Jitter", "Sensor", "custom"} <= set(dir(mk)) and not {"canvas", "instants", "TYPE_CHECKING"} & set(dir(mk))


def test_all_names_are_there():
    for module in [mk, *MODULES]:
        assert module.__doc__
        for name in getattr(module, "__all__", []):
            assert hasattr(module, name)


@pytest.mark.parametrize("module", [mk, *MODULES], ids=lambda module: module.__name__)
def test_doctests(module, monkeypatch):
    monkeypatch.chdir(ROOT)
    assert doctest.testmod(module).failed == 0


def test_the_stub_of_components_is_that_of_the_field_tables():
    assert (PACKAGE / "components.pyi").read_text(encoding="utf-8") == component_stub.text(), \
        "write it anew: python3 tests/python/component_stub.py > apps/python/mtfkit/components.pyi"
