# SPDX-License-Identifier: Apache-2.0
"""Files behind objects: names relative to a folder that the process leaves, contents that change, names that are no text."""

import os
import pickle

import numpy as np
import pytest

import mtfkit as mk
from conftest import plate_scene

STUDY = """schema = 1
sensor = "camera.toml"
[metrics]
list = ["mtf_nyquist"]
[[axis]]
parameter = "optics.f_number"
values = [2.0, 4.0]
"""
CAMERA = """schema = 1
[frame]
focal_length = "100 mm"
pitch = "15 um"
[optics]
f_number = 2.0
wavelength = "4 um"
[[presample]]
kind = "diffraction"
[[presample]]
kind = "curve"
file = "lens.csv"
"""


def write_lens(folder, value):
    """A table of a lens that is `value` at Nyquist, 33.3 cy/mm."""
    (folder / "lens.csv").write_text(f"frequency_cy_mm,mtf\n0,1\n{1000 / 30},{value}\n80,0\n")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A study with its files, where the process is; another curve of that name lies in `other`."""
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "camera.toml").write_text(CAMERA)
    write_lens(tmp_path, 0.5)
    (tmp_path / "other").mkdir()
    write_lens(tmp_path / "other", 0.1)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def diffraction(f_number):
    """Of a circular pupil at Nyquist: 2/pi (acos s - s sqrt(1 - s^2)), s = lambda F f."""
    s = 4e-3 * f_number * 1000 / 30
    return 2 / np.pi * (np.arccos(s) - s * np.sqrt(1 - s * s))


def test_studies_stay_with_their_files_wherever_the_process_goes(here, monkeypatch):
    study = mk.Study.load("study.toml")
    monkeypatch.chdir(here / "other")
    wanted = [0.5 * diffraction(2.0), 0.5 * diffraction(4.0)]
    assert study.rows()[:, 1] == pytest.approx(wanted, abs=1e-4)  # the tolerance of studies
    assert pickle.loads(pickle.dumps(study)).rows()[:, 1] == pytest.approx(wanted, abs=1e-4)


def test_rows_are_not_made_of_files_that_changed(here):
    study = mk.Study.load("study.toml")
    before = study.rows()
    os.utime(here / "lens.csv")  # the same contents
    assert study.rows().tobytes() == before.tobytes()
    for change in (lambda: write_lens(here, 0.2), lambda: (here / "lens.csv").unlink()):
        change()
        for make in (study.rows, lambda: study.gradient(0), lambda: study.sensor(0)):
            with pytest.raises(mk.DataError, match=r"lens\.csv"):
                make()
    write_lens(here, 0.5)
    assert study.rows().tobytes() == before.tobytes()


@pytest.mark.parametrize("kind", ["curve", "quantum_efficiency"])
def test_sensors_are_equal_only_with_equal_files(here, kind):
    if kind == "curve":
        text, first, second = CAMERA, "frequency_cy_mm,mtf\n0,1\n80,0\n", "frequency_cy_mm,mtf\n0,1\n80,0.1\n"
        name = "lens.csv"
    else:
        text = CAMERA[:CAMERA.rindex("[[presample]]")].replace('wavelength = "4 um"\n', "") + (
            '[band]\nwavelength = ["3.4 um", "4.8 um"]\n[detector]\nquantum_efficiency = "qe.csv"\n')
        first, second = ("wavelength_um,quantum_efficiency\n3,0.7\n5,0.7\n", "wavelength_um,quantum_efficiency\n3,0.7\n5,0.6\n")
        name = "qe.csv"
    (here / "camera.toml").write_text(text)
    (here / name).write_text(first)
    one, same = mk.Sensor.load("camera.toml"), mk.Sensor.load("camera.toml")
    assert one == same and hash(one) == hash(same)
    (here / name).write_text(second)
    other = mk.Sensor.load("camera.toml")
    assert one != other
    if kind == "quantum_efficiency":  # which is read when it is needed
        for use in (one.budget, lambda: one.simulate(np.full((8, 8), 300.0), sample="15 um", quantity="temperature")):
            with pytest.raises(mk.DataError, match=r"qe\.csv: is not what it was"):
                use()
    assert one.replace({"optics.f_number": 3}) == other.replace({"optics.f_number": 3})  # both are read now
    (here / name).write_text(first)
    assert mk.Sensor.load("camera.toml") == one


def test_heat_stays_with_its_folder(here, monkeypatch):
    (here / "plate.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng top\nf 1 2 3 4\n")
    (here / "scene.toml").write_text(plate_scene("plate", "top", position=["2 m", "-3 m", "2 m"], look_at=["0 m", "0 m", "0 m"]))
    made = mk.heat("scene.toml", out="made", tolerance="1 K")
    wanted = made.temperatures.copy()
    monkeypatch.chdir(here / "other")
    assert made.temperatures.tobytes() == wanted.tobytes()


def test_names_of_files_are_bytes(here):
    name = os.fsdecode(b"d\xe9t\xe9")
    folder = here / name
    folder.mkdir()
    for file in ("study.toml", "camera.toml", "lens.csv"):
        (folder / file).write_bytes((here / file).read_bytes())
    sensor = mk.Sensor.load(folder / "camera.toml")
    assert os.path.samefile(sensor.file, folder / "camera.toml")
    assert sensor.mtf(10.0) == mk.Sensor.load("camera.toml").mtf(10.0)
    sensor.save(folder / os.fsdecode(b"\xe9.toml"))
    assert (folder / os.fsdecode(b"\xe9.toml")).exists()
    study = mk.Study.load(folder / "study.toml")
    assert study.rows().tobytes() == mk.Study.load("study.toml").rows().tobytes()
    assert pickle.loads(pickle.dumps(study)).designs == 2
    image = folder / os.fsdecode(b"\xe9.exr")
    mk.write(image, np.ones((64, 64), np.float32), sample="15 um")
    assert mk.read(image).plane().shape == (64, 64)
    run = sensor.simulate(image, out=folder / os.fsdecode(b"\xfc.exr"))
    assert (folder / os.fsdecode(b"\xfc.exr")).exists() and run.report
    with pytest.raises(mk.DataError, match="none.toml"):
        mk.Sensor.load(folder / "none.toml")


def test_planes_keep_their_spacing(sensor, tmp_path):
    values = np.random.default_rng(0).random((64, 96), "f4")
    mk.write(tmp_path / "scene.exr", values, sample=("3.75 um", "5 um"))
    plane = mk.read(tmp_path / "scene.exr").plane()
    assert plane.sample == ("3.75 um", "5.0 um") and np.array_equal(plane, values) and np.shares_memory(plane, plane[3:])
    for same in (plane[8:-8, 4:], plane[5:], 2 * plane + plane, np.exp(plane), plane.astype("f8"), plane.copy(),
                 pickle.loads(pickle.dumps(plane))):
        assert same.sample == plane.sample
    for other in (plane[::2], plane[:, ::3], plane[::-1], plane.T, plane.repeat(2, axis=0), plane.reshape(96, 64), plane[[0, 1]],
                  plane.reshape(32, 2, 96).mean(axis=1), plane[None, 0], np.concatenate([plane, plane])):
        assert getattr(other, "sample", None) is None  # its samples lie elsewhere
    explicit = sensor.simulate(values, sample=("3.75 um", "5 um"))
    assert np.array_equal(sensor.simulate(plane).image, explicit.image)
    assert np.array_equal(sensor.compile(plane)(plane), sensor.compile(values, sample=("3.75 um", "5 um"))(values))
    assert sensor.simulate(plane, sample="7.5 um").image.shape != explicit.image.shape  # what the caller says wins
    mk.write(tmp_path / "again.exr", plane)
    assert mk.read(tmp_path / "again.exr").sample == plane.sample
    with pytest.raises(mk.UsageError, match="spacing"):
        sensor.simulate(plane[::2])
    mk.write(tmp_path / "other.exr", values, sample="3.75 um")
    other = mk.read(tmp_path / "other.exr").plane()
    for mixed in (lambda: sensor.simulate({"a": plane, "b": other}), lambda: mk.write(tmp_path / "mixed.exr", {"a": plane, "b": other}),
                  lambda: sensor.compile(plane)(other)):
        with pytest.raises(mk.UsageError, match=r"3\.75 .*5.* um|3\.75 um"):
            mixed()
    assert not (tmp_path / "mixed.exr").exists()
    assert sensor.compile((64, 96), sample=("0.00375 mm", "5 um"))(plane).shape == explicit.image.shape
