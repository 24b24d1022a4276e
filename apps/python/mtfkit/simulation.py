# SPDX-License-Identifier: Apache-2.0
"""Images of a sensor: one run, and plans for many."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.errors import UsageError
from mtfkit.images import Image
from mtfkit.targets import Target

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.custom import Canvas
    from mtfkit.images import Plane
    from mtfkit.sensors import Sensor

    #: A file, an Image, a target, a 2-D array of physical values, or planes by name.
    SceneLike = Union[str, "os.PathLike[str]", Image, Target, npt.ArrayLike, Mapping[str, npt.ArrayLike]]


class Run:
    """What a simulation made, how exactly, and how fast.

    `image` is the first plane of the first image, float32 (rows, columns), which belongs to you. `frames` has the numbers
    of the images of a sequence, `images` their first planes.
    """

    def __init__(self, run: _core.SimulateRun, seconds: float, sensor: Sensor, canvas: Canvas | None = None) -> None:
        self._run = run
        self._made: list[tuple[int, dict[str, Plane]]] = (
            run.images if canvas is None else canvas.cropped(run.images, run.pitch_um))
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


class Plan:
    """A sensor compiled for scenes of one size. Calling it gives the image of a scene.

    Plans of sensors without [detector] never change and may be called from several threads at once. Those with
    [detector] run the whole chain; they make one image at a time, and frames of detectors that remember (lag, rolling
    shutter) have to rise.
    """

    def __init__(self, sensor: Sensor, plan: _core.LinearPlan | _core.ChainPlan) -> None:
        self._sensor = sensor
        self._plan = plan

    @property
    def sensor(self) -> Sensor:
        """The sensor that the plan was made for."""
        return self._sensor

    def __call__(self, scene: npt.ArrayLike, *, out: Plane | None = None, frame: int = 0, threads: int = 0) -> Plane:
        """The image: float32 (rows, columns).

        `scene` is a 2-D array; float32 with its rows in order is read where it lies, anything else is converted once.
        With `out`, float32 of the image's shape, no memory is allocated, and `out` is returned; it may be the scene's own
        memory. `frame` chooses the noise of a sensor with [detector], whose threads are those that `compile` got. Raises
        DataError for NaN and infinite values, with their number and first place.
        """
        if isinstance(self._plan, _core.LinearPlan):
            return self._plan.run(scene, out, threads)
        return self._plan.run(scene, out, frame)

    def replace(self, sensor: Sensor) -> Plan:
        """The plan of another sensor on the same scene grid, for little of the time: what has not changed is shared."""
        if isinstance(self._plan, _core.LinearPlan):
            return Plan(sensor, self._plan.replaced(sensor._file))
        self._plan.set_sensor(sensor._file)
        return Plan(sensor, self._plan)

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns) of the image. Of a sensor with [detector] known after the first image."""
        width, height, _, _ = self._plan.grid
        return height, width

    @property
    def promised(self) -> float:
        """The predicted rms error as a share of the scene's standard deviation."""
        if not isinstance(self._plan, _core.LinearPlan):
            return self._plan.promised
        (_, _, x, y), (_, _, out_x, out_y) = self._plan.scene_grid, self._plan.grid
        return self._plan.promised + self._sensor._table_error((out_x / x + 1.0) * (out_y / y + 1.0))

    @property
    def warnings(self) -> list[str]:
        """Reasons to doubt the result."""
        return self._plan.warnings

    def explain(self) -> results.Text:
        """What was dropped, merged, chosen and rejected, and the predicted error in its parts."""
        if isinstance(self._plan, _core.LinearPlan):
            return results.Text(self._plan.explain())
        return self._sensor.explain()

    def __repr__(self) -> str:
        return f"<Plan of {self._sensor!r}>"

    def _repr_html_(self) -> str:
        return self.explain()._repr_html_()


def _is_shape(scene: object) -> bool:
    return isinstance(scene, tuple) and len(scene) == 2 and all(isinstance(n, (int, np.integer)) for n in scene)


def compile_plan(sensor: Sensor, scene: npt.ArrayLike | tuple[int, int], *, sample: quantities.Value,
                 quantity: str | None, tolerance: float | None, stage: str | None, rigor: str, threads: int) -> Plan:
    """`Sensor.compile`."""
    if sensor._functions:
        raise UsageError("compile: a component made of a general function runs in simulate; radial functions and products of "
                         "x and y compile")
    words = quantities.sample_words(sample)
    if sensor._file.has_chain:
        return Plan(sensor, _core.ChainPlan(sensor._file, words, quantity or sensor._file.quantity or "radiance", tolerance,
                                            stage, threads))
    if stage is not None:
        raise UsageError("stage: belongs to the chain of a sensor with [detector], which this one does not have")
    if _is_shape(scene):
        plane = None
        rows, columns = (int(n) for n in scene)  # type: ignore[union-attr,arg-type]
        if rows < 1 or columns < 1:
            raise UsageError(f"scene: the shape ({rows}, {columns}) has no samples")
    else:
        plane = np.asanyarray(scene)
        if plane.ndim != 2:
            raise UsageError(f"scene: has the shape {plane.shape}; give a plane of (rows, columns), or a shape")
        rows, columns = plane.shape
    return Plan(sensor, _core.LinearPlan(sensor._file, columns, rows, words, plane, tolerance, _measure(rigor), threads))


