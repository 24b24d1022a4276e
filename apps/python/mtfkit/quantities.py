# SPDX-License-Identifier: Apache-2.0
"""Values of sensor files as Python writes them: texts with a unit, or (number, unit)."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit.errors import UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

#: "15 um", (15, "um"), a plain number, a list, True or False.
Value = Any


def _number(value: float, what: str) -> str:
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if not math.isfinite(value):
        raise UsageError(f"{what}: {value} is not a finite number")
    return repr(float(value))


def shown(value: object, most: int = 80) -> str:
    """A value in a message: as Python writes it, cut where that is long."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} of the shape {value.shape}"
    try:
        text = " ".join(repr(value).split())
    except Exception:
        text = f"<{type(value).__name__}>"
    return text if len(text) <= most else f"{text[:most - 4]} ..."


def number(value: Any, what: str) -> float:
    """A plain number. Raises UsageError."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise UsageError(f"{what}: {shown(value)} is no number")
    return float(value)


def whole(value: Any, what: str) -> int:
    """A whole number. Raises UsageError."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
        raise UsageError(f"{what}: {shown(value)} is no whole number")
    return int(value)


def seed(value: int) -> None:
    """Raises UsageError for what is no seed of noise."""
    if whole(value, "seed") < 0:
        raise UsageError(f"seed: {value} is below 0")


def numbers(values: npt.ArrayLike, what: str) -> npt.NDArray[np.float64]:
    """An array of real numbers. Raises UsageError."""
    try:
        array = np.asanyarray(values)
    except ValueError:
        raise UsageError(f"{what}: {shown(values)} is no array of numbers; its rows differ in length") from None
    if isinstance(array, np.ma.MaskedArray):
        raise UsageError(f"{what}: is a masked array; say what stands for the masked values, such as a.filled(numpy.nan)")
    if array.dtype.kind not in "biuf":
        raise UsageError(f"{what}: {shown(values)} is no number or array of numbers")
    return np.asarray(array, dtype=np.float64)


def broadcast(a: npt.ArrayLike, a_name: str, b: npt.ArrayLike, b_name: str
              ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Two arrays of numbers of their common shape. Raises UsageError."""
    x, y = numbers(a, a_name), numbers(b, b_name)
    try:
        along_a, along_b = np.broadcast_arrays(x, y)
    except ValueError:
        raise UsageError(f"{a_name}: has the shape {x.shape} and {b_name} {y.shape}, which have no common one") from None
    return along_a, along_b


def band_um(band: Any, what: str) -> tuple[float, float]:
    """Both ends of a band in um. Raises UsageError."""
    if not isinstance(band, (tuple, list)) or len(band) != 2 or is_quantity(band):
        raise UsageError(f"{what}: {shown(band)} is no pair of wavelengths; write (\"3.4 um\", \"4.8 um\")")
    lo, hi = micrometres(band[0], what), micrometres(band[1], what)
    if not 0.0 < lo < hi:
        raise UsageError(f"{what}: from {lo:g} to {hi:g} um is no band; give two wavelengths above 0, the shorter one first")
    return lo, hi


def value_range(ends: Any, what: str = "range") -> tuple[float, float] | None:
    """(low, high), or None. Raises UsageError."""
    if ends is None:
        return None
    if not isinstance(ends, (tuple, list, np.ndarray)) or len(ends) != 2:
        raise UsageError(f"{what}: {shown(ends)} is not (low, high)")
    return number(ends[0], what), number(ends[1], what)


def path(file: Any, what: str) -> str:
    """The name of a file. Raises UsageError."""
    if not isinstance(file, (str, os.PathLike)):
        raise UsageError(f"{what}: {shown(file)} is no name of a file; give a text or a path")
    name = os.fspath(file)
    if not isinstance(name, str):
        raise UsageError(f"{what}: {shown(file)} is no text; give os.fsdecode of it")
    if "\0" in name:
        raise UsageError(f"{what}: {shown(name)} has a zero byte")
    return name


def is_quantity(value: Value) -> bool:
    """True for (number, unit)."""
    return (isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str)
            and isinstance(value[0], (int, float, np.integer, np.floating)) and not isinstance(value[0], bool))


def toml(value: Value, what: str) -> str:
    """The value as a TOML file has it. `what` is what messages call it."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, os.PathLike):
        return toml(os.fspath(value), what)
    if is_quantity(value):
        return toml(f"{_number(value[0], what)} {value[1]}", what)
    if isinstance(value, (int, float)):
        return _number(value, what)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml(item, f'{what}.{key}')}" for key, item in value.items()) + " }"
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, Sequence):
        return "[" + ", ".join(toml(item, f"{what}[{i}]") for i, item in enumerate(value)) + "]"
    raise UsageError(f"{what}: {shown(value)} is no value of a sensor file; give a number, a text such as \"15 um\", "
                     "(15, \"um\"), a list, or True or False")


