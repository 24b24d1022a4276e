# SPDX-License-Identifier: Apache-2.0
"""Every public function with each wrong kind of argument: words about the argument, never a message of Python's insides.

What a call may give is a result, a UsageError or DataError, or a TypeError that names the argument.
"""

import inspect
import os
import signal

import numpy as np
import pytest

import mtfkit as mk


class Nothing:
    """An object that is nothing of ours."""


def wrong_values():
    return {"None": None, "text": "no", "whole": 3, "negative": -1, "number": 1.5, "nan": float("nan"), "large": 10 ** 30, "bool": True,
            "complex": 1j, "bytes": b"x", "zero byte": "a\0b", "tuples": [(1, 2), (3, 4, 5)], "list of None": [None], "empty": [],
            "texts": ["a", "b"], "set": {1, 2}, "dictionary": {"a": {1: 2}}, "objects": np.array([object(), None], dtype=object),
            "three dimensions": np.zeros((2, 2, 2)), "class": mk.Sensor, "object": Nothing(), "function": lambda *_: None,
            "generator": (c for c in "ab")}


#: Methods of sensors and plans, whose own code is another topic; what they hand on to the functions here is looked at here.


def calls(folder, demo):
    """(function, arguments that are right) of all public functions and methods that take arguments."""
    sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0, wavelength="4 um"),
                       presample=["diffraction", mk.Jitter(rms="20 urad")])
    camera, light, design = mk.Sensor.load(demo / "camera.toml"), mk.light, dict(design=0)
    scene = (5.0 + np.random.default_rng(1).standard_normal((48, 64))).astype("f4")
    study = mk.Study(sensor, axes={"jitter.rms": ["10 urad", "20 urad"]}, metrics=["q"], objectives=["maximize jitter.rms"])
    study.save(folder / "study.toml")
    run, table, how = sensor.simulate(scene, sample="3.75 um"), study.run(), dict(sample="3.75 um")
    mk.write(folder / "edge.png", sensor.simulate(mk.targets.edge(size=(320, 320))).image)
    edge, at = folder / "edge.png", dict(wavelength_um=10.0, temperature_k=300.0)
    band, size = dict(band=("3 um", "5 um")), dict(size=(40, 40))
    flat = [mk.Stack(np.random.default_rng(light).poisson(100.0 + 200 * light, (4, 16, 16)).astype("u2"), relative=light) for light in (1, 2, 4)]
    plan, parts = sensor.compile(scene, **how), dict(frame=dict(focal_length="100 mm", pitch="15 um"))
    return [
        (mk.Sensor, parts), (mk.Sensor.load, dict(path=demo / "camera.toml")), (mk.Sensor.parse, dict(text=sensor.text)),
        (sensor.save, dict(path=folder / "d.toml")), (sensor.append, {}), (sensor.compile, dict(scene=scene, **how)), (plan, dict(scene=scene)),
        (plan.replace, dict(sensor=sensor)), (mk.custom, dict(otf=lambda x, y: 1.0 / (1.0 + x * x + y * y) ** 9, cutoff="60 cy/mm")),
        (sensor.replace, dict(values={"jitter.rms": "3 urad"})), (sensor.otf, dict(fx=3.0)), (sensor.mtf, dict(fx=3.0)), (sensor.curves, {}),
        (camera.budget, {}), (sensor.simulate, dict(scene=scene, **how)), (camera.simulate, dict(scene=demo / "thermal.exr", stage="dn")),
        (mk.fit, dict(sensor=sensor, edges=[edge], free=["jitter.rms"])), (run.map_points, dict(points=[[0, 0]])),
        (run.save, dict(path=folder / "a.exr")), (run.plane, dict(name="Y")), (run.plot, {}), (sensor.curves().plot, {}), (mk.read, dict(path=edge)),
        (mk.write, dict(path=folder / "b.exr", planes=scene)), (mk.read(edge).plane, dict(name="Y")), (mk.read(edge).temperatures, {}), (mk.measure, dict(image=edge)),
        (mk.characterize, dict(stacks=flat, bits=12)),
        (mk.metrics, dict(sensor=sensor, names=["q"])), (mk.Study, dict(sensor=sensor, axes={"jitter.rms": ["10 urad"]}, metrics=["q"])),
        (mk.Study.load, dict(file=folder / "study.toml")), (study.save, dict(file=folder / "c.toml")), (study.rows, {}), (study.run, {}),
        (study.frame, dict(rows=study.rows())), (study.pareto, dict(frame=table)), (study.to_xarray, dict(frame=table)), (study.axes, design),
        (study.sensor, design), (study.gradient, design), (study.optimum, {}), (light.planck, at), (light.log_planck, at),
        (light.planck_derivative, at), (light.brightness_temperature, dict(wavelength_um=10.0, radiance=3.0)),
        (light.band_radiance, dict(temperature_k=300.0, **band)), (light.band_derivative, dict(temperature_k=300.0, **band)),
        (light.band_temperature, dict(radiance=3.0, **band)), (light.BandResponse, dict(curves=[([3, 5], [1, 1])], **band)),
        (light.BandResponse(**band).radiance, dict(temperature_k=300.0)), (light.BandResponse(**band).derivative, dict(temperature_k=300.0)),
        (mk.air.line, dict(model="mid_latitude_summer", range="2 km", bands=[("8 um", "9 um")])), (mk.air.sky, dict(model="mid_latitude_summer")),
        (mk.noise.gaussian, dict(shape=(3, 3), sd=1.0)), (mk.noise.shot, dict(mean=scene)), (mk.targets.edge, size),
        (mk.targets.sine, dict(cycles=3, **size)), (mk.targets.points, dict(places=[(1, 1)], **size)), (mk.heat, dict(scene="none.toml")),
        (mk.render, dict(scene="none.toml", sensor=sensor)), (mk.Jitter, dict(rms="3 urad")),
        (mk.components.component, dict(kind="jitter", values=dict(rms="3 urad"))), (camera.budget()["netd"].to, dict(unit="mK"))]


