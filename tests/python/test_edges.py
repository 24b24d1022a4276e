# SPDX-License-Identifier: Apache-2.0
"""Edges measured and sensors fitted: the numbers of the command, and the loop that closes."""

import json

import numpy as np
import pytest
from conftest import run_command, run_json

import mtfkit as mk


@pytest.fixture(scope="module")
def truth():
    return mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0),
                     presample=[mk.Defocus(wavelength="4 um", distance="20 um"), mk.Footprint(width="15 um"),
                                mk.Jitter(rms="30 urad")])


@pytest.fixture(scope="module")
def images(truth):
    return [truth.simulate(mk.targets.edge(angle=angle)).image[16:-16, 16:-16]
            + mk.noise.gaussian((128, 128), sd=0.03, seed=1, frame=frame) for frame, angle in enumerate(["5 deg", "95 deg"])]


@pytest.mark.parametrize("method", ["regression", "both", "iso12233"])
def test_measurement_is_that_of_the_command(demo, method):
    said = run_json("measure", demo / "edge.exr", "--method", method, "--contrast-level", "0.35")
    for image in (demo / "edge.exr", mk.read(demo / "edge.exr")):
        edges = mk.measure(image, method=method, contrasts=[0.35])
        assert [edge.to_dict() for edge in edges] == said["edges"]
    edge = edges[0]
    assert edge.measured and edge.mtf50.value == said["edges"][0]["mtf50"]["value"]
    assert edge.frequency.shape == edge.mtf.shape and edge.figures["mtf35"].value > 0
    if method != "iso12233":
        assert edge.mtf_sd.shape == edge.mtf.shape and edge.mtf50.sd > 0
        assert np.allclose(np.abs(edge.otf)[:50], edge.mtf[:50], atol=5e-3)
    assert edges.to_pandas().loc[0, "mtf50"] == edge.mtf50.value


def test_units_need_their_lengths(demo):
    edges = mk.measure(demo / "edge.exr", unit="cy/mm", pitch="15 um")
    pixels = mk.measure(demo / "edge.exr")
    assert edges[0].mtf50.value == pytest.approx(pixels[0].mtf50.value / 15e-3, rel=1e-12)
    with pytest.raises(mk.UsageError, match="pitch"):
        mk.measure(demo / "edge.exr", unit="cy/mm")
    with pytest.raises(mk.UsageError, match="unit"):
        mk.measure(demo / "edge.exr", unit="cy/mm", pitch=15)
    for wrong in (dict(method="fast"), dict(unit="cy/um"), dict(roi=(1, 2, 3)), dict(method="both", circle=True)):
        with pytest.raises(mk.UsageError):
            mk.measure(demo / "edge.exr", **wrong)


def test_arrays_are_measured_as_files_of_them(demo, tmp_path):
    edge = mk.read(demo / "edge.exr").plane()
    assert mk.measure(edge)[0].mtf50 == mk.measure(demo / "edge.exr")[0].mtf50
    counts = np.round(edge * 25).clip(0, 255).astype("uint8")
    mk.write(tmp_path / "edge.png", counts, range=(0, 255), bits=8)
    of_file = mk.measure(tmp_path / "edge.png", encoding="linear")[0].to_dict()
    of_array = mk.measure(counts)[0].to_dict()
    for key in ("mtf50", "mtf", "noise_sd", "chi2_per_dof"):
        assert of_array[key] == of_file[key]


def test_what_cannot_be_measured_says_why():
    flat = mk.measure(np.full((64, 64), 3.0))
    assert len(flat) == 1 and not flat[0].measured and flat[0].reason and flat[0].mtf50 is None
    assert flat[0].mtf.shape == (0,)
    assert not mk.measure(np.full((64, 64), np.nan))[0].measured
    outside = mk.measure(np.zeros((64, 64)), roi=(50, 50, 40, 40))[0]
    assert outside.outcome != "measured" and "leaves the image" in outside.reason
    with pytest.raises(mk.UsageError, match="two dimensions"):
        mk.measure(np.zeros(10))
    with pytest.raises(mk.DataError):
        mk.measure("nowhere.png")


def test_measured_mtf_is_that_of_the_sensor(truth, images):
    for image in images:
        edge = mk.measure(image)[0]
        angle = np.radians(edge.angle_deg)
        true = truth.mtf(edge.frequency * np.cos(angle), edge.frequency * np.sin(angle), unit="cy/px")
        pull = (edge.mtf - true)[1:100] / edge.mtf_sd[1:100]
        assert np.sqrt(np.mean(pull ** 2)) < 4  # neighbouring frequencies share their noise: about one draw
        assert np.abs(edge.mtf - true)[1:100].max() < 0.01


