# SPDX-License-Identifier: Apache-2.0
"""Components of your own: a function of (fx, fy) becomes one, held to what every component is held to."""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import quantities
from mtfkit.arguments import checked
from mtfkit.errors import UsageError
from mtfkit.sampled import Sampled, sampled

if TYPE_CHECKING:
    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]

__all__ = ["Custom", "General", "Sampled", "custom"]

_MOST_SAMPLES = 16385  # so that a sensor file stays below a megabyte
_UNITS = ("cy/mm", "cy/mrad", "cy/px")


@dataclass(frozen=True, eq=False)
class Custom:
    """A component made of a function: tables that stand for it within `error`, absolute, up to its cutoff.

    `axis` is "radial" (one table against |f|) or "separable" (one along x, one along y). Stands in the list of a Sensor as
    any component; the text of the sensor holds the tables.
    """

    label: str
    unit: str
    axis: str
    frequency: Floats
    values: tuple[Floats, ...]
    error: float

    def lines(self, stage: str) -> str:
        """The component as a sensor file has it, with what it stands for."""
        names = ["radial"] if self.axis == "radial" else ["x", "y"]
        header = f"frequency_{self.unit.replace('/', '_')},mtf\n"
        text = f"# a function of Python by a table that is within {self.error:.2g} of it\n"
        for name, values in zip(names, self.values):
            rows = "".join(f"{f!r},{v!r}\n" for f, v in zip(self.frequency.tolist(), values.tolist()))
            label = self.label if len(names) == 1 else f"{self.label}_{name}"
            text += (f"[[{stage}]]\nkind = \"curve\"\nlabel = \"{label}\"\naxis = \"{name}\"\n"
                     f"file = \"\"\"\n{header}{rows}\"\"\"\n")
        return text


@dataclass(frozen=True, eq=False)
class General:
    """A component made of a function that neither tables nor samples stand for: one with edges or kinks.

    It acts on the scene by a transform in double precision, before all else of the sensor; for presample lists and scenes
    in memory. `otf` gives 0 beyond the cutoff, which is in `unit`. `within` is how well samples of the point spread function
    would stand for it, None where they are out of reach.
    """

    label: str
    unit: str
    cutoff: float
    function: Callable[[Any, Any], Any]
    within: float | None = None
    digest: str = ""  #: SHA-256 of 2000 values, by which `custom` tells this function from another

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, General):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[object, ...]:
        return self.label, self.unit, self.cutoff, self.digest or self.function

    def lines(self, stage: str) -> str:
        """What stands in the text of a sensor, a comment: no file can state the function."""
        return (f"# {stage}: \"{self.label}\", a function of Python that is 0 beyond {self.cutoff!r} {self.unit}, 2000 values of "
                f"which have the SHA-256\n# {self.digest}; it is no part of this text\n")

    def refusal(self, what: str) -> UsageError:
        """Why a part of the toolkit that needs the component as data cannot have it, and what to do."""
        way = (f"mtfkit.custom(..., tolerance={_rounded_up(1.3 * self.within):g}) makes samples of it that can, and the "
               "promise counts their error" if self.within is not None and self.within < 0.03 else
               "it has to be written as a kind of component")
        return UsageError(f"{what}: \"{self.label}\" is a general function, code of Python that no data stand for; {way}")

    def otf(self, fx: Floats, fy: Floats) -> npt.NDArray[np.complex128]:
        """The function at frequencies in its own unit, 0 beyond the cutoff."""
        inside = np.hypot(fx, fy) <= self.cutoff
        values = np.zeros(fx.shape, dtype=np.complex128)
        values[inside] = _evaluated(self.function, fx[inside], fy[inside])
        return values


def _rounded_up(value: float) -> float:
    """To one digit."""
    step = 10.0 ** np.floor(np.log10(value))
    return float(np.ceil(value / step) * step)


def _evaluated(otf: Callable[[Any, Any], Any], fx: Floats, fy: Floats) -> npt.NDArray[np.complex128]:
    """The function there: finite numbers, one for each frequency."""
    values = np.asarray(otf(fx.copy(), fy.copy()))  # which it may write into
    if values.shape != fx.shape:
        raise UsageError(f"custom: the function gives an array of the shape {values.shape} for frequencies of the shape "
                         f"{fx.shape}; give a value for each")
    if values.dtype.kind not in "biufc":
        raise UsageError(f"custom: the function gives values of type {values.dtype}")
    if not np.isfinite(values).all():
        bad = int(np.flatnonzero(~np.isfinite(values))[0])
        raise UsageError(f"custom: the function is not finite at ({fx[bad]:.6g}, {fy[bad]:.6g})")
    return values.astype(np.complex128)


def _real(otf: Callable[[Any, Any], Any], fx: Floats, fy: Floats) -> Floats:
    return np.asarray(_evaluated(otf, fx, fy).real, dtype=np.float64)


