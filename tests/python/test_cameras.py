# SPDX-License-Identifier: Apache-2.0
"""A camera from stacks of frames in memory: the numbers of the command on the same frames, near those that were drawn."""

import pickle

import numpy as np
import pytest

import mtfkit as mk
from conftest import run_json

GAIN, READ_E, OFFSET, RATE, SIDE = 0.4, 3.0, 100.3, 4000.0, 48
LIGHTS = (0.0, 0.5, 1.0, 2.0, 4.0, 7.0)


@pytest.fixture(scope="module")
def frames():
    """Of each light eight frames of 12 bits."""
    draw = np.random.default_rng(7)
    response, dark_e = 1 + 0.01 * draw.standard_normal((SIDE, SIDE)), 2 * draw.standard_normal((SIDE, SIDE))
    return [np.floor(GAIN * (draw.poisson(RATE * light * response, (8, SIDE, SIDE)) + dark_e
                             + READ_E * draw.standard_normal((8, SIDE, SIDE))) + OFFSET + 0.5).astype(np.uint16)
            for light in LIGHTS]


def stacks_of(frames):
    return [mk.Stack(cube, relative=light) if light else mk.Stack(cube, light=False) for cube, light in zip(frames, LIGHTS)]


@pytest.fixture(scope="module")
def camera(frames):
    return mk.characterize(stacks_of(frames), bits=14)


def test_the_numbers_are_near_the_truth(camera):
    assert camera.adequate and camera.reason == ""
    for name, truth in {"electrons_per_count": 1 / GAIN, "read_noise": READ_E, "prnu": 0.01, "dsnu": 2.0}.items():
        number = camera[name]
        assert abs(number.value - truth) < 4.5 * number.sd, name
        assert number.low < number.value < number.high and number.verdict == "determined"
    assert np.isnan(camera["transmission"].value) and camera["transmission"].why
    assert "electrons_per_count" in repr(camera) and "chi-square" in camera.explain()
    sensor = camera.sensor
    found = camera["electrons_per_count"]  # the file has two digits beyond the error
    assert abs(float(sensor["adc.electrons_per_count"].removesuffix(" e-")) - found.value) <= 0.005 * found.sd
    with pytest.raises(KeyError):
        camera["gain"]


def test_they_are_those_of_the_command(camera, frames, tmp_path):
    text = "[camera]\nbits = 14\n"
    for i, (cube, light) in enumerate(zip(frames, LIGHTS)):
        np.save(tmp_path / f"{i}.npy", cube)
        text += f'[[stack]]\nframes = "{i}.npy"\n' + (f"relative = {light}\n" if light else "light = false\n")
    (tmp_path / "stacks.toml").write_text(text)
    printed = run_json("characterize", tmp_path / "stacks.toml")
    same_file = mk.characterize(tmp_path / "stacks.toml")
    assert same_file.report == printed
    for here, there in zip(camera.report["numbers"], printed["numbers"]):
        assert {**here, "from": ""} == {**there, "from": ""}


def test_the_standard(frames):
    standard = mk.characterize([mk.Stack(cube, exposure="10 ms", photons=RATE * light) if light else
                                mk.Stack(cube, exposure="10 ms", light=False) for cube, light in zip(frames, LIGHTS)],
                               bits=14, method="emva1288")
    assert abs(standard["K"].value - GAIN) < 4.5 * standard["K"].sd
    with pytest.raises(mk.UsageError, match="no sensor file"):
        standard.sensor  # noqa: B018
    with pytest.raises(mk.UsageError, match="emva1288"):
        mk.characterize(stacks_of(frames), bits=14, method="emva")


def test_results_are_values(camera):
    assert pickle.loads(pickle.dumps(camera)) == camera


@pytest.mark.parametrize(("stacks", "words"), [
    ([], "missing"),
    ([np.zeros((2, 4, 4))], "list of stacks"),
    ([mk.Stack(np.zeros((4, 4)), light=False)], "three dimensions"),
    ([mk.Stack(np.zeros((2, 4, 4)), photons=-1.0)], "photons"),
    ([mk.Stack(np.ones((1, 8, 8)), light=False)], "single frame|two frames"),
])
def test_refusals(stacks, words):
    with pytest.raises(mk.UsageError, match=words):
        mk.characterize(stacks, bits=12)
