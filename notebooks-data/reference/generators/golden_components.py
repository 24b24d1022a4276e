#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes golden_components.csv: the OTF of one case of each component, from the definitions alone, to 25 digits.

Focal length 100 mm, pitch 17 um, F/1, 4 um unless the settings say otherwise; fy = 0. Frequencies are the doubles
printed, everything else is the decimal written here; whole numbers without a unit are counts. Cases without a formula
here take that of gradient_kinds*.py, where lengths keep their unit and all else is in the unit of its field.
Needs mpmath.
"""

import argparse
import re

import mpmath as mp

from gradients import KINDS, Point
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

SURROUNDINGS = {"frame.focal_length": 100, "frame.pitch_x": 17, "frame.pitch_y": 17, "frame.integration_time": "0.01",
                "optics.f_number": 1, "optics.wavelength": 4}
BY_DEFINITION = [
    ("gaussian", "sigma = 3 um"),
    ("rms_wavefront", "rms = 0.07; f_number = 2.0; wavelength = 10 um"),
    ("random_wavefront", "rms = 0.1; correlation = 0.2"),
    ("random_wavefront", "rms = 0.1; wavelength_reference = 3.39 um; correlation_length = 8 mm"),
    ("aerosol", "scattering = 0.1; path_length = 5 km"),
    ("aerosol", "scattering = 0.1; path_length = 5 km; mode = blur; cutoff = 2 cy/mrad"),
    ("birefringent_filter", "separation = 8.5 um"),
    ("halo", "fraction = 0.05; width = 30 um"),
    ("halo", "fraction = 0.05; width = 30 um; profile = exponential"),
    ("halo", "fraction = 0.05; width = 30 um; profile = lorentz"),
    ("psf", "samples = 0.02|0.1|0.03/0.1|0.5|0.12/0.01|0.1|0.02; step = 2 um"),
    ("circular_footprint", "diameter = 15 um"),
    ("polygon_footprint",
     "vertices = -0.5|-0.5/0.5|-0.5/0.5|0.1/0.1|0.1/0.1|0.5/-0.5|0.5; unit_length = 15 um"),
    ("binning", "columns = 2; rows = 2"),
    ("binning", "columns = 4; rows = 1; spacing = 4 um"),
    ("accelerated_motion", "velocity = 1200 um/s; acceleration = 60000 um/s^2"),
    ("accelerated_motion", "rate = 50000 urad/s; angular_acceleration = -2400000 urad/s^2"),
    ("vibration", "amplitude = 5 um; average = fixed_phase; cycles = 0.4; phase = 30 deg"),
    ("vibration", "amplitude = 12 um; average = fixed_phase; period = 0.008 s"),
    ("vibration", "amplitude = 5 um; average = rms; cycles = 0.4"),
    ("rc_lowpass", "cutoff = 400 kHz; pixel_clock = 1000000 Hz"),
    ("butterworth", "cutoff = 400 kHz; scan_velocity = 10000000 um/s; poles = 3"),
    ("rc_highpass", "cutoff = 2 cy/mm"),
    ("rc_highpass", "cutoff = 20 kHz; scan_rate = 100000000 urad/s; dc = remove"),
    ("boost", "gain = 2.0; peak = 0.5 cy/px"),
    ("sample_and_hold", "width = 1 px"),
    ("fir", "taps = 0.0|-0.25|0.0/-0.25|2.0|-0.25/0.0|-0.25|0.0"),
    ("fir", "taps = 0.1|0.5|0.7"),
    ("unsharp", "amount = 1.5; size = 3"),
    ("unsharp", "amount = 0.7; sigma = 1.2 px"),
    ("interpolation", "kernel = nearest"),
    ("interpolation", "kernel = linear"),
    ("interpolation", "kernel = cubic; a = -0.5"),
    ("interpolation", "kernel = bspline"),
    ("interpolation", "kernel = six_coefficient"),
    ("display_crt", "sigma = 0.5 px"),
    ("display_flat_panel", "width = 0.9 px"),
    ("display_flat_panel", "lcd_pitch = 1 px"),
    ("eye", "model = mtf; magnification = 10.0; luminance = 34 cd/m^2; eyes = 2"),
    ("eye", "model = barten_2003; magnification = 10.0; luminance = 34 cd/m^2; field = 10 deg"),
    ("eye", "model = barten_short; magnification = 5.0; luminance = 100 cd/m^2; field = 20 deg"),
    ("eye", "model = barten_short_squared; magnification = 5.0; luminance = 1 cd/m^2; field = 10 deg"),
    ("curve", "file = 10:0.9|20:0.7|40:0.25|60:0.1 cy/mm"),
    ("curve", "file = 0:1|0.1875:0.75|0.5:0.75|1:-0.125 cy/px; axis = x"),
    ("turbulence", "cn2 = 1e-14; path_length = 4000 m"),
    ("turbulence", "cn2 = 3e-15; path_length = 9000 m; wave = plane; exposure = short; alpha = 0.5"),
    ("turbulence", "profile = hufnagel_valley; wind = 21.0; ground_cn2 = 1.7e-14; target_altitude = 2000 m; "
                   "sensor_altitude = 20 m; path_length = 4000 m"),
    ("turbulence", "profile = hufnagel_valley; wind = 21.0; ground_cn2 = 1.7e-14; target_altitude = 20000 m; "
                   "sensor_altitude = 0 m; zenith_angle = 10 deg; wave = plane"),
]


def point(settings, f):
    """The numbers of a case, decimals taken exactly."""
    p = Point({}, (0, 0))
    p.values = {**{name: d(value) for name, value in SURROUNDINGS.items()}, "fx": d(f), "fy": d(0)}
    for name, text in (setting.split(" = ") for setting in settings.split("; ")):
        number, _, unit = text.partition(" ")
        if ":" in text:
            p.words[name] = text
        elif "|" in text:
            rows = [row.split("|") for row in text.split("/")]
            p.values.update((f"{name}[{i}]", d(tap)) for i, tap in enumerate(tap for row in rows for tap in row))
            p.words[name] = (len(rows), len(rows[0]))
        elif not unit and re.fullmatch("[0-9]+", number):
            p.words[name] = int(number)
        elif re.match("-?[0-9]", number):
            p.values[name], p.units[name] = d(number), unit
        else:
            p.words[name] = text
    return p


def by_definition(kind, settings):
    return lambda f: KINDS[kind].otf(point(settings, f))


CASES += [(kind, settings, by_definition(kind, settings), FREQUENCIES) for kind, settings in BY_DEFINITION]


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
