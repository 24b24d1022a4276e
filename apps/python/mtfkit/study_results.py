# SPDX-License-Identifier: Apache-2.0
"""What trade studies give beside their table: columns, derivatives, the optimum."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import results

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.sensors import Sensor

    Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class StudyColumn:
    """A column of the rows: its unit ("" for plain numbers), what it is, and the words of its values where they are no
    numbers. `role` is axis, link, metric, objective, feasible, yield or error."""

    name: str
    unit: str
    definition: str
    source: str
    role: str
    levels: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Gradient(results.ByValue):
    """Exact derivatives of a design by the numeric axes, by automatic differentiation; NaN where there is none.

    `value` has a row for each of `columns` and a column for each of `parameters`, in unit of the one per unit of the
    other; `objective` and `margin` (of the constraints, in SI units) likewise.
    """

    columns: list[str]
    parameters: list[str]
    value: Floats
    objective: Floats
    margin: Floats
    seconds: float = 0.0  #: wall time
    __hash__ = None  # type: ignore[assignment]

    def to_pandas(self) -> Any:
        """A DataFrame of `value`: index is the metric, a column for each parameter."""
        return results.pandas("Gradient.to_pandas").DataFrame(self.value, index=self.columns, columns=self.parameters)

    def _repr_html_(self) -> str:
        rows = [[name, *(float(v) for v in row)] for name, row in zip(self.columns, self.value)]
        return results.html_table(["d / d", *self.parameters], rows)


class Optimum(results.ByValue):
    """The best design for one goal, as `mtf optimize`.

    `status` is "optimal", "stopped", "infeasible" or "impossible"; `sensor` is None where no design is feasible.
    """

    def __init__(self, report: dict[str, Any], table: str, sensor: Sensor | None, axes: dict[str, float],
                 seconds: float) -> None:
        self.report = report  #: the JSON of this goal
        self.sensor = sensor  #: the best design as a sensor
        self.axes = axes  #: values of the axes, in their units
        self.seconds = seconds  #: wall time
        self._table = table

    __hash__ = None  # type: ignore[assignment]

    @property
    def status(self) -> str:
        """How it ended."""
        return str(self.report["status"])

    def explain(self) -> results.Text:
        """What limits the design, and what relaxing each limit would gain."""
        return results.Text(self._table)

    def __repr__(self) -> str:
        return f"<Optimum {self.status}: {', '.join(f'{k} = {v:.6g}' for k, v in self.axes.items())}>"

    def _repr_html_(self) -> str:
        return self.explain()._repr_html_()
