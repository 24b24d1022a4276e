# SPDX-License-Identifier: Apache-2.0
"""A sensor's parameters from what it measured, and what the data cannot tell."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.arguments import checked, require
from mtfkit.edges import Estimate, image_argument, regions_of
from mtfkit.errors import UsageError
from mtfkit.images import Image
from mtfkit.progress import Progress, function_of
from mtfkit.runs import Run

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.edges import ImageLike
    from mtfkit.sensors import Sensor

    Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CurveData(results.ByValue):
    """An MTF that another instrument measured: values `mtf` at `frequency` [`unit`] along `angle`.

    `sd` is one standard deviation for all, or one for each. `unit` is cy/mm, lp/mm (the same), cy/mrad or cy/px.
    """

    frequency: npt.ArrayLike
    mtf: npt.ArrayLike
    sd: npt.ArrayLike = 0.01
    unit: str = "cy/mm"
    angle: quantities.Value = 0
    name: str = "curve"
    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True, eq=False)
class Parameter(results.ByValue):
    """A fitted number of the sensor.

    `value` is NaN where the data do not determine it, `sd` where there is no standard deviation. `verdict` says how well
    it is known: "determined", "at bound", "prior only", "not determined", "interval", "ambiguous", with what it cannot be
    told from. `low` and `high` are the ends of a 95 % interval where one was made. `others` are further values that
    describe the data alike, as the other sign of a defocus. `sd` holds for the sensor as it is: `sensitivity` tells what
    value and standard deviation become with one more unknown of it, as ("defocus", value, sd), NaN where nothing is known.
    """

    name: str
    value: float
    sd: float
    unit: str
    start: float
    low: float
    high: float
    verdict: str
    others: tuple[float, ...] = ()
    sensitivity: tuple[tuple[str, float, float], ...] = ()


@dataclass(frozen=True, eq=False)
class KeptFit:
    """A finished fit by its values: as _core.FitRun, for pickle."""

    report: str
    table: str
    fitted: Sensor
    residuals: list[tuple[str, npt.NDArray[np.float32]]]


class Fit(results.ByValue):
    """What `mtf fit` gives, bit for bit. Two are equal when all but their wall times is."""

    def __init__(self, sensor: Sensor, run: _core.FitRun | KeptFit, seconds: float) -> None:
        self.seconds = seconds  #: wall time
        self._sensor = sensor
        self._run = run
        self.report: dict[str, Any] = json.loads(run.report)  #: the JSON of `mtf fit`

    def _values(self) -> Any:
        return {"sensor": self._sensor, "report": self.report, "residuals": self.residuals}

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return Fit, (self._sensor, KeptFit(self._run.report, self._run.table, self.sensor, self.residuals), self.seconds)

    @property
    def status(self) -> str:
        """"converged", "converged_model_wrong", "not_converged", "no_data"."""
        return str(self.report["status"])

    @property
    def reason(self) -> str:
        """Why it did not end well; "" when it did."""
        return self.report["reason"] or ""

    @property
    def adequate(self) -> bool:
        """True when the fit converged and the sensor describes the data: the residuals have no structure beyond noise."""
        return self.status == "converged"

    @property
    def chi2_per_dof(self) -> float:
        """Chi-square per degree of freedom, 1 for a sensor that describes the data."""
        return float(self.report["chi2_per_dof"])

    @property
    def warnings(self) -> list[str]:
        """What to be careful with."""
        return list(self.report["warnings"])

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The fitted numbers."""
        words = {name: found["text"] for found in [*self.report["alternatives"], *self.report["not_separable"]]
                 for name in found["parameters"]}
        return tuple(_parameter(entry, words.get(entry["name"], "")) for entry in self.report["parameters"])

    def __getitem__(self, name: str) -> Parameter:
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)

    @property
    def table(self) -> Any:
        """A DataFrame: index parameter; columns value, sd, unit, start, low, high, verdict."""
        pandas = results.pandas("Fit.table")
        rows = [(p.value, p.sd, p.unit, p.start, p.low, p.high, p.verdict) for p in self.parameters]
        return pandas.DataFrame(rows, columns=["value", "sd", "unit", "start", "low", "high", "verdict"],
                                index=pandas.Index([p.name for p in self.parameters], name="parameter"))

    @property
    def correlation(self) -> Floats:
        """The correlation of the parameters in their order; NaN where the data do not tell."""
        count = len(self.report["parameters"])
        rows = [[np.nan if v is None else v for v in row] for row in self.report["correlation"]]
        return np.array(rows, dtype=np.float64).reshape(len(rows), count if rows else 0)

    @property
    def covariance(self) -> Floats:
        """The covariance of the parameters in their units; NaN where there is no standard deviation."""
        sd = np.array([p.sd for p in self.parameters])
        return self.correlation * np.outer(sd, sd)

    @property
    def frequency(self) -> Floats:
        """Frequencies of `mtf` in cycles/pixel along the first edge's normal."""
        return np.array(self.report["mtf"]["frequency"], dtype=np.float64)

    @property
    def mtf(self) -> Floats:
        """The MTF of the fitted sensor."""
        return np.array(self.report["mtf"]["value"], dtype=np.float64)

    @property
    def mtf_sd(self) -> Floats:
        """Its standard deviation, from the covariance."""
        return np.array([np.nan if v is None else v for v in self.report["mtf"]["sd"]], dtype=np.float64)

    def plot(self, axes: Any = None) -> Any:
        """Draws `mtf` with a band of one standard deviation on each side, with matplotlib.

        In the `axes` given, else in new ones; returns them. Raises MissingLibrary, an ImportError, without matplotlib.
        """
        return results.plot_mtf(results.axes_for("Fit.plot", axes), self.frequency, self.mtf, self.mtf_sd, "cy/px", "fitted sensor")

    @property
    def mtf50(self) -> Estimate | None:
        """The frequency of half contrast in cycles/pixel."""
        found = self.report["mtf50"]
        return Estimate(found["value"], found["sd"]) if found else None

    @property
    def sensor(self) -> Sensor:
        """The sensor with the fitted values and their standard errors in its file, comments kept."""
        if isinstance(self._run, KeptFit):
            return self._run.fitted
        return type(self._sensor)._of(self._run.sensor, self._sensor._own)

    @property
    def residuals(self) -> list[tuple[str, npt.NDArray[np.float32]]]:
        """Of every edge and point source its name and (pixel - model) / sd, NaN where a pixel does not count."""
        return self._run.residuals

    def explain(self) -> results.Text:
        """What `mtf fit` prints."""
        return results.Text(self._run.table)

    def __repr__(self) -> str:
        values = ", ".join(f"{p.name} = {p.value:.6g} +- {p.sd:.2g} {p.unit}".rstrip() for p in self.parameters)
        return f"<Fit {self.status}: {values}>"

    def _repr_html_(self) -> str:
        return self.explain()._repr_html_()


