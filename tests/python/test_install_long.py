# SPDX-License-Identifier: Apache-2.0
"""The installed component `python` is all that the package needs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import PLATE_MATERIAL

import mtfkit as mk

PROGRAM = """
import numpy as np
import mtfkit as mk
mk.write("counts.png", np.arange(12.0).reshape(3, 4))
assert mk.read("counts.png").plane()[2, 3] == 65535
print(mk.__file__)
try:
    mk.heat("scene.toml")
except mk.Error as error:
    print(error)
"""

SCENE = PLATE_MATERIAL + """[[mesh]]
name = "plate"
file = "plate.obj"
[[region]]
mesh = "plate"
material = "plate"
"""


def test_the_component_stands_alone(tmp_path):
    build = os.environ.get("MTFKIT_BUILD")
    if not build:
        pytest.skip("MTFKIT_BUILD does not name a build folder")
    prefix = tmp_path / "prefix"
    subprocess.run([os.environ.get("MTFKIT_CMAKE", "cmake"), "--install", build, "--component", "python", "--prefix", prefix],
                   check=True, capture_output=True)
    package = next(prefix.rglob("mtfkit/__init__.py")).parent
    assert {path.name for path in package.glob("*.py*")} >= {path.name for path in Path(mk.__file__).parent.glob("*.py*")}
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "plate.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n")  # the face names a vertex that is not there
    environment = {key: value for key, value in os.environ.items() if not key.startswith("MTFKIT")}
    environment["PYTHONPATH"] = str(package.parent)
    said = subprocess.run([sys.executable, "-B", "-c", PROGRAM], cwd=tmp_path, env=environment, check=True,
                          capture_output=True, text=True).stdout
    assert said.startswith(str(package))
    assert "plate.obj" in said and "mtfkit-import" not in said  # the mesh was read, and refused for what is in it
