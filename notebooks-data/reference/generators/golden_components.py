#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes golden_components.csv: the OTF of one case of each component, from the definitions alone, to 25 digits.

Focal length 100 mm, pitch 17 um, F/1, 4 um unless the settings say otherwise; fy = 0. Frequencies are the doubles
printed, everything else is the decimal written here. Needs mpmath.
"""

import argparse

import mpmath as mp

from tables import write_table

mp.mp.dps = 50
FREQUENCIES = [5.0, 10.0, 20.0, 29.41176470588235]  # cycles/mm; the last is 0.5 / 17 um
LONG = [20.0, 50.0, 100.0]  # 2000, 5000, 10000 cycles/rad
d = mp.mpf  # d("0.015"): the decimal itself


def clear_pupil(f):
    nu = f * d("0.02")
    return 2 / mp.pi * (mp.acos(nu) - nu * mp.sqrt(1 - nu * nu))


def sinc(x):
    return mp.sin(mp.pi * x) / (mp.pi * x)


def stages(f, n=32, slip=d("0.00034")):
    return mp.fsum(mp.exp(2j * mp.pi * f * slip * (k - d(n - 1) / 2)) for k in range(n)) / n


def diffusion(f, a=d("0.01"), w=d("0.003"), length=d("0.02")):
    def collected(l):
        return 1 - mp.exp(-w / a) / (1 + l / a)

    return collected(length / mp.sqrt(1 + (2 * mp.pi * length * f) ** 2)) / collected(length)


def crosstalk(f, side=d("0.03"), corner=d("0.005"), pitch=d("0.017")):
    x = mp.cos(2 * mp.pi * f * pitch)
    return 1 - 4 * side - 4 * corner + 2 * side * (x + 1) + 4 * corner * x


def turbulence(constant, alpha):
    def otf(f):  # lambda u = 4e-6 m x 1e5 f rad, in units of r0 = 50 mm and D = 100 mm
        v, w = f * d("0.4") / 50, f * d("0.4") / 100
        return mp.exp(-constant * v ** (d(5) / 3) * (1 - alpha * mp.cbrt(w)))

    return otf


EXACT = (d(24) / 5 * mp.gamma(d(6) / 5)) ** (d(5) / 6)
CASES = [
    ("diffraction", "f_number = 2; wavelength = 10 um", clear_pupil, FREQUENCIES),
    ("footprint", "width = 15 um", lambda f: sinc(d("0.015") * f), FREQUENCIES),
    ("jitter", "rms = 4 um", lambda f: mp.exp(-2 * (mp.pi * d("0.004") * f) ** 2), FREQUENCIES),
    ("linear_motion", "travel = 10 um", lambda f: sinc(d("0.01") * f), FREQUENCIES),
    ("vibration", "amplitude = 5 um", lambda f: mp.besselj(0, 2 * mp.pi * d("0.005") * f), FREQUENCIES),
    ("bolometer", "time_constant = 10 ms; velocity = 0.5 mm/s",
     lambda f: 1 / (1 - 2j * mp.pi * f * d("0.5") * d("0.01")), FREQUENCIES),
    ("butterworth", "cutoff = 25 cy/mm; poles = 3", lambda f: 1 / mp.sqrt(1 + (f / 25) ** 6), FREQUENCIES),
    ("rc_lowpass", "cutoff = 25 cy/mm", lambda f: 1 / (1 + 1j * f / 25), FREQUENCIES),
    ("charge_transfer", "inefficiency = 1e-5; transfers = 2000",
     lambda f: mp.exp(-d("0.02") * (1 - mp.exp(-2j * mp.pi * f * d("0.017")))), FREQUENCIES),
    ("crosstalk", "side = 0.03; corner = 0.005", crosstalk, FREQUENCIES),
    ("tdi", "stages = 32; slip = 0.34 um", stages, FREQUENCIES),
    ("diffusion", "absorption_length = 10 um; depletion_depth = 3 um; diffusion_length = 20 um",
     diffusion, FREQUENCIES),
    ("turbulence", "fried_parameter = 50 mm", turbulence(EXACT, 0), LONG),
    ("turbulence", "fried_parameter = 50 mm; constant = 3.44", turbulence(d("3.44"), 0), LONG),
    ("turbulence", "fried_parameter = 50 mm; exposure = short; alpha = 0.5", turbulence(EXACT, d("0.5")), LONG),
]


def main():
    parser = argparse.ArgumentParser(description="Writes golden_components.csv.")
    parser.add_argument("--folder", help="where to write; default: the folder of the tables")
    rows = []
    for kind, settings, otf, frequencies in CASES:
        for f in frequencies:
            h = mp.mpc(otf(d(f)))
            rows.append([kind, settings, repr(f), mp.nstr(h.real, 25), mp.nstr(mp.chop(h.imag, 1e-40), 25)])
    write_table("golden_components.csv", ["kind", "settings", "f_cy_mm", "re", "im"], rows, parser.parse_args().folder)


if __name__ == "__main__":
    main()