def _require(holds: npt.NDArray[np.bool_], fx: Floats, fy: Floats, what: str) -> None:
    if not holds.all():
        bad = int(np.flatnonzero(~holds)[0])
        raise UsageError(f"custom: {what}, which fails at ({fx[bad]:.6g}, {fy[bad]:.6g})")


def _conforms(otf: Callable[[Any, Any], Any], cutoff: float,
              gain: bool) -> tuple[Floats, Floats, npt.NDArray[np.complex128]]:
    """Points over the plane and the values there, after the checks that every component passes."""
    zero = np.zeros(1)
    at_zero = complex(_evaluated(otf, zero, zero)[0])
    if abs(at_zero - 1.0) > 4 * np.finfo(float).eps:
        raise UsageError(f"custom: otf(0, 0) = {at_zero!r}; an OTF is 1 there, and what it takes from all frequencies is a "
                         "transmission")
    numbers = np.random.default_rng(0)
    radius, angle = cutoff * np.sqrt(numbers.random(2000)), 2 * np.pi * numbers.random(2000)
    fx, fy = radius * np.cos(angle), radius * np.sin(angle)
    values = _evaluated(otf, fx, fy)
    if not gain:
        _require(np.abs(values) <= 1 + 1e-12, fx, fy, "|otf| is at most 1 without gain=True")
    _require(np.abs(_evaluated(otf, -fx, -fy) - values.conj()) <= 1e-12, fx, fy,
             "the OTF at -f is the complex conjugate of that at f")
    return fx, fy, values


def _warn_of_a_cut(otf: Callable[[Any, Any], Any], cutoff: float, unit: str, tolerance: float) -> None:
    """A function that goes on beyond the cutoff is another component there, which only its author can mean."""
    numbers = np.random.default_rng(2)
    radius, angle = cutoff * numbers.uniform(1.0, 2.0, 500), 2 * np.pi * numbers.random(500)
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:  # a function may not be made for such frequencies: then it has no values there
            values = np.abs(np.asarray(otf(radius * np.cos(angle), radius * np.sin(angle)), dtype=np.complex128))
        except Exception:  # noqa: BLE001
            return
    largest = float(np.max(values, initial=0.0, where=np.isfinite(values)))
    if largest > tolerance:
        warnings.warn(f"custom: |otf| is up to {largest:.2g} between {cutoff:g} and {2 * cutoff:g} {unit}, beyond the cutoff, "
                      "where the component ends; give a larger cutoff, unless nothing else of the sensor passes that far",
                      stacklevel=4)


def _table(profiles: tuple[Callable[[Floats], Floats], ...], cutoff: float, tolerance: float,
           most: int) -> tuple[Floats, tuple[Floats, ...], float] | None:
    """Frequencies, and of each profile the values there whose monotone cubic is the profile, within the tolerance for all
    together; with what they err by between them. None where as many as may be do not suffice.

    Even steps come first. Powers of even steps lie closer near 0, as a tip there needs: of 1 - f^a, with the third power, the
    cubic errs as much near 0 as elsewhere for a = 1, with the second for a = 1.5.
    """
    count, digits = 65, int(np.ceil(2.0 - np.log10(tolerance / len(profiles))))
    while count <= most:
        for power in (1, 2, 3):
            f = np.array([float(f"{cutoff * one ** power:.12g}") for one in np.linspace(0.0, 1.0, count)])
            middle = np.concatenate([0.5 * (f[:-1] + f[1:]), 0.75 * f[:-1] + 0.25 * f[1:], 0.25 * f[:-1] + 0.75 * f[1:]])
            tables = tuple(np.round(profile(f), digits) for profile in profiles)
            errors = [2.0 * float(np.abs(monotone_cubic(f, values, middle) - profile(middle)).max())
                      for values, profile in zip(tables, profiles)]
            # Of a product each counts by the largest value of the others, above 1 where there is gain.
            sizes = [max(1.0, float(np.abs(values).max()) + one) for values, one in zip(tables, errors)]
            error = sum(one * float(np.prod(sizes)) / size for one, size in zip(errors, sizes))
            if error <= tolerance:
                return f, tables, error
        count = 2 * count - 1
    return None


