# SPDX-License-Identifier: Apache-2.0
"""What a simulation made."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, results
from mtfkit.errors import UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.canvas import Canvas
    from mtfkit.images import Plane
    from mtfkit.sensors import Sensor


class Run:
    """What a simulation made, how exactly, and how fast.

    `image` is the first plane of the first image, float32 (rows, columns), which belongs to you. `frames` has the numbers
    of the images of a sequence, `images` their first planes.
    """

    def __init__(self, run: _core.SimulateRun, seconds: float, sensor: Sensor, canvas: Canvas | None = None) -> None:
        self._run = run
        self._made: list[tuple[int, dict[str, Plane]]] = run.images
        self._canvas = canvas
        scene, out = run.scene_um, run.pitch_um
        per_pixel = (out[0] / scene[0] + 1.0) * (out[1] / scene[1] + 1.0)
        self._table_error = sensor._table_error(per_pixel)
        self.seconds = seconds  #: wall time of the whole call

    @property
    def image(self) -> Plane:
        """The first plane of the first image: float32 (rows, columns) in `unit`."""
        return self.planes[self.names[0]]

    @property
    def planes(self) -> dict[str, Plane]:
        """The planes of the first image, by name. Raises UsageError where a file has taken them."""
        if not self._made:
            raise UsageError("the image was written to a file; read that")
        return self._made[0][1]

    @property
    def names(self) -> list[str]:
        """Names of the planes: "Y", or "R", "G", "B", or those of the scene."""
        return self._run.names

    @property
    def frames(self) -> list[int]:
        """Numbers of the frames, in the order of `images`."""
        return [frame for frame, _ in self._made]

    @property
    def images(self) -> list[Plane]:
        """The first plane of every image of a sequence."""
        return [planes[self.names[0]] for _, planes in self._made]

    @property
    def promised(self) -> float:
        """The rms error predicted before anything ran, as a share of the scene's standard deviation; it is kept."""
        promised = self._run.promised + self._table_error
        return promised if self._canvas is None else self._canvas.promise(promised)

    @property
    def tolerance(self) -> float:
        """The tolerance that was kept to."""
        return self._run.tolerance

    @property
    def quantity(self) -> str:
        """What the values are: "radiance", "electrons", "counts", ..."""
        return self._run.quantity

    @property
    def unit(self) -> str:
        """Unit of the values."""
        return self._run.unit

    @property
    def warnings(self) -> list[str]:
        """Reasons to doubt the result, a sentence each."""
        return self._run.warnings

    @property
    def notes(self) -> list[str]:
        """What was done, a sentence each."""
        return self._run.notes

    @property
    def report(self) -> dict[str, Any]:
        """The report of `mtf simulate --report`: plan, timing, provenance."""
        report: dict[str, Any] = json.loads(self._run.report)
        return report

    def explain(self) -> results.Text:
        """What the plan dropped, merged, chose and rejected, and the predicted error in its parts."""
        return results.Text(self._run.explain())

    def map_points(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Places in the scene as places in the image: labels follow the resampled image.

        `points` has the shape (count, 2), x (column) and y (row) of each; the centre of the first sample, and of the first
        pixel, is at (0, 0). Scene and image share their outer corner. Distortion is followed; a region (`roi`) counts
        from its own first pixel.
        """
        return self._run.map_points(np.asarray(points, dtype=np.float64))

    def save(self, path: str | os.PathLike[str], *, image: int = 0, range: tuple[float, float] | None = None) -> None:
        """Writes an image with its provenance, as `mtf simulate -o`: OpenEXR, or PNG and TIFF with `range`."""
        if self._canvas is not None:
            raise UsageError("save: the sensor has a component made of a general function, which no file can state; "
                             "mtfkit.write writes the pixels")
        self._run.save(image, os.fspath(path), range)

    def to_xarray(self) -> Any:
        """A DataArray of the image with the dimensions (y, x) in mm at the focal plane; `attrs["units"]`."""
        image = self.image
        pitch_x, pitch_y = self._run.pitch_um
        array = results.xarray("Run.to_xarray").DataArray(
            image, dims=("y", "x"), name=self.quantity,
            coords={"y": (np.arange(image.shape[0]) + 0.5) * pitch_y * 1e-3,
                    "x": (np.arange(image.shape[1]) + 0.5) * pitch_x * 1e-3})
        array.attrs.update(units=self.unit, promised=self.promised)
        for axis in ("x", "y"):
            array.coords[axis].attrs["units"] = "mm"
        return array

    def __array__(self, dtype: npt.DTypeLike | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.image, dtype=dtype)

    def __repr__(self) -> str:
        what = f"{len(self.frames)} images" if self._made else "written"
        return (f"<Run: {what}, {self.quantity} [{self.unit}], promised error {self.promised:.2g}, "
                f"{self.seconds:.3g} s>")

    def _repr_html_(self) -> str:
        return self.explain()._repr_html_()
