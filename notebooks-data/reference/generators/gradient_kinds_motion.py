# SPDX-License-Identifier: Apache-2.0
"""Motion during the exposure, for gradient_kinds.py: OTFs from the definition and the cases to tabulate."""

import math

from mpmath import mp, mpf

from gradient_kinds import FOCAL, OBLONG, TYPICAL, ZERO, Case, around, kind, sinc, unit_vector
from tables import gauss_legendre


def along_motion(p, length_x, length_y):
    cosine, sine = unit_vector(p)
    return length_x * cosine * p["fx"] + length_y * sine * p["fy"]


@kind("linear_motion",
      Case({"travel": (10.0, "um"), "direction": 30.0}, TYPICAL),
      Case({"travel": (1.0, "px"), "direction": -90.0, **OBLONG}, TYPICAL),
      Case({"travel": (0.0, "um"), "direction": 360.0}, TYPICAL),
      Case({"velocity": 2000.0, "direction": 180.0, "frame.integration_time": 0.01}, TYPICAL),
      Case({"rate": 20000.0, "direction": 45.0, "frame.integration_time": 0.01, **FOCAL}, TYPICAL))
def linear_motion(p):
    if "travel" in p:
        return sinc(along_motion(p, p.length_mm("travel", "x"), p.length_mm("travel", "y")))
    speed = p["velocity"] / 1000 if "velocity" in p else p["rate"] * p["frame.focal_length"] / 10**6
    length = speed * p["frame.integration_time"]
    return sinc(along_motion(p, length, length))


# By quadrature of the definition. At least 1e-40 for phases to 30 rad, and the rule stays the same over a difference.
def mean_over_exposure(integrand):
    """Mean over s = -1/2 ... 1/2, time in units of the exposure."""
    return sum(weight / 2 * integrand(s / 2) for s, weight in gauss_legendre(80, mp.dps))


ACCELERATED = {"frame.integration_time": 0.01}


@kind("accelerated_motion",
      Case({"velocity": 1200.0, "acceleration": 6e4, "direction": 0.0, **ACCELERATED}, TYPICAL),
      Case({"velocity": 8000.0, "acceleration": -2.4e6, "direction": 30.0, **ACCELERATED}, TYPICAL),
      Case({"velocity": 0.0, "acceleration": 2e6, "direction": -90.0, **ACCELERATED}, TYPICAL),
      Case({"velocity": 1200.0, **ACCELERATED}, TYPICAL),
      Case({"rate": 5000.0, "angular_acceleration": 6e5, "direction": 200.0, **FOCAL, **ACCELERATED}, TYPICAL),
      digits=90, scan_every=3)
def accelerated_motion(p):
    t = p["frame.integration_time"]
    per_s = mpf(1) / 1000 if "velocity" in p else p["frame.focal_length"] / 10**6  # mm of the focal plane
    speed = p["velocity"] if "velocity" in p else p["rate"]
    names = [name for name in ("acceleration", "angular_acceleration") if name in p]
    gain = p[names[0]] if names else mpf(0)
    return mean_over_exposure(lambda s: mp.expj(-2 * mp.pi * along_motion(
        p, *[per_s * (speed * s * t + gain * (s * t) ** 2 / 2)] * 2)))


WINDOW = ZERO + [(5.0, 3.0), (-21.7, 4.4), (33.0, 33.0)]


# rms: the mean over phases of |otf|^2 is that of J0 over the differences of two times in the exposure.
@kind("vibration",
      Case({"amplitude": (5.0, "um"), "direction": 0.0}, TYPICAL + around(2.404825557695773 / (2 * math.pi * 0.005))),
      Case({"amplitude": (1.5, "px"), "direction": 30.0, **OBLONG}, TYPICAL + [(400.0, 200.0)]),
      Case({"amplitude": (0.0, "urad"), "direction": -360.0, **FOCAL}, TYPICAL),
      Case({"amplitude": (5.0, "um"), "average": "fixed_phase", "cycles": 0.4, "phase": 30.0}, WINDOW),
      Case({"amplitude": (0.8, "px"), "direction": 30.0, "average": "fixed_phase", "cycles": 2.0, "phase": -90.0,
            **OBLONG}, WINDOW),
      Case({"amplitude": (120.0, "urad"), "direction": 90.0, "average": "fixed_phase", "period": 0.025,
            "frame.integration_time": 0.01, **FOCAL}, WINDOW),
      Case({"amplitude": (5.0, "um"), "average": "rms", "cycles": 0.4, "direction": 30.0}, WINDOW),
      Case({"amplitude": (12.0, "um"), "average": "rms", "period": 0.008, "frame.integration_time": 0.01}, WINDOW),
      digits=90, scan_every=3)
def vibration(p):
    x = 2 * mp.pi * along_motion(p, p.length_mm("amplitude", "x"), p.length_mm("amplitude", "y"))
    average = p.words.get("average", "many_cycles")
    if average == "many_cycles":
        return mp.besselj(0, x)
    cycles = p["cycles"] if "cycles" in p else p["frame.integration_time"] / p["period"]
    if average == "fixed_phase":
        phase = mp.pi * p["phase"] / 180 if "phase" in p else mpf(0)
        return mean_over_exposure(lambda s: mp.expj(-x * mp.sin(2 * mp.pi * cycles * s + phase)))
    half_turn = mp.pi * cycles
    return mp.sqrt(mean_over_exposure(
        lambda s: (1 - 2 * s) * mp.besselj(0, 2 * x * mp.sin(half_turn * (s + mpf(1) / 2)))))
