#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""annular_diffraction_mtf.csv: MTF of clear and annular pupils and its derivatives, at exact doubles.

With A(R, r) the overlap area of circles of radius R, r whose centres are d = 2 nu apart,
    M = [A(1,1) - 2 A(1,e) + A(e,e)] / (pi (1 - e^2)).
Derivatives: an overlap loses its common chord with d; it grows with a radius by the arc inside the other circle.
At nu = 0, the tip of M, d_nu is the one-sided slope towards nu > 0.
"""

import argparse
import math

from mpmath import mp, mpf

import defocus
from tables import digits, hex_of, neighbours, write_table

DIGITS = 120  # areas near the cutoff are differences of angles that agree to 30 digits


def overlap(big, small, d):
    """Overlap area, the common chord, and the arcs of the big and the small circle inside the other."""
    if d >= big + small:
        return mpf(0), mpf(0), mpf(0), mpf(0)
    if d <= big - small and big > small:
        return mp.pi * small**2, mpf(0), mpf(0), 2 * mp.pi * small
    to_chord = d / 2 if big == small else (d * d + (big - small) * (big + small)) / (2 * d)
    half = mp.sqrt((big - to_chord) * (big + to_chord))
    alpha, beta = mp.atan2(half, to_chord), mp.atan2(half, d - to_chord)
    return big**2 * alpha + small**2 * beta - d * half, 2 * half, 2 * big * alpha, 2 * small * beta


def annular_mtf(nu, e):
    """M, dM/dnu, dM/de."""
    with mp.workdps(DIGITS):
        nu, e = mpf(nu), mpf(e)
        ring = mp.pi * (1 - e) * (1 + e)
        outer = overlap(mpf(1), mpf(1), 2 * nu)
        if e == 0:
            return outer[0] / ring, -2 * outer[1] / ring, mpf(0)
        mixed, inner = overlap(mpf(1), e, 2 * nu), overlap(e, e, 2 * nu)
        value = (outer[0] - 2 * mixed[0] + inner[0]) / ring
        d_nu = -2 * (outer[1] - 2 * mixed[1] + inner[1]) / ring
        arcs = -2 * mixed[3] + inner[2] + inner[3]
        return value, d_nu, (arcs + 2 * mp.pi * e * value) / ring


def check():
    """Against the chord integral of the defocused pupil in focus, and against differences."""
    h = mpf(10) ** -30
    for nu, e in [("0.1", "0.3"), ("0.4", "0.3"), ("0.36", "0.3"), ("0.8", "0.3"), ("0.3", "0.5"), ("0.93", "0.9"),
                  ("0.5", 0)]:
        nu, e = mpf(nu), mpf(e)
        value, d_nu, d_e = annular_mtf(nu, e)
        focus = defocus.defocus_otf(nu, e, 0)
        differences = [(annular_mtf(nu + h, e)[0] - annular_mtf(nu - h, e)[0]) / (2 * h),
                       (annular_mtf(nu, e + h)[0] - annular_mtf(nu, e - h)[0]) / (2 * h) if e else mpf(0)]
        pairs = [(value, focus[0]), (d_nu, focus[1]), (d_e, focus[2]), (d_nu, differences[0]), (d_e, differences[1])]
        if any(abs(a - b) > mpf(10) ** -27 for a, b in pairs):
            raise ArithmeticError(f"two routes differ at nu = {nu}, e = {e}: {pairs}")


def grid_points_of_others(e):
    """The doubles around nu = (1 - e)/2 that a grid of 1501 frequencies over +-D/lambda reaches: there a comparison
    with the touching point falls on either side by rounding alone."""
    k = (1 - e) / 2 * 750
    if abs(k - round(k)) > 1e-9:
        return set()
    found = set()
    for aperture_m in (0.1, 0.25, 0.273, 0.275, 0.3, 0.5, 1.0, 2.4):
        for wavelength_m in (0.5e-6, 0.55e-6, 0.58e-6, 0.6e-6, 0.75e-6, 4e-6, 10e-6):
            cutoff = aperture_m / wavelength_m
            found.add((-cutoff + (750 + round(k)) * (2 * cutoff / 1500)) / cutoff)
            found.add(round(k) / 750 * cutoff * wavelength_m / aperture_m)
    return found


def frequencies(e):
    points = {5e-324, 1e-300, 1e-100, 1e-30, 1e-16, 1e-12, 1e-8, 1e-6, 1e-4, 1e-3, 0.0, 1.0}
    points |= {(2 * i + 1) / 80 for i in range(40)} | {math.sqrt(i / 23) for i in range(1, 23)}
    points |= {float(1 - mpf(m) * mpf(10) ** -n) for n in range(1, 16) for m in (1, 3)} | {1 - 2.0**-53}
    for kink in (mpf(e), (1 - mpf(e)) / 2, (1 + mpf(e)) / 2):
        points |= set(neighbours(kink))
        points |= {float(kink * (1 + s * mpf(10) ** -n)) for s in (-1, 1) for n in (14, 12, 9, 6, 3)}
    points |= grid_points_of_others(e)
    return sorted(p for p in points if 0 <= p <= 1)


def main():
    parser = argparse.ArgumentParser(description="Writes annular_diffraction_mtf.csv.")
    parser.add_argument("--folder", help="where to write; default: the folder of the tables")
    options = parser.parse_args()
    check()
    rows = []
    for e in (0, 1e-6, 1e-3, 0.01, 0.05, 0.1, 0.2, 0.3, 1 / 3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 0.999):
        for nu in frequencies(e):
            rows.append([hex_of(e), hex_of(nu)] + [digits(v) for v in annular_mtf(nu, e)])
    write_table("annular_diffraction_mtf.csv", ["obscuration_hex", "nu_hex", "mtf", "d_nu", "d_obscuration"], rows,
                options.folder)


if __name__ == "__main__":
    main()
