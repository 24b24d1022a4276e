# SPDX-License-Identifier: Apache-2.0
"""The four examples that the package was designed by, as a user would write them."""

from concurrent.futures import ProcessPoolExecutor

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtfkit as mk


def test_build_budget_plot(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sensor = mk.Sensor(name="MWIR", frame=dict(focal_length="100 mm", pitch="15 um"),
                       optics=dict(f_number=2.0, wavelength="4 um"),
                       presample=["diffraction", dict(kind="footprint", width="15 um"), dict(kind="jitter", rms="20 urad")])
    f = np.linspace(0, 60, 601)
    h = sensor.otf(f, 0.0, unit="cy/mm")
    assert h.dtype == np.complex128 and h.shape == f.shape
    assert abs(sensor.mtf(1e3 / 30) - 0.3875) < 5e-5
    curves = sensor.curves(f, angle="45 deg")
    curves.to_pandas().plot(ylim=(0, 1))
    assert curves.to_xarray().dims == ("component", "frequency")
    blurrier = sensor.replace({"jitter.rms": "60 urad"})
    assert blurrier.mtf(20.0) < sensor.mtf(20.0)
    print(sensor.explain())
    sensor.save("sensor.toml")
    assert mk.Sensor.load("sensor.toml") == sensor


def test_simulate(demo, sensor):
    scene = mk.read(demo / "scene.exr").plane("Y")
    run = sensor.simulate(scene, sample="3.75 um", tolerance=1e-4)
    assert run.image.dtype == np.float32 and run.promised <= 1e-4 and run.report and run.explain()
    plan = sensor.compile(scene.shape, sample="3.75 um", tolerance=1e-4)
    frame = None
    for rms in np.linspace(10, 60, 26):
        plan = plan.replace(sensor.replace({"jitter.rms": (rms, "urad")}))
        frame = plan(scene, out=frame, threads=1)
    camera = mk.Sensor.load(demo / "camera.toml")
    counts = camera.simulate(mk.read(demo / "thermal.exr"), stage="dn", frame=7).image
    assert counts.max() > 1000
    budget = camera.budget(temperature="288 K")
    assert 10 < budget["netd"].to("mK") < 100
    assert "netd" in budget.to_pandas().index


def test_measure_and_fit(tmp_path):
    sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0),
                       presample=[mk.Defocus(wavelength="4 um", distance="20 um"), mk.Footprint(width="15 um"),
                                  mk.Jitter(rms="20 urad")])
    image1, image2 = (sensor.simulate(mk.targets.edge(angle=angle)).image[16:-16, 16:-16]
                      + mk.noise.gaussian((128, 128), sd=0.03, frame=frame)
                      for frame, angle in enumerate(["5 deg", "95 deg"]))
    edges = mk.measure(image1)
    e = edges[0]
    assert 0.2 < e.mtf50.value < 0.6 and e.mtf50.sd < 0.01
    plt.fill_between(e.frequency, e.mtf - 2 * e.mtf_sd, e.mtf + 2 * e.mtf_sd, alpha=.3)
    fit = sensor.fit(edges=[image1, image2], free={"jitter.rms": ("0 urad", "80 urad"), "defocus.distance": None})
    assert list(fit.table.columns) == ["value", "sd", "unit", "start", "low", "high", "verdict"]
    assert fit.covariance.shape == (2, 2) and fit.adequate
    fit.sensor.save(tmp_path / "fitted.toml")
    loop = mk.measure(fit.sensor.simulate(mk.targets.edge(angle="5 deg")).image[16:-16, 16:-16])
    assert abs(loop[0].mtf50.value - e.mtf50.value) < 5 * e.mtf50.sd


def test_trade_study(studies):
    study = mk.Study.load(studies / "aperture_against_pitch.toml")
    df = study.run(threads=2, progress=True)
    ok = df[df.feasible]
    front = study.pareto(ok)
    study.to_xarray(df)["niirs_giqe5"].plot()
    best = front.niirs_giqe5.idxmax()
    study.sensor(best).curves().to_pandas()
    assert study.gradient(best).to_pandas().shape[1] == 2
    with ProcessPoolExecutor(2) as pool:
        rows = pool.map(study.rows, [0, 600], [600, 1221])
        assert study.frame(list(rows)).equals(df)
