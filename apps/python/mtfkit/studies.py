# SPDX-License-Identifier: Apache-2.0
"""Trade studies: every design of a study file as a table, the best ones, derivatives, the optimum."""

from __future__ import annotations

import json
import operator
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.arguments import checked
from mtfkit.errors import UsageError
from mtfkit.folders import KeptFolder
from mtfkit.progress import Progress, function_of
from mtfkit.sensors import Sensor
from mtfkit.study_results import Gradient, Optimum, StudyColumn
from mtfkit.study_text import StudyParts, study_parts, write_copies, write_study

if TYPE_CHECKING:
    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]


class Study:
    """A trade study: a sensor, what varies in it, what is wanted. It never changes, and pickles with all that it needs.

    Made of a sensor and keywords, which are the tables of a study file with its words, or read by `Study.load`. `save`
    writes the file that `mtf sweep` runs to the same rows.

    >>> import mtfkit as mk
    >>> sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0, wavelength="4 um"),
    ...                    presample=["diffraction", mk.Footprint(width="15 um"), mk.Jitter(rms="20 urad")])
    >>> study = mk.Study(sensor, axes={"optics.f_number": [1.4, 2.0, 2.8],
    ...                                "jitter.rms": {"from": "10 urad", "to": "50 urad", "count": 5}},
    ...                  links={"footprint.width": "0.9 * pitch"}, metrics=["mtf_nyquist_x"],
    ...                  constraints=["mtf_nyquist_x > 0.3"], objectives=["maximize jitter.rms"])
    >>> study.designs, study.axes(14)
    (15, {'optics.f_number': 2.8, 'jitter.rms': 50.0})
    >>> study.rows(0, 10).shape == (10, len(study.columns))
    True

    `axes` is a dictionary by parameter, the last axis being the fastest of a grid: a list of values (numbers, texts, words,
    files, or Sensors for the parameter "sensor"), values with one unit ([100, 200], "mm"), or a range {"from": "5 um", "to":
    "15 um", "count": 11, "scale": "log"}. A number of the study's own, for links and goals, stands in a list of
    dictionaries: [{"name": "f_number", "from": 4, "to": 12, "count": 9}, {"parameter": "frame.pitch", "values": [...]}].

    `links` gives expressions by parameter, {"focal_length": "f_number * aperture"}; `constraints` and `objectives` are
    lists of texts, "netd < 50 mK" and "minimize aperture"; `metrics` are names of figures beside those in them.
    `conditions` is what metrics take from outside of the sensor: dict(range="500 km", temperature="290 K").
    `sampling` is dict(method="sobol", points=1024) in place of the grid, or "latin_hypercube"; `seed` is that of samples
    and as-built draws. `as_built` gives {"optics.obscuration": {"sd": 0.01}}, or `plus_minus`, and `draws` the number of
    sensors that the yield of a design is made of. `tolerance` is the error allowed in every metric, 1e-4 by default. All
    words, parameters, expressions and metrics are in apps/study/README.md.

    Raises UsageError with every mistake, each with its argument.
    """

    def __init__(self, sensor: Sensor, *, axes: Mapping[str, Any] | Sequence[Mapping[str, Any]],
                 links: Mapping[str, str] | None = None, constraints: Sequence[str] = (), objectives: Sequence[str] = (),
                 metrics: Sequence[str] = (), conditions: Mapping[str, quantities.Value] | None = None,
                 sampling: Mapping[str, Any] | None = None,
                 as_built: Mapping[str, Mapping[str, quantities.Value]] | Sequence[Mapping[str, Any]] | None = None,
                 draws: int | None = None, name: str = "", seed: int = 0, tolerance: float | None = None) -> None:
        if not isinstance(sensor, Sensor):
            raise UsageError(f"sensor: {quantities.shown(sensor)} is no Sensor; give one, or read a study file with Study.load(file)")
        self._take(study_parts(sensor, name=name, axes=axes, links=links, constraints=constraints, objectives=objectives,
                               metrics=metrics, conditions=conditions, sampling=sampling, as_built=as_built, draws=draws,
                               seed=seed, tolerance=tolerance))

    def _take(self, parts: StudyParts) -> None:
        """The study of a text and sensors in memory."""
        self._parts: StudyParts | None = parts
        self._folder: Any = KeptFolder("mtfkit-study-")
        self._tolerance: float | None = None
        write_study(parts, self._folder.name, "study", own_files=False)
        with self._said():
            self._study = _core.StudyFile(os.path.join(self._folder.name, "study.toml"), None)

    @contextmanager
    def _said(self) -> Iterator[None]:
        """Errors from within say arguments where the study was made of them."""
        if self._parts is None:
            yield
            return
        with self._parts.about_arguments(self._folder.name):
            yield

    @classmethod
    @checked
    def load(cls, file: str | os.PathLike[str], *, tolerance: float | None = None) -> Study:
        """Reads a study file; `tolerance` in place of its own. Raises UsageError with every error as a
        "file:line:column" line, DataError when a file cannot be read."""
        if tolerance is not None and not 1e-12 <= quantities.number(tolerance, "tolerance") <= 0.1:
            raise UsageError(f"tolerance: {tolerance!r} is outside 1e-12 to 0.1")
        study = object.__new__(cls)
        study._parts, study._folder, study._tolerance = None, None, tolerance
        # Designs read the files of sensors when they are made: where those are now, wherever the process goes.
        study._study = _core.StudyFile(os.path.abspath(quantities.path(file, "file")), tolerance)
        return study

    @checked
    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes the study file, and beside it the sensor files and all that these name, so that the folder can be moved.

        `mtf sweep file` makes the rows of this study, bit for bit. Of a study that was loaded with another tolerance, it is
        the file without it. Raises DataError where files cannot be written.
        """
        path = quantities.path(file, "file")
        folder, base = os.path.split(os.path.abspath(path))
        if self._parts is not None:
            write_study(self._parts, folder, os.path.splitext(base)[0], own_files=True, file=base)
        else:
            write_copies(self._study.files(), folder, base)

    @property
    def name(self) -> str:
        """`name` of the study file."""
        return self._study.name

    @property
    def file(self) -> str:
        """The study file; "study" for one made of keywords."""
        return self._study.file if self._parts is None else "study"

    @property
    def text(self) -> str:
        """The study file, with its comments."""
        return self._study.text

    @property
    def designs(self) -> int:
        """How many designs there are; they are numbered from 0."""
        return self._study.designs

    @property
    def tolerance(self) -> float:
        """The error allowed in every metric."""
        return self._study.tolerance

    @property
    def objectives(self) -> list[str]:
        """"maximize niirs_giqe5", ..."""
        return self._study.objectives

    @property
    def constraints(self) -> list[str]:
        """"niirs_giqe5 > 5", ..."""
        return self._study.constraints

    @property
    def warnings(self) -> list[str]:
        """What the file leaves in doubt, and the metrics that no design has, with the reason."""
        warnings = self._study.warnings
        warnings += [f"{column.name}: no design has it: {gap}" for column, gap in zip(self.columns, self._study.gaps()[0]) if gap]
        return warnings if self._parts is None else [self._parts.in_words(text, self._folder.name) for text in warnings]

    @property
    def columns(self) -> tuple[StudyColumn, ...]:
        """The columns of `rows`, in their order."""
        return tuple(StudyColumn(name=column["name"], unit=column["unit"], definition=column["definition"],
                                 source=column["source"], role=column["role"], levels=tuple(column["levels"]))
                     for column in self._study.columns)

    def rows(self, first: int | tuple[int, int] = 0, last: int | None = None, *, threads: int = 1,
             progress: Progress = None) -> Floats:
        """The rows of the designs first ... last - 1: float64 (designs, columns), the values of `mtf sweep` bit for bit.

        It depends on nothing but the study and the numbers, so that any worker on any machine makes the same bytes:
        `pool.map(study.rows, [0, 600], [600, 1221])`, or a pair `rows((0, 600))`. `threads` is 1, as workers of a pool
        want it; 0 = all cores. NaN where a design has no such number. Ctrl-C ends it. Raises UsageError for designs that
        are not there, DataError where a file of a sensor is not what it was when the study was read.
        """
        if isinstance(first, tuple):
            if len(first) != 2:
                raise UsageError(f"first: {quantities.shown(first)} is no pair (first, last)")
            first, last = first
        with self._said():
            return self._study.rows(_whole(first, "first"), self.designs if last is None else _whole(last, "last"),
                                    quantities.thread_count(threads), function_of(progress, self.name or "designs"))

    def run(self, *, threads: int = 0, progress: Progress = None) -> Any:
        """All designs as a DataFrame: see `frame`. `threads` 0 = all cores; `progress` True for a line on standard error,
        or a function of the share done. Ctrl-C ends it. `attrs["seconds"]` is the wall time, the column `error` the
        error that each design promises."""
        start = time.perf_counter()
        frame = self.frame(self.rows(0, self.designs, threads=threads, progress=progress))
        frame.attrs["seconds"] = time.perf_counter() - start
        return frame

    @checked
    def frame(self, rows: npt.ArrayLike | Sequence[npt.ArrayLike], *, first: int = 0) -> Any:
        """Rows (or a list of pieces that follow one another) as a DataFrame.

        The index is the number of the design, from `first` on; columns are those of the study, with the words of axes
        that are no numbers and `feasible` as True or False; `attrs["units"]` has the unit of each.
        """
        pandas = results.pandas("Study.frame")
        pieces = rows if isinstance(rows, (list, tuple)) else [rows]
        tables = [quantities.numbers(piece, "rows") for piece in pieces]
        columns = self.columns
        if tables and all(piece.shape == (len(columns),) for piece in tables):
            tables = [np.asarray(tables)]  # a list of rows
        for piece in tables:
            if piece.ndim != 2 or piece.shape[1] != len(columns):
                raise UsageError(f"rows: have the shape {piece.shape}, the study has {len(columns)} columns")
        table = np.concatenate(tables) if tables else np.empty((0, len(columns)))
        frame = pandas.DataFrame(table, columns=[column.name for column in columns], copy=False,
                                 index=pandas.RangeIndex(first, first + len(table), name="design"))
        for column in columns:
            if column.role == "feasible":
                frame[column.name] = frame[column.name] == 1.0
            elif column.levels:
                frame[column.name] = pandas.Categorical.from_codes(frame[column.name].astype(int), list(column.levels))
        frame.attrs["units"] = {column.name: column.unit for column in columns}
        frame.attrs["study"] = self.name
        return frame

    def _table(self, frame: Any) -> Floats:
        _require_table(frame)
        table = np.empty((len(frame), len(self.columns)))
        for i, column in enumerate(self.columns):
            if column.name not in frame:
                raise UsageError(f"the table has no column {column.name}; give one that `run` or `frame` made")
            values = frame[column.name]
            table[:, i] = values.cat.codes if column.levels else values
        return table

    def pareto(self, frame: Any) -> Any:
        """The rows of the feasible designs that no other one beats in all objectives, as in `mtf sweep`."""
        _require_table(frame)
        front = self._study.pareto([int(n) for n in frame.index], self._table(frame))
        return frame.loc[front]

    def to_xarray(self, frame: Any) -> Any:
        """A Dataset of all designs of a grid: the axes become dimensions, metrics variables with `attrs["units"]`.

        Raises UsageError for samples, and for a table that is not whole.
        """
        xarray = results.xarray("Study.to_xarray")
        if not self._study.grid:
            raise UsageError("to_xarray: the designs of this study are samples, not a grid")
        _require_table(frame)
        if len(frame) != self.designs:
            raise UsageError(f"to_xarray: the table has {len(frame)} of {self.designs} designs")
        frame = frame.sort_index()
        if frame.index[0] != 0 or frame.index[-1] != self.designs - 1 or not frame.index.is_unique:
            raise UsageError("to_xarray: the index of the table is not that of the designs, 0 to "
                             f"{self.designs - 1}")
        axes = self._study.axes
        names, shape = [axis["name"] for axis in axes], tuple(axis["points"] for axis in axes)
        coords, variables = {}, {}
        for column in self.columns:
            values = np.asarray(frame[column.name]).reshape(shape)
            if column.role == "axis":
                at = names.index(column.name)
                coords[column.name] = (column.name, np.moveaxis(values, at, 0).reshape(shape[at], -1)[:, 0],
                                       {"units": column.unit})
            else:
                variables[column.name] = (names, values, {"units": column.unit, "long_name": column.definition})
        return xarray.Dataset(variables, coords=coords, attrs={"study": self.name})

    def _values(self, design: int) -> list[float]:
        return self._study.axis_values(_whole(design, "design"))

    def axes(self, design: int) -> dict[str, float | str]:
        """The values of the axes of a design, in the units of the columns; words where they are no numbers."""
        made: dict[str, float | str] = {}
        for axis, value in zip(self._study.axes, self._values(design)):
            made[axis["name"]] = axis["levels"][int(value)] if axis["levels"] else value
        return made

    def sensor(self, design: int) -> Sensor:
        """The sensor of a design, with all its numbers set: what `mtf sweep` writes as a chosen design."""
        return self._sensor_at(self._values(design), f"design_{int(design)}.toml")

    def _sensor_at(self, values: list[float], name: str) -> Sensor:
        if self._parts is None:
            return Sensor._of(self._study.sensor_at(values, os.path.join(os.path.dirname(self.file), name)))
        given = self._parts.sensors[0]
        for axis, value in zip(self._study.axes, values):
            if axis["name"] == "sensor":
                given = self._parts.sensors[int(axis["levels"][int(value)].rpartition("_")[2].partition(".")[0])]
        with self._said():
            made = self._study.sensor_at(values, os.path.join(os.path.dirname(given.file), name))
        return Sensor._of(made, given._own)

    def gradient(self, design: int) -> Gradient:
        """Exact derivatives of the metrics, objectives and constraints of a design by the numeric axes."""
        start = time.perf_counter()
        with self._said():
            made = self._study.gradient_at(self._values(design))
        return Gradient(**made, seconds=time.perf_counter() - start)

    @checked
    def optimum(self, *, objective: int | None = None, weights: Sequence[float] | None = None, search: bool = False,
                starts: int = 8, threads: int = 0, progress: Progress = None) -> Optimum:
        """The best design between those of the grid, the numeric axes being continuous, as `mtf optimize`.

        `objective` is the number of one, from 0; `weights` weighs all of them. A study with one objective needs neither.
        `search` takes the method without slopes. Ctrl-C ends it. Raises UsageError for a study without objectives.
        """
        count, starts = len(self.objectives), quantities.count(starts, "starts")
        if objective is not None and weights is not None:
            raise UsageError("optimum: objective and weights exclude each other; give one")
        if weights is None:
            if objective is None and count != 1:
                raise UsageError(f"optimum: the study has {count} objectives; choose one with objective=N, or weigh them "
                                 f"with weights: {'; '.join(f'{i}: {text}' for i, text in enumerate(self.objectives))}")
            chosen = objective or 0
            if not 0 <= chosen < count:
                raise UsageError(f"objective: {chosen} is not among the {count} of the study, counted from 0")
            name, numbers = self.objectives[chosen], [1.0 if i == chosen else 0.0 for i in range(count)]
        else:
            numbers = [float(weight) for weight in weights]
            if len(numbers) != count:
                raise UsageError(f"weights: has {len(numbers)} numbers, the study {count} objectives")
            name = " + ".join(f"{weight:g} x {text}" for weight, text in zip(numbers, self.objectives))
        start = time.perf_counter()
        with self._said():
            report, table, best = self._study.optimum([(name, numbers)], search, starts, quantities.thread_count(threads),
                                                      function_of(progress, "optimising"))
        if self._parts is not None:
            report, table = (self._parts.in_words(text, self._folder.name) for text in (report, table))
        goals = json.loads(report)
        entry = goals["goals"][0] if "goals" in goals else goals
        sensor, axes = None, {}
        if best[0] is not None:
            sensor = self._sensor_at(best[0], "best.toml")
            axes = {axis["name"]: value for axis, value in zip(self._study.axes, best[0])}
        return Optimum(entry, table, sensor, axes, time.perf_counter() - start)

    def __reduce__(self) -> tuple[Any, ...]:
        if self._parts is not None:
            return _made, (self._parts,)
        return _unpickled, (os.path.abspath(self.file), self._study.sha256, self._study.files(), self._tolerance)

    def __eq__(self, other: object) -> bool:
        """The same study: text, every file or sensor that it names, and tolerance. One made of keywords is no equal of one
        that was read."""
        if not isinstance(other, Study):
            return NotImplemented
        if self._parts is not None or other._parts is not None:
            return self._parts == other._parts
        return (self._study.sha256, self.tolerance) == (other._study.sha256, other.tolerance)

    def __hash__(self) -> int:
        return hash((self._study.text if self._parts is not None else self._study.sha256, self.tolerance))

    def __repr__(self) -> str:
        return f"<Study {self.name or self.file!r}: {self.designs} designs>"


def _require_table(frame: Any) -> None:
    if not all(hasattr(frame, name) for name in ("columns", "index", "loc")):
        raise UsageError(f"frame: {quantities.shown(frame)} is no DataFrame; give the table that `run` or `frame` made")


def _whole(number: int, what: str) -> int:
    try:
        design = operator.index(number)
    except TypeError:
        raise TypeError(f"{what}: {quantities.shown(number)} is no number of a design; give a whole number") from None
    if abs(design) >= 1 << 63:
        raise UsageError(f"{what}: {quantities.shown(number)} is not among the designs of the study")
    return design


def _made(parts: StudyParts) -> Study:
    study = object.__new__(Study)
    study._take(parts)
    return study


def _unpickled(file: str, sha256: str, files: list[tuple[str, bytes]], tolerance: float | None) -> Study:
    """The study from its own files where they are there and unchanged, else from copies that came along."""
    if os.path.exists(file):
        try:
            study = Study.load(file, tolerance=tolerance)
            if study._study.sha256 == sha256:
                return study
        except ValueError:
            pass  # another file now lies there
    folder = KeptFolder("mtfkit-study-")
    write_copies(files, folder.name, files[0][0])
    study = Study.load(os.path.join(folder.name, files[0][0]), tolerance=tolerance)
    study._folder = folder
    return study
