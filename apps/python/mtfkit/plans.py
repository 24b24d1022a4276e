# SPDX-License-Identifier: Apache-2.0
"""Plans: a sensor compiled for many scenes of one size."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.arguments import checked
from mtfkit.canvas import Canvas
from mtfkit.errors import UsageError
from mtfkit.images import SpacedPlane, same_um, sample_of, stated_um

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.images import Plane
    from mtfkit.sensors import Sensor


class Plan:
    """A sensor compiled for scenes of one size. Calling it gives the image of a scene.

    Plans of sensors without [detector] never change and may be called from several threads at once. Those with
    [detector] run the whole chain; they make one image at a time, and frames of detectors that remember (lag, rolling
    shutter) have to rise. A plan pickles as what it was compiled from, and is compiled anew where it arrives.
    """

    def __init__(self, sensor: Sensor, plan: _core.LinearPlan | _core.ChainPlan, file: _core.SensorFile, shape: tuple[int, int],
                 sample: tuple[str, str] | None, canvas: Canvas | None, request: Mapping[str, Any], seconds: float) -> None:
        self._sensor = sensor
        self._plan = plan
        self._file = file  # of the sensor, as the plan takes it
        self._scene_shape = shape
        self._sample = sample
        self._canvas = canvas
        self._request = request  # what `compile` was asked for
        self.seconds = seconds  #: wall time of its making

    @property
    def sensor(self) -> Sensor:
        """The sensor that the plan was made for."""
        return self._sensor

    @checked
    def __call__(self, scene: npt.ArrayLike, *, out: Plane | None = None, frame: int = 0, threads: int = 0) -> Plane:
        """The image: float32 (rows, columns).

        `scene` is a 2-D array; float32 with its rows in order is read where it lies, anything else is converted once.
        With `out`, float32 of the image's shape, no memory is allocated, and `out` is returned; it may be the scene's own
        memory. `frame` chooses the noise of a sensor with [detector], whose threads are those that `compile` got. Raises
        DataError for NaN and infinite values, with their number and first place.
        """
        self._require_spacing(scene)
        if isinstance(self._plan, _core.LinearPlan):
            if self._canvas is not None:
                plane = _core.plane(scene, "scene")
                if plane.shape != self._scene_shape:
                    raise UsageError(f"scene: has the shape {plane.shape}, the plan is for {self._scene_shape}")
                scene = self._canvas.of(plane)[0]
            return self._plan.run(scene, out, quantities.thread_count(threads))
        if self._canvas is not None:
            self._canvas.begin()
        return self._plan.run(self._file, scene, out, frame)

    def _require_spacing(self, scene: object) -> None:
        if not isinstance(scene, SpacedPlane) or not scene.sample or scene.sample == self._sample:
            return
        ours, theirs = _core.sample_um(self._file, self._sample), stated_um(scene.sample)
        if not same_um(ours, theirs):
            raise UsageError("scene: states a spacing of {:.6g} x {:.6g} um, the plan is for {:.6g} x {:.6g} um; compile a plan "
                             "for it, or give numpy.asarray(scene) for its values alone".format(*theirs, *ours))

    @checked
    def replace(self, sensor: Sensor) -> Plan:
        """The plan of another sensor on the same scene grid, for little of the time: what has not changed is shared."""
        start = time.perf_counter()
        plan, canvas, file = self._plan, self._canvas, sensor._file
        if (canvas is None) != (not sensor._functions) or isinstance(plan, _core.ChainPlan) != file.has_chain or (
                canvas is not None and isinstance(plan, _core.ChainPlan) and not canvas.serves(sensor)):
            raise UsageError("replace: the plan is of a sensor with another kind of chain; compile this one")
        if canvas is not None:
            canvas = canvas if canvas.serves(sensor) else Canvas(sensor, self._sample)
            file = canvas.sensor_for(sensor, self._scene_shape, self._sample)
        if isinstance(plan, _core.LinearPlan):
            plan = plan.replaced(file)
        return Plan(sensor, plan, file, self._scene_shape, self._sample, canvas, self._request, time.perf_counter() - start)

    def __reduce__(self) -> tuple[Any, ...]:
        """Elsewhere it is compiled again, for the scene or shape that it was compiled for."""
        return _compiled_again, (self._sensor, dict(self._request))

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns) of the image. Of a sensor with [detector] known after the first image."""
        width, height, _, _ = self._plan.grid
        return height, width

    @property
    def promised(self) -> float:
        """The predicted rms error as a share of the scene's standard deviation; of a sensor with [detector] known after the
        first image."""
        (scene_x, scene_y), (_, _, x, y) = _core.sample_um(self._sensor._file, self._sample), self._plan.grid
        promised = self._plan.promised + self._sensor._table_error((x / scene_x + 1.0) * (y / scene_y + 1.0))
        return promised if self._canvas is None else self._canvas.promise(promised)

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
                 quantity: str | None, tolerance: float | None, stage: str | None, rigor: str, device: str,
                 threads: int) -> Plan:
    """`Sensor.compile`."""
    start, sample = time.perf_counter(), sample_of([scene], sample)
    words, measure, threads = quantities.sample_words(sample), is_measured(rigor), quantities.thread_count(threads)
    plane = typical = None if _is_shape(scene) else _core.plane(scene, "scene")
    rows, columns = plane.shape if plane is not None else (int(n) for n in scene)  # type: ignore[union-attr,arg-type]
    if rows < 1 or columns < 1:
        raise UsageError(f"scene: the shape ({rows}, {columns}) has no samples")
    canvas, file = None, sensor._file
    if sensor._functions:
        canvas = Canvas(sensor, words)
        file = canvas.sensor_for(sensor, (rows, columns), words)
    plan: _core.LinearPlan | _core.ChainPlan
    if file.has_chain:
        plan = _core.ChainPlan(words, quantity or file.quantity or "radiance", tolerance, stage, canvas, device, threads)
    elif stage is not None:
        raise UsageError("stage: belongs to the chain of a sensor with [detector], which this one does not have")
    else:
        if canvas is not None:
            plane = None if plane is None else canvas(plane)
        height, width = canvas.size_of((rows, columns)) if canvas is not None else (rows, columns)
        plan = _core.LinearPlan(file, width, height, words, plane, tolerance, measure, device, threads)
    request = dict(scene=(rows, columns) if file.has_chain or typical is None else typical, sample=sample,
                   quantity=quantity, tolerance=tolerance, stage=stage, rigor=rigor, device=device, threads=threads)
    return Plan(sensor, plan, file, (rows, columns), words, canvas, request, time.perf_counter() - start)


def _compiled_again(sensor: Sensor, request: dict[str, Any]) -> Plan:
    return compile_plan(sensor, **request)


def devices() -> list[dict[str, Any]]:
    """Graphics cards and other devices that may filter images, each opened and tested, as `mtf devices --format json`.

    Each has `id`, `name`, `vendor`, `driver`, `backend`, `memory_bytes`, `cpu` and `admitted`; one that is admitted its
    `rms_error` and times of filters [ms] and transfers, another one the `reason`.
    """
    return list(json.loads(_core.devices())["devices"])


def is_measured(rigor: str) -> bool:
    """Whether plans are chosen by timing. Raises UsageError for an unknown word."""
    if rigor not in ("estimate", "measure"):
        raise UsageError(f"rigor: {rigor!r} is not known (one of estimate, measure)")
    return rigor == "measure"