def test_fit_is_that_of_the_command(demo, tmp_path):
    said = json.loads(run_command("fit", demo / "fit.toml", demo / "edge.exr", "-o", tmp_path / "fitted.toml", "--format",
                                  "json"))
    fit = mk.Sensor.load(demo / "fit.toml").fit(edges=[demo / "edge.exr"])
    assert fit.report["parameters"] == said["parameters"] and fit.report["mtf"] == said["mtf"]
    assert fit.sensor == mk.Sensor.load(tmp_path / "fitted.toml")
    assert fit.adequate and fit["jitter.rms"].verdict == "determined"


def test_the_fit_finds_the_sensor_behind_the_edges(truth, images):
    guess = truth.replace({"jitter.rms": "10 urad", "defocus.distance": "5 um"})
    fit = guess.fit(edges=images, free={"jitter.rms": ("0 urad", "80 urad"), "defocus.distance": ("0 um", "60 um")})
    assert fit.adequate and 0.8 < fit.chi2_per_dof < 1.2
    for name, value in (("jitter.rms", 30.0), ("defocus.distance", 20.0)):
        parameter = fit[name]
        if np.isfinite(parameter.sd):
            assert abs(parameter.value - value) < 4 * parameter.sd
    assert fit.table.loc["jitter.rms", "unit"] == "urad"
    covariance = fit.covariance
    assert covariance.shape == (2, 2)
    assert np.allclose(covariance, covariance.T, equal_nan=True)
    f = np.linspace(0, 0.5, 6)
    assert np.abs(fit.sensor.mtf(f, unit="cy/px") - truth.mtf(f, unit="cy/px")).max() < 0.01
    assert "fit = true" in fit.sensor.text and "stderr" in fit.sensor.text
    again = mk.measure(fit.sensor.simulate(mk.targets.edge(angle="5 deg")).image, roi=(16, 16, 128, 128))[0]
    assert again.mtf50.value == pytest.approx(mk.measure(images[0])[0].mtf50.value, abs=0.01)
    assert fit.residuals[0][1].dtype == np.float32


def test_curves_and_spots_join_a_fit(truth):
    f = np.linspace(1, 30, 20)
    curve = mk.CurveData(f, truth.mtf(f), sd=1e-3)
    guess = truth.replace({"jitter.rms": "10 urad"})
    fit = guess.fit(curves=[curve], free=["jitter.rms"])
    assert abs(fit["jitter.rms"].value - 30.0) < 0.1
    with pytest.raises(mk.UsageError, match="different lengths"):
        guess.fit(curves=[mk.CurveData([1, 2], [1.0])], free=["jitter.rms"])
    with pytest.raises(mk.UsageError, match="no data"):
        guess.fit(free=["jitter.rms"])
    with pytest.raises(mk.UsageError, match="nothing to fit"):
        guess.fit(curves=[curve])
    with pytest.raises(mk.UsageError, match="jitter.rmz"):
        guess.fit(curves=[curve], free=["jitter.rmz"])
    with pytest.raises(mk.UsageError, match="does not state"):
        guess.fit(curves=[curve], free=["optics.obscuration"])
    with pytest.raises(mk.UsageError, match="pair of bounds"):
        guess.fit(curves=[curve], free={"jitter.rms": 3})
    with pytest.raises(mk.UsageError, match="list of images"):
        guess.fit(edges=np.zeros((8, 8)), free=["jitter.rms"])


def test_values_that_describe_the_data_alike_are_given_and_what_the_errors_leave_out(truth, images):
    guess = truth.replace({"defocus.distance": "-15 um"})
    fit = guess.fit(edges=images, free={"defocus.distance": None})
    distance = fit["defocus.distance"]
    assert distance.verdict.startswith("ambiguous: defocus.distance: the data do not tell")
    assert distance.value < 0 and distance.others == (-distance.value,)
    assert abs(abs(distance.value) - 20) < 4 * distance.sd  # micrometres
    # There is a jitter; a motion along either axis is what the sensor lacks.
    assert [name for name, _, _ in distance.sensitivity] == ["motion along x", "motion along y"]
    for _, value, sd in distance.sensitivity:
        assert sd >= distance.sd and abs(abs(value) - 20) < 4 * sd


def test_what_the_data_cannot_tell_is_said(images):
    twins = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0, wavelength="4 um"),
                      presample=["diffraction", mk.Jitter(rms="30 urad"), mk.Gaussian(sigma="3 um")])
    fit = twins.fit(edges=images[:1], free=["jitter.rms", "gaussian.sigma"])
    assert any("not determined" in p.verdict or ":" in p.verdict for p in fit.parameters)
    assert fit.report["not_separable"]