def name_of(function):
    return getattr(function, "__qualname__", type(function).__name__)


def complaint(function, arguments, name):
    """What is wrong with the answer to these arguments; "" for nothing."""
    try:
        function(**arguments)
    except (mk.Error, TypeError) as error:
        text = str(error)
        inside = next((words for words in ("incompatible function", "incompatible constructor", "Unable to cast", "_core", "mtfkit-")
                       if words in text), "")
        if inside or not text.strip():
            return f"{type(error).__name__}: {text[:160]!r}"
        return "" if isinstance(error, mk.Error) or name in text else f"does not say which argument: {text[:160]!r}"
    except Exception as error:  # pylint: disable=broad-except
        return f"{type(error).__name__}: {str(error)[:160]!r}"
    return ""


def test_every_function_with_each_wrong_argument(demo, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    signal.alarm(150)  # a call that does not end is a failure, too
    wrong, count = [], 0
    for function, right in calls(tmp_path, demo):
        for parameter in inspect.signature(function).parameters.values():
            if parameter.kind is parameter.VAR_KEYWORD:
                continue
            for kind, value in wrong_values().items():
                if parameter.name in ("threads", "rays") and kind == "whole":
                    continue  # right
                if parameter.name == "otf" and kind == "class":
                    continue  # a function, whose own error is the user's
                count += 1
                said = complaint(function, {**right, parameter.name: value}, parameter.name)
                if said:
                    wrong.append(f"{name_of(function)}({parameter.name}={kind}): {said}")
    signal.alarm(0)
    assert count > 4000 and not wrong, "\n".join(wrong)


def test_all_public_functions_are_among_them(demo, tmp_path):
    looked_at = {name_of(function).rpartition(".")[2] for function, _ in calls(tmp_path, demo)}
    public = {name for name in mk.__all__ if inspect.isfunction(getattr(mk, name))}
    public |= {name for module in (mk.light, mk.air, mk.noise, mk.targets) for name in module.__all__ if inspect.isfunction(getattr(module, name))}
    public |= {name for owner in (mk.Study, mk.Run, mk.Image) for name, member in vars(owner).items()
               if inspect.isfunction(member) and not name.startswith("_") and len(inspect.signature(member).parameters) > 1}
    assert public - looked_at - {"devices", "kinds"} == set()


@pytest.mark.parametrize("work,words", [
    (lambda s, d: s.simulate(np.ones((4, 4)), sample="3 um", frames=3), "frames: 3 is not range"),
    (lambda s, d: s.fit(curves=[(1, 2), (3, 4)]), r"curves\[0\]: \(1, 2\) is no CurveData; give mtfkit.CurveData"),
    (lambda s, d: mk.render("sc.toml", "lwir.toml"), "sensor: 'lwir.toml' is no Sensor, such as mtfkit.Sensor.load"),
    (lambda s, d: s.simulate(d / "scene.exr", memory=3), "memory: 3 bytes are less than 1 MiB"),
    (lambda s, d: s.simulate(np.ones((4, 4)), sample="3 um", frames=[0, 1], schedule=[(0, "jitter.rms")]), r"schedule\[0\]: .* is not \(frame"),
    (lambda s, d: s.simulate(np.ones((4, 4)), sample="3 um", frames=[0, 1], schedule=[(0, "jiter.rms", "3 urad")]), r"^schedule\[0\]: .*jiter.rms"),
    (lambda s, d: s.fit(curves=[mk.CurveData([5.0], [0.9], unit="cy/rad")], free=["jitter.rms"]), "one of cy/mm, lp/mm, .*1000 cy/rad are 1"),
    (lambda s, d: s.curves(unit="lp/mm"), "one of cy/mm, cy/mrad, cy/px.*lp/mm is cy/mm"),
    (lambda s, d: s.otf(3.0, unit="cy/rad"), "1000 cy/rad are 1 cy/mrad"), (lambda s, d: s.mtf(3.0, unit=3), "unit: 3 is no text"),
    (lambda s, d: mk.metrics(s, ["mtf51"]), '^names: unknown metric "mtf51"'), (lambda s, d: mk.metrics(s, ["q"], rnge="3 m"), "^rnge: unknown key"),
    (lambda s, d: mk.metrics(s, ["q"], tolerance=3), "^tolerance: 3 is outside"), (lambda s, d: s.budget(temperature="warm"), "temperature: "),
    (lambda s, d: mk.light.planck([1.0, 2.0], [1.0, 2.0, 3.0]), "wavelength_um: has the shape"), (lambda s, d: mk.measure(3), "image: 3 is no image"),
    (lambda s, d: mk.noise.gaussian((3, 3), sd=1, seed=-1), "seed: -1 is below 0"),
])
def test_words(sensor, demo, work, words):
    with pytest.raises(mk.UsageError, match=words) as refused:
        work(sensor, demo)
    assert "/tmp" not in str(refused.value)


def test_messages_about_the_folder_of_a_picture(sensor, demo, tmp_path):
    (tmp_path / "scene.toml").write_text("schema = 1\n")
    with pytest.raises(mk.UsageError) as refused:
        mk.render(tmp_path / "scene.toml", sensor, solve=True)
    assert "mtfkit-render" not in str(refused.value)
    assert os.path.exists(demo / "camera.toml")


def test_line_pairs_are_cycles_in_data(sensor):
    a, b = (sensor.fit(curves=[mk.CurveData([5.0, 10, 20], [0.9, 0.8, 0.6], unit=unit)], free=["jitter.rms"]) for unit in ("cy/mm", "lp/mm"))
    assert a["jitter.rms"] == b["jitter.rms"]
