#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""defocus_circular.csv and defocus_annular.csv: OTF of clear and annular pupils with defocus, at exact doubles.

Pupil radius 1, wavefront W020 rho^2 in waves, copies of the pupil at x = -nu and +nu: over the overlap the phase is
8 pi W020 nu x =: k x, so
    OTF = 1/(pi (1 - e^2)) int cos(k x) L(x) dx,  L = length of the overlap's chord at x.
The overlap is lens(1,1) - 2 lens(1,e) + lens(e,e); a lens of two circles is bounded by two arcs. On the arc
x = c + R cos t its half is the integral of 2 R^2 sin^2 t cos(k (c + R cos t)) over t, an entire integrand.
Derivatives: under the integral for k; a circle that moves by dc or grows by dR adds cos(k x) (cos t dc + dR) R dt
along its arc. `check()` holds samples against other formulas and differences.
"""

import argparse

from mpmath import mp, mpf

from tables import digits, hex_of, integrate, write_table

mp.dps = 60


def half_lens(c, radius, angle, k):
    """Of the circle segment |t| <= angle: integrals of cos(k x) and -x sin(k x) over its area, and of cos(k x) cos t
    and cos(k x) over its arc (with t, not length). A negative radius takes the left segment, x = c - |R| cos t."""
    if angle == 0:
        return [mpf(0)] * 4

    def at(t):
        cos_t, sin_t = mp.cos_sin(t)
        x = c + radius * cos_t
        cos_kx, sin_kx = mp.cos_sin(k * x)
        area = 2 * (radius * sin_t) ** 2
        return area * cos_kx, -area * x * sin_kx, 2 * cos_kx * cos_t, 2 * cos_kx

    return integrate(at, mpf(0), angle, abs(k * radius) * (1 - mp.cos(angle)) + angle)


def angle_between(adjacent, radius, product):
    """acos(adjacent/radius) from the half chord's square as an exact product, right to all digits near 0."""
    return mp.atan2(mp.sqrt(product), adjacent) if product > 0 else (mpf(0) if adjacent > 0 else mp.pi)


def overlap(nu, e, w020):
    """Integral of cos(k x) over the overlap, with derivatives by nu, k/(8 pi nu) at fixed region, e."""
    k, k_nu, k_w = 8 * mp.pi * w020 * nu, 8 * mp.pi * w020, 8 * mp.pi * nu
    value = d_nu = d_e = d_w = mpf(0)

    def add(factor, segment, velocity, radius, is_hole):
        nonlocal value, d_nu, d_e, d_w
        area, moment, arc_cos, arc = segment
        value += factor * area
        d_nu += factor * (moment * k_nu + arc_cos * velocity * abs(radius))
        d_w += factor * moment * k_w
        if is_hole:
            d_e += factor * arc * abs(radius)

    # Two outer circles: the right half is bounded by the circle at -nu, which moves by -1; the left half mirrors it.
    add(2, half_lens(-nu, mpf(1), angle_between(nu, 1, (1 - nu) * (1 + nu)), k), -1, mpf(1), False)
    if e > 0:
        if nu < e:
            add(2, half_lens(-nu, e, angle_between(nu, e, (e - nu) * (e + nu)), k), -1, e, True)
        gap = 1 - e
        if 2 * nu <= gap:
            add(-2, half_lens(nu, e, mp.pi, k), 1, e, True)
        elif 2 * nu < 1 + e:
            chord = (1 + e - 2 * nu) * (1 + e + 2 * nu) * (2 * nu - gap) * (2 * nu + gap) / (4 * nu) ** 2
            from_outer = nu + (1 - e) * (1 + e) / (4 * nu)
            from_hole = nu - (1 - e) * (1 + e) / (4 * nu)
            add(-2, half_lens(-nu, mpf(1), angle_between(from_outer, 1, chord), k), -1, mpf(1), False)
            left = half_lens(nu, -e, angle_between(from_hole, e, chord), k)
            left[2] = -left[2]  # the outward normal points to -x
            add(-2, left, 1, e, True)
    return value, d_nu, d_e, d_w


def defocus_otf(nu, e, w020):
    """OTF and its derivatives by nu, e, W020."""
    nu, e, w020 = mpf(nu), mpf(e), mpf(w020)
    area = mp.pi * (1 - e) * (1 + e)
    value, d_nu, d_e, d_w = (v / area for v in overlap(nu, e, w020))
    return value, d_nu, d_e + 2 * mp.pi * e * value / area, d_w


