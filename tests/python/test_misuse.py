# SPDX-License-Identifier: Apache-2.0
"""Calls that cannot be met: an exception with words, never a crash and never a silent wrong result."""

import copy
import pathlib
import shutil
import subprocess
import sys
import threading

import numpy as np
import pytest

import mtfkit as mk

HOW = dict(sample="3.75 um")


@pytest.fixture(scope="module")
def study(studies):
    return mk.Study.load(studies / "stabilisation.toml")


def test_a_package_that_is_not_built(tmp_path):
    shutil.copytree(pathlib.Path(mk.__file__).parent, tmp_path / "mtfkit", ignore=shutil.ignore_patterns("*.so", "__pycache__"))
    done = subprocess.run([sys.executable, "-c", "import mtfkit"], cwd=tmp_path, env={"PYTHONPATH": str(tmp_path)}, capture_output=True,
                          text=True, check=False)
    assert done.returncode == 1 and "mtfkit has no module _core for Python 3." in done.stderr and "cmake --build build" in done.stderr


@pytest.mark.parametrize("fx,fy,words", [
    ("a", 0, "type <U1"), (None, 0, "type object"), ([[1], [1, 2]], 0, "fx"), (1j, 0, "complex"),
    (np.ma.masked_array([1.0, 2.0], [0, 1]), 0, "masked"), ([1, 2, 3], [1, 2], "no common"), ([np.datetime64(1, "s")], 0, "type"),
])
def test_frequencies(sensor, fx, fy, words):
    with pytest.raises(mk.UsageError, match=words):
        sensor.otf(fx, fy)


def test_frequencies_of_any_kind(sensor):
    for value in (np.array(30.0), np.array([30.0], ">f8"), np.longdouble(30), [30], np.int8(30), np.array([[30.0]] * 9)[::3, :]):
        assert np.abs(sensor.otf(value) - sensor.otf(30.0)).max() == 0.0
    assert np.isnan(sensor.otf([np.nan, 3.0])).tolist() == [True, False]
    assert sensor.otf(np.inf) == 0 and sensor.otf([]).shape == (0,)


def test_frames_that_fit_nowhere_are_refused_at_once(sensor, scene):
    with pytest.raises(mk.UsageError, match="1000000000 frames are more than 10000000"):
        sensor.simulate(scene, frames=range(10 ** 9), **HOW)
    with pytest.raises(mk.UsageError, match=r"^frames: 10000000 images of \d+x\d+ pixels need .* .iB; .* .iB: .*frame.%04d.exr"):
        sensor.simulate(scene, frames=range(10 ** 7), **HOW)


@pytest.mark.parametrize("threads", [-1, 4097, 10 ** 9, 10 ** 20, 1.5, "2", True, None])
def test_threads(sensor, scene, demo, study, threads):
    plan = sensor.compile(scene, **HOW)
    for work in (lambda: sensor.simulate(scene, threads=threads, **HOW), lambda: plan(scene, threads=threads),
                 lambda: sensor.compile(scene, threads=threads, **HOW), lambda: mk.measure(demo / "edge.exr", threads=threads),
                 lambda: study.rows(0, 2, threads=threads), lambda: mk.noise.gaussian((3, 3), sd=1.0, threads=threads),
                 lambda: sensor.fit(edges=[demo / "edge.exr"], free=["jitter.rms"], threads=threads)):
        with pytest.raises(mk.UsageError, match="threads"):
            work()


def test_most_threads(sensor, scene):
    assert np.array_equal(sensor.simulate(scene, threads=4096, **HOW).image, sensor.simulate(scene, threads=1, **HOW).image)


