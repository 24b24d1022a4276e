# SPDX-License-Identifier: Apache-2.0
"""Images of a sensor: the call of `Sensor.simulate`."""

from __future__ import annotations

import os
import re
import time
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from mtfkit import _core, quantities
from mtfkit.arguments import checked
from mtfkit.canvas import Canvas
from mtfkit.errors import UsageError
from mtfkit.images import Image, sample_of
from mtfkit.messages import reworded
from mtfkit.plans import is_measured
from mtfkit.progress import function_of
from mtfkit.runs import Run
from mtfkit.targets import Target

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.sensors import Sensor

    #: A file, an Image, a target, a 2-D array of physical values, or planes by name.
    SceneLike = Union[str, "os.PathLike[str]", Image, Target, npt.ArrayLike, Mapping[str, npt.ArrayLike]]


def _frame_range(frames: Iterable[int]) -> tuple[int, int, int]:
    if isinstance(frames, range) and frames and frames[0] >= 0 and frames.step > 0:  # of any length, in no time
        return frames[0], frames[-1], frames.step
    numbers = [quantities.count(frame, "frames", 0) for frame in frames]
    if not numbers:
        raise UsageError("frames: is empty; give range(5) or numbers")
    step = numbers[1] - numbers[0] if len(numbers) > 1 else 1
    if step < 1 or numbers != list(range(numbers[0], numbers[-1] + 1, step)):
        raise UsageError("frames: rise by one step, as a range does")
    return numbers[0], numbers[-1], step


def _scene_words(sensor: Sensor, scene: SceneLike, sample: quantities.Value, quantity: str | None,
                 beside: Mapping[str, npt.ArrayLike] | None) -> _core.SceneWords:
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
        what = "an Image" if image is not None else f"the file {path}"
        plane = "image.plane()" if image is not None else f"mtfkit.read({path!r}).plane()"
        given = " and ".join(name for name, value in (("sample", sample), ("quantity", quantity)) if value is not None)
        raise UsageError(f"{given}: for arrays; {what} says its own, or [scene] of the sensor does. Give sensor.simulate({plane}, "
                         f"sample=..., quantity=...), or write a file that says it with mtfkit.write(path, image, sample=...)")
    quantity = quantity or sensor._file.quantity or "radiance"
    if quantity == "temperature" and sensor._file.has_chain:
        _warn_of_cold(planes)
    return _core.SceneWords(path, image, planes, list((beside or {}).items()), quantities.sample_words(sample), quantity, blur)


def _warn_of_cold(planes: list[tuple[str, Any]]) -> None:
    """Arrays have no unit: numbers that are all small may be differences of temperature, or degrees Celsius."""
    cold = 100.0
    for name, given in planes:
        plane = _core.plane(given, "scene" if len(planes) == 1 else f"scene: plane '{name}'")
        largest = np.max(plane, initial=-np.inf, where=np.isfinite(plane))
        if -np.inf < largest < cold:
            warnings.warn(f"scene: plane {name!r} was taken for temperatures in K, of {largest:.4g} K at most; for degrees Celsius "
                          "give plane + 273.15, for differences add the temperature of the background", stacklevel=6)


def _canvas(sensor: Sensor, scene: SceneLike, sample: quantities.Value,
            refused: Mapping[str, bool]) -> tuple[Canvas, _core.SensorFile]:
    """What filters the scene by the general functions of the sensor, and the sensor that takes what it makes."""
    for name, asked in refused.items():
        if asked:
            raise UsageError(f"{name}: does not go with a component made of a general function, "
                             f"\"{sensor._functions[0].label}\"")
    plane: Any
    if isinstance(scene, Target):
        sample, plane = "0.125 px" if sample is None else sample, scene.values
    elif isinstance(scene, (str, os.PathLike, Image)):
        raise UsageError("scene: a component made of a general function acts on arrays; read the file, and give its plane and "
                         "sample")
    else:
        plane = next(iter(scene.values()), scene) if isinstance(scene, Mapping) else scene
    words = quantities.sample_words(sample)
    canvas = Canvas(sensor, words)
    return canvas, canvas.sensor_for(sensor, _core.plane(plane, "scene").shape, words)


