# SPDX-License-Identifier: Apache-2.0
"""Sensors: built, loaded, changed, saved, explained; the same numbers as the command."""

import pickle
import warnings

import numpy as np
import pytest
from conftest import run_command, run_json

import mtfkit as mk


def test_keywords_and_file_make_the_same_sensor(sensor, tmp_path):
    path = tmp_path / "sensor.toml"
    sensor.save(path)
    assert mk.Sensor.load(path) == sensor
    assert hash(mk.Sensor.load(path)) == hash(sensor)
    assert sensor.replace({"jitter.rms": "21 urad"}) != sensor
    # Units and comments are no part of the value.
    assert mk.Sensor.parse("# mine\n" + sensor.text) == sensor


def test_otf_at_nyquist_is_the_published_product(sensor):
    # sinc(1/2) of the footprint, diffraction at 33.3 of 125 cy/mm, a Gaussian of 2 um.
    f, cutoff = 1e3 / 30, 125.0
    x = f / cutoff
    diffraction = 2 / np.pi * (np.arccos(x) - x * np.sqrt(1 - x * x))
    product = diffraction * np.sinc(0.5) * np.exp(-2 * (np.pi * 2e-3 * f) ** 2)
    assert abs(sensor.mtf(f) - product) < 1e-12
    assert abs(sensor.mtf(f) - 0.3875) < 5e-5


def test_otf_broadcasts_and_knows_its_units(sensor):
    f = np.linspace(0, 60, 7)
    values = sensor.otf(f, 0.0, unit="cy/mm")
    assert values.dtype == np.complex128 and values.shape == f.shape
    assert sensor.otf(f[:, None], f[None, :]).shape == (7, 7)
    assert np.array_equal(sensor.otf(f[:, None], f[None, :])[:, 0], values)
    np.testing.assert_allclose(sensor.otf(f * 15e-3, unit="cy/px"), values, rtol=0, atol=1e-15)
    np.testing.assert_allclose(sensor.otf(f * 0.1, unit="cy/mrad"), values, rtol=0, atol=1e-15)
    assert isinstance(complex(sensor.otf(10.0)), complex)
    with pytest.raises(mk.UsageError, match="cy/um"):
        sensor.otf(f, unit="cy/um")
    with pytest.raises(mk.UsageError, match="type <U2"):
        sensor.otf(["10"])


@pytest.mark.parametrize("angle,unit", [("0 deg", "cy/mm"), ("45 deg", "cy/px"), ((30, "deg"), "cy/mrad")])
def test_curves_are_those_of_the_command(demo, angle, unit):
    degrees = {"0 deg": "0", "45 deg": "45"}.get(angle, "30")
    for name in ("sensor.toml", "camera.toml", "uncooled.toml"):
        said = run_json("curve", demo / name, "--freq", "0:0.9:10", "--unit", unit, "--angle", degrees)
        made = mk.Sensor.load(demo / name).curves(said["frequency"], angle=angle, unit=unit)
        assert made.frequency.tolist() == said["frequency"]
        for entry in [*said["components"], {"label": "system", **said["system"]}]:
            assert made[entry["label"]].otf.real.tolist() == entry["re"]
            assert made[entry["label"]].otf.imag.tolist() == entry["im"]
        assert (made.nyquist, made.cutoff, made.q) == (said["nyquist"], said["cutoff"], said["q"])


def test_curves_as_tables(sensor):
    curves = sensor.curves(np.linspace(0, 60, 61))
    frame = curves.to_pandas()
    assert list(frame.columns) == ["diffraction", "footprint", "jitter", "presample", "system"]
    assert frame.attrs["units"] == {"frequency": "cy/mm"}
    array = curves.to_xarray()
    assert array.dims == ("component", "frequency") and array.attrs["units"] == "1"
    assert "<table>" in curves._repr_html_()


