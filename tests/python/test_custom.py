# SPDX-License-Identifier: Apache-2.0
"""Components made of functions: their numbers, their promise, and what is refused."""

import pickle

import numpy as np
import pytest

import mtfkit as mk

FRAME = dict(focal_length="100 mm", pitch="15 um")


def gaussian(fx, fy, sigma_mm=4e-3):
    return np.exp(-2 * (np.pi * sigma_mm) ** 2 * (fx ** 2 + fy ** 2))


def test_a_function_is_the_component_that_it_copies():
    mine = mk.Sensor(frame=FRAME, optics=dict(f_number=2.0, wavelength="4 um"),
                     presample=["diffraction", mk.custom(gaussian, cutoff="400 cy/mm", label="coating")])
    theirs = mk.Sensor(frame=FRAME, optics=dict(f_number=2.0, wavelength="4 um"),
                       presample=["diffraction", mk.Gaussian(sigma="4 um")])
    f = np.linspace(-130, 130, 301)
    assert np.abs(mine.otf(f[:, None], f) - theirs.otf(f[:, None], f)).max() < 1e-6
    assert mine.curves().columns[1].label == "coating"


def test_the_promise_is_kept_against_the_function(scene):
    # The function itself on the frequencies of the mirrored scene, folded by the sampling: numpy and nothing of ours.
    made = mk.custom(gaussian, cutoff="400 cy/mm", tolerance=1e-5)
    sensor = mk.Sensor(frame=FRAME, presample=[made])
    mirrored = np.block([[scene, scene[:, ::-1]], [scene[::-1], scene[::-1, ::-1]]]).astype("f8")
    fy, fx = (np.fft.fftfreq(n, 3.75e-3) for n in mirrored.shape)
    spectrum = np.fft.fft2(mirrored) * gaussian(fx[None, :], fy[:, None])
    # Pixel centres lie 1.5 samples beyond the first sample.
    shift = np.exp(2j * np.pi * 1.5 * 3.75e-3 * (fx[None, :] + fy[:, None]))
    exact = np.fft.ifft2(spectrum * shift).real[:scene.shape[0]:4, :scene.shape[1]:4]
    for tolerance in (1e-3, 1e-5):
        run = sensor.simulate(scene, sample="3.75 um", tolerance=tolerance)
        error = np.sqrt(np.mean((run.image - exact) ** 2)) / scene.std()
        assert error <= run.promised
        assert run.promised <= tolerance + 1e-3
    plan = sensor.compile(scene, sample="3.75 um", tolerance=1e-4)
    assert np.sqrt(np.mean((plan(scene) - exact) ** 2)) / scene.std() <= plan.promised


def test_products_of_x_and_y(scene):
    made = mk.custom(lambda fx, fy: np.sinc(fx) * np.exp(-fy ** 2), cutoff=(4.0, "cy/px"), label="stripe")
    assert made.axis == "separable"
    sensor = mk.Sensor(frame=FRAME, presample=[made])
    assert [c.label for c in sensor.curves()][:2] == ["stripe_x", "stripe_y"]
    assert abs(sensor.otf(0.3, 0.7, unit="cy/px") - np.sinc(0.3) * np.exp(-0.49)) < 1e-6


def test_it_saves_pickles_and_changes(tmp_path):
    sensor = mk.Sensor(frame=FRAME, presample=[mk.custom(gaussian, cutoff="400 cy/mm"), mk.Jitter(rms="20 urad")])
    for other in (pickle.loads(pickle.dumps(sensor)), sensor.replace({"jitter.rms": "20 urad"})):
        assert other.otf(20.0, 10.0) == sensor.otf(20.0, 10.0)
    sensor.save(tmp_path / "mine.toml")
    assert [p.name for p in tmp_path.iterdir()] == ["mine.toml"]  # the text holds the table
    again = mk.Sensor.load(tmp_path / "mine.toml")
    assert again.otf(20.0, 10.0) == sensor.otf(20.0, 10.0) and again.sha256 == sensor.sha256
    assert again == sensor and hash(again) == hash(sensor)
    assert mk.Sensor.parse(sensor._file.canonical("/x/sensor.toml")) == sensor


