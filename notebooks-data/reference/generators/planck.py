#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""planck.csv, planck_bands.csv: radiance of blackbodies, its derivative by the temperature and its logarithm.

Constants of CODATA 2018. Bands from Bp(x) = integral from x to infinity of t^p/(e^t - 1) dt, below x = 2 by the Taylor
series of the integrand (Bernoulli numbers), above by the exponential series; samples are first held against quadrature
of Planck's law over the wavelength. A radiance below 1e-400 is written as 0.
"""

import argparse
import math

from mpmath import mp, mpf

from tables import digits, hex_of, write_table

mp.dps = 90
GOLDEN = (math.sqrt(5) - 1) / 2
H, C, K = mpf("6.62607015e-34"), mpf(299792458), mpf("1.380649e-23")
MICRON = mpf(10) ** -6


def exponent(wavelength_um, temperature_k):
    return H * C / (K * mpf(wavelength_um) * MICRON * mpf(temperature_k))


def planck(flux, wavelength_um, temperature_k):
    """Spectral radiance per um, its derivative by T, its logarithm."""
    x, m = exponent(wavelength_um, temperature_k), mpf(wavelength_um) * MICRON
    factor = 2 * H * C**2 / m**5 if flux == "watts" else 2 * C / m**4
    radiance = factor * MICRON / mp.expm1(x)
    return radiance, radiance * x / temperature_k / -mp.expm1(-x), mp.log(radiance)


def tail(p, x):
    """Bp(x)."""
    if x >= 2:
        total, n = mpf(0), 0
        while True:
            n += 1
            term = mp.exp(-n * x) * sum(mp.factorial(p) / mp.factorial(p - j) * x ** (p - j) / mpf(n) ** (j + 1)
                                        for j in range(p + 1))
            total += term
            if term < total * mpf(10) ** (-mp.dps - 2):
                return total
    total = mpf(0)
    for j in range(0, 400):
        if j == 1 or j % 2 == 0:
            total += mp.bernoulli(j) * x ** (j + p) / (mp.factorial(j) * (j + p))
    return mp.gamma(p + 1) * mp.zeta(p + 1) - total


def band(flux, lo_um, hi_um, temperature_k):
    """Radiance in the band, its derivative by T, its logarithm."""
    p, t = (3 if flux == "watts" else 2), mpf(temperature_k)
    factor = 2 * K**4 / (H**3 * C**2) if flux == "watts" else 2 * K**3 / (H**3 * C**2)
    x1, x2 = exponent(lo_um, t), exponent(hi_um, t)
    # The difference of two tails cancels for narrow bands, more than the digits kept where x is small.
    with mp.extradps(60):
        integral = tail(p, x2) - tail(p, x1)
        ends = x2 ** (p + 1) / mp.expm1(x2) - x1 ** (p + 1) / mp.expm1(x1)
        slope = (p + 1) * integral + ends
    return factor * t ** (p + 1) * integral, factor * t**p * slope, mp.log(factor * t ** (p + 1) * integral)


def verify():
    for flux in ("watts", "photons"):
        for lo, hi, t in ((3.0, 5.0, 300.0), (8.0, 8.01, 77.0), (0.4, 20.0, 6000.0), (10.0, 1e4, 2.7), (1.0, 3.0, 1e6)):
            value, slope, _ = band(flux, lo, hi, t)
            edges = [mpf(lo) * (mpf(hi) / lo) ** (mpf(i) / 24) for i in range(25)]
            with mp.workdps(30):
                by_value = mp.quad(lambda w: planck(flux, w, t)[0], edges)
                by_slope = mp.quad(lambda w: planck(flux, w, t)[1], edges)
            assert abs(by_value / value - 1) < mpf(10) ** -20 and abs(by_slope / slope - 1) < mpf(10) ** -20, (lo, hi, t)


def row_of(flux, arguments, values):
    numbers = ["0" if i < 2 and v < mpf(10) ** -400 else digits(v, 50) for i, v in enumerate(values)]
    return [flux] + [hex_of(a) for a in arguments] + numbers


def spread(k, multiplier, lo, hi):
    """The k-th of doubles evenly spread over the decades from lo to hi."""
    return float(mpf(lo) * (mpf(hi) / lo) ** mpf((k * multiplier) % 1))


def main():
    parser = argparse.ArgumentParser(description="Writes planck.csv and planck_bands.csv.")
    parser.add_argument("--folder", help="where to write; default: the folder of the tables")
    folder = parser.parse_args().folder
    verify()

    corners = [(w, t) for w in (0.1, 1.0, 10.0, 1e6) for t in (1.0, 77.0, 300.0, 6000.0, 1e9)]
    points = corners + [(spread(k, GOLDEN, 0.1, 1e6), spread(k, math.sqrt(2), 1, 1e9)) for k in range(1, 161)]
    # Along x = 0.1 ... 1500: the doubles where e^x leaves the range of a double among them.
    for i, x in enumerate((0.1, 0.5, 0.69, 0.7, 1, 3, 20, 36.7, 37, 80, 300, 599, 601, 690, 708, 709.7, 720, 745, 800, 1500)):
        w = spread(i, GOLDEN, 0.1, 100)
        points.append((w, float(H * C / K / MICRON / (w * mpf(x)))))
    rows = [row_of(flux, p, planck(flux, *p)) for flux in ("watts", "photons") for p in points]
    write_table("planck.csv", ["flux", "wavelength_um_hex", "temperature_k_hex", "radiance", "derivative", "log_radiance"],
                rows, folder)

    bands = [(lo, hi, t) for lo, hi in ((3.0, 5.0), (8.0, 12.0), (7.5, 13.5), (0.1, 1e6), (10.0, 10.001))
             for t in (1.0, 4.2, 30.0, 77.0, 300.0, 1000.0, 6000.0, 1e9)]
    for k in range(1, 121):
        lo = spread(k, GOLDEN, 0.1, 1e5)
        hi = lo * (1 + spread(k, math.sqrt(2), 1e-9, 9))
        bands.append((lo, hi, spread(k, math.sqrt(3), 1, 1e9)))
    rows = [row_of(flux, b, band(flux, *b)) for flux in ("watts", "photons") for b in bands]
    write_table("planck_bands.csv",
                ["flux", "lo_um_hex", "hi_um_hex", "temperature_k_hex", "radiance", "derivative", "log_radiance"],
                rows, folder)


if __name__ == "__main__":
    main()
