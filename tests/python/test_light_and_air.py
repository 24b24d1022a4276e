# SPDX-License-Identifier: Apache-2.0
"""Light, air and figures of merit: the numbers of the libraries and of the command."""

import json
import numpy as np
import pytest
from conftest import run_command

import mtfkit as mk

SIGMA = 5.670374419e-8  # CODATA 2018


def test_blackbody_keeps_stefan_boltzmann_and_wien():
    t = np.array([77.0, 300.0, 1200.0])
    whole = mk.light.band_radiance(("0.05 um", "1e6 um"), t)
    np.testing.assert_allclose(np.pi * whole, SIGMA * t ** 4, rtol=1e-9)
    peak = 2897.771955 / 300
    around = mk.light.planck([peak * 0.999, peak, peak * 1.001], 300.0)
    assert around[1] > around[0] and around[1] > around[2]
    band = ("3.4 um", "4.8 um")
    step = 1e-3
    slope = (mk.light.band_radiance(band, 300 + step) - mk.light.band_radiance(band, 300 - step)) / (2 * step)
    assert mk.light.band_derivative(band, 300.0) == pytest.approx(slope, rel=1e-8)
    assert mk.light.band_temperature(band, mk.light.band_radiance(band, t)) == pytest.approx(t, rel=1e-13)
    assert mk.light.brightness_temperature(4.0, mk.light.planck(4.0, t)) == pytest.approx(t, rel=1e-13)
    assert mk.light.log_planck(4.0, 300.0) == pytest.approx(np.log(mk.light.planck(4.0, 300.0)), rel=1e-14)
    photons = mk.light.planck(4.0, 300.0, flux="photons")
    energy = 6.62607015e-34 * 299792458 / 4e-6
    assert photons * energy == pytest.approx(mk.light.planck(4.0, 300.0), rel=1e-14)
    assert np.isnan(mk.light.planck(4.0, -1.0)) and mk.light.planck(4.0, 0.0) == 0.0
    with pytest.raises(mk.UsageError, match="flux"):
        mk.light.planck(4.0, 300.0, flux="lumen")
    with pytest.raises(mk.UsageError, match="unit"):
        mk.light.band_radiance((3, 5), 300.0)


def test_band_response_is_the_band_where_the_curve_is_one():
    band = ("3.4 um", "4.8 um")
    flat = mk.light.BandResponse(band, [([3.0, 5.0], [1.0, 1.0])])
    assert flat.range_um == (3.4, 4.8) and flat.integral_um == pytest.approx(1.4)
    assert flat.radiance(300.0) == pytest.approx(mk.light.band_radiance(band, 300.0), rel=1e-12)
    assert flat.derivative(300.0, flux="photons") == pytest.approx(
        mk.light.band_derivative(band, 300.0, flux="photons"), rel=1e-12)
    with pytest.raises(mk.UsageError):
        mk.light.BandResponse(band, [([5.0, 6.0], [1.0, 1.0])])


def test_air_is_that_of_the_command():
    said = json.loads(run_command("atmosphere", "--model", "mid_latitude_summer", "--haze", "rural", "--range", "2 km",
                                  "--bands", "3.4:4.8,8:12", "--format", "json"))
    line = mk.air.line(model="mid_latitude_summer", haze="rural", range="2 km", bands=[("3.4 um", "4.8 um"), ("8 um", "12 um")])
    assert line.report == said
    assert line.bands[1].transmission == said["bands"][1]["transmission"]
    assert line.transmittance.shape == line.wavelength_um.shape
    assert all(curve.shape == line.transmittance.shape for curve in line.components.values())
    assert list(line.to_pandas().columns[:2]) == ["transmittance", "path_radiance"]
    sky = json.loads(run_command("atmosphere", "--model", "us_standard_1976", "--sky", "--bands", "8:12", "--format", "json"))
    made = mk.air.sky(model="us_standard_1976", bands=[("8 um", "12 um")])
    assert made.report == sky and made.in_band().shape == made.zenith_angle_deg.shape
    with pytest.raises(mk.UsageError, match="cloud"):
        mk.air.sky(model="us_standard_1976", cloud_cover=0.5)
    with pytest.raises(mk.UsageError):
        mk.air.line(model="mars", range="2 km")


def test_metrics_are_those_of_studies(studies, sensor, demo):
    study = mk.Study.load(studies / "aperture_against_pitch.toml")
    row = dict(zip((c.name for c in study.columns), study.rows(600, 601)[0]))
    names = ["niirs_giqe5", "target_snr", "rer_x", "mtf_nyquist", "q"]
    conditions = {}
    for line in (studies / "aperture_against_pitch.toml").read_text().split("[conditions]")[1].splitlines():
        if "=" in line and not line.startswith("#"):
            key, value = line.split("#")[0].split("=")
            conditions[key.strip()] = json.loads(value)
    made = mk.metrics(study.sensor(600), names, tolerance=study.tolerance, **conditions)
    for name in names:
        assert made[name].value == pytest.approx(row[name], rel=1e-9)
    nothing = mk.metrics(sensor, ["netd", "mtf50_x"])
    assert np.isnan(nothing["netd"].value) and "detector" in nothing["netd"].reason
    assert nothing["mtf50_x"].value > 0 and nothing["mtf50_x"].unit
    budget = mk.Sensor.load(demo / "camera.toml").budget(temperature="300 K")["netd"]
    assert mk.metrics(mk.Sensor.load(demo / "camera.toml"), ["netd"])["netd"].to("mK") == pytest.approx(budget.to("mK"), rel=1e-6)
    with pytest.raises(mk.UsageError, match="mtf_nyqist"):
        mk.metrics(sensor, ["mtf_nyqist"])