@pytest.mark.parametrize("function,words", [
    (lambda fx, fy: 0.9 + 0 * fx, r"otf\(0, 0\)"),
    (lambda fx, fy: np.cosh(fx / 100), "at most 1"),
    (lambda fx, fy: np.exp(2j * np.pi * np.abs(fx) * 0.01), "complex conjugate"),
    (lambda fx, fy: np.exp(-np.where(fx > 0, 1, 2) * fx ** 2), "complex conjugate"),
    (lambda fx, fy: np.where(fx > 20, np.nan, 1.0), "not finite"),
    (lambda fx, fy: 1.0, "shape"),
    (lambda fx, fy: np.full(np.shape(fx), "1"), "type <U1"),
])
def test_what_no_component_may_be_is_refused(function, words):
    with pytest.raises(mk.UsageError, match=words):
        mk.custom(function, cutoff="60 cy/mm")


def test_arguments_say_what_they_are():
    for cutoff in (60, "60", "60 um", "-3 cy/mm", "x cy/mm", (np.nan, "cy/mm")):
        with pytest.raises(mk.UsageError, match="cutoff"):
            mk.custom(gaussian, cutoff=cutoff)
    with pytest.raises(mk.UsageError, match="label"):
        mk.custom(gaussian, cutoff="60 cy/mm", label="a/b")
    with pytest.raises(ZeroDivisionError):
        mk.custom(lambda fx, fy: 1 / 0, cutoff="60 cy/mm")
    with pytest.raises(mk.UsageError, match="labels are unique"):
        mk.Sensor(frame=FRAME, presample=[mk.custom(gaussian, cutoff="400 cy/mm"),
                                          mk.custom(lambda fx, fy: gaussian(fx, fy, 1e-3), cutoff="400 cy/mm")])


def test_a_function_that_goes_on_beyond_its_cutoff_is_said():
    with pytest.warns(UserWarning, match="up to 1 between 3 and 6 cy/mm, beyond the cutoff"):
        mk.custom(gaussian, cutoff="3 cy/mm")

    def ends(fx, fy):
        with np.errstate(invalid="raise"):
            return np.sqrt(1 - (fx ** 2 + fy ** 2) / 60 ** 2)  # nothing beyond

    mk.custom(ends, cutoff="60 cy/mm", tolerance=0.1)


@pytest.mark.parametrize("profile,cutoff", [
    (lambda f: np.exp(-f / 50), 700), (lambda f: np.exp(-(f / 30) ** (5 / 3)), 200), (lambda f: np.exp(-(f / 55) ** 1.5), 400),
    (lambda f: np.exp(-(f / 30) ** 0.8), 900)], ids=["exponential", "turbulence", "power 1.5", "power 0.8"])
def test_a_tip_at_zero_is_a_table(profile, cutoff, tmp_path):
    """Against the function itself, from a billionth of the cutoff on."""
    made = mk.custom(lambda fx, fy: profile(np.hypot(fx, fy)), cutoff=(cutoff, "cy/mm"), label="own")
    assert isinstance(made, mk.Custom) and made.axis == "radial" and made.error <= 1e-6 and made.frequency.size < 1000
    sensor = mk.Sensor(frame=FRAME, optics=dict(f_number=2.0, wavelength="4 um"), presample=[made, mk.Jitter(rms="20 urad")])
    f = cutoff * np.append(np.geomspace(1e-9, 1.0, 20000)[:-1], np.linspace(0.0, 0.999, 20000))
    alone = mk.Sensor(frame=FRAME, presample=[made])
    for angle in (0.0, 0.7):
        assert np.abs(alone.otf(f * np.cos(angle), f * np.sin(angle)) - profile(f)).max() <= made.error
    sensor.save(tmp_path / "own.toml")
    assert mk.Sensor.load(tmp_path / "own.toml") == sensor
    # The contrast falls to one half where the function and the blur of the jitter, exp(-2 (pi s f)^2) with s = 2 um, say so.
    half = float(mk.metrics(sensor, ["mtf50_x"])["mtf50_x"]) * 1e3 / 15.0
    assert abs(profile(half) * np.exp(-2 * (np.pi * 2e-3 * half) ** 2) - 0.5) < 1e-6


