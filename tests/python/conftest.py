# SPDX-License-Identifier: Apache-2.0
"""What the tests share: the command, its demo files, and the sensors of the examples."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import mtfkit as mk

ROOT = Path(__file__).resolve().parents[2]
COMMAND = os.environ.get("MTFKIT_COMMAND", "mtf")

# A scene file up to its meshes: place, weather, and the material `plate`.
PLATE_MATERIAL = """schema = 1
[place]
latitude = "40 deg"
longitude = "0 deg"
altitude = "0 m"
[time]
start = 2026-06-21T06:00:00Z
end = 2026-06-21T12:00:00Z
step = "1 h"
[weather]
air_temperature = "288 K"
wind_speed = "2 m/s"
direct_normal = "700 W/m2"
diffuse_horizontal = "80 W/m2"
longwave_down = "320 W/m2"
vapour_pressure = "10 hPa"
[[material]]
name = "plate"
solar_absorptance = 0.7
emissivity = 0.9
convection = "mcadams"
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "10 mm" }]
inside = { kind = "adiabatic" }
"""


def plate_scene(mesh, *groups, position, look_at):
    """The text of a scene file: groups of the mesh `mesh`.obj, all of that material, and a camera."""
    regions = "".join(f'[[region]]\nname = "{group}"\nmesh = "{mesh}"\ngroup = "{group}"\nmaterial = "plate"\n' for group in groups)
    return (PLATE_MATERIAL + f'[[mesh]]\nname = "{mesh}"\nfile = "{mesh}.obj"\nunit = "1 m"\n' + regions
            + f'[camera]\nposition = {json.dumps(position)}\nlook_at = {json.dumps(look_at)}\n')


def run_command(*words):
    """Standard output of `mtf`, which has to end well."""
    return subprocess.run([COMMAND, *map(str, words)], check=True, capture_output=True, text=True).stdout


def run_json(*words):
    """The same, as JSON."""
    return json.loads(run_command(*words, "--format", "json"))


@pytest.fixture(scope="session")
def demo(tmp_path_factory):
    """The folder of `mtf demo`: that of the suite, or one of this run."""
    if "MTFKIT_DEMO" in os.environ:
        return Path(os.environ["MTFKIT_DEMO"])
    folder = tmp_path_factory.mktemp("demo") / "files"
    run_command("demo", "-o", folder)
    return folder


@pytest.fixture(scope="session")
def studies():
    """The studies of the repository."""
    return ROOT / "notebooks-data" / "studies"


@pytest.fixture(scope="session")
def sensor():
    """The sensor of the first example."""
    return mk.Sensor(name="MWIR", frame=dict(focal_length="100 mm", pitch="15 um"),
                     optics=dict(f_number=2.0, wavelength="4 um"),
                     presample=["diffraction", dict(kind="footprint", width="15 um"), dict(kind="jitter", rms="20 urad")])


@pytest.fixture(scope="session")
def scene():
    """A scene with detail at all frequencies, 4 samples a pixel."""
    numbers = np.random.default_rng(1)
    return (5.0 + numbers.standard_normal((192, 256))).astype("float32")