@checked
def run_simulation(sensor: Sensor, scene: SceneLike, *, sample: quantities.Value, quantity: str | None,
                   beside: Mapping[str, npt.ArrayLike] | None, tolerance: float | None, nan: str, stage: str | None,
                   frame: int, frames: Iterable[int] | None,
                   schedule: str | os.PathLike[str] | Sequence[tuple[int, str, quantities.Value]] | None,
                   roi: tuple[int, int, int, int] | None, memory: int | None, rigor: str,
                   out: str | os.PathLike[str] | None, range: tuple[float, float] | None, device: str, threads: int,
                   progress: Any) -> Run:
    """`Sensor.simulate`."""
    planes = scene.values() if isinstance(scene, Mapping) else [scene]
    given, sample = sample, sample_of(planes, sample)
    if given is None and sample is not None:
        sample_of([*planes, *(beside or {}).values()], None)  # what lies beside the scene has its spacing
    canvas, file = None, sensor._file
    if sensor._functions:
        canvas, file = _canvas(sensor, scene, sample, {
            "roi": roi is not None and not sensor._file.has_chain, "memory": memory is not None, "out": out is not None,
            "schedule": schedule is not None, "nan": nan == "propagate"})
    words = _scene_words(sensor, scene, sample, quantity, beside)
    if frame != 0 and frames is not None:
        raise UsageError("frame and frames exclude each other; give one")
    frame = quantities.count(frame, "frame", 0)
    if memory is not None and memory < 1 << 20:
        raise UsageError(f"memory: {memory} bytes are less than 1 MiB; give 512 << 20 for 512 MiB")
    span = _frame_range(frames) if frames is not None else (frame, frame, 1) if frame != 0 else None
    start, told = time.perf_counter(), function_of(progress, "simulating")
    if told is not None:
        told(0.0)
    with _folder_for(schedule) as folder, reworded(lambda text: _in_lines(text, folder)):
        run = _core.simulate(file, words, tolerance, nan, is_measured(rigor), stage, roi, memory, span,
                             _schedule_file(schedule, folder), os.fspath(out) if out is not None else "", range, canvas,
                             device, quantities.thread_count(threads), told)
    if told is not None:
        told(1.0)
    return Run._of(run, time.perf_counter() - start, sensor, canvas, stage)


def _in_lines(text: str, folder: str) -> str:
    """A message about lines of a schedule in memory: schedule[3] in place of line 5 of its file."""
    if not folder:
        return text
    file = re.escape(os.path.join(folder, "schedule.csv"))
    text = re.sub(rf"{file}:(\d+)(:\d+)?", lambda found: f"schedule[{max(int(found[1]) - 2, 0)}]", text)
    return re.sub(file, "schedule", text)


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

    if not isinstance(schedule, (list, tuple)) and not hasattr(schedule, "__next__"):
        raise UsageError(f"schedule: {quantities.shown(schedule)} is no list; write [(frame, \"jitter.rms\", \"60 urad\")], or the name "
                         "of a CSV file")
    lines = list(schedule)
    if not lines:
        raise UsageError("schedule: is empty; write [(frame, \"jitter.rms\", \"60 urad\")]")
    path = os.path.join(folder, "schedule.csv")
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["frame", "parameter", "value"])
        for number, line in enumerate(lines):
            if not isinstance(line, (tuple, list)) or len(line) != 3 or not isinstance(line[1], str):
                raise UsageError(f"schedule[{number}]: {quantities.shown(line)} is not (frame, parameter, value)")
            frame = quantities.count(line[0], f"schedule[{number}]: frame", 0)
            writer.writerow([frame, line[1], quantities.words(line[2], f"schedule[{number}]: {line[1]}")])
    return path