def test_a_fit_takes_turbulence_of_ones_own():
    air = mk.custom(lambda fx, fy: np.exp(-(np.hypot(fx, fy) / 30) ** (5 / 3)), cutoff="200 cy/mm", label="air")
    sensor = mk.Sensor(frame=FRAME, presample=[air, mk.Jitter(rms="20 urad")])
    edge = sensor.simulate(mk.targets.edge(angle="5 deg")).image[16:-16, 16:-16] + mk.noise.gaussian((128, 128), sd=0.02)
    rms = sensor.replace({"jitter.rms": "10 urad"}).fit(edges=[edge], free={"jitter.rms": ("0 urad", "80 urad")})["jitter.rms"]
    assert abs(rms.value - 20.0) < 5 * rms.sd


def test_a_product_with_tips_has_a_table_along_each_axis():
    made = mk.custom(lambda fx, fy: np.exp(-np.abs(fx / 60) - np.abs(fy / 40) ** (5 / 3)), cutoff="900 cy/mm")
    assert isinstance(made, mk.Custom) and made.axis == "separable" and made.error <= 1e-6
    f = np.geomspace(1e-6, 600.0, 301)
    exact = np.exp(-f[:, None] / 60 - (f / 40) ** (5 / 3))
    assert np.abs(mk.Sensor(frame=FRAME, presample=[made]).otf(f[:, None], f) - exact).max() <= made.error


def test_kinks_and_steps_are_general_in_one_dimension_too(scene):
    step = mk.custom(lambda fx, fy: (np.hypot(fx, fy) < 20) * 1.0, cutoff="60 cy/mm")
    assert isinstance(step, mk.General)
    image = mk.Sensor(frame=FRAME, presample=[step]).simulate(scene, sample="3.75 um", tolerance=1e-5)
    assert rms(image.image, exact_image(scene, step.otf), scene) <= image.promised


def test_a_sensor_with_a_general_function_is_another_one():
    first, same, other = (mk.custom(f, cutoff="1000 cy/mm", label="ridge") for f in (
        kinked, lambda fx, fy: kinked(fx, fy), lambda fx, fy: kinked(fx, 0.9 * fy)))
    without = mk.Sensor(frame=FRAME, presample=["diffraction"], optics=dict(f_number=2.0, wavelength="4 um"))
    sensors = [without.append(presample=[one]) for one in (first, same, other)]
    assert sensors[0] == sensors[1] and hash(sensors[0]) == hash(sensors[1])
    assert len({without, *sensors}) == 3 and len({s.sha256 for s in (without, *sensors)}) == 3
    assert pickle.loads(pickle.dumps(sensors[0])) == sensors[0]
    assert "ridge" in sensors[0].explain() and "ridge" in str(sensors[0].check()) and sensors[0].check()
    assert "ridge" not in without.explain() and mk.Sensor.parse(sensors[0].text) == without


def tilted(fx, fy):
    """A Gaussian blur along a diagonal, with a shift of 0.01 mm to the right: with phase, and no product of x and y."""
    along, across = (fx + fy) / np.sqrt(2), (fx - fy) / np.sqrt(2)
    return np.exp(-2 * np.pi ** 2 * ((6e-3 * along) ** 2 + (2e-3 * across) ** 2) - 2j * np.pi * 0.01 * fx)