def words(value: Value, what: str) -> str:
    """The value as `replace` and schedules have it: texts without their quotes."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if is_quantity(value):
        return f"{_number(value[0], what)} {value[1]}"
    return toml(value, what)  # of a dictionary the inline table, { value = ..., fit = true }


def sample_words(sample: Value) -> tuple[str, str] | None:
    """The spacing of scene samples along x and y: one value for both, or a pair of them."""
    if sample is None:
        return None
    if isinstance(sample, str) or is_quantity(sample):
        return words(sample, "sample"), words(sample, "sample")
    if isinstance(sample, (tuple, list)) and len(sample) == 2 and all(
            isinstance(one, str) or is_quantity(one) for one in sample):
        return words(sample[0], "sample"), words(sample[1], "sample")
    raise UsageError(f"sample: {shown(sample)} has no unit; write it with its unit, such as \"3.75 um\" or (3.75, \"um\"), "
                     "or a pair of them for x and y")


def _lacks_unit(value: Value, unit: str) -> str:
    if isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool):
        return f"{shown(value)} has no unit; write it with its unit, such as \"5 {unit}\" or (5, \"{unit}\")"
    return f"{shown(value)} is no text with a unit, such as \"5 {unit}\", and no (5, \"{unit}\")"


def _named(conversion: Callable[[str], float], text: str, what: str) -> float:
    try:
        return conversion(text)
    except UsageError as error:
        raise UsageError(f"{what}: {error}") from None


def angle_deg(angle: Value, what: str = "angle") -> float:
    """An angle in degrees: "45 deg", (45, "deg"), "0.1 rad"; a plain 0 is 0 in any unit."""
    from mtfkit import _core

    if isinstance(angle, (int, float)) and not isinstance(angle, bool) and angle == 0:
        return 0.0
    if isinstance(angle, str) or is_quantity(angle):
        return _named(_core.angle_deg, words(angle, what), what)
    raise UsageError(f"{what}: {_lacks_unit(angle, 'deg')}")


def kelvin(temperature: Value, what: str = "temperature") -> float:
    """A temperature in K: "288 K", "15 degC", (288, "K")."""
    from mtfkit import _core

    if isinstance(temperature, str) or is_quantity(temperature):
        return _named(_core.to_kelvin, words(temperature, what), what)
    raise UsageError(f"{what}: {_lacks_unit(temperature, 'K')}")


def micrometres(length: Value, what: str) -> float:
    """A length in um: "4 um", (4000, "nm")."""
    from mtfkit import _core

    if isinstance(length, str) or is_quantity(length):
        return _named(_core.length_um, words(length, what), what)
    raise UsageError(f"{what}: {_lacks_unit(length, 'um')}")


def count(number: int, what: str, least: int = 1) -> int:
    """A whole number of things. Raises UsageError."""
    if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or not least <= number < 1 << 31:
        raise UsageError(f"{what}: {shown(number)} is not a whole number from {least} on")
    return int(number)


def plane_shape(size: tuple[int, int], what: str) -> tuple[int, int]:
    """(rows, columns) of a plane. Raises UsageError."""
    if not isinstance(size, (tuple, list)) or len(size) != 2:
        raise UsageError(f"{what}: {shown(size)} is not (rows, columns)")
    return count(size[0], what), count(size[1], what)


def thread_count(threads: int) -> int:
    """A number of threads, 0 for all cores. Raises UsageError."""
    if isinstance(threads, bool) or not isinstance(threads, (int, np.integer)) or not 0 <= threads <= 4096:
        raise UsageError(f"threads: {shown(threads)} is not a whole number from 0 (all cores) to 4096")
    return int(threads)


def frequencies(values: npt.ArrayLike, what: str) -> npt.NDArray[np.float64]:
    """An array of frequencies. Raises UsageError for what is no number."""
    try:
        array = np.asanyarray(values)
    except ValueError as ragged:
        raise UsageError(f"{what}: {ragged}") from None
    if array.dtype.kind not in "biuf" or isinstance(array, np.ma.MaskedArray):
        kind = "a masked array" if isinstance(array, np.ma.MaskedArray) else f"values of type {array.dtype}"
        raise UsageError(f"{what}: holds {kind}; frequencies are numbers in `unit`")
    return np.asarray(array, dtype=np.float64)


def frequency_pair(fx: npt.ArrayLike, fy: npt.ArrayLike) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Frequencies along x and y, of their common shape."""
    x, y = frequencies(fx, "fx"), frequencies(fy, "fy")
    try:
        along_x, along_y = np.broadcast_arrays(x, y)
    except ValueError:
        raise UsageError(f"otf: fx has the shape {x.shape} and fy {y.shape}, which have no common one") from None
    return along_x, along_y