def test_numbers_of_things(sensor, scene, demo, study):
    edge = demo / "edge.exr"
    for work in (lambda: mk.measure(edge, most=0), lambda: mk.measure(edge, most=1.5),
                 lambda: sensor.fit(edges=[edge], free=["jitter.rms"], starts=0), lambda: study.optimum(objective=0, starts=-1),
                 lambda: sensor.simulate(scene, frames="ab", **HOW), lambda: sensor.simulate(scene, frame="x", **HOW),
                 lambda: sensor.simulate(scene, frame=-1, **HOW), lambda: mk.noise.gaussian((1, 2, 3), sd=1.0),
                 lambda: mk.noise.gaussian((-1, 3), sd=1.0), lambda: mk.noise.gaussian((3, 3), sd=np.nan),
                 lambda: mk.targets.edge(size=(0, 3)), lambda: mk.targets.points([(1000, 0)]),
                 lambda: mk.targets.points([(-1, 0)]), lambda: mk.targets.points([1]), lambda: mk.targets.points([], size=(-1, 4)),
                 lambda: mk.targets.sine(cycles=np.nan), lambda: sensor.simulate(scene, progress=3, **HOW)):
        with pytest.raises(mk.UsageError):
            work()


def test_studies(study, studies):
    for tolerance in (-1, 0, np.nan, 1.0):
        with pytest.raises(mk.UsageError, match="tolerance"):
            mk.Study.load(studies / "stabilisation.toml", tolerance=tolerance)
    for work in (lambda: study.gradient(1.5), lambda: study.sensor("1"), lambda: study.rows(0.5, 3)):
        with pytest.raises(TypeError):
            work()
    for design in (-1, study.designs, 10 ** 12):
        with pytest.raises(mk.UsageError, match="design"):
            study.sensor(design)


def test_tables_in_any_order(study):
    table = study.run()
    right = study.to_xarray(table)
    assert study.to_xarray(table.sample(frac=1, random_state=0)).identical(right)
    with pytest.raises(mk.UsageError, match="index"):
        study.to_xarray(table.set_index(table.index + 1))
    with pytest.raises(mk.UsageError, match="index"):
        study.to_xarray(table.set_index(0 * table.index))


def test_images(tmp_path, scene):
    for planes, how, words in [({"a\0b": scene, "c": scene}, {}, "zero byte"), (scene, dict(range=(0, 1)), "PNG and TIFF"),
                               (scene, dict(attributes={"a\0b": "x"}), "zero byte"),
                               (scene * 1j, {}, "real part"), (scene[None], {}, "two dimensions"), ({"a": scene, "b": scene[1:]}, {}, "size"),
                               ({}, {}, "plane"), ({"a" * 300: scene, "c": scene}, {}, "255"), (None, {}, "None")]:
        with pytest.raises(mk.UsageError, match=words):
            mk.write(tmp_path / "a.exr", planes, **how)
    for name in ("a.png", "a.tif"):
        with pytest.raises(mk.DataError, match="NaN"):
            mk.write(tmp_path / name, np.where(scene > 6, np.nan, scene))
    assert not list(tmp_path.iterdir())


def test_a_file_that_was_closed_under_its_array(sensor, scene, tmp_path):
    scene.tofile(tmp_path / "raw")
    mapped = np.memmap(tmp_path / "raw", "float32", "r+", shape=scene.shape)
    plan = sensor.compile(scene.shape, **HOW)
    image = plan(mapped)
    part = mapped[:48, :64]
    mapped._mmap.close()
    for work in (lambda: plan(mapped), lambda: plan(scene, out=part), lambda: sensor.simulate(mapped[1:], **HOW),
                 lambda: mk.measure(mapped)):
        with pytest.raises(mk.UsageError, match="closed"):
            work()
    assert np.isfinite(image).all()


def test_arrays_of_other_libraries(sensor, scene):
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    plan = sensor.compile(scene.shape, **HOW)
    image = plan(scene)
    for same in (pandas.DataFrame(scene), xarray.DataArray(scene), memoryview(scene), scene.tolist(),
                 np.broadcast_to(scene, (1, *scene.shape))[0], np.ndarray(scene.shape, "f4", b"\0" * 3 + scene.tobytes(), 3)):
        assert np.array_equal(plan(same), image)


def test_an_array_cannot_go_away_while_it_is_read(sensor):
    scene = np.random.default_rng(1).random((2048, 2048), "f4")
    plan = sensor.compile(scene.shape, **HOW)
    right, results = plan(scene), []
    worker = threading.Thread(target=lambda: results.append(plan(scene, threads=1)))
    worker.start()
    with pytest.raises(ValueError, match="resize"):
        scene.resize((10, 10))
    scene = None
    worker.join()
    assert np.array_equal(results[0], right)