def kinked(fx, fy):
    """A ridge along a diagonal, with a shift: no samples of its PSF come to an end."""
    return np.maximum(0, 1 - np.abs(fx + 0.5 * fy) / 80) * np.exp(-2j * np.pi * 0.01 * fx - (fy / 200) ** 2)


def exact_image(scene, otf, step_mm=3.75e-3, ratio=4):
    """The same by numpy alone: the OTF on the frequencies of the mirrored scene, every fourth sample at the pixel centres."""
    mirrored = np.block([[scene, scene[:, ::-1]], [scene[::-1], scene[::-1, ::-1]]]).astype("f8")
    fy, fx = (np.fft.fftfreq(n, step_mm) for n in mirrored.shape)
    x, y = fx[None, :] + 0 * fy[:, None], fy[:, None] + 0 * fx[None, :]
    shift = np.exp(2j * np.pi * 0.5 * (ratio - 1) * step_mm * (x + y))
    return np.fft.ifft2(np.fft.fft2(mirrored) * otf(x, y) * shift).real[:scene.shape[0]:ratio, :scene.shape[1]:ratio]


def rms(image, exact, scene):
    return np.sqrt(np.mean((image - exact) ** 2)) / scene.std()


def test_functions_with_phase_become_samples(scene, tmp_path):
    made = mk.custom(tilted, cutoff="1000 cy/mm", label="tilted")
    assert isinstance(made, mk.Sampled) and 0 < made.error <= 1e-6
    sensor = mk.Sensor(frame=FRAME, presample=[made, mk.Gaussian(sigma="4 um")])
    f = np.linspace(-130, 130, 61)
    both = tilted(f[:, None], f) * gaussian(f[:, None], f)
    assert np.abs(sensor.otf(f[:, None], f) - both).max() < made.error
    assert abs(sensor.otf(0.3, 0.15, unit="cy/px") - tilted(20.0, 10.0) * gaussian(20.0, 10.0)) < made.error
    exact = exact_image(scene, lambda x, y: tilted(x, y) * gaussian(x, y))
    for tolerance in (1e-3, 1e-5):
        run = sensor.simulate(scene, sample="3.75 um", tolerance=tolerance)
        assert rms(run.image, exact, scene) <= run.promised < 2 * tolerance
        plan = sensor.compile(scene, sample="3.75 um", tolerance=tolerance)
        assert np.array_equal(plan(scene), run.image) and plan.promised == run.promised
    sensor.save(tmp_path / "mine.toml")
    assert f"within {made.error:.2g} of it" in (tmp_path / "mine.toml").read_text()
    for same in (mk.Sensor.load(tmp_path / "mine.toml"), pickle.loads(pickle.dumps(sensor))):
        assert same == sensor and same.otf(20.0, 10.0) == sensor.otf(20.0, 10.0)
    loose = mk.custom(tilted, cutoff="1000 cy/mm", tolerance=1e-3)
    assert made.error < loose.error <= 1e-3 and loose.samples.size < made.samples.size


@pytest.mark.parametrize("unit,per_mm", [("cy/px", 0.015), ("cy/mrad", 0.1)])
def test_samples_follow_the_frame(unit, per_mm):
    made = mk.custom(lambda fx, fy: tilted(fx / per_mm, fy / per_mm), cutoff=(1000 * per_mm, unit))
    sensor = mk.Sensor(frame=FRAME, presample=[made])
    assert abs(sensor.otf(20.0, 10.0) - tilted(20.0, 10.0)) < 1e-6
    change = {"cy/px": {"frame.pitch": "30 um"}, "cy/mrad": {"frame.focal_length": "50 mm"}}[unit]
    assert abs(sensor.replace(change).otf(10.0, 5.0) - tilted(20.0, 10.0) * (1 if unit == "cy/px" else 0)
               - (0 if unit == "cy/px" else tilted(5.0, 2.5))) < 1e-6