def check():
    """Other formulas: Hopkins' integral by adaptive quadrature, the chord length row by row, differences."""
    def hopkins(nu, w020):
        return 4 / mp.pi * mp.quad(lambda x: mp.sqrt(1 - x * x) * mp.cos(8 * mp.pi * w020 * nu * (x - nu)), [nu, 1])

    def chord(x, nu, e):
        def pieces(centre):
            outer, inner = 1 - (x - centre) ** 2, e * e - (x - centre) ** 2
            return mp.sqrt(max(outer, 0)), mp.sqrt(max(inner, 0))
        (o1, i1), (o2, i2) = pieces(-nu), pieces(nu)
        return 2 * max(min(o1, o2) - max(i1, i2), 0)

    def rows(nu, e, w020):
        cuts = {mpf(0), 1 - nu, e - nu, nu - e, nu + e, abs((1 - e) * (1 + e) / (4 * nu))}
        cuts = sorted(c for c in cuts if 0 <= c <= 1 - nu)
        # x = end +- step^2 at both ends of every interval: the square roots become smooth.
        f = lambda x: chord(x, nu, e) * mp.cos(8 * mp.pi * w020 * nu * x)
        total = mpf(0)
        for lo, hi in zip(cuts, cuts[1:]):
            half = (hi - lo) / 2
            total += mp.quad(lambda t: f((lo + hi) / 2 - half * mp.cos(t)) * half * mp.sin(t), mp.linspace(0, mp.pi, 9))
        return 2 * total / (mp.pi * (1 - e) * (1 + e))

    def near(a, b, tolerance):
        if abs(a - b) > tolerance:
            raise ArithmeticError(f"two routes differ: {a} {b}")

    with mp.workdps(30):
        for nu, w020 in [("0.2", 1), ("0.5", "0.5"), ("0.9", 5), ("0.01", 20)]:
            near(defocus_otf(nu, 0, w020)[0], hopkins(mpf(nu), mpf(w020)), mpf(10) ** -20)
        for nu, e, w020 in [("0.1", "0.3", 1), ("0.4", "0.3", 2), ("0.6", "0.5", 1), ("0.3", "0.5", 3),
                            ("0.7", "0.3", 2), ("0.85", "0.9", 1), ("0.5", "0.9", 1)]:
            near(defocus_otf(nu, e, w020)[0], rows(mpf(nu), mpf(e), mpf(w020)), mpf(10) ** -15)
    h = mpf(10) ** -20
    for nu, e, w020 in [("0.1", "0.3", 1), ("0.4", "0.3", 2), ("0.3", "0.5", 3), ("0.85", "0.9", 1), ("0.25", 0, 7)]:
        nu, e, w020 = mpf(nu), mpf(e), mpf(w020)
        value, d_nu, d_e, d_w = defocus_otf(nu, e, w020)
        difference = lambda f: (f(h) - f(-h)) / (2 * h)
        near(d_nu, difference(lambda d: defocus_otf(nu + d, e, w020)[0]), mpf(10) ** -30)
        near(d_w, difference(lambda d: defocus_otf(nu, e, w020 + d)[0]), mpf(10) ** -30)
        if e:
            near(d_e, difference(lambda d: defocus_otf(nu, e + d, w020)[0]), mpf(10) ** -30)


def frequencies(lines):
    """nu as doubles: both ends, and a grid that is not a multiple of anything in the integrand."""
    ends = [mpf(10) ** -n for n in (12, 9, 6, 5, 4, 3)]
    inner = [mpf(2 * i + 1) / (2 * lines) for i in range(lines)]
    return sorted({float(x) for x in ends + [1 - x for x in ends] + inner + [mpf(1) / 100, mpf(1) / 2]})


def circular(folder):
    rows = []
    for w in ["1e-6", "1e-4", "1e-3", "0.01", "0.05", "0.1", "0.25", "0.5", "0.75", "1", "1.5", "2", "2.5", "3", "4",
              "5", "7", "10", "15", "20", "30", "40", "50"]:
        w020 = float(w)
        for nu in frequencies(24 if w020 < 0.05 else 48 if w020 <= 5 else 96):
            value, d_nu, _, d_w = defocus_otf(nu, 0, w020)
            rows.append([hex_of(w020), hex_of(nu), digits(value), digits(d_nu), digits(d_w)])
    write_table("defocus_circular.csv", ["w020_hex", "nu_hex", "otf", "d_nu", "d_w020"], rows, folder)


def annular(folder):
    rows = []
    for e in (0.1, 0.3, 0.5, 0.9, 0.999):
        kinks = [e, (1 - e) / 2, (1 + e) / 2]
        sides = [nu for kink in kinks for nu in (kink, kink * (1 - 1e-6), kink * (1 + 1e-6)) if 0 < nu < 1]
        for w in ("1e-6", "1e-3", "0.05", "0.25", "0.5", "1", "2", "3", "5", "7", "10"):
            w020 = float(w)
            for nu in sorted({*sides, *frequencies(24)}):
                otf = [digits(v) for v in defocus_otf(nu, e, w020)]
                rows.append([hex_of(e), hex_of(w020), hex_of(nu)] + otf)
    header = ["obscuration_hex", "w020_hex", "nu_hex", "otf", "d_nu", "d_obscuration", "d_w020"]
    write_table("defocus_annular.csv", header, rows, folder)


def main():
    parser = argparse.ArgumentParser(description="Writes defocus_circular.csv and defocus_annular.csv.")
    parser.add_argument("--folder", help="where to write; default: the folder of the tables")
    parser.add_argument("tables", nargs="*", default=[], help="circular, annular; default: both")
    options = parser.parse_args()
    check()
    for name in options.tables or ["circular", "annular"]:
        {"circular": circular, "annular": annular}[name](options.folder)


if __name__ == "__main__":
    main()
