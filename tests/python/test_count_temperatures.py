# SPDX-License-Identifier: Apache-2.0
"""Temperatures of counts and what is uncertain of them, against the published formula (FLIR, ThermoVision SDK) written here: its central
differences, and Monte Carlo of numpy."""

import pickle
import subprocess

import numpy as np
import pytest
from conftest import COMMAND, run_command, run_json
from test_flir import CAMERA, fff, jpeg

import mtfkit as mk

NAMES = ("emissivity", "surroundings", "distance", "air_temperature", "relative_humidity", "window_transmission", "window_temperature")
UNITS = ("", " K", " m", " K", "", "", " K")
PLACES = (0x20, 0x28, 0x24, 0x2c, 0x3c, 0x34, 0x30)  # in the camera's record
MILD = (0.95, 293.15, 12.0, 288.15, 0.6, 0.9, 300.0), (0.02, 2.0, 1.5, 2.0, 0.1, 0.01, 2.0)
STIFF = (0.3, 330.0, 5.0, 293.0, 0.5, 1.0, 293.0), (0.05, 5.0, 1.0, 2.0, 0.1, 0.0, 0.0)
R1, B, F, R2 = (float(np.float32(CAMERA[at])) for at in (0x58, 0x5c, 0x60, 0x30c))
O = -6233.0
ALPHA1, ALPHA2, BETA1, BETA2, X = (float(np.float32(CAMERA[at])) for at in (0x70, 0x74, 0x78, 0x7c, 0x80))


def signal(kelvin):
    return R1 / (R2 * (np.exp(B / kelvin) - F))


def air(distance, kelvin, humidity):
    c = kelvin - 273.15
    water = np.sqrt(humidity * np.exp(1.5587 + 6.939e-2 * c - 2.7816e-4 * c ** 2 + 6.8455e-7 * c ** 3))
    return X * np.exp(-np.sqrt(distance) * (ALPHA1 + BETA1 * water)) + (1 - X) * np.exp(-np.sqrt(distance) * (ALPHA2 + BETA2 * water))


def count_of(kelvin, e, surroundings, distance, air_k, humidity, window, window_k):
    t = air(distance, air_k, humidity)
    return window * (t * (e * signal(kelvin) + (1 - e) * signal(surroundings)) + (1 - t) * signal(air_k)) + (1 - window) * signal(window_k) - O


def temperature(count, e, surroundings, distance, air_k, humidity, window, window_k):
    """NaN for what is no temperature, told by the sign of the radiance."""
    t = air(distance, air_k, humidity)
    behind = ((count + O) - (1 - window) * signal(window_k)) / window
    of_surface = ((behind - (1 - t) * signal(air_k)) / t - (1 - e) * signal(surroundings)) / e
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(of_surface > 0, B / np.log(R1 / (R2 * of_surface) + F), np.nan)


def changes(count, numbers, sd):
    """Central differences times the standard deviations."""
    found = []
    for i, number in enumerate(numbers):
        step = np.zeros(len(numbers))
        step[i] = 1e-5 * abs(number)
        rise = temperature(count, *(numbers + step)) - temperature(count, *(numbers - step))
        found.append(float(rise) / (2 * step[i]) * sd[i])
    return np.array(found)


def monte_carlo(count, numbers, sd, draws=1_000_000):
    """Ends of 95 % of numbers that are possible; one without a temperature is below all others."""
    e, surroundings, distance, air_k, humidity, window, window_k = drawn = np.array(numbers)[:, None] + np.array(sd)[:, None] * \
        np.random.default_rng(5).standard_normal((len(numbers), draws))
    possible = (e > 0) & (e <= 1) & (surroundings > 0) & (distance >= 0) & (air_k > 0) & (humidity >= 0) & (humidity <= 1)
    possible &= (window > 0) & (window <= 1) & (window_k > 0)
    kelvin = np.nan_to_num(temperature(count, *drawn[:, possible]), nan=0.0)
    return np.quantile(kelvin, [0.025, 0.975])


