# SPDX-License-Identifier: Apache-2.0
"""3-D scenes: temperatures and pictures are those of the command."""

from datetime import date, datetime, time, timedelta, timezone

import numpy as np
import pytest
from conftest import plate_scene, run_command

import mtfkit as mk

SCENE = plate_scene("plates", "soil", "target", position=["0 m", "-12 m", "3 m"], look_at=["0 m", "0 m", "0.7 m"])

PLATES = ("v -4 -4 0\nv 4 -4 0\nv 4 4 0\nv -4 4 0\nv -0.5 0 0.2\nv 0.5 0 0.2\nv 0.5 0 1.2\nv -0.5 0 1.2\n"
          "g soil\nf 1 2 3 4\ng target\nf 5 6 7 8\n")

CAMERA = """schema = 1
name = "uncooled"
[frame]
focal_length = "12.5 mm"
pitch = "12 um"
format = [64, 48]
[optics]
f_number = 1.2
[band]
wavelength = ["8 um", "13 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
fill_factor = 0.85
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plates")
    (folder / "plates.obj").write_text(PLATES)
    (folder / "scene.toml").write_text(SCENE)
    (folder / "camera.toml").write_text(CAMERA)
    return folder / "scene.toml"


def test_temperatures_are_those_of_the_command(scene, tmp_path):
    run_command("heat", scene, "-o", tmp_path / "heat")
    shares = []
    heat = mk.heat(scene, progress=shares.append)
    assert np.array_equal(heat.temperatures, np.load(tmp_path / "heat" / "temperatures.npy"), equal_nan=True)
    assert heat.temperatures.shape == (7, 2) and len(heat.times) == 7
    assert heat.regions().loc[(slice(None), "target"), "mean_K"].shape == (7,)
    assert list(heat.facets().region) == ["soil", "target"]
    assert 0 < heat.promised <= 0.1 and shares and heat.report["finished"]
    kept = mk.heat(scene, tolerance=(0.5, "K"), out=tmp_path / "kept")
    assert (tmp_path / "kept" / "heat.json").exists() and kept.promised <= 0.5


def test_pictures_are_those_of_the_command(scene, tmp_path):
    heat = mk.heat(scene)
    camera = mk.Sensor.load(scene.parent / "camera.toml")
    said = tmp_path / "said.exr"
    run_command("render", scene, scene.parent / "camera.toml", "--temperatures", heat.folder, "-o", said, "--quantity", "radiance",
                "--layer", "temperature")
    picture = mk.render(scene, camera, temperatures=heat, plain=True, layers=["temperature"])
    assert np.array_equal(picture.plane("Y"), mk.read(said, channel="Y").plane("Y"))
    assert np.array_equal(picture.layers["temperature"], mk.read(said, channel="temperature").plane(), equal_nan=True)
    assert picture.attributes["mtf:quantity"] == "radiance"
    assert 0 < picture.promised < 1e-4 and picture.seconds > 0 and picture.report["promised_error"] == picture.promised
    image = camera.simulate(picture).image
    assert image.shape == (48, 64)
    aside = mk.render(scene, camera, temperatures=heat, plain=True, position=[5, -12, 3], look_at=[0, 0, 0.7])
    assert not np.array_equal(aside.plane("Y"), picture.plane("Y"))


def test_mistakes_say_where(scene, tmp_path):
    with pytest.raises(mk.UsageError, match="unit"):
        mk.heat(scene, tolerance=0.1)
    (tmp_path / "file").write_text("x")
    with pytest.raises(mk.UsageError, match="not empty"):
        mk.heat(scene, out=tmp_path)
    with pytest.raises(mk.DataError, match="nowhere"):
        mk.heat("nowhere.toml")
    camera = mk.Sensor.load(scene.parent / "camera.toml")
    with pytest.raises(mk.UsageError, match="no layer"):
        mk.render(scene, camera, solve=True, plain=True, layers=["sound"])
    with pytest.raises(mk.UsageError):
        mk.render(scene, camera, solve=True)  # weighted radiance needs [detector]


def test_times_of_any_kind(scene):
    pandas = pytest.importorskip("pandas")
    camera = mk.Sensor.load(scene.parent / "camera.toml")
    how = dict(temperatures=mk.heat(scene), plain=True)
    right = mk.render(scene, camera, at="2026-06-21T09:30:00Z", **how)
    assert not np.array_equal(right.plane("Y"), mk.render(scene, camera, at="2026-06-21T08:30:00Z", **how).plane("Y"))
    east = timezone(timedelta(hours=2))
    for at in ("09:30", "9:30", "09:30:00Z", "2026-06-21 09:30", "2026-06-21T11:30:00+02:00", datetime(2026, 6, 21, 9, 30),
               datetime(2026, 6, 21, 11, 30, tzinfo=east), time(9, 30), np.datetime64("2026-06-21T09:30"),
               pandas.Timestamp("2026-06-21 09:30"), pandas.Timestamp("2026-06-21 11:30", tz=east)):
        assert np.array_equal(mk.render(scene, camera, at=at, **how).plane("Y"), right.plane("Y")), at


@pytest.mark.parametrize("at,words", [
    ("noon", "'noon' is no time; give a time of day"), ("2026-06-21", "no time"), ("25:00", "no time"), ("2026-06-31T12:00", "no time"),
    (12, "12 is no time"), (np.datetime64("NaT"), "no time"), (date(2026, 6, 21), "no time"), ([], "no time"),
    ("05:00", "does not occur between 2026-06-21T06:00:00Z and 2026-06-21T12:00:00Z"),
])
def test_wrong_times_say_what_is_allowed(scene, at, words):
    with pytest.raises(mk.UsageError, match=f"at: .*{words}"):
        mk.render(scene, mk.Sensor.load(scene.parent / "camera.toml"), solve=True, plain=True, at=at)


def test_a_picture_names_no_file_that_is_gone(scene, tmp_path):
    camera = mk.Sensor.load(scene.parent / "camera.toml")
    picture = mk.render(scene, camera, solve=True, plain=True)
    assert picture.path == "picture" and "mtfkit-" not in repr(picture) + str(picture.report) + str(camera.simulate(picture).report)
    kept = mk.render(scene, camera, solve=True, plain=True, out=tmp_path / "kept.exr")
    assert kept.path == str(tmp_path / "kept.exr") and np.array_equal(kept.plane("Y"), picture.plane("Y"))
