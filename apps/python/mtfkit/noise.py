# SPDX-License-Identifier: Apache-2.0
"""Noise by counter: each number is a function of seed, frame and pixel, whatever region or number of threads makes it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mtfkit import _core, quantities
from mtfkit.arguments import checked

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.images import Plane

__all__ = ["gaussian", "shot"]


@checked
def gaussian(shape: tuple[int, int], *, sd: float, seed: int = 0, frame: int = 0, origin: tuple[int, int] = (0, 0),
             threads: int = 1) -> Plane:
    """Normal numbers of that standard deviation: float32 of `shape`, (rows, columns).

    They are those of the read noise of a sensor with that seed. `origin` is the place (column, row) of the first pixel
    on the detector: a region has the numbers of its pixels. Raises UsageError for a negative `sd` or `frame`.

    >>> import mtfkit as mk
    >>> whole = mk.noise.gaussian((4, 6), sd=1.0, seed=3)
    >>> (mk.noise.gaussian((2, 3), sd=1.0, seed=3, origin=(1, 2)) == whole[2:, 1:4]).all()
    True
    """
    rows, columns = quantities.plane_shape(shape, "shape")
    quantities.count(frame, "frame", 0)
    quantities.seed(seed)
    return _core.gaussian_noise(rows, columns, sd, seed, frame, origin[0], origin[1], quantities.thread_count(threads))


@checked
def shot(mean: npt.ArrayLike, *, seed: int = 0, frame: int = 0, origin: tuple[int, int] = (0, 0), threads: int = 1) -> Plane:
    """Poisson numbers of these mean electrons, exact for any mean: float32 of the same shape.

    A mean below 0 counts as 0, NaN stays NaN. They are those of the shot noise of a sensor with that seed.
    """
    quantities.count(frame, "frame", 0)
    quantities.seed(seed)
    return _core.shot_noise(mean, seed, frame, origin[0], origin[1], quantities.thread_count(threads))
