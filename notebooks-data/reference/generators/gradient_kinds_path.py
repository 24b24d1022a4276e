# SPDX-License-Identifier: Apache-2.0
"""The path through the air, for gradient_kinds.py: OTFs from the definition and the cases to tabulate."""

from mpmath import mp, mpf

from gradient_kinds import FOCAL, OBLONG, TYPICAL, ZERO, Case, around, kind
from tables import gauss_legendre

KOLMOGOROV = (mpf(24) / 5 * mp.gamma(mpf(6) / 5)) ** (mpf(5) / 6)


# lambda u = D at 100 mm/(0.004 mm x 100 mm) = 250 cycles/mm for the first short exposures; from there on the bracket
# keeps its value, and that side's slope is the one that counts.
BEYOND_APERTURE = {**dict.fromkeys(("fx", "wavelength", "frame.focal_length"), "right"), "aperture": "left"}


LAYERS = {"profile": "hufnagel_valley", "wind": 25.0, "ground_cn2": 1.7e-14, "wavelength": 4.0}
ALONG = ZERO + [(5.0, 3.0), (-21.7, 4.4)]


def structure_parameter(p, h):
    return (mpf(594) / 10**55 * (p["wind"] / 27) ** 2 * h**10 * mp.exp(-h / 1000)
            + mpf(27) / 10**17 * mp.exp(-h / 1500) + p["ground_cn2"] * mp.exp(-h / 100))


def fried_parameter_mm(p, wavelength):
    """Given, or from Cn2 along the path; s = q^3 makes the weight s^(5/3) ds smooth."""
    if "fried_parameter" in p:
        return p["fried_parameter"]
    plane = p.words.get("wave") == "plane"
    if "cn2" in p:
        path = p["cn2"] * p["path_length"] * (1 if plane else mpf(3) / 8)
    else:
        low, rise = p["target_altitude"], p["sensor_altitude"] - p["target_altitude"]
        path = mpf(0)
        for t, weight in gauss_legendre(100, mp.dps):
            q = (1 + t) / 2
            path += weight / 2 * 3 * q**2 * (1 if plane else q**5) * structure_parameter(p, low + q**3 * rise)
        path *= p["path_length"] if "path_length" in p else abs(rise) / mp.cos(mp.pi * p["zenith_angle"] / 180)
    return 1000 * (mpf(423) / 1000 * (2 * mp.pi * 10**6 / wavelength) ** 2 * path) ** (-mpf(3) / 5)


@kind("turbulence",
      Case({"fried_parameter": 50.0, "wavelength": 4.0, **FOCAL}, TYPICAL + [(200.0, 0.0)]),
      Case({"fried_parameter": 50.0, "wavelength_reference": 0.55, "constant": "3.44", "optics.wavelength": 4.0,
            **FOCAL}, TYPICAL),
      Case({"fried_parameter": 300.0, "exposure": "short", "alpha": 0.5, "aperture": 100.0, "wavelength": 4.0, **FOCAL},
           TYPICAL + around(250.0)[:1] + around(250.0)[3:] + [(400.0, 1.0)], BEYOND_APERTURE),
      Case({"fried_parameter": 300.0, "exposure": "short", "alpha": 1.0, "aperture": 100.0, "wavelength": 4.0, **FOCAL},
           TYPICAL + around(250.0)[:1] + around(250.0)[3:], BEYOND_APERTURE),
      Case({"fried_parameter": 50.0, "exposure": "short", "alpha": 0.0, "optics.f_number": 2.0, "wavelength": 4.0,
            **FOCAL}, TYPICAL),
      Case({"fried_parameter": 1e6, "wavelength": 4.0, **FOCAL}, TYPICAL),
      Case({"cn2": 1e-14, "path_length": 4000.0, "wavelength": 4.0, **FOCAL}, TYPICAL),
      Case({"cn2": 3e-15, "path_length": 9000.0, "wave": "plane", "exposure": "short", "alpha": 0.5, "aperture": 100.0,
            "optics.wavelength": 4.0, **FOCAL}, TYPICAL),
      Case({**LAYERS, "target_altitude": 2000.0, "sensor_altitude": 20.0, "path_length": 4000.0, **FOCAL}, ALONG),
      Case({**LAYERS, "target_altitude": 30.0, "sensor_altitude": 9000.0, "zenith_angle": 60.0, **FOCAL}, ALONG),
      Case({**LAYERS, "target_altitude": 20000.0, "sensor_altitude": 0.0, "zenith_angle": 10.0, "wave": "plane",
            **FOCAL}, ALONG),
      Case({**LAYERS, "target_altitude": 15.0, "sensor_altitude": 15.0, "path_length": 3000.0, **FOCAL}, ALONG))
