# SPDX-License-Identifier: Apache-2.0
"""A camera's gain, noise, response and patterns from stacks of its flat frames."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.arguments import checked
from mtfkit.edges import image_argument
from mtfkit.errors import UsageError
from mtfkit.progress import Progress, function_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.edges import ImageLike
    from mtfkit.sensors import Sensor


@dataclass(frozen=True, eq=False)
class Stack(results.ByValue):
    """Frames of one flat scene that does not change: an array (frames, rows, columns) of counts.

    Light is stated by one of `photons` (mean number at a pixel in an exposure), `irradiance` (W/m^2), `relative` (any
    unit), for blackbodies by `temperature` or `radiance` (W m^-2 sr^-1 in the band of the nominal), else it is as the
    `exposure`. `light=False` is a dark stack. All stacks state it in one way. `step` is the time from frame to frame of
    successive frames, between two of which the light steps to another level: they tell the lag, and state no light.
    """

    frames: npt.ArrayLike
    exposure: quantities.Value | None = None
    light: bool = True
    photons: float | None = None
    irradiance: float | None = None
    relative: float | None = None
    temperature: quantities.Value | None = None
    radiance: float | None = None
    step: quantities.Value | None = None
    __hash__ = None  # type: ignore[assignment]

    def _entry(self, name: str) -> str:
        given = {key: getattr(self, key) for key in ("exposure", "photons", "irradiance", "relative", "temperature", "radiance", "step")}
        lines = [f"{key} = {quantities.toml(value, f'{name}.{key}')}" for key, value in given.items() if value is not None]
        return "\n".join(["[[stack]]", f'frames = "{name}"', *([] if self.light else ["light = false"]), *lines]) + "\n"


@dataclass(frozen=True, eq=False)
class CameraNumber(results.ByValue):
    """A number of a camera in `unit`, NaN where frames do not determine it, with its standard deviation.

    `low` and `high` are the ends of its 95 % interval, `verdict` is "determined", "upper limit", "predicted", or "not
    determined" with the reason in `why`. `source` names the stacks and the method. `sd_array` is the standard deviation of
    the number of this one array, where `sd` is that of the process of which the array is a draw; `sd_systematic` is what
    blackbodies leave open, which more frames do not bring down.
    """

    name: str
    value: float
    sd: float
    low: float
    high: float
    unit: str
    verdict: str
    source: str
    why: str
    sd_array: float
    sd_systematic: float


def _number(entry: dict[str, Any]) -> CameraNumber:
    def real(value: float | None) -> float:
        return float("nan") if value is None else float(value)

    low, high = entry["interval95"] or (None, None)
    return CameraNumber(entry["name"], real(entry["value"]), real(entry["sd"]), real(low), real(high), entry["unit"],
                        entry["verdict"], entry["from"], entry["why"] or "", real(entry["sd_array"]),
                        real(entry["sd_systematic"]))


class Camera(results.ByValue):
    """What `mtf characterize` finds."""

    def __init__(self, report: str, table: str, sensor_text: str | None) -> None:
        self._kept = (report, table, sensor_text)
        self.report: dict[str, Any] = json.loads(report)  #: the JSON of `mtf characterize`

    def _values(self) -> Any:
        return self._kept

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return Camera, self._kept

    @property
    def numbers(self) -> list[CameraNumber]:
        """All numbers, those that frames do not determine too."""
        return [_number(entry) for entry in self.report["numbers"]]

    def __getitem__(self, name: str) -> CameraNumber:
        for number in self.numbers:
            if number.name == name:
                return number
        raise KeyError(name)

    @property
    def adequate(self) -> bool:
        """True when the models describe the frames, and the edges; of EMVA 1288's own formulas, which test none, always."""
        return self.report.get("status", "ok") == "ok" and self.report.get("edges", {}).get("status", "converged") == "converged"

    @property
    def reason(self) -> str:
        """Which level disagrees most where the model does not describe the frames; "" where it does."""
        return self.report.get("reason") or ""

    @property
    def warnings(self) -> list[str]:
        """What to be careful with."""
        return list(self.report["warnings"])

    @property
    def sensor(self) -> Sensor:
        """The sensor with these numbers, each with its standard deviation or interval; the rest is the nominal's.

        Raises UsageError where frames make none: a photon detector before blackbodies, EMVA 1288's own formulas.
        """
        from mtfkit.sensors import Sensor

        if self._kept[2] is None:
            raise UsageError("sensor: these frames make no sensor file; give stacks by light, and the default method")
        return Sensor.parse(self._kept[2])

    @property
    def table(self) -> Any:
        """A DataFrame: index name; columns value, sd, low, high, unit, verdict, source, why."""
        pandas = results.pandas("Camera.table")
        columns = ["value", "sd", "low", "high", "unit", "verdict", "source", "why"]
        rows = [[getattr(number, column) for column in columns] for number in self.numbers]
        return pandas.DataFrame(rows, columns=columns, index=pandas.Index([n.name for n in self.numbers], name="number"))

    def explain(self) -> results.Text:
        """What `mtf characterize` prints."""
        return results.Text(self._kept[1])

    def __repr__(self) -> str:
        found = ", ".join(f"{n.name} = {n.value:.4g} +- {n.sd:.2g} {n.unit}".rstrip() for n in self.numbers
                          if n.verdict == "determined")
        return f"<Camera {'' if self.adequate else '(the model does not describe the frames) '}{found}>"

    def _repr_html_(self) -> str:
        return self.explain()._repr_html_()


