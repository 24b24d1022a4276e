#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""elementary.csv, kolmogorov.csv: the scalar functions below the components with their slopes, at exact doubles.

sinc: sin(pi x)/(pi x); gaussian: exp(-2 pi^2 x^2); j0: J0(x); jinc: 2 J1(x)/x. kolmogorov.csv: the exponent of the
turbulence OTF, v^(5/3) [1 - alpha min(w, 1)^(1/3)], and exp(-c exponent), c = (24/5 Gamma(6/5))^(5/6).
"""

import argparse
import math

from mpmath import mp, mpf

from tables import digits, hex_of, neighbours, write_table

mp.dps = 60
GOLDEN = (math.sqrt(5) - 1) / 2  # multiples of it, modulo 1, spread evenly and meet nothing


def decades(lo, hi, count):
    """`count` doubles between 10^lo and 10^hi, evenly over the decades."""
    return [float(mpf(10) ** (lo + (hi - lo) * ((k * GOLDEN) % 1))) for k in range(1, count + 1)]


def sinc(x):
    if x == 0:
        return mpf(1), mpf(0)
    value = mp.sinpi(x) / (mp.pi * x)
    with mp.extradps(40):  # cos - sinc cancels like x^2
        return value, (mp.cospi(x) - mp.sinpi(x) / (mp.pi * x)) / x


def gaussian(x):
    value = mp.exp(-2 * mp.pi**2 * x**2)
    return value, -4 * mp.pi**2 * x * value


def j0(x):
    return mp.besselj(0, x), -mp.besselj(1, x)


def jinc(x):
    return (2 * mp.besselj(1, x) / x, -2 * mp.besselj(2, x) / x) if x else (mpf(1), mpf(0))


def zeros(order):
    """Doubles next to zeros of J0 or J1, from the first to beyond 1e8."""
    for n in (1, 2, 3, 5, 10, 100, 10**4, 10**6, 3 * 10**7):
        start = (n + mpf(order) / 2 - mpf(1) / 4) * mp.pi
        start -= (4 * order**2 - 1) / (8 * start)
        yield from neighbours(mp.findroot(lambda x: mp.besselj(order, x), start))


def elementary(folder):
    whole = [x for n in (1, 2, 3, 10, 1001, 10**6, 10**8) for x in neighbours(n)]
    points = {
        sinc: [0.0, 5e-324, *neighbours(0.05), *whole, *decades(-12, 0, 80), *decades(0, 8, 160)],
        gaussian: [0.0, 5e-324, *decades(-9, 0, 120), *(6.3 * ((k * GOLDEN) % 1) for k in range(1, 120))],
        j0: [0.0, 5e-324, *zeros(0), *zeros(1), *decades(-8, 0, 40), *decades(0, 8, 300)],
        jinc: [0.0, 5e-324, *neighbours(0.1), *zeros(1), *decades(-8, 0, 60), *decades(0, 8, 200)],
    }
    rows = [[f.__name__, hex_of(x)] + [digits(v) for v in f(mpf(x))]
            for f, xs in points.items() for x in sorted(set(xs))]
    write_table("elementary.csv", ["function", "x_hex", "value", "slope"], rows, folder)


def kolmogorov(folder):
    c = (mpf(24) / 5 * mp.gamma(mpf(6) / 5)) ** (mpf(5) / 6)
    rows = []
    for alpha in (0.0, 0.3, 0.5, 1.0):
        for k in range(1, 151):
            v = float(mpf(10) ** (-6 + mpf("7.4") * ((k * GOLDEN) % 1)))
            nearly = 1 - float(mpf(10) ** (-(k % 15)))
            for w in {0.0} if alpha == 0 else {float(mpf(10) ** (-7 + 8 * ((k * k * GOLDEN) % 1))), nearly}:
                exponent = mpf(v) ** (mpf(5) / 3) * (1 - mpf(alpha) * mp.cbrt(min(mpf(w), 1)))
                rows.append([hex_of(v), hex_of(w), hex_of(alpha), digits(exponent), digits(mp.exp(-c * exponent))])
    write_table("kolmogorov.csv", ["v_hex", "w_hex", "alpha_hex", "exponent", "otf"], sorted(rows), folder)


def main():
    parser = argparse.ArgumentParser(description="Writes elementary.csv and kolmogorov.csv.")
    parser.add_argument("--folder", help="where to write; default: the folder of the tables")
    options = parser.parse_args()
    elementary(options.folder)
    kolmogorov(options.folder)


if __name__ == "__main__":
    main()