def turbulence(p):
    wavelength = p["wavelength"] if "wavelength" in p else p["optics.wavelength"]
    r0 = fried_parameter_mm(p, wavelength)
    if "wavelength_reference" in p:
        r0 *= (wavelength / p["wavelength_reference"]) ** (mpf(6) / 5)
    span = mp.hypot(p["fx"], p["fy"]) * p["frame.focal_length"] * wavelength / 1000  # in the aperture, mm
    c = mpf(344) / 100 if p.words.get("constant") == "3.44" else KOLMOGOROV
    bracket = mpf(1)
    if p.words.get("exposure") == "short":
        aperture = p["aperture"] if "aperture" in p else p["frame.focal_length"] / p["optics.f_number"]
        bracket = 1 - p["alpha"] * mp.cbrt(min(span / aperture, 1))
    return mp.exp(-c * (span / r0) ** (mpf(5) / 3) * bracket)


# At and beyond uc the loss is constant; `contrast` is 1 at f = 0 alone.
OFF_ZERO = [(1e-9, -2e-9), (5.0, 3.0), (-21.7, 4.4), (0.0, 47.0)]
BEYOND = {**dict.fromkeys(("fx", "wavelength", "frame.focal_length"), "right"), "cutoff": "left",
          "particle_radius": "left"}


@kind("aerosol",
      Case({"scattering": 0.1, "path_length": 5.0}, OFF_ZERO),
      Case({"scattering": 0.1, "path_length": 5.0, "mode": "blur", "cutoff": (40.0, "cy/mm")},
           TYPICAL + around(40.0)[:1] + around(40.0)[3:], BEYOND),
      Case({"scattering": 3.0, "path_length": 0.0, "mode": "blur", "cutoff": (2.0, "cy/mrad"), **FOCAL}, TYPICAL),
      Case({"scattering": 0.5, "path_length": 8.0, "mode": "blur", "cutoff": (0.4, "cy/px"), **OBLONG}, TYPICAL),
      Case({"scattering": 0.2, "path_length": 7.0, "mode": "blur", "particle_radius": 1e4, "wavelength": 4.0, **FOCAL},
           TYPICAL),
      Case({"scattering": 0.0, "path_length": 7.0, "mode": "blur", "particle_radius": 1e4, "optics.wavelength": 4.0,
            **FOCAL}, TYPICAL))
def aerosol(p):
    depth = p["scattering"] * p["path_length"]
    if p.words.get("mode", "contrast") == "contrast":
        return mp.exp(-depth) if (p["fx"], p["fy"]) != (0, 0) else mpf(1)
    if "cutoff" in p:
        relative = mp.hypot(*[p.frequency(a) / p.frequency_cy_mm("cutoff", a) for a in "xy"])
    else:
        wavelength = p["wavelength"] if "wavelength" in p else p["optics.wavelength"]
        relative = mp.hypot(p["fx"], p["fy"]) * p["frame.focal_length"] * wavelength / p["particle_radius"]
    return mp.exp(-depth * min(relative, mpf(1)) ** 2)
