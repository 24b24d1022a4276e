#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""fresnel_integrals.csv: C(u) and S(u). accelerated_motion.csv: the mean of exp(-2 pi i (d s + b s^2)) over
s = -1/2 ... 1/2 and its slopes, by adaptive quadrature. Needs mpmath."""

import argparse
import math
import random

from mpmath import exp, fresnelc, fresnels, linspace, mp, mpc, mpf, nstr, pi, quad

from tables import hex_of, write_table

mp.dps = 50


def text(x):
    return nstr(x, 30, strip_zeros=False)


def integrals(folder):
    edge = 1.5
    arguments = [0.0, 5e-324, 1e-300, 1e-8, 0.1, 0.3, 0.5, 0.75, 1.0, 1.25, math.nextafter(edge, 0), edge,
                 math.nextafter(edge, 2), 1.6, 2.0, 2.5, 3.0, 4.0, 5.5, 8.0, 12.3, 40.0, 100.7, 1e3, 12345.678, 1e6,
                 3.3e7, 1e8, 1e10, 1e15]
    rows = []
    for u in arguments:
        mp.dps = 50 + 2 * max(0, int(math.log10(u or 1)))
        rows.append([hex_of(u), text(fresnelc(mpf(u))), text(fresnels(mpf(u)))])
    write_table("fresnel_integrals.csv", ["u_hex", "c", "s"], rows, folder)


def moments(d, b):
    """Integrals over s = -1/2 ... 1/2 of s^k exp(-2 pi i (d s + b s^2)), k = 0, 1, 2."""
    d, b = mpf(d), mpf(b)
    turns = int(abs(d) + abs(b)) + 1
    points = linspace(mpf(-1) / 2, mpf(1) / 2, turns + 1)
    return [quad(lambda s: s**k * exp(-2j * pi * (d * s + b * s * s)), points) for k in range(3)]


def motion(folder):
    mp.dps = 30
    random.seed(1)
    cases = [(0.0, 0.0), (0.0, 0.3), (0.7, 0.0), (1e-300, 1e-300), (1e-9, 1e-9), (4.0, 1e-12), (3.999, 3.999),
             (4.001, 1e-3), (4.001, 3.999), (3.999, 4.001), (0.0, 4.001), (0.0, 30.0), (5.0, 5.0), (5.0, 5.0000001),
             (5.0000001, 5.0), (60.0, 59.0), (59.0, 60.0), (200.0, 1e-9), (200.3, 0.4), (7.5, -2.0), (-7.5, 2.0),
             (-2.5, -40.25)]
    cases += [(10 ** random.uniform(-2, 2), 10 ** random.uniform(-2, 2)) for _ in range(40)]
    rows = []
    for d, b in cases:
        h, first, second = moments(d, b)
        parts = [part for z in (h, -2j * pi * first, -2j * pi * second) for part in (mpc(z).real, mpc(z).imag)]
        rows.append([hex_of(d), hex_of(b)] + [text(part) for part in parts])
    header = ["d_hex", "b_hex", "re", "im", "re_by_d", "im_by_d", "re_by_b", "im_by_b"]
    write_table("accelerated_motion.csv", header, rows, folder)


def main():
    parser = argparse.ArgumentParser(description="Writes fresnel_integrals.csv and accelerated_motion.csv.")
    parser.add_argument("--folder", help="where to write; default: the folder of the tables")
    options = parser.parse_args()
    integrals(options.folder)
    motion(options.folder)


if __name__ == "__main__":
    main()