@pytest.mark.parametrize("name,temperature", [("camera.toml", "288 K"), ("uncooled.toml", "15 degC")])
def test_budget_is_that_of_the_command(demo, name, temperature):
    said = run_json("budget", demo / name, "--temperature", temperature)["terms"]
    budget = mk.Sensor.load(demo / name).budget(temperature=temperature)
    assert list(budget) == list(said)
    for term, entry in said.items():
        assert budget[term].unit == entry["unit"]
        assert budget[term].value == entry["value"] or (entry["value"] is None and np.isnan(budget[term].value))
    assert budget["netd"].to("K") == pytest.approx(1e-3 * budget["netd"].to("mK"), rel=1e-15)
    assert list(budget.to_pandas().index) == list(said)
    with pytest.raises(mk.UsageError, match="has no 'nedt'"):
        budget["nedt"]
    with pytest.raises(mk.UsageError, match="different things"):
        budget["netd"].to("um")


def test_explain_and_check_are_those_of_the_command(demo):
    path = demo / "camera.toml"
    camera = mk.Sensor.load(path)
    assert str(camera.explain()) + "" == run_command("config", "explain", path)
    assert camera.check()
    said = run_json("config", "check", path)["diagnostics"]
    assert [finding.text for finding in camera.check()] == [entry["text"] for entry in said]


def test_a_sensor_never_changes(sensor):
    with pytest.raises(AttributeError, match="never changes"):
        sensor.name = "other"
    text = sensor.text
    sensor.replace({"jitter.rms": "60 urad"})
    assert sensor.text == text


def test_replace_keeps_comments_and_takes_every_form():
    starter = mk.Sensor.starter()
    changed = starter.replace({"jitter.rms": (60, "urad"), "optics.f_number": 4, "presample[1].width": "14 um"})
    assert changed.text.count("#") == starter.text.count("#")
    assert 'rms = "60 urad"' in changed.text
    with pytest.raises(mk.UsageError, match="did you mean|nearest|jitter.rms"):
        starter.replace({"jitter.rmz": "1 urad"})
    with pytest.raises(mk.UsageError, match="unit"):
        starter.replace({"jitter.rms": 60})


def test_tables_are_changed_and_added(sensor):
    other = sensor.replace({"scene.border": "periodic", "frame.format": [64, 32], "detector.quantum_efficiency": 0.7})
    assert 'border = "periodic"' in other.text and "format = [64, 32]" in other.text and "[detector]" in other.text
    assert other == sensor.append(detector=dict(quantum_efficiency=0.7)).replace(
        {"scene.border": "periodic", "frame.format": (64, 32)})
    for values, words in (({"scene.bordr": "periodic"}, 'did you mean "border"'), ({"sceen.border": "x"}, "no parameter"),
                          ({"scene.border": "round"}, "unknown word")):
        with pytest.raises(mk.UsageError, match=words):
            sensor.replace(values)
    with pytest.raises(mk.UsageError, match="TOML"):
        other.append(detector=dict(quantum_efficiency=0.5))
    with pytest.raises(mk.UsageError, match="no table"):
        sensor.append(adc=14)


def test_saved_elsewhere_a_sensor_finds_its_files(tmp_path, sensor):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    (tmp_path / "a" / "lens.csv").write_text("frequency_cy_mm,mtf\n0,1\n30,0.5\n60,0.1\n")
    path = tmp_path / "a" / "s.toml"
    path.write_text(sensor.text + '[[presample]]\nkind = "curve"\nfile = "lens.csv"\n')
    loaded = mk.Sensor.load(path)
    loaded.save(tmp_path / "b" / "s.toml")
    assert mk.Sensor.load(tmp_path / "b" / "s.toml").mtf(30.0) == loaded.mtf(30.0)
    assert pickle.loads(pickle.dumps(loaded)).mtf(30.0) == loaded.mtf(30.0)


def test_what_a_sensor_names_is_where_it_was(tmp_path, monkeypatch):
    for name in ("here", "there"):
        (tmp_path / name).mkdir()
    (tmp_path / "here" / "lens.csv").write_text("frequency_cy_mm,mtf\n0,1\n30,0.5\n60,0.1\n")
    monkeypatch.chdir(tmp_path / "here")
    sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), presample=[dict(kind="curve", file="lens.csv"), mk.Jitter(rms="9 urad")])
    data = pickle.dumps(sensor)
    monkeypatch.chdir(tmp_path / "there")
    sensor.save("s.toml")
    for other in (sensor.replace({"jitter.rms": "9 urad"}), pickle.loads(data), mk.Sensor.load("s.toml")):
        assert other.mtf(20.0) == sensor.mtf(20.0)


