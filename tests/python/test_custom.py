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
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.toml", "mine_custom.csv"]
    assert mk.Sensor.load(tmp_path / "mine.toml").otf(20.0, 10.0) == sensor.otf(20.0, 10.0)


@pytest.mark.parametrize("function,words", [
    (lambda fx, fy: 0.9 + 0 * fx, r"otf\(0, 0\)"),
    (lambda fx, fy: np.cosh(fx / 100), "at most 1"),
    (lambda fx, fy: np.exp(2j * np.pi * np.abs(fx) * 0.01), "complex conjugate"),
    (lambda fx, fy: np.exp(-np.where(fx > 0, 1, 2) * fx ** 2), "complex conjugate"),
    (lambda fx, fy: np.where(fx > 20, np.nan, 1.0), "not finite"),
    (lambda fx, fy: 1.0, "shape"),
    (lambda fx, fy: np.full(np.shape(fx), "1"), "type <U1"),
    (lambda fx, fy: (np.hypot(fx, fy) < 20) * 1.0, "too steep"),
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
    with pytest.raises(mk.UsageError, match="another label"):
        mk.Sensor(frame=FRAME, presample=[mk.custom(gaussian, cutoff="400 cy/mm"),
                                          mk.custom(lambda fx, fy: gaussian(fx, fy, 1e-3), cutoff="400 cy/mm")])


def tilted(fx, fy):
    """A Gaussian blur along a diagonal, with a shift of 0.01 mm to the right: with phase, and no product of x and y."""
    along, across = (fx + fy) / np.sqrt(2), (fx - fy) / np.sqrt(2)
    return np.exp(-2 * np.pi ** 2 * ((6e-3 * along) ** 2 + (2e-3 * across) ** 2) - 2j * np.pi * 0.01 * fx)


def test_general_functions_keep_their_promise(scene):
    # The same by numpy alone: the function on the frequencies of the mirrored scene, every fourth sample at the pixel centres.
    made = mk.custom(tilted, cutoff="1000 cy/mm", label="tilted")
    assert isinstance(made, mk.General)
    sensor = mk.Sensor(frame=FRAME, presample=[made, mk.Gaussian(sigma="4 um")])
    assert abs(sensor.otf(20.0, 10.0) - tilted(20.0, 10.0) * gaussian(20.0, 10.0)) < 1e-12
    assert abs(sensor.otf(0.3, 0.15, unit="cy/px") - tilted(20.0, 10.0) * gaussian(20.0, 10.0)) < 1e-12
    mirrored = np.block([[scene, scene[:, ::-1]], [scene[::-1], scene[::-1, ::-1]]]).astype("f8")
    fy, fx = (np.fft.fftfreq(n, 3.75e-3) for n in mirrored.shape)
    x, y = fx[None, :] + 0 * fy[:, None], fy[:, None] + 0 * fx[None, :]
    shift = np.exp(2j * np.pi * 1.5 * 3.75e-3 * (x + y))
    exact = np.fft.ifft2(np.fft.fft2(mirrored) * tilted(x, y) * gaussian(x, y) * shift).real[:192:4, :256:4]
    for tolerance in (1e-3, 1e-5):
        run = sensor.simulate(scene, sample="3.75 um", tolerance=tolerance)
        assert run.image.shape == exact.shape
        error = np.sqrt(np.mean((run.image - exact) ** 2)) / scene.std()
        assert error <= run.promised < 10 * tolerance


def test_what_general_functions_do_not_go_with_has_words(scene, tmp_path, demo):
    sensor = mk.Sensor(frame=FRAME, presample=[mk.custom(tilted, cutoff="1000 cy/mm", label="tilted"), mk.Jitter(rms="9 urad")])
    for work in (lambda: sensor.compile((64, 64), sample="3.75 um"), lambda: sensor.save(tmp_path / "s.toml"),
                 lambda: sensor.curves(), lambda: sensor.simulate(str(demo / "scene.exr")),
                 lambda: sensor.simulate(scene[0], sample="3.75 um"), lambda: sensor.fit(free=["jitter.rms"]),
                 lambda: sensor.simulate(scene, sample="3.75 um").save(tmp_path / "x.exr"),
                 lambda: sensor.simulate(mk.targets.edge()), lambda: sensor.simulate(scene, sample="3.75 um", roi=(0, 0, 2, 2)),
                 lambda: mk.Sensor(frame=FRAME, postsample=[mk.custom(tilted, cutoff="9 cy/mm")])):
        with pytest.raises(mk.UsageError, match="general function|2-D array"):
            work()
    with pytest.raises(mk.DataError, match="NaN"):
        sensor.simulate(np.full((8, 8), np.nan), sample="3.75 um")
    assert pickle.loads(pickle.dumps(sensor)).otf(20.0, 10.0) == sensor.otf(20.0, 10.0)
    assert sensor.replace({"jitter.rms": "90 urad"}).mtf(20.0) < sensor.mtf(20.0)
