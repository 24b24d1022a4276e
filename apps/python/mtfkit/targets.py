# SPDX-License-Identifier: Apache-2.0
"""Scenes to test with: an edge whose samples alias nothing, a sine, points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mtfkit import quantities, results
from mtfkit.arguments import checked
from mtfkit.errors import UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.images import Plane

__all__ = ["Target", "edge", "points", "sine"]


@dataclass(frozen=True, eq=False)
class Target(results.ByValue):
    """Values of a scene, float32, and the blur that is in its samples: the sigma of a Gaussian in samples, 0 for none.

    `sensor.simulate(target)` divides the blur out again, so that the image is that of the sharp target. Samples are an
    eighth of a pixel apart where nothing else is said.
    """

    values: Plane
    blur_samples: float = 0.0
    __hash__ = None  # type: ignore[assignment]


def _grid(size: tuple[int, int]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    rows, columns = quantities.plane_shape(size, "size")
    return (np.arange(rows)[:, None] + 0.5 - 0.5 * rows), (np.arange(columns)[None, :] + 0.5 - 0.5 * columns)


_erfc = np.frompyfunc(math.erfc, 1, 1)


@checked
def edge(*, angle: quantities.Value = "5 deg", size: tuple[int, int] = (1280, 1280), low: float = 2.0,
         high: float = 8.0) -> Target:
    """A straight edge through the middle, whose normal points `angle` from +x towards +y; `high` lies on that side.

    `size` is (rows, columns) in samples. The step is blurred by a Gaussian of one sample, which the simulation divides out:
    what aliases is below 1e-5. Cut off a margin of the image, where the mirrored border bends the edge.
    """
    y, x = _grid(size)
    direction = math.radians(quantities.angle_deg(angle))
    distance = math.cos(direction) * x + math.sin(direction) * y
    # erfc is 0 or 2 to the precision of float32 beyond 8 sigma; only the samples near the edge need it.
    near = np.abs(distance) < 8.0
    share = (distance > 0.0).astype(np.float64)
    share[near] = 0.5 * _erfc(-distance[near] / math.sqrt(2.0)).astype(np.float64)
    return Target((low + (high - low) * share).astype(np.float32), 1.0)


@checked
def sine(*, cycles: float, size: tuple[int, int] = (512, 512), mean: float = 5.0, amplitude: float = 1.0,
         angle: quantities.Value = 0) -> Target:
    """A sine of that many cycles over the width, along `angle` from +x to +y. `size` is (rows, columns) in samples."""
    y, x = _grid(size)
    if not math.isfinite(cycles):
        raise UsageError(f"cycles: {cycles} is not finite")
    direction = math.radians(quantities.angle_deg(angle))
    phase = 2.0 * np.pi * cycles / size[1] * (math.cos(direction) * x + math.sin(direction) * y)
    return Target((mean + amplitude * np.cos(phase)).astype(np.float32))


@checked
def points(places: list[tuple[int, int]], *, size: tuple[int, int] = (512, 512), background: float = 0.0,
           peak: float = 1.0) -> Target:
    """Single samples of `peak` at these places (column, row) on a background."""
    values = np.full(quantities.plane_shape(size, "size"), background, dtype=np.float32)
    if not isinstance(places, (list, tuple, np.ndarray)):
        raise UsageError(f"places: {quantities.shown(places)} is no list of (column, row)")
    for place in places:
        if not isinstance(place, (list, tuple, np.ndarray)) or len(place) != 2 or not all(
                isinstance(one, (int, np.integer)) for one in place) or not (0 <= place[0] < size[1] and 0 <= place[1] < size[0]):
            raise UsageError(f"places: {place!r} is no (column, row) of a scene of the size {size}")
        values[place[1], place[0]] = peak
    return Target(values)
