# SPDX-License-Identifier: Apache-2.0
"""Every kind of component for gradients.py: its OTF from the definition, and the cases to tabulate.

A case: settings as in a sensor file (float: a scalar that is differentiated by; (float, unit): the same with its unit;
list of lists: taps; int or word: kept), surroundings named frame.*, optics.*, and the frequencies in cycles/mm.
To add a kind: write its function of a Point, decorate it with @kind and its cases. Motion and the path have files of
their own.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache

from mpmath import mp, mpf

from annular import annular_mtf
from defocus import defocus_otf
from tables import gauss_legendre

KINDS = {}


@dataclass
class Case:
    settings: dict
    at: list
    side: dict = field(default_factory=dict)  # by name: the slope that is meant where right and left differ


@dataclass
class Kind:
    otf: object
    cases: tuple
    digits: int = 150  # of the arithmetic
    scan_every: int = 1  # of the frequencies searched for the largest derivative
    rounding: bool = True  # whether the conditioning is worked out; not where it is far below 1e-9


def kind(name, *cases, **options):
    def register(otf):
        KINDS[name] = Kind(otf, cases, **options)
        return otf

    return register


def around(f, along=(1.0, 0.0), steps=(1e-9,)):
    """The double nearest to f, its neighbours, and points a little further away on both sides, along a direction."""
    points = [f, math.nextafter(f, 0.0), math.nextafter(f, math.inf)]
    points += [f * (1 + sign * step) for step in steps for sign in (-1, 1)]
    return [(u * along[0], u * along[1]) for u in points]


ZERO = [(0.0, 0.0)]
TYPICAL = ZERO + [(1e-9, -2e-9), (5.0, 3.0), (-21.7, 4.4), (33.0, 33.0), (0.0, 47.0)]
SQUARE = {"frame.pitch_x": 17.0, "frame.pitch_y": 17.0}
OBLONG = {"frame.pitch_x": 17.0, "frame.pitch_y": 20.0}
FOCAL = {"frame.focal_length": 100.0}


def sinc(x):
    return mp.sin(mp.pi * x) / (mp.pi * x) if x != 0 else mpf(1)


def jinc(x):
    return 2 * mp.besselj(1, x) / x if x != 0 else mpf(1)


def unit_vector(p):
    degrees = p["direction"] if "direction" in p else mpf(0)
    return mp.cos(mp.pi * degrees / 180), mp.sin(mp.pi * degrees / 180)


def axis_of(p):
    return p.words.get("axis", "x")


def nu_of(p):
    """f lambda N; the wavelength of the component, or of the surroundings."""
    own = {n: p[n] if n in p else p["optics." + n] for n in ("wavelength", "f_number")}
    return mp.hypot(p["fx"], p["fy"]) * own["wavelength"] / 1000 * own["f_number"]


def gaussian_of(p, name):
    return mp.exp(-2 * mp.pi**2 * sum((p.length_mm(name, a) * p.frequency(a)) ** 2 for a in "xy"))


@kind("gaussian",
      Case({"sigma": (3.0, "um")}, TYPICAL),
      Case({"sigma": (0.25, "px"), **OBLONG}, TYPICAL),
      Case({"sigma_x": (20.0, "urad"), "sigma_y": (70.0, "urad"), **FOCAL}, TYPICAL + [(0.0, 300.0)]),
      Case({"sigma": (0.0, "um")}, TYPICAL),
      Case({"sigma": (1e9, "um")}, ZERO + [(1e-9, 0.0), (1e-7, 2e-7), (5.0, 3.0)]))
def gaussian(p):
    return gaussian_of(p, "sigma")


@kind("jitter",
      Case({"rms": (8.0, "urad"), **FOCAL}, TYPICAL),
      Case({"rms_x": (2.0, "um"), "rms_y": (0.3, "px"), **OBLONG}, TYPICAL),
      Case({"rms": (0.0, "urad"), **FOCAL}, TYPICAL))
def jitter(p):
    return gaussian_of(p, "rms")


def rectangle(p):
    width = {a: p.pitch_mm(a) * mp.sqrt(p["fill_factor"]) if "fill_factor" in p else p.length_mm("width", a)
             for a in "xy"}
    return sinc(width["x"] * p["fx"]) * sinc(width["y"] * p["fy"])


# sinc passes from its series to the closed form at 0.05, and has zeros at whole numbers.
kind("footprint",
     Case({"width": (15.0, "um")}, TYPICAL + around(0.05 / 0.015) + around(1 / 0.015)),
     Case({"width_x": (0.9, "px"), "width_y": (120.0, "urad"), **OBLONG, **FOCAL}, TYPICAL),
     Case({"width": (0.0, "um")}, TYPICAL),
     Case({"width": (1e9, "um")}, ZERO + [(1e-6, 0.0), (1e-7, 2e-7)]),
     Case({"fill_factor": 0.9, **OBLONG}, TYPICAL),
     Case({"fill_factor": 1.0, **SQUARE}, TYPICAL),
     Case({"fill_factor": 1e-9, **SQUARE}, TYPICAL))(rectangle)


@kind("birefringent_filter",
      Case({"separation": (8.5, "um")}, TYPICAL + around(500 / 8.5)),
      Case({"separation_x": (0.5, "px"), "separation_y": (60.0, "urad"), **OBLONG, **FOCAL}, TYPICAL),
      Case({"separation": (0.0, "um")}, TYPICAL),
      Case({"separation": (1e9, "um")}, ZERO + [(1e-6, 0.0), (1e-7, 2e-7)]))
def birefringent_filter(p):
    return mp.cos(mp.pi * p.length_mm("separation", "x") * p["fx"]) * mp.cos(mp.pi * p.length_mm("separation", "y") * p["fy"])


@kind("halo",
      Case({"fraction": 0.05, "width": (200.0, "um"), "profile": "gaussian"}, TYPICAL + [(0.5, 1.0)]),
      Case({"fraction": 0.05, "width": (200.0, "um"), "profile": "exponential"}, TYPICAL + [(0.5, 1.0)]),
      Case({"fraction": 0.05, "width": (200.0, "um"), "profile": "lorentz"}, TYPICAL + [(0.5, 1.0)]),
      Case({"fraction": 0.3, "width_x": (4.0, "px"), "width_y": (900.0, "urad"), "profile": "exponential", **OBLONG,
            **FOCAL}, TYPICAL),
      Case({"fraction": 1.0, "width": (2.0, "px"), "profile": "lorentz", **OBLONG}, TYPICAL),
      Case({"fraction": 0.0, "width": (50.0, "um"), "profile": "gaussian"}, TYPICAL),
      Case({"fraction": 0.5, "width": (1e9, "um"), "profile": "exponential"},
           ZERO + [(1e-9, 0.0), (1e-7, 2e-7), (5.0, 3.0)]))
def halo(p):
    q = mp.hypot(*(p.length_mm("width", a) * p.frequency(a) for a in "xy"))
    halo_of = {"gaussian": lambda: mp.exp(-2 * (mp.pi * q) ** 2),
               "exponential": lambda: (1 + (2 * mp.pi * q) ** 2) ** mpf("-1.5"),
               "lorentz": lambda: mp.exp(-2 * mp.pi * q)}
    return 1 - p["fraction"] + p["fraction"] * halo_of[p.words.get("profile", "gaussian")]()


@kind("circular_footprint",
      Case({"diameter": (15.0, "um")}, TYPICAL + around(0.1 / math.pi / 0.015) + around(1.2196698912665045 / 0.015)),
      Case({"diameter_x": (0.9, "px"), "diameter_y": (120.0, "urad"), **OBLONG, **FOCAL}, TYPICAL),
      Case({"diameter": (0.0, "um")}, TYPICAL))
def circular_footprint(p):
    return jinc(mp.pi * mp.hypot(p.length_mm("diameter", "x") * p["fx"], p.length_mm("diameter", "y") * p["fy"]))


# A whole number of turns from pixel to pixel is a zero of both sines of the closed form.
@kind("binning",
      Case({"columns": 2, "rows": 3, **OBLONG}, TYPICAL + around(2000 / 17.0) + around(1000 / 17.0)),
      Case({"columns": 4, "rows": 1, "spacing": (4.0, "um")}, TYPICAL + around(250.0)),
      Case({"columns": 3, "rows": 5, "spacing_x": (0.3, "px"), "spacing_y": (30.0, "urad"), **OBLONG, **FOCAL},
           TYPICAL),
      Case({"columns": 1, "rows": 1, "spacing": (0.0, "um")}, TYPICAL))
def binning(p):
    def mean(axis, count):
        apart = p.length_mm("spacing", axis) if "spacing" in p or "spacing_x" in p else p.pitch_mm(axis) / count
        turn = 2 * mp.pi * p.frequency(axis) * apart
        return sum(mp.cos((i - mpf(count - 1) / 2) * turn) for i in range(count)) / count

    return mean("x", p.words["columns"]) * mean("y", p.words["rows"])


# Green's theorem: along the edges, the integral over dy of the antiderivative by x.
@kind("polygon_footprint",
      Case({"vertices": [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.1], [0.1, 0.1], [0.1, 0.5], [-0.5, 0.5]],
            "unit_length": (15.0, "um")}, ZERO + [(1e-9, -2e-9), (-21.7, 4.4), (33.0, 33.0), (0.0, 47.0)]),
      Case({"vertices": [[0.2, -0.4], [-0.6, 0.3], [0.5, 0.7]], "unit_length": (0.8, "px"), **OBLONG},
           ZERO + [(5.0, 3.0), (21.7, 4.4), (33.0, -60.0)]),
      Case({"vertices": [[-7.5, -6.0], [7.5, -6.0], [7.5, 6.0], [-7.5, 6.0]], "unit_length_x": (10.0, "urad"),
            "unit_length_y": (1.0, "um"), **FOCAL}, ZERO + [(5.0, 3.0), (0.0, 47.0), (500.0 / 7.5, 10.0)]),
      digits=90, scan_every=3, rounding=False)
def polygon_footprint(p):
    corners = [(p[f"vertices[{2 * k}]"], p[f"vertices[{2 * k + 1}]"]) for k in range(p.words["vertices"][0])]
    gx, gy = (-2j * mp.pi * p.frequency(a) * p.length_mm("unit_length", a) for a in "xy")

    def antiderivative(x, y):
        return mp.exp(gy * y) * (mp.expm1(gx * x) / gx if gx != 0 else x)

    total = area = mpf(0)
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1]):
        area += (x0 * y1 - x1 * y0) / 2
        for t, weight in gauss_legendre(40, mp.dps):
            s = (1 + t) / 2
            total += weight / 2 * (y1 - y0) * antiderivative(x0 + s * (x1 - x0), y0 + s * (y1 - y0))
    return total / area


@kind("sample_and_hold",
      Case({"width": (1.0, "px"), **OBLONG}, TYPICAL + around(1 / 0.017)),
      Case({"width": (120.0, "urad"), "axis": "y", **FOCAL}, TYPICAL),
      Case({"width": (0.0, "um")}, TYPICAL))
def sample_and_hold(p):
    return sinc(p.length_mm("width", axis_of(p)) * p.frequency(axis_of(p)))


@kind("rc_lowpass",
      Case({"cutoff": (40.0, "cy/mm")}, TYPICAL + around(40.0)),
      Case({"cutoff": (3.0, "cy/mrad"), "axis": "y", **FOCAL}, TYPICAL),
      Case({"cutoff": (0.4, "cy/px"), **OBLONG}, TYPICAL),
      Case({"cutoff": (400.0, "kHz"), "scan_velocity": 1e7}, TYPICAL + around(40.0)),
      Case({"cutoff": (400.0, "kHz"), "scan_rate": 1e8, "axis": "y", **FOCAL}, TYPICAL),
      Case({"cutoff": (400.0, "kHz"), "pixel_clock": 1e6, **OBLONG}, TYPICAL),
      Case({"cutoff": (1e-9, "cy/mm")}, ZERO + around(1e-9) + [(5.0, 3.0)]),
      Case({"cutoff": (1e9, "cy/mm")}, TYPICAL + around(1e9)))
def rc_lowpass(p):
    return 1 / (1 + mp.j * p.frequency(axis_of(p)) / p.frequency_cy_mm("cutoff", axis_of(p)))


@kind("butterworth",
      Case({"cutoff": (25.0, "cy/mm"), "poles": 3}, TYPICAL + around(25.0)),
      Case({"cutoff": (3.0, "cy/mrad"), "poles": 1, "axis": "y", **FOCAL}, TYPICAL),
      Case({"cutoff": (0.4, "cy/px"), "poles": 20, **OBLONG}, TYPICAL),
      Case({"cutoff": (400.0, "kHz"), "poles": 3, "scan_velocity": 1e7}, TYPICAL + around(40.0)),
      Case({"cutoff": (400.0, "kHz"), "poles": 3, "scan_rate": 1e8, "axis": "y", **FOCAL}, TYPICAL),
      Case({"cutoff": (400.0, "kHz"), "poles": 3, "pixel_clock": 1e6, **OBLONG}, TYPICAL),
      Case({"cutoff": (1e-9, "cy/mm"), "poles": 20}, ZERO + around(1e-9) + [(5.0, 3.0)]),
      Case({"cutoff": (1e9, "cy/mm"), "poles": 1}, TYPICAL + around(1e9)))
def butterworth(p):
    ratio = p.frequency(axis_of(p)) / p.frequency_cy_mm("cutoff", axis_of(p))
    return 1 / mp.sqrt(1 + ratio ** (2 * p.words["poles"]))


@kind("boost",
      Case({"gain": 2.0, "peak": (0.5, "cy/px"), **OBLONG}, TYPICAL + around(500 / 17.0)),
      Case({"gain": 5.0, "peak": (3.0, "cy/mrad"), "axis": "y", **FOCAL}, TYPICAL),
      Case({"gain": 1.0, "peak": (30.0, "cy/mm")}, TYPICAL),
      Case({"gain": 100.0, "peak": (1e9, "cy/mm")}, TYPICAL + around(1e9)))
def boost(p):
    turn = mp.pi * p.frequency(axis_of(p)) / p.frequency_cy_mm("peak", axis_of(p))
    return 1 + (p["gain"] - 1) / 2 * (1 - mp.cos(turn))


@kind("charge_transfer",
      Case({"inefficiency": 1e-5, "transfers": 2000, **OBLONG}, TYPICAL + around(1000 / 17.0)),
      Case({"inefficiency": 1e-4, "transfers": 30000, "axis": "y", **OBLONG}, TYPICAL),
      Case({"inefficiency": 0.0, "transfers": 1000, **SQUARE}, TYPICAL),
      Case({"inefficiency": 0.1, "transfers": 20, **SQUARE}, TYPICAL),
      Case({"inefficiency": 0.1, "transfers": 0, **SQUARE}, TYPICAL))
def charge_transfer(p):
    turn = 2 * mp.pi * p.frequency(axis_of(p)) * p.pitch_mm(axis_of(p))
    return mp.exp(-p.words["transfers"] * p["inefficiency"] * (1 - mp.expj(-turn)))


@kind("crosstalk",
      Case({"side": 0.03, "corner": 0.005, **OBLONG}, TYPICAL + around(500 / 17.0)),
      Case({"side": 0.03, **SQUARE}, TYPICAL),
      Case({"side": 0.0, "corner": 0.125, **SQUARE}, TYPICAL),
      Case({"side": 0.125, "corner": 0.0, **OBLONG}, TYPICAL))
def crosstalk(p):
    x, y = (mp.cos(2 * mp.pi * p.frequency(a) * p.pitch_mm(a)) for a in "xy")
    side, corner = p["side"], p["corner"] if "corner" in p else mpf(0)
    return (1 - 4 * side - 4 * corner) + 2 * side * (x + y) + 4 * corner * x * y


# Whole numbers of slips a cycle are the zeros of the denominator.
@kind("tdi",
      Case({"stages": 8, "slip": (4.0, "um"), "clock_phases": 3, **OBLONG}, TYPICAL + around(125.0) + around(250.0)),
      Case({"stages": 5, "slip": (0.3, "px"), "clock_phases": 0, "axis": "y", **OBLONG}, TYPICAL),
      Case({"stages": 8, "slip": (0.0, "urad"), "clock_phases": 4, **SQUARE, **FOCAL}, TYPICAL),
      Case({"stages": 1, "slip": (4.0, "um"), "clock_phases": 0}, TYPICAL))
def tdi(p):
    axis, stages, phases = axis_of(p), p.words["stages"], p.words["clock_phases"]
    half_turn = mp.pi * p.frequency(axis) * p.length_mm("slip", axis)
    mean = sum(mp.cos((2 * k - stages + 1) * half_turn) for k in range(stages)) / stages
    return mean * (sinc(p.frequency(axis) * p.pitch_mm(axis) / phases) if phases else 1)


@kind("bolometer",
      Case({"time_constant": 0.01, "velocity": 500.0}, TYPICAL),
      Case({"time_constant": 0.012, "rate": -20000.0, "axis": "y", **FOCAL}, TYPICAL),
      Case({"time_constant": 0.0, "velocity": 500.0}, TYPICAL),
      Case({"time_constant": 0.01, "velocity": 0.0}, TYPICAL),
      Case({"time_constant": 1e3, "velocity": 1e12}, ZERO + [(1e-13, 0.0), (5.0, 3.0)]))
def bolometer(p):
    speed = p["velocity"] / 1000 if "velocity" in p else p["rate"] * p["frame.focal_length"] / 10**6
    return 1 / (1 - 2 * mp.pi * mp.j * p.frequency(axis_of(p)) * speed * p["time_constant"])


@kind("diffusion",
      Case({"absorption_length": 10.0, "depletion_depth": 3.0, "diffusion_length": 20.0}, TYPICAL),
      Case({"absorption_length": 2.0, "depletion_depth": 0.0, "diffusion_length": 50.0}, TYPICAL),
      Case({"absorption_length": 1e-3, "depletion_depth": 5.0, "diffusion_length": 20.0}, TYPICAL),
      Case({"absorption_length": 1e6, "depletion_depth": 5.0, "diffusion_length": 1e6}, TYPICAL),
      Case({"absorption_length": 10.0, "depletion_depth": 1e6, "diffusion_length": 1e-6}, TYPICAL))
def diffusion(p):
    a, depth, l0 = p["absorption_length"], p["depletion_depth"], p["diffusion_length"]
    l_f = l0 / mp.sqrt(1 + (2 * mp.pi * l0 / 1000) ** 2 * (p["fx"] ** 2 + p["fy"] ** 2))
    left = mp.exp(-depth / a)
    return (1 - left / (1 + l_f / a)) / (1 - left / (1 + l0 / a))


DIFFRACTION = {"wavelength": 4.0, "f_number": 2.0}  # cutoff 125 cycles/mm


@kind("diffraction",
      Case({"obscuration": 0.0, **DIFFRACTION}, TYPICAL + around(125.0, steps=(1e-12, 1e-9, 1e-3)) + [(300.0, 0.0)]),
      Case({"obscuration": 0.3, **DIFFRACTION},
           TYPICAL + around(43.75) + around(37.5) + around(81.25, steps=(1e-12, 1e-6)) + around(125.0)),
      Case({"optics.obscuration": 0.6, "optics.f_number": 4.0, "optics.wavelength": 10.0},
           TYPICAL + around(5.0) + around(20.0) + around(15.0) + around(25.0, (0.6, 0.8))),
      Case({"obscuration": 1e-6, **DIFFRACTION}, ZERO + around(62.5, steps=(1e-6, 1e-3)) + [(100.0, 10.0)]),
      Case({"obscuration": 0.999, **DIFFRACTION}, ZERO + around(0.0625) + [(30.0, 40.0), (124.0, 0.0), (124.99, 0.0)]))
def diffraction(p):
    nu = nu_of(p)
    e = abs(p["obscuration"] if "obscuration" in p else p["optics.obscuration"])
    return annular_mtf(nu, e)[0] if nu < 1 else mpf(0)


def waves_of(p, name):
    """Waves at the wavelength in use."""
    wavelength = p["wavelength"] if "wavelength" in p else p["optics.wavelength"]
    return p[name] * (p["wavelength_reference"] / wavelength if "wavelength_reference" in p else 1)


@kind("defocus",
      Case({"waves": 0.5, "obscuration": 0.0, **DIFFRACTION}, TYPICAL + around(125.0) + [(300.0, 0.0)]),
      Case({"waves": -2.0, "wavelength_reference": 5.0, "obscuration": 0.3, **DIFFRACTION},
           TYPICAL + around(43.75)[:2] + around(37.5)[:2] + around(81.25)[:2]),
      Case({"distance": 60.0, "optics.f_number": 2.5, "optics.wavelength": 10.0, "optics.obscuration": 0.5}, TYPICAL),
      Case({"waves": 0.0, "obscuration": 0.3, **DIFFRACTION}, TYPICAL),
      scan_every=3)
def defocus(p):
    nu = nu_of(p)
    if nu >= 1:
        return mpf(0)
    wavelength = p["wavelength"] if "wavelength" in p else p["optics.wavelength"]
    f_number = p["f_number"] if "f_number" in p else p["optics.f_number"]
    waves = waves_of(p, "waves") if "waves" in p else p["distance"] / (8 * f_number**2 * wavelength)
    return defocus_otf(nu, abs(p["obscuration"] if "obscuration" in p else p["optics.obscuration"]), waves)[0]


def seidel_and_zernike(p):
    """The wavefront in waves as a function of x and y, before it is turned."""
    seidel = {"w020": lambda x, y, q: q, "w040": lambda x, y, q: q * q, "w131": lambda x, y, q: q * x,
              "w222": lambda x, y, q: x * x, "w311": lambda x, y, q: x}
    fringe = [lambda x, y, q: mpf(1), lambda x, y, q: x, lambda x, y, q: y, lambda x, y, q: 2 * q - 1,
              lambda x, y, q: x * x - y * y, lambda x, y, q: 2 * x * y, lambda x, y, q: (3 * q - 2) * x,
              lambda x, y, q: (3 * q - 2) * y, lambda x, y, q: 6 * q * q - 6 * q + 1]
    root3, root6, root8 = mp.sqrt(3), mp.sqrt(6), mp.sqrt(8)
    noll = [lambda x, y, q: mpf(1), lambda x, y, q: 2 * x, lambda x, y, q: 2 * y, lambda x, y, q: root3 * (2 * q - 1),
            lambda x, y, q: 2 * root6 * x * y, lambda x, y, q: root6 * (x * x - y * y),
            lambda x, y, q: root8 * (3 * q - 2) * y, lambda x, y, q: root8 * (3 * q - 2) * x]
    terms = [(waves_of(p, name), term) for name, term in seidel.items() if name in p]
    zernike = fringe if p.words.get("numbering", "fringe") == "fringe" else noll
    terms += [(waves_of(p, f"zernike[{i}]"), term) for i, term in enumerate(zernike) if f"zernike[{i}]" in p]
    return lambda x, y: sum(c * term(x, y, x * x + y * y) for c, term in terms)


# Over a cap x = c + R cos t, |y| <= R sin t (R < 0: the left one), by Gauss-Legendre in t and in y / (R sin t).
@kind("wavefront",
      Case({"w040": 0.2, "w131": 0.15, "w222": -0.1, "w311": 0.1, "orientation": 20.0, "obscuration": 0.3,
            **DIFFRACTION}, ZERO + [(5.0, 3.0), (-21.7, 4.4), (33.0, 60.0)]),
      Case({"w020": 0.1, "zernike": [[0.0, 0.05, -0.03, 0.1, 0.08, 0.02, 0.06]], "numbering": "noll",
            "wavelength_reference": 3.0, "optics.obscuration": 0.0, "optics.f_number": 2.0, "optics.wavelength": 4.0},
           ZERO + [(20.0, -13.0), (70.0, 60.0)]),
      Case({"zernike": [[0.0, 0.0, 0.0, -0.1, 0.05, 0.07, 0.0, -0.06, 0.1]], "obscuration": 0.5, **DIFFRACTION},
           [(40.0, 11.0), (0.0, 47.0)]),
      digits=60, scan_every=13, rounding=False)
def wavefront(p):
    nu = nu_of(p)
    if nu == 0 or nu >= 1:
        return mpf(1 if nu == 0 else 0)
    turn = mp.pi * p["orientation"] / 180 if "orientation" in p else mpf(0)
    direction = mp.atan2(p["fy"], p["fx"]) - turn
    cosine, sine = mp.cos(direction), mp.sin(direction)
    surface = seidel_and_zernike(p)
    e = abs(p["obscuration"] if "obscuration" in p else p["optics.obscuration"])
    rule = gauss_legendre(22, 60)

    def cap(centre, radius, angle):
        total = mpf(0)
        for a, weight_a in rule:
            cos_t, sin_t = mp.cos_sin(angle * (1 + a) / 2)
            x, half = centre + radius * cos_t, abs(radius) * sin_t
            row = mpf(0)
            for b, weight_b in rule:
                u, v = x * cosine - half * b * sine, x * sine + half * b * cosine
                difference = surface(u + nu * cosine, v + nu * sine) - surface(u - nu * cosine, v - nu * sine)
                row += weight_b * mp.expj(2 * mp.pi * difference)
            total += weight_a * row * half * half
        return total * angle / 2

    return sum(sign * cap(*c) for sign, c in lens_caps(nu, e)) / (mp.pi * (1 - e) * (1 + e))


def lens_caps(nu, e):
    """Signed caps (centre, radius, half angle) whose sum is the overlap of two annuli at -nu and nu."""
    def angle(adjacent, square):
        return mp.atan2(mp.sqrt(square), adjacent)

    outer = angle(nu, (1 - nu) * (1 + nu))
    caps = [(1, (-nu, mpf(1), outer)), (1, (nu, mpf(-1), outer))]
    if e == 0:
        return caps
    if e > nu:
        inner = angle(nu, (e - nu) * (e + nu))
        caps += [(1, (-nu, e, inner)), (1, (nu, -e, inner))]
    if 2 * nu <= 1 - e:
        caps += [(-1, (nu, e, mp.pi)), (-1, (-nu, -e, mp.pi))]
    elif 2 * nu < 1 + e:
        shift = (1 - e) * (1 + e) / (4 * nu)
        square = 1 - (nu + shift) ** 2
        big, small = angle(nu + shift, square), angle(nu - shift, square)
        caps += [(-1, (-nu, mpf(1), big)), (-1, (nu, -e, small)), (-1, (nu, mpf(-1), big)), (-1, (-nu, e, small))]
    return caps


# A factor that starts and stops at the cutoff: the slope jumps there; and clipped at zero.
@kind("rms_wavefront",
      Case({"rms": 0.07, **DIFFRACTION}, TYPICAL + around(125.0)[:1] + around(125.0)[3:],
           dict.fromkeys(("fx", "wavelength", "f_number"), "right")),
      Case({"rms": 0.05, "wavelength_reference": 0.6328, **DIFFRACTION}, TYPICAL),
      Case({"rms": 0.0, "optics.wavelength": 10.0, "optics.f_number": 1.5}, TYPICAL),
      Case({"rms": 0.36, **DIFFRACTION}, TYPICAL + around(62.5 * (1 - math.sqrt(0.75)))[3:]))
def rms_wavefront(p):
    nu = nu_of(p)
    if nu >= 1:
        return mpf(1)
    wavelength = p["wavelength"] if "wavelength" in p else p["optics.wavelength"]
    rms = p["rms"] * (p["wavelength_reference"] / wavelength if "wavelength_reference" in p else 1)
    return max(mpf(0), 1 - (rms / (mpf(18) / 100)) ** 2 * (1 - 4 * (nu - mpf(1) / 2) ** 2))


@kind("random_wavefront",
      Case({"rms": 0.1, "correlation": 0.2, "aperture": 50.0, "wavelength": 4.0, **FOCAL}, TYPICAL),
      Case({"rms": 0.4, "wavelength_reference": 3.0, "correlation": 0.05, "optics.f_number": 2.0,
            "optics.wavelength": 4.0}, TYPICAL),
      Case({"rms": 1.5, "correlation_length": 8.0, "wavelength": 10.0, **FOCAL}, TYPICAL),
      Case({"rms": 0.0, "correlation_length": 1e-3, "wavelength": 4.0, **FOCAL}, TYPICAL))
def random_wavefront(p):
    wavelength = p["wavelength"] if "wavelength" in p else p["optics.wavelength"]
    in_pupil = mp.hypot(p["fx"], p["fy"]) * wavelength / 1000  # for a focal length of 1
    if "correlation_length" in p:
        relative = in_pupil * p["frame.focal_length"] / p["correlation_length"]
    elif "aperture" in p:
        relative = in_pupil * p["frame.focal_length"] / (p["correlation"] * p["aperture"])
    else:  # the focal length cancels
        relative = in_pupil * p["optics.f_number"] / p["correlation"]
    return mp.exp((2 * mp.pi * waves_of(p, "rms")) ** 2 * mp.expm1(-(relative**2)))


@kind("fir",
      Case({"taps": [[0.0, -0.25, 0.0], [-0.25, 2.0, -0.25], [0.0, -0.25, 0.0]], **OBLONG}, TYPICAL),
      Case({"taps": [[0.1, 0.5, 0.7]], **SQUARE}, TYPICAL + around(500 / 17.0)))
def fir(p):
    rows, columns = p.words["taps"]
    x, y = (-2 * mp.pi * p.frequency(a) * p.pitch_mm(a) for a in "xy")
    return sum(p[f"taps[{j * columns + k}]"] * mp.expj(x * (k - (columns - 1) // 2) + y * (j - (rows - 1) // 2))
               for j in range(rows) for k in range(columns))


PSF = [[0.02, 0.1, 0.03], [0.1, 0.5, 0.12], [0.01, 0.1, 0.02]]


# Within half a cycle per sample; 0 beyond, with a step that is no slope.
@kind("psf",
      Case({"samples": PSF, "step": (2.0, "um")}, TYPICAL + [(240.0, 10.0), (-3.0, -240.0), (260.0, 1.0), (1.0, -251.0)]),
      Case({"samples": [[1.0, 4.0, 1.0]], "step_x": (0.2, "px"), "step_y": (30.0, "urad"), **OBLONG, **FOCAL}, TYPICAL),
      Case({"samples": [[-10.0, 5.0, 3.0], [40.0, 500.0, -20.0], [5.0, -7.0, 9.0], [1.0, 2.0, 3.0], [0.0, 0.0, 1.0]],
            "step": (1.0, "um")}, TYPICAL))
def psf(p):
    rows, columns = p.words["samples"]
    x, y = (p.frequency(a) * p.length_mm("step", a) for a in "xy")
    if max(abs(x), abs(y)) >= mpf(1) / 2:
        return mpf(0)
    sample = [p[f"samples[{i}]"] for i in range(rows * columns)]
    return sum(sample[j * columns + k] * mp.expj(-2 * mp.pi * (x * (k - (columns - 1) // 2) + y * (j - (rows - 1) // 2)))
               for j in range(rows) for k in range(columns)) / sum(sample)


CURVE = "10:0.9|20:0.7|40:0.25|60:0.1"
IN_PIXELS = "0:1|0.1875:0.75|0.5:0.75|1:-0.125"


# Fritsch and Carlson's monotone cubic with Brodlie's slopes, secants at the ends; past the end straight on to zero.
# The value is smooth through a sample, its second derivative is not.
@kind("curve",
      Case({"file": CURVE + " cy/mm"}, TYPICAL + around(20.0) + [(60.0, 0.0), (61.0, 0.0), (59.0, 0.0), (80.0, 80.0)],
           {"fx": "right"}),
      Case({"file": CURVE + " cy/mrad", "axis": "y", **FOCAL}, ZERO + [(1.0, 1.5), (0.0, -3.0), (2.0, 6.5)]),
      Case({"file": IN_PIXELS + " cy/px", "axis": "x", **OBLONG}, TYPICAL + [(58.0, 3.0)]))
def curve(p):
    samples, unit = p.words["file"].split()
    x, y = zip(*([mpf(float(n)) for n in pair.split(":")] for pair in samples.split("|")))
    if x[0] > 0:
        x, y = (mpf(0), *x), (mpf(1), *y)
    scale = {"cy/mm": lambda a: 1, "cy/mrad": lambda a: p["frame.focal_length"] / 1000, "cy/px": p.pitch_mm}[unit]
    axis = p.words.get("axis", "radial")
    along = [p.frequency(a) * scale(a) for a in "xy" if axis in (a, "radial")]
    f = mp.sqrt(sum(u * u for u in along))
    secant = [(y1 - y0) / (x1 - x0) for x0, x1, y0, y1 in zip(x, x[1:], y, y[1:])]

    def slope(i):
        if i in (0, len(x) - 1):
            return secant[min(i, len(secant) - 1)]
        before, after = secant[i - 1], secant[i]
        if before * after <= 0:
            return mpf(0)
        left, right = x[i] - x[i - 1], x[i + 1] - x[i]
        weight = (left + 2 * right) / (3 * (left + right))
        return before * after / (weight * after + (1 - weight) * before)

    if f >= x[-1]:
        steepness = max(abs(slope(len(x) - 1)), 1 / x[-1])
        return mp.sign(y[-1]) * max(mpf(0), abs(y[-1]) - steepness * (f - x[-1]))
    i = max(k for k in range(len(x)) if x[k] <= f)
    h = x[i + 1] - x[i]
    t = (f - x[i]) / h
    c2 = 3 * secant[i] - 2 * slope(i) - slope(i + 1)
    c3 = slope(i) + slope(i + 1) - 2 * secant[i]
    return y[i] + h * t * (slope(i) + t * (c2 + t * c3))


@kind("rc_highpass",
      Case({"cutoff": (2.0, "cy/mm")}, [(5.0, 3.0), (-21.7, 4.4), (0.1, 47.0)] + around(2.0)),
      Case({"cutoff": (0.4, "cy/px"), "axis": "y", "dc": "remove", **OBLONG}, TYPICAL),
      Case({"cutoff": (20.0, "kHz"), "scan_velocity": 1e7}, [(5.0, 3.0), (-21.7, 4.4)]),
      Case({"cutoff": (20.0, "kHz"), "scan_rate": 1e8, **FOCAL}, [(5.0, 3.0), (-21.7, 4.4)]),
      Case({"cutoff": (20.0, "kHz"), "pixel_clock": 1e6, "dc": "remove", **OBLONG}, [(5.0, 3.0), (-21.7, 4.4)]))
def rc_highpass(p):
    u = p.frequency(axis_of(p)) / p.frequency_cy_mm("cutoff", axis_of(p))
    return mp.j * u / (1 + mp.j * u)


@kind("unsharp",
      Case({"amount": 1.5, "size": 3, **OBLONG}, TYPICAL + around(1000 / 17.0)),
      Case({"amount": 0.7, "sigma": 1.2, **OBLONG}, TYPICAL + around(500 / 17.0)),
      Case({"amount": 0.0, "sigma": 0.3, **SQUARE}, TYPICAL))
def unsharp(p):
    def blur(axis):
        turn = 2 * mp.pi * p.frequency(axis) * p.pitch_mm(axis)
        if "size" in p.words:
            reach = (p.words["size"] - 1) // 2
            return sum(mp.cos(k * turn) for k in range(-reach, reach + 1)) / p.words["size"]
        taps = [mp.exp(-(mpf(k) ** 2) / (2 * p["sigma"] ** 2)) for k in range(40)]
        weights = [taps[0]] + [2 * t for t in taps[1:]]
        return sum(w * mp.cos(k * turn) for k, w in enumerate(weights)) / sum(weights)

    return 1 + p["amount"] * (1 - blur("x") * blur("y"))


@kind("interpolation",
      Case({"kernel": "nearest", **OBLONG}, TYPICAL + around(1000 / 17.0)),
      Case({"kernel": "linear", **OBLONG}, TYPICAL),
      Case({"kernel": "cubic", "a": -0.5, **OBLONG}, TYPICAL + around(1000 / 17.0) + [(0.5, -0.3), (3.0, 8.0)]),
      Case({"kernel": "cubic", "a": -1.0, **OBLONG}, TYPICAL),
      Case({"kernel": "bspline", **OBLONG}, TYPICAL),
      Case({"kernel": "six_coefficient", **OBLONG}, TYPICAL))
def interpolation(p):
    def response(x):
        kernel, turn = p.words["kernel"], mp.pi * x
        if kernel == "six_coefficient":
            c = [mpf(n) / 10000 for n in (6213, -1704, 693, -276, 100, -30)]
            return mpf(1) / 2 + sum(c_j * mp.cos((2 * j + 1) * turn) for j, c_j in enumerate(c))
        if kernel == "bspline":
            return sinc(x) ** 4 / (mpf(2) / 3 + mp.cos(2 * turn) / 3)
        if kernel == "cubic":
            if x == 0:
                return mpf(1)
            a = 3 * (sinc(x) ** 2 - sinc(2 * x)) / turn**2
            return a + p["a"] * 2 * (3 * sinc(2 * x) ** 2 - 2 * sinc(2 * x) - sinc(4 * x)) / turn**2
        return sinc(x) ** {"nearest": 1, "linear": 2}[kernel]

    return response(p["fx"] * p.pitch_mm("x")) * response(p["fy"] * p.pitch_mm("y"))


@kind("display_crt",
      Case({"sigma": (0.5, "px"), **OBLONG}, TYPICAL),
      Case({"sigma_x": (8.0, "um"), "sigma_y": (0.0, "um")}, TYPICAL))
def display_crt(p):
    return gaussian_of(p, "sigma")


@kind("display_flat_panel",
      Case({"width": (0.9, "px"), **OBLONG}, TYPICAL),
      Case({"lcd_pitch": (1.0, "px"), **OBLONG}, TYPICAL))
def display_flat_panel(p):
    if "width" in p:
        return sinc(p.length_mm("width", "x") * p["fx"]) * sinc(p.length_mm("width", "y") * p["fy"])
    x, y = (p.length_mm("lcd_pitch", a) * p["f" + a] for a in "xy")
    stripes = mpf(68) / 100 + mpf(32) / 100 * mp.cos(mpf(64) / 100 * mp.pi * x)
    return sinc(mpf(29) / 100 * x) * stripes * sinc(mpf(85) / 100 * y)


def contrast_sensitivity(model, u, luminance, field_deg):
    if model == "barten_2003":
        noise = 63 / luminance ** (mpf(83) / 100) + 1 / (1 - mp.exp(-u * u / 50))
        return (5200 * mp.exp(-mpf(16) / 10000 * u * u * (1 + 100 / luminance) ** (mpf(8) / 100))
                / mp.sqrt((1 + 144 / field_deg**2 + mpf(64) / 100 * u * u) * noise))
    b = mpf(3) / 10 * (1 + 100 / luminance) ** (mpf(15) / 100)
    a = 540 * (1 + mpf(7) / 10 / luminance) ** (-mpf(2) / 10)
    a /= 1 + 12 / (field_deg * (1 + u / 3) ** (2 if model == "barten_short_squared" else 1))
    return a * u * mp.exp(-b * u) * mp.sqrt(1 + mpf(6) / 100 * mp.exp(b * u))


@lru_cache(maxsize=None)
def peak_of_sensitivity(model, luminance, field_deg):
    """Where the sensitivity is largest, to half the digits: there it has no slope."""
    with mp.workdps(80):
        log_of = lambda u: mp.log(contrast_sensitivity(model, u, mpf(luminance), mpf(field_deg)))
        start = max((mpf(k) / 4 for k in range(1, 80)), key=log_of)
        return mp.findroot(lambda u: mp.diff(log_of, u), start, tol=mpf(10) ** -60)


IN_SIGHT = [(0.5, -0.2), (5.0, 3.0), (-21.7, 4.4), (33.0, 33.0)]


@kind("eye",
      Case({"model": "mtf", "magnification": 10.0, "luminance": 34.0, "eyes": 2, **FOCAL}, IN_SIGHT),
      Case({"model": "mtf", "magnification": 3.0, "luminance": 500.0, "eyes": 1, **FOCAL}, IN_SIGHT),
      Case({"model": "barten_2003", "magnification": 10.0, "luminance": 34.0, "field": 10.0, **FOCAL}, IN_SIGHT),
      Case({"model": "barten_short", "magnification": 5.0, "luminance": 100.0, "field": 20.0, **FOCAL}, IN_SIGHT),
      Case({"model": "barten_short_squared", "magnification": 5.0, "luminance": 1.0, "field": 10.0, **FOCAL}, IN_SIGHT))
def eye(p):
    f = mp.hypot(p["fx"], p["fy"]) * p["frame.focal_length"] / 1000 / p["magnification"]
    luminance, model = p["luminance"], p.words["model"]
    if model == "mtf":
        in_foot_lamberts = luminance * mp.pi * (mpf(3048) / 10000) ** 2
        d = -mpf(9011) / 1000 + mpf(1323) / 100 * mp.exp(-mp.log10(in_foot_lamberts) / (mpf(21082) / 1000))
        d -= mpf(1) / 2 if p.words["eyes"] == 2 else 0
        f0 = mp.exp(mpf(3663) / 1000 - mpf(216) / 10000 * d * d * mp.log(d))
        i0 = (mpf(7155) / 10000 + mpf(277) / 1000 / mp.sqrt(d)) ** 2
        return (mp.exp(-((mpf(4369) / 100 * f / f0) ** i0)) * mp.exp(-mpf(375) / 1000 * f ** (mpf(121) / 100))
                * mp.exp(-mpf(4441) / 10000 * f * f))
    u = f * 1000 * mp.pi / 180
    peak = peak_of_sensitivity(model, float(luminance), float(p["field"]))
    here, largest = (contrast_sensitivity(model, v, luminance, p["field"]) for v in (u, peak))
    return here / largest
