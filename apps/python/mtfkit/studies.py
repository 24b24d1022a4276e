# SPDX-License-Identifier: Apache-2.0
"""Trade studies: every design of a study file as a table, the best ones, derivatives, the optimum."""

from __future__ import annotations

import json
import operator
import os
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.errors import UsageError
from mtfkit.progress import Progress, function_of
from mtfkit.sensors import Sensor
from mtfkit.study_results import Gradient, Optimum, StudyColumn

if TYPE_CHECKING:
    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]


class Study:
    """A trade study, as its file describes it. It never changes, and pickles with all its files.

    >>> import mtfkit as mk
    >>> study = mk.Study.load("notebooks-data/studies/aperture_against_pitch.toml")
    >>> study.designs
    1221
    >>> rows = study.rows(0, 10)
    >>> rows.shape == (10, len(study.columns))
    True
    """

    def __init__(self, file: str | os.PathLike[str], *, tolerance: float | None = None) -> None:
        if tolerance is not None and not 1e-12 <= tolerance <= 0.1:
            raise UsageError(f"tolerance: {tolerance!r} is outside 1e-12 to 0.1")
        self._tolerance = tolerance
        self._study = _core.StudyFile(os.fspath(file), tolerance)
        self._folder: Any = None  # of copies, where the files came by pickle

    @classmethod
    def load(cls, file: str | os.PathLike[str], *, tolerance: float | None = None) -> Study:
        """Reads a study file; `tolerance` in place of its own. Raises UsageError with every error as a
        "file:line:column" line, DataError when a file cannot be read."""
        return cls(file, tolerance=tolerance)

    @property
    def name(self) -> str:
        """`name` of the study file."""
        return self._study.name

    @property
    def file(self) -> str:
        """The study file."""
        return self._study.file

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
        """What the file leaves in doubt."""
        return self._study.warnings

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
        are not there.
        """
        if isinstance(first, tuple):
            first, last = first
        return self._study.rows(first, self.designs if last is None else last, quantities.thread_count(threads),
                                function_of(progress, self.name or "designs"))

    def run(self, *, threads: int = 0, progress: Progress = None) -> Any:
        """All designs as a DataFrame: see `frame`. `threads` 0 = all cores; `progress` True for a line on standard error,
        or a function of the share done. Ctrl-C ends it. `attrs["seconds"]` is the wall time, the column `error` the
        error that each design promises."""
        start = time.perf_counter()
        frame = self.frame(self.rows(0, self.designs, threads=threads, progress=progress))
        frame.attrs["seconds"] = time.perf_counter() - start
        return frame

    def frame(self, rows: npt.ArrayLike | Sequence[npt.ArrayLike], *, first: int = 0) -> Any:
        """Rows (or a list of pieces that follow one another) as a DataFrame.

        The index is the number of the design, from `first` on; columns are those of the study, with the words of axes
        that are no numbers and `feasible` as True or False; `attrs["units"]` has the unit of each.
        """
        pandas = results.pandas("Study.frame")
        table = np.concatenate([np.asarray(piece) for piece in rows]) if isinstance(rows, (list, tuple)) else np.asarray(rows)
        columns = self.columns
        if table.ndim != 2 or table.shape[1] != len(columns):
            raise UsageError(f"rows: have the shape {table.shape}, the study has {len(columns)} columns")
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
        table = np.empty((len(frame), len(self.columns)))
        for i, column in enumerate(self.columns):
            if column.name not in frame:
                raise UsageError(f"the table has no column {column.name}; give one that `run` or `frame` made")
            values = frame[column.name]
            table[:, i] = values.cat.codes if column.levels else values
        return table

    def pareto(self, frame: Any) -> Any:
        """The rows of the feasible designs that no other one beats in all objectives, as in `mtf sweep`."""
        front = self._study.pareto([int(n) for n in frame.index], self._table(frame))
        return frame.loc[front]

    def to_xarray(self, frame: Any) -> Any:
        """A Dataset of all designs of a grid: the axes become dimensions, metrics variables with `attrs["units"]`.

        Raises UsageError for samples, and for a table that is not whole.
        """
        xarray = results.xarray("Study.to_xarray")
        if not self._study.grid:
            raise UsageError("to_xarray: the designs of this study are samples, not a grid")
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
        return self._study.axis_values(operator.index(design))

    def axes(self, design: int) -> dict[str, float | str]:
        """The values of the axes of a design, in the units of the columns; words where they are no numbers."""
        made: dict[str, float | str] = {}
        for axis, value in zip(self._study.axes, self._values(design)):
            made[axis["name"]] = axis["levels"][int(value)] if axis["levels"] else value
        return made

    def sensor(self, design: int) -> Sensor:
        """The sensor of a design, with all its numbers set: what `mtf sweep` writes as a chosen design."""
        file = os.path.join(os.path.dirname(self.file), f"design_{int(design)}.toml")
        return Sensor._of(self._study.sensor_at(self._values(design), file))

    def gradient(self, design: int) -> Gradient:
        """Exact derivatives of the metrics, objectives and constraints of a design by the numeric axes."""
        start = time.perf_counter()
        made = self._study.gradient_at(self._values(design))
        return Gradient(**made, seconds=time.perf_counter() - start)

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
            name = " + ".join(f"{weight:g} x {text}" for weight, text in zip(numbers, self.objectives))
        start = time.perf_counter()
        report, table, best = self._study.optimum([(name, numbers)], search, starts, quantities.thread_count(threads),
                                                  function_of(progress, "optimising"))
        goals = json.loads(report)
        entry = goals["goals"][0] if "goals" in goals else goals
        sensor, axes = None, {}
        if best[0] is not None:
            file = os.path.join(os.path.dirname(self.file), "best.toml")
            sensor = Sensor._of(self._study.sensor_at(best[0], file))
            axes = {axis["name"]: value for axis, value in zip(self._study.axes, best[0])}
        return Optimum(entry, table, sensor, axes, time.perf_counter() - start)

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        return _unpickled, (os.path.abspath(self.file), self._study.sha256, self._study.files(), self._tolerance)

    def __eq__(self, other: object) -> bool:
        """The same study: text, every file that it names, and tolerance."""
        if not isinstance(other, Study):
            return NotImplemented
        return (self._study.sha256, self.tolerance) == (other._study.sha256, other.tolerance)

    def __hash__(self) -> int:
        return hash((self._study.sha256, self.tolerance))

    def __repr__(self) -> str:
        return f"<Study {self.name or self.file!r}: {self.designs} designs>"


def _unpickled(file: str, sha256: str, files: list[tuple[str, bytes]], tolerance: float | None) -> Study:
    """The study from its own files where they are there and unchanged, else from copies that came along."""
    if os.path.exists(file):
        try:
            study = Study(file, tolerance=tolerance)
            if study._study.sha256 == sha256:
                return study
        except ValueError:
            pass  # another file now lies there
    import tempfile

    folder = tempfile.TemporaryDirectory(prefix="mtfkit-study-")
    for name, content in files:
        path = os.path.join(folder.name, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as copy:
            copy.write(content)
    study = Study(os.path.join(folder.name, files[0][0]), tolerance=tolerance)
    study._folder = folder
    return study
