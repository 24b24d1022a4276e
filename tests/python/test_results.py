# SPDX-License-Identifier: Apache-2.0
"""Results say how long they took, and what they promise where there is a promise."""

import sys

import numpy as np
import pytest

import mtfkit as mk


def test_every_result_says_its_seconds(sensor, scene, demo, studies):
    study = mk.Study.load(studies / "stabilisation.toml")
    camera = mk.Sensor.load(demo / "camera.toml")
    edge = demo / "edge.exr"
    results = [sensor.simulate(scene, sample="3.75 um"), sensor.compile(scene, sample="3.75 um"), sensor.curves(),
               camera.budget(), mk.measure(edge), study.gradient(0), study.optimum(objective=0),
               mk.air.line(model="mid_latitude_summer", range="2 km"), mk.air.sky(model="mid_latitude_summer")]
    for result in results:
        assert 0 < result.seconds < 100, result
    assert 0 < study.run().attrs["seconds"] < 100


def test_curves_promise_their_error(sensor):
    # The band average against one of 4 times as many wavelengths by hand, and a table against its function.
    assert sensor.curves().promised == 0.0  # one wavelength, no table
    how = dict(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0))
    broad = mk.Sensor(band=dict(wavelength=["3.4 um", "4.8 um"]), presample=["diffraction"], **how).curves()
    nodes, weights = np.polynomial.legendre.leggauss(64)
    exact = 0.0
    for node, weight in zip(nodes, weights):
        one = mk.Sensor(presample=[mk.Diffraction(wavelength=(4.1 + 0.7 * node, "um"))], **how)
        exact = exact + 0.5 * weight * one.otf(broad.frequency, unit=broad.unit)
    assert 0 < broad.promised < 1e-5
    # 64 nodes see the kink of the cutoff, which moves with the wavelength, to 1e-6.
    assert np.abs(broad.system.otf - exact).max() <= broad.promised + 1e-6
    blur = mk.custom(lambda fx, fy: np.exp(-(fx ** 2 + fy ** 2) / 900), cutoff="200 cy/mm", tolerance=1e-4)
    table = mk.Sensor(presample=[blur], **how).curves()
    assert table.promised == blur.error
    assert np.abs(table.system.otf - np.exp(-table.frequency ** 2 / 900)).max() <= table.promised


def test_runs_promise_what_their_plan_does(sensor, scene):
    run = sensor.simulate(scene, sample="3.75 um", tolerance=1e-4)
    assert run.promised == run.report["plan"]["predicted_error"] <= run.tolerance == 1e-4
    with pytest.raises(mk.ToleranceError) as refused:
        sensor.compile(scene, sample="3.75 um", tolerance=1e-9)
    plan = sensor.compile(scene, sample="3.75 um", tolerance=refused.value.reachable)
    assert plan.promised <= refused.value.reachable


def test_results_are_drawn(sensor, scene, monkeypatch):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    curves = sensor.curves()
    axes = curves.plot()
    assert [line.get_label() for line in axes.lines][:len(curves)] == [column.label for column in curves]
    assert np.array_equal(axes.lines[len(curves) - 1].get_ydata(), curves.system.mtf) and curves.unit in axes.get_xlabel()
    assert curves.plot(axes) is axes
    run = sensor.simulate(scene, sample="3.75 um")
    assert np.array_equal(run.plot().images[0].get_array(), run.image)
    edge = mk.measure(sensor.simulate(mk.targets.edge(angle="5 deg")).image[16:-16, 16:-16] + mk.noise.gaussian((128, 128), sd=0.03))[0]
    assert np.array_equal(edge.plot().lines[0].get_ydata(), edge.mtf)
    fit = sensor.fit(curves=[mk.CurveData([5.0, 10, 20], [0.9, 0.8, 0.6], unit="cy/mm")], free=["jitter.rms"])
    assert np.array_equal(fit.plot(edge.plot()).lines[1].get_ydata(), fit.mtf)
    pyplot.close("all")
    flat = mk.measure(np.full((64, 64), 5.0, "f4"))[0]
    with pytest.raises(mk.UsageError, match="plot: the edge has no MTF"):
        flat.plot()
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match="Curves.plot needs matplotlib; install python3-matplotlib"):
        curves.plot()