def test_bare_numbers_and_wrong_keys_are_errors_that_say_so():
    good = dict(focal_length="100 mm", pitch="15 um")
    with pytest.raises(mk.UsageError, match=r"focal_length.*\n?.*unit"):
        mk.Sensor(frame=dict(focal_length=100, pitch="15 um"))
    with pytest.raises(mk.UsageError, match="focal_lengh"):
        mk.Sensor(frame=dict(focal_lengh="100 mm", pitch="15 um"))
    with pytest.raises(mk.UsageError, match="list of components"):
        mk.Sensor(frame=good, presample="diffraction")
    with pytest.raises(mk.UsageError, match="no component"):
        mk.Sensor(frame=good, presample=[3])
    with pytest.raises(mk.UsageError, match="not a finite"):
        mk.Sensor(frame=good, optics=dict(f_number=float("nan")))
    with pytest.raises(mk.UsageError, match="no value of a sensor file"):
        mk.Sensor(frame=good, optics=dict(f_number=object()))
    with pytest.raises(ValueError):
        mk.Sensor(frame=good, optics=dict(f_number=-2.0))
    with pytest.raises(mk.UsageError, match=r"'MWIR' has no name.*frame=dict.*mtfkit\.Sensor\.load"):
        mk.Sensor("MWIR")
    with pytest.raises(mk.UsageError, match=r"D=0.1 is no table.*frame=dict.*aperture"):
        mk.Sensor(D=0.1)
    with pytest.raises(mk.UsageError, match="needs frame"):
        mk.Sensor()
    with pytest.raises(mk.UsageError, match="has no unit"):
        mk.Sensor(frame=good, detector=dict(quantum_efficiency=0.7)).budget(temperature=300)
    with pytest.raises(mk.DataError, match="nowhere.toml"):
        mk.Sensor.load("nowhere.toml")


def test_errors_are_a_small_family():
    assert issubclass(mk.UsageError, mk.Error) and issubclass(mk.UsageError, ValueError)
    assert issubclass(mk.ToleranceError, mk.UsageError)
    assert issubclass(mk.DataError, mk.Error) and issubclass(mk.DataError, RuntimeError)
    error = pickle.loads(pickle.dumps(mk.ToleranceError("no", 2e-7)))
    assert error.reachable == 2e-7 and str(error) == "no"


def test_components_have_classes_of_their_own(sensor):
    typed = mk.Sensor(name="MWIR", frame=dict(focal_length="100 mm", pitch="15 um"),
                      optics=dict(f_number=2.0, wavelength="4 um"),
                      presample=[mk.Diffraction(), mk.Footprint(width="15 um"), mk.Jitter(rms="20 urad")])
    assert typed == sensor
    assert mk.Jitter(rms=(20, "urad")).rms == (20, "urad")
    assert pickle.loads(pickle.dumps(mk.Jitter(rms="20 urad"))) == mk.Jitter(rms="20 urad")
    assert "one standard deviation" in mk.Jitter.__doc__ or "rms" in mk.Jitter.__doc__
    with pytest.raises(mk.UsageError, match="rms"):
        mk.Jitter(rsm="20 urad")
    with pytest.raises(mk.UsageError, match="needs"):
        mk.Jitter()
    with pytest.raises(AttributeError):
        mk.Jiter
    for made in mk.components.classes().values():
        assert made.__doc__ and made.stages


def test_sensors_pickle(sensor, demo):
    for one in (sensor, mk.Sensor.load(demo / "camera.toml")):
        assert pickle.loads(pickle.dumps(one)) == one


def test_values_are_read_by_the_names_of_replace(sensor):
    assert sensor["jitter.rms"] == sensor.jitter.rms == sensor["presample[2].rms"] == "20 urad"
    assert sensor["optics.f_number"] == sensor.optics.f_number == 2.0 and sensor.frame.pitch == "15 um"
    assert sensor.replace({"jitter.rms": {"value": "7 urad", "fit": True}})["jitter.rms"] == "7 urad"
    assert sensor.replace({"frame.format": [640, 512]})["frame.format"] == [640, 512]
    assert sensor["diffraction.obscuration"] is None  # left at its default
    for name in ("jitter.rms", "optics.f_number", "frame.pitch"):
        assert sensor.replace({name: sensor[name]}) == sensor
    assert "jitter.rms" in sensor and "jitter.rsm" not in sensor and 3 not in sensor
    assert {"frame", "optics", "jitter", "save"} <= set(dir(sensor)) and "pitch" in dir(sensor.frame)
    assert "pitch='15 um'" in repr(sensor.frame)


