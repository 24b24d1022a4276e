# SPDX-License-Identifier: Apache-2.0
"""Results go through pickle and process pools, and come back equal: values, arrays, what they say, what they can do."""

import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from conftest import plate_scene

import mtfkit as mk

HOW = dict(sample="3.75 um")


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plate")
    (folder / "plate.obj").write_text("v -4 -4 0\nv 4 -4 0\nv 4 4 0\nv -4 4 0\ng soil\nf 1 2 3 4\n")
    (folder / "scene.toml").write_text(plate_scene("plate", "soil", position=["0 m", "-12 m", "3 m"], look_at=["0 m", "0 m", "0.7 m"]))
    return folder / "scene.toml"


def made(kind, sensor, scene, demo, studies, plate):
    camera = mk.Sensor.load(demo / "camera.toml")
    if kind == "heat":
        return mk.heat(plate)
    if kind == "picture":
        eye = mk.Sensor(frame=dict(focal_length="12.5 mm", pitch="12 um", format=[32, 24]), optics=dict(f_number=1.2),
                        band=dict(wavelength=["8 um", "13 um"]), presample=["diffraction"])
        return mk.render(plate, eye, solve=True, plain=True, layers=["temperature"])
    if kind == "fit":
        edge = sensor.simulate(mk.targets.edge(size=(640, 640))).image[8:-8, 8:-8]
        return sensor.fit(edges=[edge + mk.noise.gaussian(edge.shape, sd=0.03)], free={"jitter.rms": ("1 urad", "80 urad")})
    study = mk.Study.load(studies / "stabilisation.toml")
    return {"run": lambda: sensor.simulate(scene, tolerance=1e-3, **HOW), "target run": lambda: sensor.simulate(mk.targets.edge(size=(64, 64))),
            "colour run": lambda: sensor.simulate({"R": scene, "G": scene + 1}, **HOW),
            "sequence": lambda: camera.simulate(demo / "thermal.exr", stage="dn", frames=range(2, 7, 2)),
            "image": lambda: mk.read(demo / "scene.exr"), "edges": lambda: mk.measure(demo / "edge.exr"),
            "curves": sensor.curves, "budget": lambda: camera.budget(), "gradient": lambda: study.gradient(0),
            "optimum": lambda: study.optimum(objective=0), "study": lambda: study,
            "findings": sensor.check, "metrics": lambda: mk.metrics(sensor, ["mtf50_x", "snr"]),
            "line": lambda: mk.air.line(model="mid_latitude_summer", range="2 km"),
            "sky": lambda: mk.air.sky(model="mid_latitude_summer"),
            "response": lambda: mk.light.BandResponse(("3 um", "5 um"), [([3, 4, 5], [0, 1, 0.5])]),
            "target": lambda: mk.targets.edge(size=(64, 64)), "component": lambda: mk.Jitter(rms="3 urad"),
            "curve data": lambda: mk.CurveData([1.0, 2.0], np.array([0.5, 0.2]), sd=np.nan),
            "custom": lambda: sensor.append(presample=[mk.custom(lambda fx, fy: np.exp(-(fx ** 2 + fy ** 2) / 900), cutoff="200 cy/mm")]
                                            ).simulate(scene, **HOW)}[kind]()


KINDS = ["run", "target run", "colour run", "sequence", "custom", "image", "picture", "heat", "fit", "edges", "curves", "budget", "gradient",
         "optimum", "study", "findings", "metrics", "line", "sky", "response", "target", "component", "curve data"]


@pytest.mark.parametrize("kind", KINDS)
def test_results_come_back_equal(kind, sensor, scene, demo, studies, plate):
    result = made(kind, sensor, scene, demo, studies, plate)
    copy = pickle.loads(pickle.dumps(result))
    assert copy == result and not copy != result and type(copy) is type(result)
    assert pickle.loads(pickle.dumps(copy)) == result
    assert repr(copy) == repr(result)
    if hasattr(result, "seconds"):
        assert copy.seconds == result.seconds
    for name in ("report", "promised", "warnings"):
        if hasattr(result, name):
            assert getattr(copy, name) == getattr(result, name)
    if hasattr(result, "explain"):
        assert copy.explain() == result.explain()
    if hasattr(result, "_repr_html_"):
        assert copy._repr_html_() == result._repr_html_()


def test_other_values_are_not_equal(sensor, scene, demo):
    run = sensor.simulate(scene, **HOW)
    assert run == sensor.simulate(scene, **HOW)  # whatever the time it took
    assert run != sensor.simulate(scene + 1, **HOW) and run != run.image.tolist()
    changed = pickle.loads(pickle.dumps(run))
    changed.image[3, 4] += 1
    assert changed != run
    assert sensor.curves() != sensor.replace({"jitter.rms": "50 urad"}).curves()
    edges = mk.measure(demo / "edge.exr")
    assert edges != mk.measure(demo / "edge.exr", unit="cy/mm", pitch="15 um") and edges[0].mtf50 != edges[0].nyquist
    assert mk.read(demo / "scene.exr") != mk.read(demo / "thermal.exr")


def test_runs_that_were_moved_can_do_all_that_runs_can(demo, tmp_path):
    camera = mk.Sensor.load(demo / "camera.toml")
    run = camera.simulate(demo / "thermal.exr", stage="dn", roi=(4, 2, 32, 24))
    copy = pickle.loads(pickle.dumps(run))
    places = [[0, 0], [10, 3.5]]
    assert np.array_equal(copy.map_points(places), run.map_points(places))
    for name in ("a.exr", "a.png"):
        run.save(tmp_path / name)
        (tmp_path / name).rename(tmp_path / f"run_{name}")
        copy.save(tmp_path / name)
        assert (tmp_path / name).read_bytes() == (tmp_path / f"run_{name}").read_bytes()
    assert copy.to_xarray().equals(run.to_xarray()) and mk.Sensor.load(demo / "camera.toml").simulate is not None


def test_images_that_were_moved_are_simulated_as_their_file(demo, tmp_path):
    sensor = mk.Sensor.load(demo / "sensor.toml")
    image = mk.read(demo / "scene.exr")
    copy = pickle.loads(pickle.dumps(image))
    assert sensor.simulate(copy) == sensor.simulate(demo / "scene.exr")
    mk.write(tmp_path / "a.png", np.arange(4096.0).reshape(64, 64))
    counts = mk.read(tmp_path / "a.png")
    assert pickle.loads(pickle.dumps(counts)).integer and pickle.loads(pickle.dumps(counts)) == counts


def test_fits_that_were_moved_can_do_all_that_fits_can(sensor, scene, demo, studies, plate):
    fit = made("fit", sensor, scene, demo, studies, plate)
    copy = pickle.loads(pickle.dumps(fit))
    assert copy.sensor == fit.sensor and copy.table.equals(fit.table)
    assert np.array_equal(copy.residuals[0][1], fit.residuals[0][1], equal_nan=True)


def work(name, sensor, scene):
    return sensor.simulate(scene, threads=1, **HOW) if name == "run" else mk.measure(sensor.simulate(mk.targets.edge(size=(640, 640))))


def test_process_pools_return_results(sensor, scene):
    with ProcessPoolExecutor(1) as pool:
        run, edges = pool.map(work, ["run", "edges"], [sensor] * 2, [scene] * 2)
    assert run == work("run", sensor, scene) and edges == work("edges", sensor, scene)