def _parameter(entry: Mapping[str, Any], word: str) -> Parameter:
    def number(value: float | None) -> float:
        return float("nan") if value is None else float(value)

    interval = entry["interval"] or {}
    ends = entry["interval95"] or [interval.get("low"), interval.get("high")]
    low, high = (number(end) for end in ends)
    verdict = entry["knowledge"] + (f": {word}" if word else "")
    if entry["limit95"] is not None:
        verdict += f"; 95 %: {'at most' if entry['limit_is'] == 'upper' else 'at least'} {entry['limit95']:.4g}"
    return Parameter(entry["name"], number(entry["value"]), number(entry["stderr"]), entry["unit"], entry["start"], low,
                     high, verdict, tuple(other["value"] for other in entry["other_values"]),
                     tuple((model["unknown"], number(model["value"]), number(model["stderr"]))
                           for model in entry["model_sensitivity"]))


def _bounds(name: str, given: Any) -> dict[str, Any]:
    if given is None:
        return {}
    if isinstance(given, Mapping):
        unknown = set(given) - {"min", "max", "prior", "value"}
        if unknown:
            raise UsageError(f"free: {name}: {', '.join(sorted(map(str, unknown)))} is not known (min, max, prior, value)")
        fields = dict(given)
        if isinstance(fields.get("prior"), (tuple, list)):
            fields["prior"] = dict(zip(("mean", "sd"), fields["prior"]))
        return fields
    if isinstance(given, (tuple, list)) and len(given) == 2 and not quantities.is_quantity(given):
        return {key: bound for key, bound in zip(("min", "max"), given) if bound is not None}
    raise UsageError(f"free: {name}: {given!r} is no pair of bounds; give (least, largest), {{\"min\": ..., \"max\": ..., "
                     "\"prior\": (mean, sd)}, or None for the bounds of the sensor file")


def marked(sensor: Sensor, free: Mapping[str, Any] | Iterable[str] | None) -> Sensor:
    """The sensor with { value, fit = true, min, max } for what is free; without `free` it stays as it is."""
    if free is None:
        return sensor
    if isinstance(free, str) or not isinstance(free, Iterable):
        raise UsageError(f"free: {quantities.shown(free)} is no dictionary; write {{\"jitter.rms\": (\"0 urad\", \"80 urad\")}}, or a "
                         "list of names")
    named = dict(free) if isinstance(free, Mapping) else {name: None for name in list(free)}
    for name in named:
        if not isinstance(name, str):
            raise UsageError(f"free: {quantities.shown(name)} is no name of a parameter, such as \"jitter.rms\"")
    marks = {}
    for name, given in named.items():
        fields = _bounds(name, given)
        stated = sensor._file.stated(name)
        if "value" not in fields and not stated:
            raise UsageError(f"free: {name}: the sensor file does not state it; give it a value to start from, as "
                             f"{{\"value\": ...}} or with sensor.replace")
        if "value" not in fields:
            fields = {"value": json.loads(stated) if stated.startswith('"') else float(stated), **fields}
        marks[name] = {"value": fields.pop("value"), "fit": True, **fields}
    return sensor.replace(marks)


