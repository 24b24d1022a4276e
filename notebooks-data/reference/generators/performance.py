#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""performance.csv: image quality and target acquisition from their definitions, 40 digits. Needs mpmath.

The system's MTF is exp(-(f/a)^2), that of the noise exp(-(f/b)^2), so that a table holds a case by numbers alone.
Frequencies in cycles/mrad. Arguments, in this order and as exact doubles joined by |:
  niirs3      rer gsd_m overshoot gain snr
  niirs4      the same, elevation_deg
  niirs5      rer_x rer_y gsd_m snr elevation_deg
  grd         a snr ifov_mrad range_m
  channel     f b: integral of exp(-4.4 ln^2(|f'|/f)) exp(-2 (f'/b)^2) df' over all f'
  averaged    w band b: integral of sinc^2(w f) exp(-2 (f/b)^2) df over |f| <= band
  mrtd        axis(0 x, 1 y) f tvh vh th tv h v spacing_x spacing_y snr_threshold eye_time frame_rate aspect a b
  ttp_axis    model(0 2003, 1 short, 2 short squared) luminance field_deg magnification display_contrast factor a C;
              and its slope by C
  ttp_range   the same without C, size_m C beta v50 probability psychometric(0 NVThermIP, 1 NV-IPM)
  ratio       psychometric(0, 1, 2 Johnson) probability: x of P = x^E/(1 + x^E)