def test_plans_of_a_chain_are_independent(demo):
    camera = mk.Sensor.load(demo / "camera.toml")
    scene = np.full((64, 64), 300.0, "f4")
    plan = camera.compile(scene, quantity="temperature", **HOW)
    with pytest.raises(mk.UsageError, match="image"):
        plan.promised
    short = plan.replace(camera.replace({"frame.integration_time": "1 ms"}))
    before = plan(scene, frame=3)
    assert short(scene, frame=3).mean() < 0.8 * before.mean()
    assert np.array_equal(plan(scene, frame=3), before)
    with pytest.raises(mk.UsageError, match="another kind"):
        plan.replace(mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um")))
    for shape in ("x", (1, 2, 3), (-1, 5), (0, 0), np.zeros((2, 2, 2))):
        with pytest.raises(mk.UsageError):
            camera.compile(shape, **HOW)


def test_copies(sensor, study):
    assert copy.deepcopy(sensor) == sensor and copy.deepcopy(study) == study


def test_a_function_may_write_into_its_frequencies():
    made = mk.custom(lambda fx, fy: np.exp(-np.square(fx, out=fx) / 900 - np.square(fy, out=fy) / 900), cutoff="200 cy/mm")
    assert made.axis == "radial"
    for wrong in (dict(label=3), dict(label=""), dict(tolerance=0), dict(tolerance=np.nan), dict(tolerance=-1)):
        with pytest.raises(mk.UsageError):
            mk.custom(lambda fx, fy: np.exp(-fx ** 2 - fy ** 2), cutoff="60 cy/mm", **wrong)


def test_numbers_beyond_float32_are_not_written_as_infinite(tmp_path):
    with pytest.raises(mk.DataError, match="beyond 3.4e38"):
        mk.write(tmp_path / "large.exr", np.full((4, 4), 1e300))
    assert not (tmp_path / "large.exr").exists()
    mk.write(tmp_path / "infinite.exr", np.full((4, 4), np.inf))


def test_contrast_below_rounding_is_warned_of(demo):
    plain = mk.Sensor(frame=dict(focal_length="200 mm", pitch="12 um"), presample=[mk.Jitter(rms="10 um")])
    image = np.random.default_rng(1).standard_normal((48, 64))
    run = plain.simulate(1e7 + image, sample="3 um")
    assert any("less contrast than its values are rounded by" in text for text in run.warnings)
    assert not plain.simulate(1e3 + image, sample="3 um").warnings


def test_figures_say_why_they_are_absent(sensor, demo):
    pandas = pytest.importorskip("pandas")
    figures = mk.metrics(sensor, ["snr", "mtf_nyquist"])
    assert "snr = nan (no [detector])" in repr(figures) and "(no [detector])" in figures._repr_html_()
    assert figures.to_pandas().reason.tolist() == ["no [detector]", ""] and list(figures) == ["snr", "mtf_nyquist"]
    budget = mk.Sensor.load(demo / "camera.toml").budget()
    absent = [name for name, figure in budget.items() if np.isnan(figure.value)]
    for name in absent:
        assert budget[name].reason and budget[name].reason in repr(budget[name]) and f"({budget[name].reason})" in budget._repr_html_()
    blank = mk.measure(np.random.default_rng(0).random((64, 64)), roi=(0, 0, 40, 40))
    assert blank[0].reason and blank[0].reason in repr(blank[0]) and "contrast of the best line" in blank[0]._repr_html_()
    assert blank.to_pandas().reason.tolist() == [blank[0].reason]
    gaussian = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), presample=[mk.Jitter(rms="37 urad")])
    sharp = mk.measure(gaussian.simulate(mk.targets.edge(angle="5 deg")).image[16:-16, 16:-16])[0]
    assert sharp.mtf50 is not None and sharp.figures["mtf10"] is None
    assert "above 10 %" in sharp.reasons["mtf10"] and "mtf50" not in sharp.reasons
    assert "above 10 %" in sharp._repr_html_() and "above 10 %" in sharp.to_pandas().attrs["reason"]
    assert isinstance(blank.to_pandas(), pandas.DataFrame)