def test_sensors_are_fitted_beside_a_function():
    # What the others blur is found again, the function held fixed: an edge of the true sensor, whose blur is known.
    coma = mk.custom(lambda fx, fy: np.exp(-((fx + 0.4 * fy) / 60) ** 2 - (fy / 90) ** 2 - 1j * (fx / 50) ** 3 * np.exp(-(fx / 40) ** 2)),
                     cutoff="400 cy/mm", label="coma")
    assert isinstance(coma, mk.Sampled)
    truth = mk.Sensor(frame=FRAME, presample=[coma, mk.Footprint(width="15 um"), mk.Jitter(rms="30 urad")])
    edges = [truth.simulate(mk.targets.edge(angle=angle)).image[16:-16, 16:-16] + mk.noise.gaussian((128, 128), sd=0.01, frame=k)
             for k, angle in enumerate(["5 deg", "95 deg"])]
    fit = truth.replace({"jitter.rms": "10 urad"}).fit(edges=edges, free={"jitter.rms": ("0 urad", "80 urad")})
    rms_urad = fit.parameters[0]
    assert fit.adequate and abs(rms_urad.value - 30) < 4 * rms_urad.sd and rms_urad.sd < 0.5
    assert fit.sensor.otf(20.0, 10.0) != truth.otf(20.0, 10.0) and "coma" in fit.sensor.text