def _measure(rigor: str) -> bool:
    if rigor not in ("estimate", "measure"):
        raise UsageError(f"rigor: {rigor!r} is not known (one of estimate, measure)")
    return rigor == "measure"


def _frame_range(frames: Iterable[int]) -> tuple[int, int, int]:
    numbers = [int(frame) for frame in frames]
    if not numbers:
        raise UsageError("frames: is empty")
    step = numbers[1] - numbers[0] if len(numbers) > 1 else 1
    if step < 1 or numbers != list(range(numbers[0], numbers[-1] + 1, step)):
        raise UsageError("frames: rise by one step, as a range does")
    return numbers[0], numbers[-1], step


def _scene_words(sensor: Sensor, scene: SceneLike, sample: quantities.Value, quantity: str | None,
                 beside: Mapping[str, npt.ArrayLike] | None, periodic: bool) -> _core.SceneWords:
    planes: list[tuple[str, Any]] = []
    path, image, blur = "", None, 0.0
    if isinstance(scene, (str, os.PathLike)):
        path = os.fspath(scene)
    elif isinstance(scene, Image):
        image = scene._file
    elif isinstance(scene, Target):
        sample = "0.125 px" if sample is None else sample
        planes, blur = [("Y", scene.values)], scene.blur_samples
    elif isinstance(scene, Mapping):
        planes = list(scene.items())
        if not planes:
            raise UsageError("scene: is a dictionary without planes")
    else:
        planes = [("Y", scene)]
    if not planes and (sample is not None or quantity is not None):
        raise UsageError("sample and quantity are for arrays; a file says its own, or [scene] of the sensor does")
    return _core.SceneWords(path, image, planes, list((beside or {}).items()), quantities.sample_words(sample),
                            quantity or sensor._file.quantity or "radiance", blur, periodic)


def run_simulation(sensor: Sensor, scene: SceneLike, *, sample: quantities.Value, quantity: str | None,
                   beside: Mapping[str, npt.ArrayLike] | None, tolerance: float | None, nan: str, stage: str | None,
                   frame: int, frames: Iterable[int] | None,
                   schedule: str | os.PathLike[str] | Sequence[tuple[int, str, quantities.Value]] | None,
                   roi: tuple[int, int, int, int] | None, memory: int | None, rigor: str,
                   out: str | os.PathLike[str] | None, range: tuple[float, float] | None, threads: int,
                   progress: Any) -> Run:
    """`Sensor.simulate`."""
    canvas = sensor._canvas(scene, sample) if sensor._functions else None
    if canvas is not None:
        sample = "0.125 px" if sample is None and isinstance(scene, Target) else sample
        if roi is not None or memory is not None or out is not None:
            raise UsageError("roi, memory and out: do not go with a component made of a general function; take the part of "
                             "the image, or save the run")
        scene = canvas.scene
    words = _scene_words(sensor, scene, sample, quantity, beside, canvas is not None)
    if frame != 0 and frames is not None:
        raise UsageError("frame and frames exclude each other; give one")
    span = _frame_range(frames) if frames is not None else (int(frame), int(frame), 1) if frame != 0 else None
    start = time.perf_counter()
    with _folder_for(schedule) as folder:
        file = _schedule_file(schedule, folder)
        run = _core.simulate(sensor._file, words, tolerance, nan, _measure(rigor), stage, roi, memory, span, file,
                             os.fspath(out) if out is not None else "", range, threads, progress)
    return Run(run, time.perf_counter() - start, sensor, canvas)


class _NoFolder:
    def __enter__(self) -> str:
        return ""

    def __exit__(self, *_: object) -> None:
        pass


def _folder_for(schedule: object) -> Any:
    """Where lines that are no file yet are written."""
    if schedule is None or isinstance(schedule, (str, os.PathLike)):
        return _NoFolder()
    import tempfile

    return tempfile.TemporaryDirectory(prefix="mtfkit-")


def _schedule_file(schedule: str | os.PathLike[str] | Sequence[tuple[int, str, quantities.Value]] | None,
                   folder: str) -> str:
    if schedule is None:
        return ""
    if isinstance(schedule, (str, os.PathLike)):
        return os.fspath(schedule)
    import csv

    path = os.path.join(folder, "schedule.csv")
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["frame", "parameter", "value"])
        for line in schedule:
            if len(line) != 3:
                raise UsageError(f"schedule: {line!r} is not (frame, parameter, value)")
            writer.writerow([line[0], line[1], quantities.words(line[2], line[1])])
    return path
