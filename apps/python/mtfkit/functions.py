# SPDX-License-Identifier: Apache-2.0
"""What general functions and tables in place of functions do to the numbers of a sensor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mtfkit import _core
from mtfkit.curves import Column, Curves, curves_of
from mtfkit.findings import Finding

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.custom import General

    Floats = npt.NDArray[np.float64]


def _nyquist(file: _core.SensorFile, unit: str) -> tuple[float, float]:
    """Nyquist frequencies along x and y; frequencies in units are to one another as these are."""
    x, y = (float(_core.curves(file, [0.0], angle, unit)["nyquist"]) for angle in (0.0, 90.0))
    return x, y


def same_units(a: _core.SensorFile, b: _core.SensorFile) -> bool:
    """Whether a frequency in any unit is the same for both."""
    return all(_nyquist(a, unit) == _nyquist(b, unit) for unit in ("cy/mm", "cy/mrad", "cy/px"))


def product(file: _core.SensorFile, functions: Sequence[General], x: Floats, y: Floats,
            unit: str) -> npt.NDArray[np.complex128]:
    """The product of general functions at frequencies of that unit."""
    values, here = np.ones(x.shape, dtype=np.complex128), _nyquist(file, unit)
    for function in functions:
        there = _nyquist(file, function.unit)
        values *= function.otf(x * (there[0] / here[0]), y * (there[1] / here[1]))
    return values


def with_functions(curves: Curves, file: _core.SensorFile, functions: Sequence[General]) -> Curves:
    """The curves with a column for each general function, which the presample list and the whole have as factors."""
    angle = np.radians(curves.angle_deg)
    x, y = (np.atleast_1d(np.round(part, 15) * curves.frequency) for part in (np.cos(angle), np.sin(angle)))
    none = np.zeros(len(curves.frequency))
    own = [Column(function.label, "custom", "presample", "a function of Python", bool((values.imag == 0.0).all()), values, none)
           for function in functions for values in [product(file, [function], x, y, curves.unit)]]
    factor = product(file, functions, x, y, curves.unit)
    columns = [Column(c.label, c.kind, c.stage, c.doc, c.real and all(f.real for f in own), c.otf * factor,
                      c.error * np.abs(factor)) if c.label in ("presample", "system") else c for c in curves.columns]
    at = next(i for i, column in enumerate(columns) if column.label == "presample")
    return Curves(curves.name, curves.unit, curves.angle_deg, curves.nyquist, curves.cutoff, curves.q, curves.frequency,
                  (*columns[:at], *own, *columns[at:]), curves.seconds, curves.table_error)


def explained(functions: Sequence[General]) -> str:
    """What `Sensor.explain` says of them below the rest."""
    if not functions:
        return ""
    lines = [f"  {f.label:<16} {f.function!r}, 0 beyond {f.cutoff:g} {f.unit}" for f in functions]
    return "\nGeneral functions of Python, which act on the scene before all else\n" + "\n".join(lines) + "\n"


def findings(functions: Sequence[General]) -> list[Finding]:
    """What `Sensor.check` says of them."""
    return [Finding("note", 0, 0, f.label, "a general function of Python: curves, compile and simulate count it; budgets, "
                    "which no MTF enters, stay as they are, and what reads a file (fit, studies, metrics, save) refuses it")
            for f in functions]


def table_error(file: _core.SensorFile, error: float, samples_per_pixel: float) -> float:
    """What tables in place of functions cost an image, as a share of the scene's standard deviation: an error D of the OTF
    at each frequency costs at most D x the square root of how many alias onto one x 2, the square root of the area of the
    mirrored canvas, x the largest gain of what follows."""
    if error == 0.0:
        return 0.0
    gain = max([1.0, *(float(np.max(column.mtf)) for angle in (0.0, 45.0, 90.0)
                       for column in curves_of(_core.curves(file, [], angle, "cy/mm"))
                       if column.label in ("readout", "postsample"))])
    return float(2.0 * gain * error * np.sqrt(samples_per_pixel))
