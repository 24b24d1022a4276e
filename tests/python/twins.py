# SPDX-License-Identifier: Apache-2.0
"""Cameras, their frames, and the tests of two samples that ask whether two stacks of frames are of the same camera."""

import numpy as np
from scipy import stats

import mtfkit as mk

SIDE, FRAMES = 128, 16
LIGHTS = (0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)
KELVIN = (298.0, 303.0, 308.0)

PHOTON_CAMERA = """schema = 2
[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "1 ms"
[scene]
quantity = "photon_radiance"
sample = "15 um"
[optics]
f_number = 2.0
[band]
wavelength = ["3.8 um", "4.2 um"]
[detector]
quantum_efficiency = {efficiency}
full_well = "80 ke-"
"""
PHOTON_REST = """read_noise = "{read} e-"
[[readout]]
kind = "crosstalk"
side = {side}
[nonlinearity]
a2 = {a2}
[nonuniformity]
prnu = {prnu}
dsnu = "{dsnu} e-"
[noise]
seed = {seed}
row = "{row} e-"
column = "{column} e-"
fixed_row = "{fixed_row} e-"
fixed_column = "{fixed_column} e-"
[adc]
bits = 14
electrons_per_count = "{gain} e-"
offset = {offset}
"""
THERMAL_CAMERA = """schema = 2
[frame]
focal_length = "100 mm"
pitch = "15 um"
frame_time = "20 ms"
[scene]
quantity = "temperature"
sample = "15 um"
[optics]
f_number = 1.0
transmission = 0.9
emissivity = 0.1
temperature = "293 K"
stop_temperature = "293 K"
[band]
wavelength = ["8 um", "13 um"]
[detector]
kind = "thermal"
absorptance = 0.8
responsivity = {responsivity}
shutter_temperature = "293 K"
netd = "{netd} mK"
netd_f_number = 1.0
netd_transmission = 1.0
netd_temperature = "300 K"
[nonuniformity]
dsnu = "{dsnu} uV"
prnu = {prnu}
[noise]
seed = {seed}
row = "{row} uV"
column = "{column} uV"
fixed_column = "{fixed_column} uV"
[adc]
bits = 14
volts_per_count = "0.1 uV"
offset = {offset}
"""


def frames_of(sensor, level, first, seed=None):
    """FRAMES frames (numbered from `first`) of a flat scene of that level, of the array of that seed."""
    sensor = sensor if seed is None else sensor.replace({"noise.seed": seed})
    scene = np.full((SIDE, SIDE), level, "float32")
    plan = sensor.compile(scene, stage="dn", threads=1)
    return np.array([plan(scene, frame=first + i) for i in range(FRAMES)]).astype(np.uint16)


class PhotonCamera:
    """A camera with every noise, pattern and response that frames can tell, drawn by `draw`."""

    nonlinearity = 1

    def __init__(self, draw):
        of = lambda low, high: round(float(draw.uniform(low, high)), 4)  # noqa: E731
        efficiency, gain = of(0.4, 0.8), of(3.6, 7.0)  # the brightest level is 48 ke-, below the end of 14 bits
        rest = PHOTON_REST.format(
            read=of(2.0, 8.0), side=of(0.0, 0.02), a2=of(-0.04, 0.02), prnu=of(0.004, 0.02), dsnu=of(2.0, 8.0), row=of(0.5, 3.0),
            column=of(0.5, 3.0), fixed_row=of(1.0, 4.0), fixed_column=of(1.0, 4.0), gain=gain, offset=of(100.0, 300.0),
            seed=int(draw.integers(1 << 30)))
        self.sensor = mk.Sensor.parse(PHOTON_CAMERA.format(efficiency=efficiency) + rest)
        self.nominal = self.sensor.replace({"detector.quantum_efficiency": 0.5, "nonuniformity.prnu": 0.05})
        still = mk.Sensor.parse(PHOTON_CAMERA.format(efficiency=1.0) + "[noise]\nshot = false\n")
        unit = 1e17
        scene = np.full((8, 8), unit, "float32")
        photons = float(still.simulate(scene, stage="electrons").image[4, 4])
        self.levels = [unit * light * 6000.0 / (photons * efficiency) for light in LIGHTS]  # electrons: 6000 a light
        self.photons = [photons * level / unit for level in self.levels]
        self.tested = (0, 3, 7, 11)

    def stack(self, i, cube):
        return mk.Stack(cube, photons=self.photons[i]) if i else mk.Stack(cube, light=False)


class FaultyCamera(PhotonCamera):
    """The same with hot, dead and blinking pixels, and 1/f noise from frame to frame, none of which the nominal has."""

    def __init__(self, draw):
        super().__init__(draw)
        self.sensor = mk.Sensor.parse(self.sensor.text + """
[defects]
dead_fraction = 0.004
hot_fraction = 0.006
hot = "300 e-"
[frame_flicker]
octave = "2 e-"
lowest = 0.006
[blinking]
fraction = 0.008
excess = "400 e-"
dwell = 4
""")