def monotone_cubic(f: Floats, values: Floats, at: Floats) -> Floats:
    """The curve of a table as the component `curve` has it: Fritsch and Carlson, SIAM J. Numer. Anal. 17, 238 (1980)."""
    step, slope = np.diff(f), np.diff(values) / np.diff(f)
    tangent = np.empty_like(values)
    left, right = slope[:-1], slope[1:]
    a, b = 2 * step[1:] + step[:-1], step[1:] + 2 * step[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = (a + b) / (a / left + b / right)
    tangent[1:-1] = np.where(left * right > 0, inner, 0.0)
    tangent[0], tangent[-1] = slope[0], slope[-1]
    k = np.clip(np.searchsorted(f, at, side="right") - 1, 0, len(f) - 2)
    t = (at - f[k]) / step[k]
    return np.asarray(values[k] * (1 + 2 * t) * (1 - t) ** 2 + values[k + 1] * t * t * (3 - 2 * t)
                      + step[k] * t * (1 - t) * (tangent[k] * (1 - t) - tangent[k + 1] * t), dtype=np.float64)


@checked
def custom(otf: Callable[[Any, Any], Any], *, cutoff: quantities.Value, label: str = "custom", gain: bool = False,
           tolerance: float = 1e-6) -> Custom | Sampled | General:
    """A component of your own, for exploration: `otf(fx, fy)` takes arrays of frequencies and gives the OTF there.

    `cutoff` is where it ends, in the unit that the function takes: "60 cy/mm", (2, "cy/px"), "5 cy/mrad"; there the
    component falls to 0, and a function that goes on is warned of. The function is held to what every component is held to: 1 at zero, at most 1 without `gain`, finite, the
    complex conjugate at -f. It becomes data that differ from it by less than `tolerance`, as seen at thousands of frequencies
    all over the plane (what is narrower than a hundredth of the cutoff can be overlooked): tables where it
    is radial, or a product of x and y, real and even (Custom), else samples of its point spread function (Sampled). Such a
    component compiles, saves, pickles and is fitted beside as any other, and the promises of the sensor count its error.
    What no data stand for within the tolerance, as functions with edges and kinks, is General: it acts on arrays, exactly, by a transform in double precision, in `simulate` and `compile`. Raises UsageError that says which
    property fails, and where.

    >>> import numpy as np, mtfkit as mk
    >>> blur = mk.custom(lambda fx, fy: np.exp(-((fx ** 2 + fy ** 2) / 40 ** 2)), cutoff="200 cy/mm", label="coating")
    >>> blur.axis, blur.error < 1e-6
    ('radial', True)
    >>> shift = mk.custom(lambda fx, fy: np.exp(-(fx / 40) ** 2 - (fy / 60) ** 2 - 2j * np.pi * 0.004 * fx), cutoff="300 cy/mm")
    >>> shift.samples.shape, shift.error < 1e-6
    ((21, 23), True)
    """
    words = quantities.words(cutoff, "cutoff") if isinstance(cutoff, str) or quantities.is_quantity(cutoff) else ""
    unit = next((u for u in _UNITS if words.endswith(u)), "")
    try:
        end = float(words[:len(words) - len(unit)]) if unit else 0.0
    except ValueError:
        end = 0.0
    if not end > 0.0 or not np.isfinite(end):
        raise UsageError(f"cutoff: {cutoff!r} is no frequency above 0 with its unit, such as \"60 cy/mm\"")
    if not isinstance(label, str) or not label.replace("_", "a").isalnum():
        raise UsageError(f"label: {label!r} has other characters than letters, digits and _")
    if not 1e-12 <= tolerance <= 0.1:
        raise UsageError(f"tolerance: {tolerance!r} is outside 1e-12 to 0.1")
    fx, fy, values = _conforms(otf, end, gain)
    _warn_of_a_cut(otf, end, unit, tolerance)
    tables = _tables(otf, fx, fy, values, end, tolerance)
    if tables is not None:
        return Custom(label, unit, *tables)
    whole = General(label, unit, end, otf, None, hashlib.sha256(values.tobytes()).hexdigest())
    made = sampled(whole.otf, label=label, unit=unit, cutoff=end, tolerance=tolerance)
    if made is None or made.error <= tolerance:
        return whole if made is None else made
    return replace(whole, within=made.error)


def _tables(otf: Callable[[Any, Any], Any], fx: Floats, fy: Floats, values: npt.NDArray[np.complex128], end: float,
            tolerance: float) -> tuple[str, Floats, tuple[Floats, ...], float] | None:
    """Axis, frequencies, tables and error of a radial function or a product; None for others and for too steep ones."""
    def along_x(f: Floats) -> Floats:
        return _real(otf, f, np.zeros_like(f))

    def along_y(f: Floats) -> Floats:
        return _real(otf, np.zeros_like(f), f)

    if np.abs(along_x(np.hypot(fx, fy)) - values).max() <= 1e-12:
        radial = _table((along_x,), end, tolerance, _MOST_SAMPLES)
        return None if radial is None else ("radial", *radial)
    even = np.abs(_evaluated(otf, -fx, fy) - values).max() <= 1e-12
    if not even or np.abs(along_x(fx) * along_y(fy) - values).max() > 1e-12:
        return None
    product = _table((along_x, along_y), end, tolerance, _MOST_SAMPLES // 2 + 1)
    return None if product is None else ("separable", *product)
