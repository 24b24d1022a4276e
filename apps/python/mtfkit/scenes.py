# SPDX-License-Identifier: Apache-2.0
"""3-D scenes: surface temperatures over time, and the pictures of them that sensors take in."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.arguments import checked
from mtfkit.errors import UsageError
from mtfkit.folders import KeptFolder
from mtfkit.images import Image, read
from mtfkit.instants import Instant, instant_text
from mtfkit.messages import about_arguments, in_arguments
from mtfkit.progress import Progress, function_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.images import Plane
    from mtfkit.sensors import Sensor

__all__ = ["Heat", "Picture", "heat", "render"]


class Heat(results.ByValue):
    """Temperatures of all surfaces of a scene over a run, as `mtf heat` writes them.

    `folder` holds its files; it goes away with this object unless it was named. A Heat pickles with its files, which are
    in a folder of their own where it arrives; two are equal when their temperatures, times and warnings are.
    """

    def __init__(self, folder: str, report: dict[str, Any], warnings: list[str], seconds: float, keep: Any) -> None:
        self.folder = folder  #: temperatures.npy, regions.csv, facets.csv, times.csv, heat.json
        self.report = report  #: heat.json
        self.warnings = warnings  #: reasons to doubt the result
        self.seconds = seconds  #: wall time
        self._keep = keep

    def _values(self) -> Any:
        return {"temperatures": np.asarray(self.temperatures), "times": self.times, "warnings": self.warnings}

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        files = {}
        for name in sorted(os.listdir(self.folder)):
            with open(os.path.join(self.folder, name), "rb") as file:
                files[name] = file.read()
        return _moved_heat, (files, self.report, self.warnings, self.seconds)

    @property
    def promised(self) -> float:
        """The error of the worst facet at any output, in K, given the tables of views and shadows; closures apart."""
        return float(self.report["promised_K"])

    @property
    def temperatures(self) -> npt.NDArray[np.float32]:
        """Temperatures in K: float32 (outputs, facets), mapped from the file; the front of sheets."""
        temperatures: npt.NDArray[np.float32] = np.load(os.path.join(self.folder, "temperatures.npy"), mmap_mode="r")
        return temperatures

    @property
    def times(self) -> list[str]:
        """The output times, UTC."""
        import csv

        with open(os.path.join(self.folder, "times.csv"), encoding="utf-8") as file:
            return [row["time"] for row in csv.DictReader(file)]

    def regions(self) -> Any:
        """A DataFrame of min_K, mean_K and max_K by (time, region)."""
        pandas = results.pandas("Heat.regions")
        frame = pandas.read_csv(os.path.join(self.folder, "regions.csv"))
        frame["time"] = pandas.to_datetime(frame["time"])
        return frame.set_index(["time", "region"])

    def facets(self) -> Any:
        """A DataFrame of the facets: mesh, region, material, area, centre and normal."""
        return results.pandas("Heat.facets").read_csv(os.path.join(self.folder, "facets.csv"), index_col="facet")

    def __repr__(self) -> str:
        outputs, facets = self.temperatures.shape
        return f"<Heat: {outputs} outputs of {facets} facets, promised {self.promised:.2g} K, {self.seconds:.3g} s>"


class Picture(Image):
    """A picture that `render` made: an Image of its radiance, and `layers`, the other planes by name, float32."""

    __slots__ = ("layers", "report", "seconds")
    layers: dict[str, Plane]
    report: dict[str, Any]  #: the JSON of `mtf render`
    seconds: float  #: wall time

    def __init__(self, file: _core.ImageFile, layers: dict[str, Plane], report: dict[str, Any], seconds: float) -> None:
        super().__init__(file)
        self.layers = layers
        self.report = report
        self.seconds = seconds

    def _values(self) -> Any:
        return {**super()._values(), "layers": self.layers}

    def __reduce__(self) -> tuple[Any, ...]:
        return Picture, (self._file, self.layers, self.report, self.seconds)

    @property
    def promised(self) -> float:
        """The error of the tables that radiance is made of, relative to it, at most."""
        return float(self.report["promised_error"])


def _moved_heat(files: dict[str, bytes], report: dict[str, Any], warnings: list[str], seconds: float) -> Heat:
    keep = KeptFolder("mtfkit-heat-")
    for name, content in files.items():
        with open(os.path.join(keep.name, name), "wb") as file:
            file.write(content)
    return Heat(keep.name, report, warnings, seconds, keep)


def _point(place: Sequence[float] | None, what: str) -> list[float] | None:
    if place is None:
        return None
    numbers = quantities.numbers(place, what).tolist()
    if not isinstance(numbers, list) or len(numbers) != 3 or not all(isinstance(number, float) for number in numbers):
        raise UsageError(f"{what}: {quantities.shown(place)} is not (x, y, z) in m")
    return numbers


@checked
def heat(scene: str | os.PathLike[str], *, tolerance: quantities.Value = "0.1 K", rays: int = 128,
         every_facet: bool = False, out: str | os.PathLike[str] | None = None, threads: int = 0,
         progress: Progress = None) -> Heat:
    """Surface temperatures of a scene file, as `mtf heat`.

    `tolerance` is in K, for the worst facet at any output; `rays` those of the view of each side of a facet;
    `every_facet` solves each by itself. `out` is a folder for the files, which is created and has to be empty. Ctrl-C
    ends the run. Raises UsageError for a scene file with mistakes, each with its place.
    """
    kelvin = quantities.kelvin(tolerance, "tolerance")
    rays = quantities.count(rays, "rays")
    start, keep = time.perf_counter(), None
    if out is None:
        keep = KeptFolder("mtfkit-heat-")
        folder = keep.name
    else:
        folder = os.path.abspath(quantities.path(out, "out"))
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as error:
            raise UsageError(f"out: {folder} cannot be made a folder: {error.strerror}; name another one") from None
        if any(not name.endswith(".mtf-new") for name in os.listdir(folder)):  # which killed processes leave
            raise UsageError(f"out: {folder} is not empty; name another folder")
    report, warnings = _core.heat(os.fspath(scene), folder, kelvin, rays, every_facet, quantities.thread_count(threads),
                                  function_of(progress, "heat"))
    return Heat(folder, json.loads(report), warnings, time.perf_counter() - start, keep)


@checked
def render(scene: str | os.PathLike[str], sensor: Sensor, *, temperatures: Heat | str | os.PathLike[str] | None = None,
           at: Instant | None = None, solve: bool = False, position: Sequence[float] | None = None,
           look_at: Sequence[float] | None = None, samples_per_pitch: float | None = None, points: int = 2, plain: bool = False,
           air: bool = True, layers: Sequence[str] = (), out: str | os.PathLike[str] | None = None,
           threads: int = 0) -> Picture:
    """The picture of a scene file at the aperture of a sensor, as `mtf render`: for `sensor.simulate(picture)`.

    `temperatures` is a Heat, its folder or a table of facets; with `solve` they are solved first, without either they are
    those of the scene file. `at` is ISO 8601 text, a datetime, a numpy.datetime64 or a pandas.Timestamp, UTC without an
    offset, or a time of day "12:30" within the run of the scene; by default the last of the folder, or the start of the
    scene. `position` and `look_at` are x (east), y (north), z (up) in m, by
    default those of [camera]. `samples_per_pitch` follows from the sensor's MTF where it is not given. `plain` gives radiance in the band, else it is weighted by the sensor's response.
    `layers` of the picture: temperature, emissivity, Z, facet, material, normal, surface, transmittance. `out` keeps the file.
    Raises UsageError for what does not fit, each with its place.
    """
    import tempfile

    start, points = time.perf_counter(), quantities.count(points, "points")
    source = "" if temperatures is None else temperatures.folder if isinstance(temperatures, Heat) else os.fspath(temperatures)
    with tempfile.TemporaryDirectory(prefix="mtfkit-render-") as folder:
        file = os.path.join(folder, "sensor.toml")
        sensor.save(file)
        picture = os.fspath(out) if out is not None else os.path.join(folder, "picture.exr")
        with about_arguments(folder, {"sensor.toml": "sensor", "picture.exr": "out"}):
            report = _core.render(os.fspath(scene), [file], picture, source, instant_text(at, os.fspath(scene)), solve,
                                  _point(position, "position"), _point(look_at, "look_at"), samples_per_pitch, points,
                                  plain, not air, list(layers), quantities.thread_count(threads))
        channels = [name for layer in layers
                    for name in ([f"normal.{axis}" for axis in "XYZ"] if layer == "normal" else [layer])]
        planes = {name: read(picture, channel=name).plane() for name in channels}
        file_of = read(picture, channel="Y")._file
        if out is None:  # the file goes away
            file_of = file_of.called("picture")
        report = in_arguments(report, folder, {"sensor.toml": "sensor", "picture.exr": "picture"})
        return Picture(file_of, planes, json.loads(report), time.perf_counter() - start)