def _frames(stack: Stack, what: str) -> list[Any]:
    array = stack.frames
    if not isinstance(array, (list, tuple)):
        array = np.asanyarray(array)
        if array.ndim != 3:
            raise UsageError(f"{what}.frames: has the shape {array.shape}; a stack has three dimensions, (frames, rows, columns)")
    return list(array)


@checked
def characterize(stacks: str | os.PathLike[str] | Sequence[Stack], *, nominal: Sensor | None = None,
                 edges: Sequence[ImageLike] = (), bits: int | None = None, nonlinearity: int = 0, trend: int = 2,
                 repeatability: float = 0.0, method: str = "fit", threads: int = 0, progress: Progress = None) -> Camera:
    """A camera's numbers from stacks of its flat frames, as `mtf characterize`.

    `stacks` is the file that describes them, which then states all else, or a list of Stack. `nominal` is a sensor for what
    frames do not tell. `edges` are raw images of edges (files or arrays), of the camera and settings of the frames: what the
    nominal marks to be fitted is fitted to them then, by the noise, response and crosstalk of the frames, and `report["edges"]`
    is what `fit` reports, with what both share. `bits` are those of the converter, else the nominal's. `nonlinearity` is the
    number of terms of the response (0 to 3), `trend` the degree of the shading that is no part of PRNU, `repeatability` the
    relative standard deviation of the light from stack to stack. `method="emva1288"` gives the numbers of EMVA 1288 by its own formulas, each
    with its bias for this camera.

    Frames that the model does not describe give a result with `adequate` False. Raises UsageError for stacks that cannot be
    used (single or equal frames, a lamp that drifts, processed frames), DataError for files that cannot be read.
    """
    if method not in ("fit", "emva1288"):
        raise UsageError(f'method: {quantities.shown(method)} is not known; "fit" or "emva1288"')
    if not isinstance(edges, (list, tuple)):
        raise UsageError(f"edges: {quantities.shown(edges)} is no list of images; write [image]")
    if edges and method != "fit":
        raise UsageError("edges: the standard knows none; leave method out")
    images = [image_argument(image, f"edges[{number}]") for number, image in enumerate(edges)]
    handle = nominal._file if nominal is not None else None
    if isinstance(stacks, (str, os.PathLike)):
        path, text, frames = os.fspath(stacks), "", []
    else:
        path = "stacks"
        if not isinstance(stacks, (list, tuple)) or not all(isinstance(one, Stack) for one in stacks):
            raise UsageError("stacks: is no list of stacks; write [mtfkit.Stack(array, exposure=\"10 ms\"), ...], or name a file")
        names = [f"stacks[{i}]" for i in range(len(stacks))]
        frames = [(name, _frames(stack, name)) for name, stack in zip(names, stacks)]
        head = "" if bits is None else f"[camera]\nbits = {quantities.count(bits, 'bits')}\n"
        head += f"[light]\nrepeatability = {quantities.toml(repeatability, 'repeatability')}\n" if repeatability else ""
        options = f"[options]\nnonlinearity = {quantities.count(nonlinearity, 'nonlinearity', 0)}\n" if nonlinearity else "[options]\n"
        text = head + options + f"trend = {quantities.count(trend, 'trend', 0)}\n" + "".join(
            stack._entry(name) for name, stack in zip(names, stacks))
    run = _core.characterize(path, text, frames, handle, images, method == "emva1288",
                             quantities.thread_count(threads), function_of(progress, "reading"))
    return Camera(run.report, run.table, run.sensor_text)