def test_a_wrong_name_gives_the_nearest_one(sensor):
    with pytest.raises(mk.UsageError, match=r"'jitter\.rsm'; did you mean jitter\.rms\?"):
        sensor["jitter.rsm"]
    with pytest.raises(mk.UsageError, match=r"jitter.rms\[3\]: .*index"):
        sensor["jitter.rms[3]"]
    with pytest.raises(mk.UsageError, match=r"'frame\.pich'; did you mean frame\.pitch\?"):
        sensor["frame.pich"]
    with pytest.raises(AttributeError, match=r"did you mean frame\.pitch\?"):
        sensor.frame.pich
    with pytest.raises(AttributeError, match="'f_number'; it has .*optics"):
        sensor.f_number
    with pytest.raises(TypeError):
        iter(sensor)


def test_a_sensor_is_shown_in_a_few_lines(sensor, demo):
    assert repr(sensor) == """<Sensor 'MWIR'
  frame: focal_length = "100 mm", pitch = "15 um"
  optics: f_number = 2.0, wavelength = "4 um"
  presample: diffraction, footprint (width = "15 um"), jitter (rms = "20 urad")>"""
    table = mk.custom(lambda fx, fy: np.exp(-(fx ** 2 + fy ** 2) / 1600), cutoff="200 cy/mm", label="coating")
    for other in (mk.Sensor.load(demo / "camera.toml"), sensor.append(presample=[table]), mk.Sensor.starter()):
        lines = repr(other).split("\n")
        assert len(lines) <= 8 and max(map(len, lines)) <= 111 and lines[-1].endswith(">")
    assert "coating" in repr(sensor.append(presample=[table])) and "detector" in repr(mk.Sensor.load(demo / "camera.toml"))


def test_one_value_needs_no_name():
    assert mk.Jitter("20 urad") == mk.Jitter(rms="20 urad") and mk.Fir([[1.0]]) == mk.Fir(taps=[[1.0]])
    for wrong in (lambda: mk.Footprint("15 um"), lambda: mk.Jitter("1 um", "2 um"), lambda: mk.Jitter("1 um", rms="2 um")):
        with pytest.raises(mk.UsageError, match="each with its name, such as "):
            wrong()


def test_findings_without_a_place_have_none():
    found = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um")).check()
    assert "diffraction" in str(found) and "0:0" not in str(found)


def test_an_otf_over_the_field_says_that_it_is_that_of_the_axis(tmp_path):
    path = tmp_path / "field.toml"
    path.write_text("""schema = 2
[frame]
focal_length = "100 mm"
pitch = "15 um"
format = [16, 12]
[optics]
f_number = 2.0
wavelength = "4 um"
[[presample]]
kind = "wavefront"
orientation = "field"
w131 = { r = 0.7 }
""")
    sensor = mk.Sensor.load(path)
    with pytest.warns(UserWarning, match="optical axis"):
        on_axis = sensor.otf(30.0)
    assert on_axis.imag == 0.0
    fixed = mk.Sensor.parse(path.read_text().replace('"field"', '"36.869897645844021 deg"').replace("{ r = 0.7 }", "0.7"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        here = sensor.otf([30.0, 10.0], [10.0, 50.0], field=(0.8, 0.6))
        assert np.allclose(here, fixed.otf([30.0, 10.0], [10.0, 50.0]), rtol=0, atol=1e-12)
        assert sensor.mtf(30.0, field=(0.8, 0.6)) == sensor.curves([30.0], field=(0.8, 0.6)).system.mtf[0]
    with pytest.raises(mk.UsageError, match="half diagonals"):
        sensor.otf(30.0, field=(9, 9))
    with pytest.raises(mk.UsageError, match="place"):
        sensor.otf(30.0, field=0.5)
    scene = np.random.default_rng(1).normal(size=(12, 16)).astype(np.float32)
    image = sensor.simulate(scene, sample="15 um", quantity="counts", tolerance=1e-2).image
    assert np.isfinite(np.asarray(image)).all()
