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


def run_command(*words):
    """Standard output of `mtf`, which has to end well."""
    return subprocess.run([COMMAND, *map(str, words)], check=True, capture_output=True, text=True).stdout


def run_json(*words):
    """The same, as JSON."""
    return json.loads(run_command(*words, "--format", "json"))


@pytest.fixture(scope="session")
def demo(tmp_path_factory):
    """The folder of `mtf demo`."""
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