class ThermalCamera:
    """The same of an uncooled camera before blackbodies."""

    nonlinearity = 0

    def __init__(self, draw):
        of = lambda low, high: round(float(draw.uniform(low, high)), 4)  # noqa: E731
        self.sensor = mk.Sensor.parse(THERMAL_CAMERA.format(
            responsivity=of(0.7e5, 1.5e5), netd=of(30.0, 80.0), dsnu=of(0.1, 0.4), prnu=of(0.005, 0.02), row=of(0.03, 0.1), column=of(0.03, 0.1),
            fixed_column=of(0.05, 0.2), offset=of(3000.0, 5000.0), seed=int(draw.integers(1 << 30))))
        self.nominal = self.sensor.replace({"detector.responsivity": 2e5, "detector.netd": "100 mK"})
        self.levels, self.tested = KELVIN, (0, 1, 2)

    def stack(self, i, cube):
        return mk.Stack(cube, temperature=f"{KELVIN[i]} K")


def twin_of(camera):
    """The Camera that frames of every level give."""
    stacks = [camera.stack(i, frames_of(camera.sensor, level, 1 + FRAMES * i)) for i, level in enumerate(camera.levels)]
    return mk.characterize(stacks, nominal=camera.nominal, nonlinearity=camera.nonlinearity, trend=0)


def mean_squares(cube):
    """Of an analysis of variance over frames, rows and columns: {part: (mean square, degrees of freedom)}."""
    cube = cube - cube.mean()
    parts, left = {}, cube
    for name, axes in {"t": (1, 2), "v": (0, 2), "h": (0, 1), "tv": (2,), "th": (1,), "vh": (0,)}.items():
        part = left.mean(axes, keepdims=True)
        left = left - part
        sizes = [n for axis, n in enumerate(cube.shape) if axis not in axes]
        dof = np.prod([n - 1 for n in sizes])
        parts[name] = (part ** 2).sum() * np.prod([cube.shape[axis] for axis in axes]) / dof, dof
    dof = np.prod([n - 1 for n in cube.shape])
    return {**parts, "tvh": ((left ** 2).sum() / dof, dof)}, left


def normal(p_below):
    """The number of standard deviations at that probability."""
    return float(stats.norm.ppf(np.clip(p_below, 1e-15, 1 - 1e-15)))


def comparisons(one, other):
    """Standard normal numbers, {test: z}, where both cubes of counts are of the same camera but of arrays of their own.

    Mean squares by F, means by the errors that their mean squares give, the values of pixels (Kolmogorov and Smirnov, on pixels
    that are no neighbours), and the products of neighbours in columns, rows, on diagonals and in time (the lags of the spectra).
    """
    one, other = one.astype(float), other.astype(float)
    (a, left_a), (b, left_b) = mean_squares(one), mean_squares(other)
    z = {name: normal(stats.f.cdf(b[name][0] / a[name][0], b[name][1], a[name][1])) for name in a}
    of_mean = [sum(ms[k][0] for k in ("t", "v", "h")) - sum(ms[k][0] for k in ("tv", "th", "vh")) + ms["tvh"][0] for ms in (a, b)]
    z["mean"] = float((other.mean() - one.mean()) / np.sqrt(sum(of_mean) / one.size))
    p = stats.ks_2samp(one[0, ::7, ::7].ravel(), other[0, ::7, ::7].ravel()).pvalue
    z["values"] = normal(1 - p / 2)
    for name, lag in {"row": (0, 0, 1), "column": (0, 1, 0), "diagonal": (0, 1, 1), "time": (1, 0, 0)}.items():
        here, there = (tuple(slice(0, -n or None) for n in lag), tuple(slice(n, None) for n in lag))
        products = [(left[here] * left[there]).mean() / (left ** 2).mean() for left in (left_a, left_b)]
        z["lag " + name] = float((products[1] - products[0]) * np.sqrt(left_a.size / 2))
    return z


def compared(camera, twin, seed):
    """All comparisons of new frames of the camera with frames of its twin: {(level, test): z}."""
    return {(i, name): z for i in camera.tested
            for name, z in comparisons(frames_of(camera.sensor, camera.levels[i], 100_001 + FRAMES * i),
                                       frames_of(twin.sensor, camera.levels[i], 1 + FRAMES * i, seed)).items()}


def faults(dark, bright):
    """What both arrays of a faulty camera have alike, {name: (number, standard deviation)}: hot, dead and noisy pixels, the mean dark count,
    the power of the noise of the other pixels in differences of 1 and of 8 frames, and how often noisy ones pass their mean."""
    mean, lit, variance = dark.mean(0, dtype=float), bright.mean(0, dtype=float), dark.var(0, dtype=float)
    above = mean - np.median(mean)
    far = 6.0 * 1.4826 * np.median(np.abs(above))
    noisy = variance > 10.0 * np.median(variance)
    hot, dead = (above > far) & ~noisy, lit < 0.5 * np.median(lit)
    excess, rms = above[hot] - far, np.sqrt(variance[noisy])
    high = dark[:, noisy] > mean[noisy]
    passes = (high[1:] != high[:-1]).mean(0)
    good = dark[:, (np.abs(above) < far) & ~noisy].astype(float)
    steps = (good[0::2] - good[1::2]).ravel()
    halves = good[:FRAMES // 2].sum(0) - good[FRAMES // 2:].sum(0)
    power = {name: ((d ** 2).mean() / n, (d ** 2).mean() / n * np.sqrt(2.0 / d.size))
             for name, d, n in (("power of 1", steps, 2), ("power of 8", halves, FRAMES))}
    means = {name: (x.mean(), x.std() / np.sqrt(x.size)) for name, x in (("excess", excess), ("rms", rms), ("passes", passes), ("dark", mean.ravel()))}
    return {**{name: (x.sum(), np.sqrt(x.sum())) for name, x in (("hot", hot), ("dead", dead), ("noisy", noisy))}, **means, **power}
