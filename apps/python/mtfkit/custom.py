# SPDX-License-Identifier: Apache-2.0
"""Components of your own: a function of (fx, fy) becomes one, held to what every component is held to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import quantities
from mtfkit.errors import UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]

__all__ = ["Custom", "General", "custom"]

_MOST_SAMPLES = 16385
_UNITS = ("cy/mm", "cy/mrad", "cy/px")


@dataclass(frozen=True, eq=False)
class Custom:
    """A component made of a function: tables that stand for it within `error`, absolute, at every frequency.

    `axis` is "radial" (one table against |f|) or "separable" (one along x, one along y). Stands in the list of a Sensor as
    any component; the sensor carries the tables, saves and pickles with them.
    """

    label: str
    unit: str
    axis: str
    frequency: Floats
    values: tuple[Floats, ...]
    error: float

    def tables(self) -> list[tuple[str, str, str]]:
        """(label, axis, CSV) of each table."""
        header = f"frequency_{self.unit.replace('/', '_')},mtf\n"
        names = ["radial"] if self.axis == "radial" else ["x", "y"]
        return [(self.label if len(names) == 1 else f"{self.label}_{name}", name,
                 header + "".join(f"{f!r},{v!r}\n" for f, v in zip(self.frequency.tolist(), values.tolist())))
                for name, values in zip(names, self.values)]


@dataclass(frozen=True, eq=False)
class General:
    """A component made of a function that no tables stand for: with phase, or neither radial nor a product of x and y.

    It acts on the scene by a transform in double precision, before all else of the sensor; for presample lists and scenes
    in memory. `otf` gives 0 beyond the cutoff, which is in `unit`.
    """

    label: str
    unit: str
    cutoff: float
    function: Callable[[Any, Any], Any]

    def otf(self, fx: Floats, fy: Floats) -> npt.NDArray[np.complex128]:
        """The function at frequencies in its own unit, 0 beyond the cutoff."""
        inside = np.hypot(fx, fy) <= self.cutoff
        values = np.zeros(fx.shape, dtype=np.complex128)
        values[inside] = _evaluated(self.function, fx[inside], fy[inside])
        return values


class Canvas:
    """A scene with its border, which repeats, behind components made of general functions.

    The mirrored scene is filtered as a whole, so that OTFs with phase keep their exact meaning; the rest of the sensor
    takes it as a scene that repeats, and what belongs to the scene is cut out of the image.
    """

    def __init__(self, scene: Floats, border: str, step_um: tuple[float, float],
                 otf: Callable[[Floats, Floats], npt.NDArray[np.complex128]]) -> None:
        self._size, self._step_um = scene.shape, step_um
        canvas = scene if border == "periodic" else np.block([[scene, scene[:, ::-1]], [scene[::-1], scene[::-1, ::-1]]])
        fy = np.fft.fftfreq(canvas.shape[0], step_um[1] * 1e-3)
        fx = np.fft.rfftfreq(canvas.shape[1], step_um[0] * 1e-3)
        mean = float(canvas.mean())
        x, y = np.broadcast_arrays(fx[None, :], fy[:, None])
        values = otf(x.ravel(), y.ravel()).reshape(x.shape)
        if canvas.shape[1] % 2 == 0:  # the highest frequency stands for both of its signs: the mean of both
            values[:, -1] = 0.5 * (values[:, -1] + otf(-x[:, -1], y[:, -1]))
        if canvas.shape[0] % 2 == 0:
            row = canvas.shape[0] // 2
            values[row] = 0.5 * (values[row] + otf(x[row], -y[row]))
        filtered = mean + np.fft.irfft2(np.fft.rfft2(canvas - mean) * values, canvas.shape)
        self.scene = filtered.astype(np.float32)
        spread = float(scene.std())
        self._ratio = float(self.scene.std()) / spread if spread > 0 else 1.0
        self._rounding = 2.0 ** -24 * float(np.abs(filtered).max()) / spread if spread > 0 else 0.0

    def cropped(self, images: list[Any], pitch_um: tuple[float, float]) -> list[Any]:
        """The pixels of the scene itself."""
        rows, columns = (int(np.floor(n * step / pitch + 1e-9))
                         for n, step, pitch in zip(self._size, self._step_um[::-1], pitch_um[::-1]))
        return [(frame, {name: np.ascontiguousarray(plane[:rows, :columns]) for name, plane in planes.items()})
                for frame, planes in images]

    def promise(self, promised: float) -> float:
        """A promise about the filtered canvas, as one about the scene: an image of it is a part of the canvas, of at least
        a quarter of its pixels, hence the 2; and the rounding of the filtered scene to float32."""
        return 2.0 * promised * self._ratio + 2.0 * self._rounding


def _evaluated(otf: Callable[[Any, Any], Any], fx: Floats, fy: Floats) -> npt.NDArray[np.complex128]:
    """The function there: finite numbers, one for each frequency."""
    values = np.asarray(otf(fx, fy))
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


def _table(profile: Callable[[Floats], Floats], cutoff: float, tolerance: float) -> tuple[Floats, Floats, float]:
    """Samples whose monotone cubic is the profile within the tolerance, and what it errs by between them."""
    count = 65
    while True:
        f = np.linspace(0.0, cutoff, count)
        values = profile(f)
        middle = np.concatenate([0.5 * (f[:-1] + f[1:]), 0.75 * f[:-1] + 0.25 * f[1:], 0.25 * f[:-1] + 0.75 * f[1:]])
        error = float(np.abs(monotone_cubic(f, values, middle) - profile(middle)).max())
        if 2.0 * error <= tolerance:
            return f, values, 2.0 * error
        if count >= _MOST_SAMPLES:
            raise UsageError(f"custom: a table of {count} samples is off by {error:.2g}, more than half of the tolerance "
                             f"{tolerance:g}: the function is too steep somewhere; give a larger tolerance")
        count = 2 * count - 1


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


def custom(otf: Callable[[Any, Any], Any], *, cutoff: quantities.Value, label: str = "custom", gain: bool = False,
           tolerance: float = 1e-6) -> Custom | General:
    """A component of your own, for exploration: `otf(fx, fy)` takes arrays of frequencies and gives the OTF there.

    `cutoff` is where it ends, in the unit that the function takes: "60 cy/mm", (2, "cy/px"), "5 cy/mrad"; beyond it the OTF
    falls to 0. The function is held to what every component is held to: 1 at zero, at most 1 without `gain`, finite, the
    complex conjugate at -f. One that is radial, or a product of x and y, real and even, is replaced by tables that differ
    from it by less than `tolerance` at every frequency: such a component compiles, saves, pickles and is fitted beside as
    any other. All others, with phase or of no such form, are General: they act on scenes in memory, by a transform in
    double precision. Promises of the sensor count both. Raises UsageError that says which property fails, and where.

    >>> import numpy as np, mtfkit as mk
    >>> blur = mk.custom(lambda fx, fy: np.exp(-((fx ** 2 + fy ** 2) / 40 ** 2)), cutoff="200 cy/mm", label="coating")
    >>> blur.axis, blur.error < 1e-6
    ('radial', True)
    """
    words = quantities.words(cutoff, "cutoff") if isinstance(cutoff, str) or quantities.is_quantity(cutoff) else ""
    unit = next((u for u in _UNITS if words.endswith(u)), "")
    try:
        end = float(words[:len(words) - len(unit)]) if unit else 0.0
    except ValueError:
        end = 0.0
    if not end > 0.0 or not np.isfinite(end):
        raise UsageError(f"cutoff: {cutoff!r} is no frequency above 0 with its unit, such as \"60 cy/mm\"")
    if not label.replace("_", "a").isalnum():
        raise UsageError(f"label: {label!r} has other characters than letters, digits and _")
    fx, fy, values = _conforms(otf, end, gain)

    def along_x(f: Floats) -> Floats:
        return _real(otf, f, np.zeros_like(f))

    def along_y(f: Floats) -> Floats:
        return _real(otf, np.zeros_like(f), f)

    if np.abs(along_x(np.hypot(fx, fy)) - values).max() <= 1e-12:
        f, table, error = _table(along_x, end, tolerance)
        return Custom(label, unit, "radial", f, (table,), error)
    even = np.abs(_evaluated(otf, -fx, fy) - values).max() <= 1e-12
    if even and np.abs(along_x(fx) * along_y(fy) - values).max() <= 1e-12:
        f, x_table, x_error = _table(along_x, end, 0.5 * tolerance)
        g, y_table, y_error = _table(along_y, end, 0.5 * tolerance)
        if len(f) != len(g):  # one grid for both
            f = f if len(f) > len(g) else g
            x_table, y_table = along_x(f), along_y(f)  # a finer table errs by less
        return Custom(label, unit, "separable", f, (x_table, y_table), x_error + y_error)
    return General(label, unit, end, otf)
