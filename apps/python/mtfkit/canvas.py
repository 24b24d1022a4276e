# SPDX-License-Identifier: Apache-2.0
"""Scenes behind components made of general functions: filtered before everything of the sensor."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, functions
from mtfkit.errors import DataError, UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.sensors import Sensor

    Floats = npt.NDArray[np.float64]
    Plane = npt.NDArray[np.float32]
    Otf = Callable[[Floats, Floats], npt.NDArray[np.complex128]]


def _blocks(count: int, length: int) -> Iterator[slice]:
    """Parts of `count` lines of that length, small enough that Ctrl-C is heard between them."""
    lines = max(1, 2 ** 19 // length)
    for first in range(0, count, lines):
        _core.require_going_on()
        yield slice(first, min(first + lines, count))


def _filtered(plane: Floats, otf: npt.NDArray[np.complex128]) -> Floats:
    """The plane filtered: numpy's irfft2(rfft2(plane) * otf), line by line."""
    rows, columns = plane.shape
    spectrum, filtered = np.empty(otf.shape, dtype=np.complex128), np.empty(plane.shape)
    for some in _blocks(rows, columns):
        spectrum[some] = np.fft.rfft(plane[some])
    for some in _blocks(otf.shape[1], rows):
        spectrum[:, some] = np.fft.ifft(np.fft.fft(spectrum[:, some], axis=0) * otf[:, some], axis=0)
    for some in _blocks(rows, columns):
        filtered[some] = np.fft.irfft(spectrum[some], columns)
    return filtered


class Canvas:
    """Makes of a scene a canvas that repeats, the scene and its mirror images, behind the functions.

    The mirrored scene is filtered as a whole, in double precision, so that OTFs with phase keep their exact meaning. The
    rest of the sensor takes the canvas as a scene that repeats; the image is that of its first quarter.
    """

    def __init__(self, sensor: Sensor, sample: tuple[str, str] | None) -> None:
        tables = tomllib.loads(sensor.text)
        self._border = tables.get("scene", {}).get("border", "reflect")
        if self._border not in ("reflect", "periodic"):
            raise UsageError(f"scene.border: \"{self._border}\" does not go with a component made of a general function; take "
                             "reflect or periodic")
        if "distortion" in tables:
            raise UsageError("distortion: does not go with a component made of a general function, which acts on the scene "
                             "before it")
        self._step_um = _core.sample_um(sensor._file, sample)
        self._sensor = sensor
        self._otfs: dict[tuple[int, ...], npt.NDArray[np.complex128]] = {}
        self._parts: list[tuple[float, float]] = []  # of the scenes that were filtered: see promise()

    def _product(self, x: Floats, y: Floats) -> npt.NDArray[np.complex128]:
        return functions.product(self._sensor._file, self._sensor._functions, x, y, "cy/mm")

    def _otf(self, shape: tuple[int, ...]) -> npt.NDArray[np.complex128]:
        if shape in self._otfs:
            return self._otfs[shape]
        fy = np.fft.fftfreq(shape[0], self._step_um[1] * 1e-3)
        fx = np.fft.rfftfreq(shape[1], self._step_um[0] * 1e-3)
        x, y = np.broadcast_arrays(fx[None, :], fy[:, None])
        values = np.empty(x.shape, dtype=np.complex128)
        for some in _blocks(*x.shape):
            values[some] = self._product(x[some], y[some])
        if shape[1] % 2 == 0:  # the highest frequency stands for both of its signs: the mean of both
            values[:, -1] = 0.5 * (values[:, -1] + self._product(-x[:, -1], y[:, -1]))
        if shape[0] % 2 == 0:
            row = shape[0] // 2
            values[row] = 0.5 * (values[row] + self._product(x[row], -y[row]))
        self._otfs = {shape: values}
        return values

    def of(self, scene: npt.NDArray[Any]) -> tuple[Plane, tuple[float, float]]:
        """The canvas of a scene, and what its promise is made of."""
        plane = scene.astype(np.float64)
        if not np.isfinite(plane).all():
            row, column = np.argwhere(~np.isfinite(plane))[0]
            raise DataError(f"scene: {np.count_nonzero(~np.isfinite(plane))} values are NaN or infinite, the first at column "
                            f"{column}, row {row}; a component made of a general function needs all")
        canvas = plane if self._border == "periodic" else np.block([[plane, plane[:, ::-1]], [plane[::-1], plane[::-1, ::-1]]])
        mean = float(canvas.mean())
        filtered = mean + _filtered(canvas - mean, self._otf(canvas.shape))
        rounded = filtered.astype(np.float32)
        spread = float(plane.std())
        if spread == 0.0:
            return rounded, (1.0, 0.0)
        return rounded, (float(rounded.std(dtype=np.float64)) / spread, 2.0 ** -24 * float(np.abs(filtered).max()) / spread)

    def size_of(self, shape: tuple[int, int]) -> tuple[int, int]:
        """The shape of the canvas of a scene of that shape."""
        return shape if self._border == "periodic" else (2 * shape[0], 2 * shape[1])

    def serves(self, sensor: Sensor) -> bool:
        """Whether the functions of that sensor are the same on the same grid."""
        return sensor._functions == self._sensor._functions and functions.same_units(sensor._file, self._sensor._file)

    def __call__(self, scene: Plane) -> Plane:
        """The canvas; `promise` counts the scene."""
        canvas, part = self.of(scene)
        self._parts.append(part)
        return canvas

    def begin(self) -> None:
        """The promise is about what is filtered from now on."""
        self._parts = []

    def promise(self, promised: float) -> float:
        """A promise about canvases as one about their scenes, with the rounding of the canvas to float32. That an image is a
        part of its canvas is in the promise."""
        return max((promised * ratio + 2.0 * rounding for ratio, rounding in self._parts), default=promised)

    def sensor_for(self, sensor: Sensor, shape: tuple[int, ...], sample: tuple[str, str] | None) -> _core.SensorFile:
        """The sensor as it takes canvases of scenes of that shape."""
        return _core.canvas_sensor(sensor._file, shape[1], shape[0], sample)
