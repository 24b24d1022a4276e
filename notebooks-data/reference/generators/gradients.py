#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""gradients.csv: OTF of every kind of component and its derivatives by each scalar and by the frequency.

The formulas are in gradient_kinds*.py, written from their definitions, not from the C++ code. A derivative is the
difference quotient with a step of 1e-60 at 150 digits (`wavefront`, a double integral: 1e-24 at 60), from both sides:
where they agree it exists (`both`), otherwise the row states which one is meant (`left`, `right`, or `mean`, which
leaves 0 of the tip of an even OTF).
`*_rounding`: what moves when fx and fy move by 4 x 2^-53 of themselves, the conditioning of nu = f lambda N and of
every other product of a frequency and a length. `d_largest`: the largest |derivative| over frequencies to 60 cycles/mm.
"""

import argparse
from itertools import product

from mpmath import mp, mpf

import gradient_kinds_motion  # noqa: F401  registers its kinds
import gradient_kinds_path  # noqa: F401
from gradient_kinds import KINDS
from tables import digits, hex_of, write_table

mp.dps = 150
ROUNDING = mpf(2) ** -51
SCAN = [(u * x, u * y) for u in (1.3 + 4.9 * i for i in range(13)) for x, y in ((1, 0), (0, 1), (0.83, 0.56))]


class Point:
    """The numbers of one case: settings and surroundings by name, fx and fy among them."""

    def __init__(self, settings, frequency):
        self.values, self.units, self.words = {}, {}, {}
        for name, setting in settings.items():
            if isinstance(setting, (str, int)):
                self.words[name] = setting
            elif isinstance(setting, list):
                for i, number in enumerate(n for row in setting for n in row):
                    self.values[f"{name}[{i}]"] = mpf(number)
                self.words[name] = (len(setting), len(setting[0]))
            else:
                number, unit = setting if isinstance(setting, tuple) else (setting, "")
                self.values[name], self.units[name] = mpf(number), unit
        self.values["fx"], self.values["fy"] = (mpf(f) for f in frequency)

    def __getitem__(self, name):
        return self.values[name]

    def __contains__(self, name):
        return name in self.values

    def moved(self, changes):
        copy = Point({}, (0, 0))
        copy.values, copy.units, copy.words = {**self.values, **changes}, self.units, self.words
        return copy

    def frequency(self, axis):
        return self["f" + axis]

    def pitch_mm(self, axis):
        return self["frame.pitch_" + axis] / 1000

    def length_mm(self, name, axis):
        """A length of the focal plane, given as such, as an angle or in pixels; `name` or `name_x`, `name_y`."""
        name = name if name in self else f"{name}_{axis}"
        value, unit = self[name], self.units[name]
        if unit == "px":
            return value * self.pitch_mm(axis)
        if unit in ("urad", "mrad"):
            return value * self["frame.focal_length"] / {"urad": 10**6, "mrad": 10**3}[unit]
        return value / {"um": 1000, "mm": 1}[unit]

    def frequency_cy_mm(self, name, axis):
        value, unit = self[name], self.units[name]
        if unit == "cy/px":
            return value / self.pitch_mm(axis)
        if unit == "kHz":  # in time: cycles/mm = cycles/s / (mm/s)
            if "pixel_clock" in self:
                return value * 1000 / (self.pitch_mm(axis) * self["pixel_clock"])
            rate = self["scan_velocity"] / 1000 if "scan_velocity" in self else (
                self["scan_rate"] * self["frame.focal_length"] / 10**6)
            return value * 1000 / rate
        return value * 1000 / self["frame.focal_length"] if unit == "cy/mrad" else value


def scale_of(point, name):
    return abs(point[name]) or mpf(1)


def one_sided(otf, point, name):
    """Slopes from the right and from the left."""
    step = mpf(10) ** -otf.step_digits * scale_of(point, name)
    here = otf(point)
    return ((otf(point.moved({name: point[name] + step})) - here) / step,
            (here - otf(point.moved({name: point[name] - step}))) / step)


def derivative(otf, point, name, stated):
    right, left = one_sided(otf, point, name)
    # A smooth function leaves a difference of the step, a power 3/2 or 5/3 its root or so, a kink of slopes far more.
    relative, absolute = mpf(10) ** (-otf.step_digits / mpf(3)), mpf(10) ** (-otf.step_digits * mpf(5) / 12)
    if abs(right - left) <= max(relative * max(abs(right), abs(left)), absolute / scale_of(point, name)):
        return "both", (right + left) / 2
    at_zero = name in ("fx", "fy") and point[name] == 0
    side = "mean" if at_zero else stated.get(name)
    if side is None:
        raise ArithmeticError(f"no derivative by {name} at {point.values}: {right} {left}; state the side in the case")
    return side, {"right": right, "left": left, "mean": (right + left) / 2}[side]


def perturbed(point):
    for s, t in product((-1, 1), repeat=2):
        yield point.moved({"fx": point["fx"] * (1 + s * ROUNDING), "fy": point["fy"] * (1 + t * ROUNDING)})


def settings_text(settings):
    def text(setting):
        if isinstance(setting, (str, int)):
            return str(setting)
        if isinstance(setting, list):
            return "/".join("|".join(hex_of(n) for n in row) for row in setting)
        number, unit = setting if isinstance(setting, tuple) else (setting, "")
        return f"{hex_of(number)} {unit}".strip()

    return ";".join(f"{name}={text(setting)}" for name, setting in settings.items())


def remembered(function, digits_kept, step_digits):
    """The OTF at so many digits, each point evaluated once."""
    known = {}

    def otf(point):
        key = tuple(point.values.values())
        if key not in known:
            with mp.workdps(digits_kept):
                known[key] = mp.mpmathify(function(point))
        return known[key]

    otf.step_digits = step_digits
    return otf


def rows_of(name_of_kind, kind, case):
    otf = remembered(kind.otf, kind.digits, kind.digits * 2 // 5)
    points = [Point(case.settings, f) for f in case.at]
    scan = [Point(case.settings, f) for f in SCAN[:: kind.scan_every]]
    short = lambda x: digits(x, 3)
    for name in points[0].values:
        largest = max(abs(s) for p in points + scan for s in one_sided(otf, p, name))
        for p in points:
            value, (side, slope) = otf(p), derivative(otf, p, name, case.side)
            value_moved = moved = mpf(0)
            if kind.rounding:
                value_moved = max(abs(otf(q) - value) for q in perturbed(p))
            if kind.rounding and side == "both":
                moved = max(abs(s - slope) for q in perturbed(p) for s in one_sided(otf, q, name))
            # What is below comes from the step.
            noise = mpf(10) ** (-otf.step_digits * 2 / mpf(3)) / scale_of(p, name)
            slope, moved, top = (s if abs(s) > noise else mpf(0) for s in (slope, moved, largest))
            yield [name_of_kind, settings_text(case.settings), hex_of(p["fx"]), hex_of(p["fy"]), name, side,
                   digits(mp.re(value), 25), digits(mp.im(value), 25), short(value_moved),
                   digits(mp.re(slope), 25), digits(mp.im(slope), 25), short(moved), short(top)]


def main():
    parser = argparse.ArgumentParser(description="Writes gradients.csv.")
    parser.add_argument("--folder", help="where to write; default: the folder of the tables")
    parser.add_argument("kinds", nargs="*", help="these kinds only, for a look while adding one")
    options = parser.parse_args()
    rows = [row for name, kind in KINDS.items() if name in options.kinds or not options.kinds
            for case in kind.cases for row in rows_of(name, kind, case)]
    header = ["kind", "settings", "fx_hex", "fy_hex", "parameter", "side", "otf_re", "otf_im", "otf_rounding",
              "d_re", "d_im", "d_rounding", "d_largest"]
    write_table("gradients.csv", header, rows, options.folder)


if __name__ == "__main__":
    main()