def written(tmp_path, numbers, kelvin):
    """An FFF of a surface of these temperatures that a camera with these numbers sees; its counts are whole."""
    counts = np.rint(count_of(np.asarray(kelvin), *numbers)).astype("u2")
    path = tmp_path / "a.fff"
    path.write_bytes(fff(counts, camera={**CAMERA, **dict(zip(PLACES, numbers))}))
    return path, counts


def stored(numbers):
    """Numbers of the file are float32."""
    return np.array([float(np.float32(number)) for number in numbers])


def assumed(sd):
    return {name: f"+- {one}{unit}" for name, one, unit in zip(NAMES, sd, UNITS) if one > 0}


def test_first_order_is_that_of_central_differences(tmp_path):
    numbers, sd = MILD
    path, counts = written(tmp_path, numbers, [[280.0, 300.0, 310.0], [330.0, 400.0, 295.0]])
    found = mk.read(path).temperatures(**assumed(sd))
    assert list(found.shares) == list(NAMES) and pickle.loads(pickle.dumps(found)) == found
    for place in np.ndindex(counts.shape):
        count, exact = float(counts[place]), stored(numbers)
        change = changes(count, exact, sd)
        assert found.temperature_k[place] == pytest.approx(float(temperature(count, *exact)), rel=1e-12)
        assert found.sd_k[place] == pytest.approx(np.sqrt(np.sum(change ** 2)), rel=1e-6)  # the square of a step of 1e-5, and rounding
        shares = np.array([found.shares[name][place] for name in NAMES])
        assert shares == pytest.approx(change ** 2 / np.sum(change ** 2), rel=1e-5, abs=1e-9)
        assert shares.sum() == pytest.approx(1.0, abs=1e-12)
        low, high = monte_carlo(count, exact, sd)  # which of 1e6 numbers is known to 0.003 sd
        assert abs(found.low_k[place] - low) < 0.03 * found.sd_k[place]
        assert abs(found.high_k[place] - high) < 0.03 * found.sd_k[place]


def test_where_first_order_breaks_the_interval_holds(tmp_path):
    numbers, sd = STIFF
    path, counts = written(tmp_path, numbers, [[310.0, 310.0]])
    found = mk.read(path).temperatures(**assumed(sd))
    count, exact = float(counts[0, 0]), stored(numbers)
    low, high = monte_carlo(count, exact, sd)
    first = np.sqrt(np.sum(changes(count, exact, sd) ** 2))
    kelvin = float(temperature(count, *exact))
    assert kelvin - 1.96 * first - low > 0.4 * 1.96 * first  # the interval of first order begins far above the true one
    assert np.isnan(found.sd_k).all() and all(np.isnan(share).all() for share in found.shares.values())
    assert abs(found.low_k[0, 0] - low) < 0.01 * (high - low) and abs(found.high_k[0, 0] - high) < 0.01 * (high - low)
    row = run_json("info", path, *(word for key, words in assumed(sd).items() for word in ("--assume", f"{key}={words}")))["temperatures"][0]
    assert row["sd_K"] is None and row["first_order_holds"] is False
    assert row["interval95_K"] == [found.low_k[0, 0], found.high_k[0, 0]]
    text = run_command("info", path, "--assume", "emissivity=+- 0.05", "--assume", "surroundings=+- 5 K")
    assert "the first order does not hold, and the interval does" in text
    # With surroundings far hotter some of the emissivities leave no light of the surface itself: there is no lower end.
    path, counts = written(tmp_path, (0.3, 400.0, *numbers[2:]), [[310.0, 310.0]])
    found = mk.read(path).temperatures(emissivity="+- 0.05", surroundings="+- 5 K")
    low, high = monte_carlo(float(counts[0, 0]), stored((0.3, 400.0, *numbers[2:])), (0.05, 5.0, 0, 0, 0, 0, 0))
    assert low == 0.0 and np.isnan(found.low_k).all() and np.isnan(found.sd_k).all()
    assert found.high_k[0, 0] == pytest.approx(high, abs=0.5)


