# SPDX-License-Identifier: Apache-2.0
"""Functions with phase, or of no simple form, by samples of their point spread function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]
    #: The OTF at frequencies (fx, fy) of one shape, 0 beyond its cutoff.
    Otf = Callable[[Floats, Floats], npt.NDArray[np.complex128]]

_MOST_SAMPLES = 40000
_MOST_ALONG_AN_AXIS = 1025


@dataclass(frozen=True, eq=False)
class Sampled:
    """A component made of a function, by the samples of its point spread function: the component `psf`.

    `samples` are rows of values, `step` apart (along x and y, the inverse of `unit`), about the middle one. Their OTF is
    within `error`, absolute, of the function at every frequency. Stands in the list of a Sensor as any component.
    """

    label: str
    unit: str
    samples: Floats
    step: tuple[float, float]
    error: float

    def lines(self, stage: str) -> str:
        """The component as a sensor file has it, with what it stands for."""
        length = {"cy/mm": "mm", "cy/mrad": "mrad", "cy/px": "px"}[self.unit]
        rows = ",\n  ".join(f"[{', '.join(repr(value) for value in row)}]" for row in self.samples.tolist())
        return (f"# a function of Python by the samples of its PSF: their OTF is within {self.error:.2g} of it\n"
                f"[[{stage}]]\nkind = \"psf\"\nlabel = \"{self.label}\"\nstep_x = \"{self.step[0]!r} {length}\"\n"
                f"step_y = \"{self.step[1]!r} {length}\"\nsamples = [\n  {rows}]\n")

    def otf(self, fx: Floats, fy: Floats) -> npt.NDArray[np.complex128]:
        """What the component makes of the samples, at frequencies in `unit`."""
        rows, columns = self.samples.shape
        x = np.exp(-2j * np.pi * fx.ravel()[:, None] * self.step[0] * (np.arange(columns) - columns // 2))
        y = np.exp(-2j * np.pi * fy.ravel()[:, None] * self.step[1] * (np.arange(rows) - rows // 2))
        inside = (np.abs(fx) * self.step[0] < 0.5) & (np.abs(fy) * self.step[1] < 0.5)
        values = np.einsum("fj,jk,fk->f", y, self.samples, x, optimize=True) / self.samples.sum()
        return np.asarray(np.where(inside, values.reshape(fx.shape), 0.0))


def _band(otf: Otf, cutoff: float, least: float) -> tuple[float, float]:
    """Where the function has fallen below `least` for good, along x and y."""
    f = np.linspace(-cutoff, cutoff, 257)
    large = np.abs(otf(*np.meshgrid(f, f))) > least
    ends = [float(np.abs(f[large.any(axis=axis)]).max(initial=0.0)) + f[1] - f[0] for axis in (0, 1)]
    return min(cutoff, ends[0]), min(cutoff, ends[1])


def _on_grid(otf: Otf, step: tuple[float, float], columns: int, rows: int) -> Floats:
    """The PSF that the function has on a grid that repeats: its inverse transform, the origin in the middle."""
    fx, fy = np.fft.fftfreq(columns, step[0]), np.fft.fftfreq(rows, step[1])
    values = otf(*np.meshgrid(fx, fy))
    return np.asarray(np.fft.fftshift(np.fft.ifft2(values).real), dtype=np.float64)


def _trimmed(samples: Floats, budget: float) -> Floats:
    """Without the border whose samples sum up to less than the budget; a middle one stays the middle."""
    rows, columns = samples.shape
    for axis in (0, 1):
        lines = np.abs(samples).sum(axis=1 - axis)
        outer = np.cumsum(lines + lines[::-1])[:len(lines) // 2]
        cut = int(np.searchsorted(outer, 0.5 * budget))
        samples = samples[cut:rows - cut] if axis == 0 else samples[:, cut:columns - cut]
    return samples


def _error(otf: Otf, made: Sampled, cutoff: float) -> float:
    """The largest difference at frequencies all over the plane, about zero and at the ends of the samples' band."""
    numbers = np.random.default_rng(1)
    radius = cutoff * np.concatenate([np.sqrt(numbers.random(2000)), 10.0 ** numbers.uniform(-4, 0, 600)])
    angle = 2 * np.pi * numbers.random(radius.size)
    ends = [numbers.uniform(-0.5, 0.5, (2, 400)) / np.array(made.step)[:, None] for _ in range(2)]
    for axis in (0, 1):
        ends[axis][axis] = 0.4999999 / made.step[axis]
    fx, fy = np.concatenate([[radius * np.cos(angle), radius * np.sin(angle)], *ends], axis=1)
    return float(np.abs(made.otf(fx, fy) - otf(fx, fy)).max())


def sampled(otf: Otf, *, label: str, unit: str, cutoff: float, tolerance: float) -> Sampled | None:
    """Samples that stand for the function within the tolerance, or as well as 40 000 of them can; None where the PSF is
    not within their reach."""
    band = _band(otf, cutoff, 0.1 * tolerance)
    step = (0.5 / band[0], 0.5 / band[1])
    best: Sampled | None = None
    count = 17
    while count <= _MOST_ALONG_AN_AXIS:
        window = _trimmed(_on_grid(otf, step, count, count), 0.2 * tolerance)
        if window.size > _MOST_SAMPLES:  # as many as may be, about the middle
            half = int(np.sqrt(_MOST_SAMPLES)) // 2
            rows, columns = window.shape
            window = window[max(0, rows // 2 - half):rows // 2 + half + 1, max(0, columns // 2 - half):columns // 2 + half + 1]
        digits = max(0, int(np.ceil(-np.log10(0.1 * tolerance / window.size))))
        made = Sampled(label, unit, np.round(window, digits) + 0.0, step, 0.0)
        if made.samples.sum() > 0.5:
            made = Sampled(label, unit, made.samples, step, 2.0 * _error(otf, made, cutoff))
            best = made if best is None or made.error < best.error else best
            if best.error <= tolerance:
                return best
        count = 2 * count - 1
    return best