"""

import argparse

from mpmath import exp, findroot, linspace, log, log10, mp, mpf, pi, quad, sin, sqrt

from tables import digits, hex_of, write_table

mp.dps = 40


def niirs3(rer, gsd, overshoot, gain, snr):
    return mpf("11.81") + mpf("3.32") * log10(rer / (gsd / mpf("0.0254"))) - mpf("1.48") * overshoot - gain / snr


def niirs4(rer, gsd, overshoot, gain, snr, elevation):
    a, b = (mpf("3.32"), mpf("1.559")) if rer >= mpf(float(0.9)) else (mpf("3.16"), mpf("2.817"))
    ground = gsd / sqrt(sin(elevation * pi / 180)) / mpf("0.0254")
    return (mpf("10.251") - a * log10(ground) + b * log10(rer) - mpf("0.656") * overshoot
            - mpf("0.344") * gain / snr)


def niirs5(rer_x, rer_y, gsd, snr, elevation):
    rer = (max(rer_x, rer_y) * min(rer_x, rer_y) ** 2) ** (mpf(1) / 3)
    between = gsd / sin(elevation * pi / 180) ** (mpf(1) / 4) / mpf("0.0254")
    return (mpf("9.57") - mpf("3.32") * log10(between) + mpf("3.32") * (1 - exp(-mpf("1.9") / snr)) * log10(rer)
            - 2 * log10(rer) ** 4 - mpf("1.8") / snr)


def grd(a, snr, ifov, distance):
    u = a * sqrt(log(snr / 3))
    return distance / 1000 * max(1 / u, 2 * ifov)


def channel(f, b):
    # In t = ln(f'/f), both signs of f'.
    def integrand(t):
        return exp(t - mpf("4.4") * t * t - 2 * (f * exp(t) / b) ** 2)
    return 2 * f * quad(integrand, linspace(-5, 5, 21))


def averaged(w, band, b):
    def integrand(lobes):
        s = mpf(1) if lobes == 0 else sin(pi * lobes) / (pi * lobes)
        return s * s * exp(-2 * (lobes / w / b) ** 2)
    end = w * band
    whole = int(end)
    points = [mpf(i) for i in range(whole + 1)] + ([end] if end > whole else [])
    return 2 / w * quad(integrand, points, method="gauss-legendre")


def mrtd(axis, f, tvh, vh, th, tv, h, v, spacing_x, spacing_y, snr, eye_time, rate, aspect, a, b):
    across, along = 1 / (2 * f), aspect / (2 * f)
    widths = (along, across) if axis else (across, along)
    e_x, e_y = (s * averaged(w, 1 / (2 * s), b) for s, w in zip((spacing_x, spacing_y), widths))
    e_t = min(mpf(1), 1 / (rate * eye_time))
    variance = tvh**2 * e_t * e_x * e_y + vh**2 * e_x * e_y
    variance += (tv**2 * e_t + v**2) * e_y if axis else (th**2 * e_t + h**2) * e_x
    return pi**2 / 8 * snr * sqrt(variance) / exp(-((f / a) ** 2))


def sensitivity(model, u, lum, field):
    if model == 0:
        top = 5200 * exp(-mpf("0.0016") * u**2 * (1 + 100 / lum) ** mpf("0.08"))
        size = 1 + 144 / field**2 + mpf("0.64") * u**2
        return top / sqrt(size * (63 / lum ** mpf("0.83") + 1 / (1 - exp(-mpf("0.02") * u**2))))
    b = mpf("0.3") * (1 + 100 / lum) ** mpf("0.15")
    a = 540 * (1 + mpf("0.7") / lum) ** mpf("-0.2") / (1 + 12 / (field * (1 + u / 3) ** int(model)))
    return a * u * exp(-b * u) * sqrt(1 + mpf("0.06") * exp(b * u))


def system(model, lum, field, magnification, display, factor, a):
    def of(f):
        u = f / magnification * pi / mpf("0.18")  # 1 cycle/mrad = pi / 0.18 cycles/degree
        return display * sensitivity(model, u, lum, field) * exp(-((f / a) ** 2)) / factor
    return of


def ends(of, contrast):
    """Both frequencies at which contrast x sensitivity = 1, or None."""
    grid = [mpf(2) ** (mpf(i) / 8) for i in range(-160, 80)]
    values = [contrast * of(f) - 1 for f in grid]
    up = next((i for i, value in enumerate(values) if value > 0), None)
    if up is None:
        return None
    down = next(i for i in range(up, len(grid)) if values[i] < 0)
    solve = lambda i: findroot(lambda f: contrast * of(f) - 1, (grid[i - 1], grid[i]), solver="anderson", tol=mpf(10) ** -70)
    return solve(up), solve(down)


def ttp(of, contrast):
    lo, hi = ends(of, contrast)
    return quad(lambda t: exp(t) * sqrt(contrast * of(exp(t))), linspace(log(lo), log(hi), 5))


def ttp_axis(*arguments):
    of, contrast = system(*arguments[:-1]), arguments[-1]
    step = mpf(10) ** -12
    mp.dps = 50
    slope = (ttp(of, contrast * (1 + step)) - ttp(of, contrast * (1 - step))) / (2 * step * contrast)
    mp.dps = 40
    return ttp(of, contrast), slope


STEEPNESS = [(mpf("1.51"), mpf("0.24")), (mpf("1.5"), mpf(0)), (mpf("2.7"), mpf("0.7"))]


def ratio(model, probability):
    constant, slope = STEEPNESS[int(model)]
    odds = log(probability / (1 - probability))
    if odds == 0:
        return mpf(1)
    ends_of = sorted([mpf(0), odds / constant])
    return exp(findroot(lambda x: (constant + slope * exp(x)) * x - odds, ends_of, solver="anderson"))


def ttp_range(model, lum, field, magnification, display, factor, a, size, contrast, beta, v50, probability, steepness):
    of, needed = system(model, lum, field, magnification, display, factor, a), v50 * ratio(steepness, probability)
    far = 1000 * ttp(of, contrast) * size / needed
    if beta == 0:
        return far

    def surplus(distance):
        here = contrast * exp(-beta * distance / 1000)
        return (1000 * size * ttp(of, here) if ends(of, here) else mpf(0)) - needed * distance

    lo, hi = mpf(0), far
    for _ in range(24):
        middle = (lo + hi) / 2
        lo, hi = (middle, hi) if surplus(middle) > 0 else (lo, middle)
    return findroot(surplus, (lo, hi), solver="secant", tol=mpf(10) ** -40)


CASES = [
    (niirs3, [(0.9, 0.5, 1.2, 2.0, 50.0), (0.3, 2.0, 1.0, 1.0, 5.0)]),
    (niirs4, [(0.9, 0.5, 1.2, 2.0, 50.0, 60.0), (0.35, 0.52832, 1.0, 1.0, 50.0, 90.0), (0.89, 0.3, 1.4, 6.0, 20.0, 35.0)]),
    (niirs5, [(0.5, 0.4, 0.5, 50.0, 60.0), (0.35, 0.35, 0.52832, 50.0, 90.0), (0.2, 0.6, 0.3, 3.0, 25.0),
              (1.1, 0.9, 0.1, 1e6, 89.0)]),
    (grd, [(2.0, 20.0, 0.1, 1000.0), (2.0, 3.001, 0.1, 1000.0), (2.0, 1e9, 0.5, 1e5)]),
    (channel, [(1.0, 2.0), (0.05, 5.0), (3.0, 1.0), (1.0, 1e9)]),
    (averaged, [(0.05, 5.0, 3.0), (1.0, 5.0, 3.0), (12.0, 5.0, 3.0), (13.1, 5.0, 3.0), (70.0, 5.0, 3.0),
                (70.0, 5.0, 1e9), (400.0, 5.0, 3.0)]),
    (mrtd, [(0, 1.0, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.1, 2.5, 0.1, 30.0, 7.0, 2.0, 4.0),
            (1, 1.0, 0.05, 0.02, 0.01, 0.015, 0.007, 0.009, 0.1, 0.12, 2.8, 0.2, 60.0, 7.0, 2.0, 4.0),
            (0, 0.2, 0.05, 0.02, 0.01, 0.015, 0.007, 0.009, 0.1, 0.12, 2.8, 0.2, 60.0, 7.0, 2.0, 4.0),
            (0, 3.5, 0.05, 0.02, 0.01, 0.015, 0.007, 0.009, 0.1, 0.12, 2.8, 0.01, 60.0, 7.0, 2.0, 4.0)]),
    (ttp_axis, [(0, 34.26, 10.0, 10.0, 1.0, 1.0, 4.0, 0.2), (1, 34.26, 10.0, 10.0, 0.9, 1.5, 4.0, 0.2),
                (2, 34.26, 15.0, 5.0, 0.9, 1.5, 2.0, 0.05), (2, 100.0, 15.0, 20.0, 1.0, 1.0, 2.0, 2.0),
                (2, 34.26, 10.0, 1.0, 1.0, 1.0, 4.0, 0.003)]),
    (ttp_range, [(2, 34.26, 15.0, 10.0, 1.0, 1.0, 4.0, 3.1, 0.2, 0.0, 13.0, 0.5, 0),
                 (2, 34.26, 15.0, 10.0, 1.0, 1.0, 4.0, 3.1, 0.2, 0.2, 13.0, 0.7, 0),
                 (0, 34.26, 15.0, 10.0, 0.8, 1.4, 4.0, 0.75, 0.05, 1.5, 2.0, 0.9, 1)]),
    (ratio, [(0, 0.5), (0, 0.01), (0, 0.99), (1, 0.2), (2, 0.8), (2, 1e-6)]),
]


def main():
    parser = argparse.ArgumentParser(description="Writes performance.csv.")
    parser.add_argument("--folder", help="where to write; default: the folder of the tables")
    options = parser.parse_args()
    rows = []
    for function, cases in CASES:
        for case in cases:
            numbers = [int(x) if isinstance(x, int) else mpf(x) for x in case]
            result = function(*numbers)
            value, slope = result if isinstance(result, tuple) else (result, None)
            rows.append([function.__name__, "|".join(hex_of(x) for x in case), digits(value, 25),
                         "" if slope is None else digits(slope, 15)])
    write_table("performance.csv", ["quantity", "arguments_hex", "value", "slope"], rows, options.folder)


if __name__ == "__main__":
    main()
