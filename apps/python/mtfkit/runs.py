# SPDX-License-Identifier: Apache-2.0
"""What a simulation made."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.arguments import checked
from mtfkit.errors import UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.canvas import Canvas
    from mtfkit.images import Plane
    from mtfkit.sensors import Sensor


@dataclass(frozen=True, eq=False)
class KeptRun:
    """What a simulation made, by its values: as _core.SimulateRun, for pickle."""

    images: list[tuple[int, dict[str, Plane]]]
    names: list[str]
    report: str
    tolerance: float
    quantity: str
    unit: str
    warnings: list[str]
    notes: list[str]
    image_grid: tuple[int, int, float, float]
    scene_grid: tuple[int, int, float, float]
    region: list[int] | None
    metadata: list[tuple[Any, ...]]
    text: str

    def explain(self) -> str:
        """The plan in words."""
        return self.text


class Run(results.ByValue):
    """What a simulation made, how exactly, and how fast.

    `image` is the image of a run that made one with one plane, float32 (rows, columns), which belongs to you. `frames` has
    the numbers of the images of a sequence, `images` their planes. Runs pickle with their images and their sensor; two are
    equal when images, names, units, promise and warnings are.
    """

    def __init__(self, run: _core.SimulateRun | KeptRun, seconds: float, sensor: Sensor, promised: float, stage: str | None,
                 writable: bool = True) -> None:
        self._run = run
        self._made: list[tuple[int, dict[str, Plane]]] = run.images
        self._report = run.report  # now: it has the memory of the process
        self._sensor = sensor
        self._promised = promised
        self._stage = stage
        self._writable = writable  # by a sensor file
        self.seconds = seconds  #: wall time of the whole call

    @classmethod
    def _of(cls, run: _core.SimulateRun, seconds: float, sensor: Sensor, canvas: Canvas | None, stage: str | None) -> Run:
        (_, _, *scene), (_, _, *image) = run.scene_grid, run.image_grid
        promised = run.promised + sensor._table_error((image[0] / scene[0] + 1.0) * (image[1] / scene[1] + 1.0))
        return cls(run, seconds, sensor, promised if canvas is None else canvas.promise(promised), stage, canvas is None)

    def _values(self) -> Any:
        return {"images": self._made, "what": (self.names, self.quantity, self.unit, self.promised, self.tolerance, self.warnings)}

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        run = self._run
        if not isinstance(run, KeptRun):
            run = KeptRun(run.images, run.names, self._report, run.tolerance, run.quantity, run.unit, run.warnings, run.notes,
                          run.image_grid, run.scene_grid, run.region, run.metadata, run.explain())
        return Run, (run, self.seconds, self._sensor, self._promised, self._stage, self._writable)

    @property
    def image(self) -> Plane:
        """The image of a run that made one, of one plane: float32 (rows, columns) in `unit`.

        Raises UsageError where there are several frames, which `images` has, or several planes, which `planes` has.
        """
        if len(self._made) > 1:
            raise UsageError(f"image: the run made the frames {_shortened(self.frames)}; take run.images[number], one after the "
                             "other")
        if len(self.names) > 1:
            raise UsageError(f"image: has the planes {', '.join(self.names)}; take run.planes[\"{self.names[0]}\"], or all")
        return self.planes[self.names[0]]

    @property
    def planes(self) -> dict[str, Plane]:
        """The planes of the only image, by name. Raises UsageError for a sequence, and where a file has taken them."""
        if not self._made:
            raise UsageError("the image was written to a file; read that")
        if len(self._made) > 1:
            raise UsageError(f"planes: the run made the frames {_shortened(self.frames)}; take run.plane(name, frame)")
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
        """Every image of a sequence. Raises UsageError where images have several planes: see `plane`."""
        if len(self.names) > 1:
            raise UsageError(f"images: have the planes {', '.join(self.names)}; take run.plane(\"{self.names[0]}\", frame)")
        return [planes[self.names[0]] for _, planes in self._made]

    @checked
    def plane(self, name: str, frame: int | None = None) -> Plane:
        """A plane by its name, of the frame of that number; without it of the only image."""
        if frame is None and len(self._made) > 1:
            raise UsageError(f"frame: the run made the frames {_shortened(self.frames)}; name one of them")
        if frame is not None and frame not in self.frames:
            raise UsageError(f"frame: {frame!r} is not among those that the run made and has, {_shortened(self.frames)}")
        planes = self.planes if frame is None else self._made[self.frames.index(frame)][1]
        if name not in planes:
            raise UsageError(f"name: there is no plane {name!r}; there are {', '.join(planes)}")
        return planes[name]

    @property
    def promised(self) -> float:
        """The rms error predicted before anything ran, as a share of the scene's standard deviation; it is kept."""
        return self._promised

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
        report: dict[str, Any] = json.loads(self._report)
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
        return _core.map_points(self._sensor._file, self._run.scene_grid, self._run.image_grid, self._run.region,
                                quantities.numbers(points, "points"))

    @checked
    def save(self, path: str | os.PathLike[str], *, image: int = 0, range: tuple[float, float] | None = None) -> None:
        """Writes an image with its provenance, as `mtf simulate -o`: OpenEXR, ENVI, or PNG and TIFF with `range`."""
        if not self._writable:
            raise UsageError("save: the sensor has a component made of a general function, which no file can state; "
                             "mtfkit.write writes the pixels")
        if not 0 <= quantities.whole(image, "image") < len(self._made):
            raise UsageError(f"image: {image} is not among the {len(self._made)} that the run has in memory, counted from 0")
        _core.save_image(self._sensor._file, self._stage, self._made[image][1], self._run.metadata[image],
                         quantities.path(path, "path"), quantities.value_range(range))

    def to_xarray(self) -> Any:
        """A DataArray of the image with the dimensions (y, x) in mm at the focal plane; `attrs["units"]`."""
        image = self.image
        _, _, pitch_x, pitch_y = self._run.image_grid
        array = results.xarray("Run.to_xarray").DataArray(
            image, dims=("y", "x"), name=self.quantity,
            coords={"y": (np.arange(image.shape[0]) + 0.5) * pitch_y * 1e-3,
                    "x": (np.arange(image.shape[1]) + 0.5) * pitch_x * 1e-3})
        array.attrs.update(units=self.unit, promised=self.promised)
        for axis in ("x", "y"):
            array.coords[axis].attrs["units"] = "mm"
        return array

    def plot(self, axes: Any = None) -> Any:
        """Shows the image in grey from its least to its largest value, with a scale in `unit`, with matplotlib.

        In the `axes` given, else in new ones; returns them. Raises as `image` does, and MissingLibrary, an ImportError, without
        matplotlib.
        """
        image = self.image
        axes = results.axes_for("Run.plot", axes)
        shown = axes.imshow(image, cmap="gray")
        axes.figure.colorbar(shown, ax=axes, label=f"{self.quantity} [{self.unit}]")
        axes.set(xlabel="x [px]", ylabel="y [px]")
        return axes

    def __array__(self, dtype: npt.DTypeLike | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.image, dtype=dtype)

    def __repr__(self) -> str:
        what = f"{len(self.frames)} images" if self._made else "written"
        return (f"<Run: {what}, {self.quantity} [{self.unit}], promised error {self.promised:.2g}, "
                f"{self.seconds:.3g} s>")

    def _repr_html_(self) -> str:
        return self.explain()._repr_html_()


def _shortened(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers)) if len(numbers) <= 4 else f"{numbers[0]}, {numbers[1]}, ... {numbers[-1]}"