def test_the_command_says_what_python_says(tmp_path):
    numbers, sd = MILD
    path, _ = written(tmp_path, numbers, [[280.0, 300.0], [330.0, 300.0]])
    words = [word for key, one in assumed(sd).items() for word in ("--assume", f"{key}={one}")]
    least, mean, largest = run_json("info", path, *words)["temperatures"]
    found = mk.read(path).temperatures(**assumed(sd))
    for row, place in (least, (0, 0)), (largest, (1, 0)):
        assert row["temperature_K"] == found.temperature_k[place] and row["sd_K"] == found.sd_k[place]
        assert row["interval95_K"] == [found.low_k[place], found.high_k[place]] and row["first_order_holds"] is True
        assert [source["name"] for source in row["sources"]] == list(NAMES)
        assert [source["share"] for source in row["sources"]] == [share[place] for share in found.shares.values()]
        assert sum(source["change_K"] ** 2 for source in row["sources"]) == pytest.approx(row["sd_K"] ** 2, rel=1e-12)
    assert least["temperature_K"] < mean["temperature_K"] < largest["temperature_K"]
    text = run_command("info", path, *words)
    assert "emissivity 0.95 +- 0.02" in text and " %" in text
    # A number in place of that of the file.
    other = mk.read(path).temperatures(emissivity="0.5 +- 0.02")
    count = float(mk.read(path).plane()[0, 0])
    assert other.temperature_k[0, 0] == pytest.approx(float(temperature(count, 0.5, *stored(numbers)[1:])), rel=1e-12)


def test_nothing_stated_is_no_interval(tmp_path):
    path, _ = written(tmp_path, MILD[0], [[280.0, 300.0]])
    found = mk.read(path).temperatures()
    assert found.sd_k is None and found.low_k is None and found.high_k is None and found.shares == {}
    assert found.temperature_k[0, 1] == pytest.approx(300.0, abs=0.02)  # a count is some 0.015 K
    facts = run_json("info", path)
    assert any("no interval of these temperatures: no standard deviation" in note for note in facts["notes"])
    for row in facts["temperatures"]:
        assert row["sd_K"] is None and row["interval95_K"] is None and row["sources"] == [] and row["first_order_holds"] is None


def test_of_a_radiometric_jpeg_the_counts_are_asked_for(tmp_path):
    path = tmp_path / "a.jpg"
    path.write_bytes(jpeg(written(tmp_path, MILD[0], [[280.0, 300.0]])[0].read_bytes()))
    assert mk.read(path, channel="counts").temperatures(emissivity="+- 0.02").sd_k.shape == (1, 2)
    refused = subprocess.run([COMMAND, "info", path, "--assume", "emissivity=+- 0.02"], capture_output=True, text=True, check=False)
    assert refused.returncode == 2 and "--channel counts" in refused.stderr


@pytest.mark.parametrize("words, said", [
    ({"emisivity": "+- 0.02"}, "KEY one of emissivity surroundings"), ({"emissivity": "1.2"}, r"1.2 is outside \(0, 1\]"),
    ({"emissivity": "0.9 +- -1"}, "above 0"), ({"surroundings": "+- 2"}, "no unit"), ({"surroundings": "+- 2 degC"}, "difference"),
    ({"distance": "5 K"}, "length"), ({"emissivity": "+-"}, "no number"), ({"emissivity": "+- 50"}, "less than 5 %"),
    ({"emissivity": None}, "'None' is no number")])
def test_what_cannot_be_is_refused(tmp_path, words, said):
    image = mk.read(written(tmp_path, MILD[0], [[280.0, 300.0]])[0])
    with pytest.raises(mk.UsageError, match=said):
        image.temperatures(**words)


def test_without_constants_of_the_air_its_numbers_are_refused(tmp_path):
    path = tmp_path / "a.fff"
    path.write_bytes(fff(np.full((2, 2), 15000, "u2"), camera={**CAMERA, 0x80: float("nan")}))
    with pytest.raises(mk.UsageError, match="no constants of an air"):
        mk.read(path).temperatures(distance="+- 1 m")