@pytest.mark.parametrize("border", ["reflect", "periodic"])
def test_general_functions_keep_their_promise(scene, border):
    made = mk.custom(kinked, cutoff="1000 cy/mm", label="ridge")
    assert isinstance(made, mk.General)
    sensor = mk.Sensor(frame=FRAME, scene=dict(border=border), presample=[made, mk.Gaussian(sigma="4 um")])
    assert abs(sensor.otf(20.0, 10.0) - kinked(20.0, 10.0) * gaussian(20.0, 10.0)) < 1e-12
    assert abs(sensor.otf(0.3, 0.15, unit="cy/px") - kinked(20.0, 10.0) * gaussian(20.0, 10.0)) < 1e-12

    def both(x, y):
        return kinked(x, y) * gaussian(x, y)

    exact = exact_image(scene, both)
    if border == "periodic":  # a scene that is its own mirror image repeats as its mirrored canvas does
        scene = np.block([[scene, scene[:, ::-1]], [scene[::-1], scene[::-1, ::-1]]])
    for tolerance in (1e-3, 1e-5):
        run = sensor.simulate(scene, sample="3.75 um", tolerance=tolerance)
        image = run.image[:48, :64]
        assert run.image.shape == (scene.shape[0] // 4, scene.shape[1] // 4)
        assert rms(image, exact, scene) <= run.promised < 3 * tolerance
        plan = sensor.compile(scene, sample="3.75 um", tolerance=tolerance)
        assert plan.shape == run.image.shape and plan.seconds > 0
        out = np.empty_like(run.image)
        assert plan(scene.astype("f8"), out=out) is out and np.array_equal(out, plan(scene))
        assert rms(out[:48, :64], exact, scene) <= plan.promised < 3 * tolerance
    narrow = plan.replace(mk.Sensor(frame=FRAME, scene=dict(border=border), presample=[made, mk.Gaussian(sigma="1 um")]))
    assert rms(narrow(scene)[:48, :64], exact_image(scene[:192, :256], lambda x, y: kinked(x, y) * gaussian(x, y, 1e-3)),
               scene) <= narrow.promised
    other = plan.replace(mk.Sensor(frame=FRAME, scene=dict(border=border), presample=[mk.General("g", "cy/mm", 900, tilted)]))
    assert rms(other(scene)[:48, :64], exact_image(scene[:192, :256], tilted), scene) <= other.promised


@pytest.mark.parametrize("stage", ["radiance", "electrons", "dn"])
def test_chains_of_a_detector_go_with_functions(demo, stage):
    # The same blur as a table, as samples and as a function: the same light, the same noise.
    camera = mk.Sensor.load(demo / "camera.toml")
    image = mk.read(demo / "thermal.exr")
    thermal, how = image.plane()[256:768, 300:980], dict(sample=image.sample, quantity="temperature", stage=stage)

    def blur(fx, fy):
        return gaussian(fx, fy, 9e-3)

    table = mk.custom(blur, cutoff="200 cy/mm", label="blur")
    shifted = mk.custom(lambda fx, fy: blur(fx, fy) * np.exp(-2e-9j * np.pi * fx), cutoff="200 cy/mm", label="blur")
    function = mk.General("blur", "cy/mm", 200.0, blur)
    assert isinstance(shifted, mk.Sampled)
    runs = []
    for component in (table, shifted, function):
        sensor = camera.append(presample=[component])
        run = sensor.simulate(thermal, tolerance=1e-4, frame=3, **how)
        assert run.promised < 3e-4 and run.image.shape == (128, 170)
        plan = sensor.compile(thermal, tolerance=1e-4, **how)
        assert np.array_equal(plan(thermal, frame=3), run.image)
        assert plan.promised == pytest.approx(run.promised, rel=0.2)
        runs.append(run)
    plain = camera.simulate(thermal, tolerance=1e-4, frame=3, **how).image.astype("f8")
    sharp = mk.Sensor.parse(camera.text.replace('"diffraction"', '"gaussian"\nsigma = "0.1 um"')).simulate(thermal, **how)
    scene_std = sharp.image.std(dtype="f8")
    for run in runs[1:]:
        most = 2 * (run.promised + runs[0].promised) * scene_std
        bound = most if stage == "radiance" else most + np.sqrt(most)  # whole electrons and counts go up or down
        assert np.sqrt(np.mean((run.image - runs[0].image.astype("f8")) ** 2)) <= bound
    assert np.sqrt(np.mean((plain - runs[0].image) ** 2)) > 0.01 * scene_std
    if stage == "radiance":
        part = sensor.simulate(thermal, tolerance=1e-4, roi=(10, 20, 30, 40), **how).image
        whole = runs[2].image[20:60, 10:40].astype("f8")  # by the plan of an image, those above by the one of a sequence
        assert part.shape == (40, 30) and np.sqrt(np.mean((part - whole) ** 2)) <= 2 * runs[2].promised * scene_std


def test_what_general_functions_do_not_go_with_has_words(scene, tmp_path, demo):
    made = mk.custom(kinked, cutoff="1000 cy/mm", label="ridge")
    sensor = mk.Sensor(frame=FRAME, presample=[made, mk.Jitter(rms="9 urad")])
    curves = sensor.curves(angle="30 deg")
    assert [c.label for c in curves] == ["jitter", "ridge", "presample", "system"] and not curves["ridge"].real
    f = curves.frequency
    assert np.abs(curves.system.otf - sensor.otf(f * np.cos(np.pi / 6), f * np.sin(np.pi / 6))).max() < 1e-12
    how = dict(sample="3.75 um")
    for work in (lambda: sensor.save(tmp_path / "s.toml"), lambda: sensor.simulate(str(demo / "scene.exr")),
                 lambda: sensor.fit(free=["jitter.rms"]), lambda: mk.metrics(sensor, ["mtf50_x"]),
                 lambda: mk.Study(sensor, axes={"jitter.rms": ["9 urad"]}, metrics=["q"]),
                 lambda: sensor.simulate(scene, **how).save(tmp_path / "x.exr"), lambda: sensor.simulate(mk.read(demo / "scene.exr")),
                 lambda: sensor.simulate(scene, roi=(0, 0, 2, 2), **how), lambda: sensor.simulate(scene, memory=1 << 20, **how),
                 lambda: sensor.simulate(scene, out=tmp_path / "x.exr", **how), lambda: sensor.simulate(scene, nan="propagate", **how),
                 lambda: mk.Sensor(frame=FRAME, scene=dict(border="replicate"), presample=[made]).simulate(scene, **how),
                 lambda: mk.Sensor(frame=dict(FRAME, format=[640, 512]), presample=[made]).simulate(scene, **how),
                 lambda: mk.Sensor(frame=FRAME, postsample=[made])):
        with pytest.raises(mk.UsageError, match="general function"):
            work()
    with pytest.raises(mk.UsageError, match="tolerance="):  # the way out that save names
        mk.Sensor(frame=FRAME, presample=[mk.custom(lambda fx, fy: np.maximum(0, 1 - np.hypot(fx, 1.3 * fy) / 120),
                                                    cutoff="120 cy/mm")]).save(tmp_path / "s.toml")
    for plane in (scene[0], np.ma.masked_array(scene, scene > 6), np.full((3, 3), "x")):
        with pytest.raises(mk.UsageError, match="two dimensions|masked|type"):
            sensor.simulate(plane, **how)
    holes = scene.copy()
    holes[3, 5] = np.nan
    with pytest.raises(mk.DataError, match="column 5, row 3"):
        sensor.simulate(holes, **how)
    plan = sensor.compile(scene.shape, **how)
    with pytest.raises(mk.DataError, match="column 5, row 3"):
        plan(holes)
    with pytest.raises(mk.UsageError, match="shape"):
        plan(scene[:100])
    assert np.isfinite(sensor.simulate(holes, nan="fill", **how).image).all()
    assert pickle.loads(pickle.dumps(sensor)).otf(20.0, 10.0) == sensor.otf(20.0, 10.0)
    assert sensor.replace({"jitter.rms": "90 urad"}).mtf(20.0) < sensor.mtf(20.0)


def test_a_function_that_fails_in_the_middle_ends_the_work(scene):
    calls = []

    def fails(fx, fy):
        calls.append(fx.size)
        if len(calls) > 2:
            raise RuntimeError("mine")
        return kinked(fx, fy)

    sensor = mk.Sensor(frame=FRAME, presample=[mk.General("fails", "cy/mm", 900.0, fails)])
    with pytest.raises(RuntimeError, match="mine"):
        for _ in range(3):
            sensor.simulate(scene, sample="3.75 um")


def test_components_are_appended(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lens.csv").write_text("frequency_cy_mm,mtf\n0,1\n40,0.5\n90,0\n")
    sensor = mk.Sensor(frame=FRAME, presample=[dict(kind="curve", file="lens.csv")])
    more = sensor.append(presample=[mk.custom(gaussian, cutoff="400 cy/mm"), mk.Jitter(rms="20 urad")],
                         postsample=[dict(kind="fir", taps=[[0.25, 0.5, 0.25]])])
    assert [c.label for c in more.curves()][:5] == ["curve", "custom", "jitter", "fir", "presample"] and more != sensor
    twice = more.append(presample=[mk.custom(lambda fx, fy: gaussian(fx, fy, 1e-3), cutoff="2000 cy/mm", label="second")])
    assert abs(twice.mtf(30.0) / more.mtf(30.0) - gaussian(30.0, 0.0, 1e-3)) < 1e-5
    (tmp_path / "elsewhere").mkdir()
    twice.save(tmp_path / "elsewhere" / "s.toml")
    again = mk.Sensor.load(tmp_path / "elsewhere" / "s.toml")
    assert [p.name for p in (tmp_path / "elsewhere").iterdir()] == ["s.toml"]
    assert again.otf(20.0, 10.0) == twice.otf(20.0, 10.0) == pickle.loads(pickle.dumps(twice)).otf(20.0, 10.0)
    assert pickle.loads(pickle.dumps(twice)) == twice
    with pytest.raises(mk.UsageError, match="is a list"):
        sensor.append(presample=mk.Jitter(rms="20 urad"))
    with pytest.raises(mk.UsageError, match="labels are unique"):
        more.append(presample=[mk.custom(lambda fx, fy: gaussian(fx, fy, 1e-3), cutoff="2000 cy/mm")])