def _curves(curves: Any) -> list[tuple[Any, ...]]:
    if not isinstance(curves, (list, tuple)):
        raise UsageError(f"curves: {quantities.shown(curves)} is no list; write [mtfkit.CurveData(frequency, mtf)]")
    made: list[tuple[Any, ...]] = []
    for number, curve in enumerate(curves):
        what = f"curves[{number}]"
        if not isinstance(curve, CurveData):
            raise UsageError(f"{what}: {quantities.shown(curve)} is no CurveData; give mtfkit.CurveData(frequency, mtf, sd=0.01)")
        require(curve.name, "str", f"{what}.name")
        require(curve.unit, "str", f"{what}.unit")
        frequency, mtf, sd = (np.atleast_1d(quantities.numbers(getattr(curve, name), f"{what}.{name}")).ravel().tolist()
                              for name in ("frequency", "mtf", "sd"))
        made.append((curve.name, frequency, mtf, sd, curve.unit, quantities.angle_deg(curve.angle, f"{what}.angle")))
    return made


@checked
def fit(sensor: Sensor, *, edges: Sequence[ImageLike | tuple[ImageLike, Sensor]] = (),
        free: Mapping[str, Any] | Iterable[str] | None = None, curves: Sequence[CurveData] = (),
        spots: Sequence[ImageLike | tuple[ImageLike, Sensor]] = (), robust: bool = True, starts: int = 1,
        profile: bool = False, residual_otf: bool = False, channel: str | None = None, encoding: str = "",
        roi: Sequence[Sequence[int]] | None = None, noise_sd: float | None = None, saturation: float | None = None,
        most: int = 64, threads: int = 0, progress: Progress = None) -> Fit:
    """Fits numbers of a sensor to what it measured, as `mtf fit`, bit for bit.

    `edges` are images of edges, `spots` images of point sources, `curves` MTFs of other instruments. An image that was
    taken with another setting (focus, exposure, band) is a pair (image, sensor of that setting); the fitted numbers are
    shared by all. `free` names what is fitted: {"jitter.rms": ("0 urad", "80 urad"), "defocus.distance": None}, a pair of
    bounds, a dictionary of min, max, prior and value, or None; without `free` it is what the sensor file marks
    { value = ..., fit = true }. `robust` lets outliers count less, `starts` runs from several values, `profile` makes
    intervals by profile likelihood. Ctrl-C ends the fit.

    A fit that does not end well is a result with its `status` and `reason`. Raises UsageError for parameters that do not
    exist, DataError for files that cannot be read.
    """
    from mtfkit.sensors import Sensor

    def require_data(of: Sensor | None) -> None:
        if of is not None and of._functions:
            raise of._functions[0].refusal("fit")

    require_data(sensor)

    def pairs(images: Sequence[Any], what: str) -> list[tuple[Any, Any]]:
        if isinstance(images, (str, os.PathLike, Image, Run)) or (isinstance(images, np.ndarray) and images.ndim == 2):
            raise UsageError(f"{what}: is a list of images; write [image]")
        if not isinstance(images, (list, tuple, np.ndarray)):
            raise UsageError(f"{what}: {quantities.shown(images)} is no list of images; write [image]")
        made = []
        for number, image in enumerate(images):
            taken = image if isinstance(image, tuple) and len(image) == 2 and isinstance(image[1], Sensor) else (image, None)
            require_data(taken[1])
            made.append((image_argument(taken[0], f"{what}[{number}]"), taken[1]._file if taken[1] is not None else None))
        return made

    given = _curves(curves)
    words = {"channel": channel, "encoding": encoding, "regions": regions_of(roi),
             "noise_sd": noise_sd, "saturation": saturation, "most": quantities.count(most, "most")}
    asked = marked(sensor, free)
    start = time.perf_counter()
    run = _core.fit(asked._file, pairs(edges, "edges"), pairs(spots, "spots"), given, words, robust, quantities.count(starts, "starts"), profile,
                    residual_otf, quantities.thread_count(threads), function_of(progress, "fitting"))
    return Fit(asked, run, time.perf_counter() - start)
