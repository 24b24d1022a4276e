# SPDX-License-Identifier: Apache-2.0
"""The budget of a sensor: electrons, each noise term, and the sensitivity that follows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from mtfkit import _core, results
from mtfkit.arguments import checked
from mtfkit.errors import UsageError


@dataclass(frozen=True, eq=False)
class Figure(results.ByValue):
    """A number with its unit. `value` is NaN where there is none, and `reason` says why."""

    name: str
    value: float
    unit: str
    doc: str
    reason: str

    @checked
    def to(self, unit: str) -> float:
        """The value in another unit of the same kind, such as "mK" for a figure in K. Raises UsageError."""
        return _core.convert(self.value, self.unit, unit)

    def __float__(self) -> float:
        return self.value

    def __repr__(self) -> str:
        text = f"{self.name} = {self.value:.7g} {self.unit}".rstrip()
        return f"{text} ({self.reason})" if self.reason else text


def _html(figures: Iterable[Figure], what: str) -> str:
    return results.html_table([what, "value", "unit", "what it is"],
                              [[f.name, "-" if math.isnan(f.value) else f.value, f.unit, f"{f.doc} ({f.reason})" if f.reason else f.doc]
                               for f in figures])


def _frame(figures: Mapping[str, Figure], what: str, asked: str) -> Any:
    pandas = results.pandas(asked)
    return pandas.DataFrame([(f.value, f.unit, f.doc, f.reason) for f in figures.values()],
                            columns=["value", "unit", "doc", "reason"], index=pandas.Index(list(figures), name=what))


class Figures(dict[str, Figure]):
    """Figures of merit by name, each with its unit, and the reason where there is none."""

    def to_pandas(self) -> Any:
        """A DataFrame: index is the name; columns value, unit, doc, reason."""
        return _frame(self, "figure", "Figures.to_pandas")

    def _repr_html_(self) -> str:
        return _html(self.values(), "figure")


class Budget(Mapping[str, Figure]):
    """What `mtf budget` prints, by name: `budget["netd"].to("mK")`.

    `notes` says what the numbers rest on; `saturated` is True where full well or converter is at its end.
    """

    def __init__(self, temperature_k: float, made: dict[str, Any], seconds: float) -> None:
        self.temperature_k = temperature_k
        self.seconds = seconds  #: wall time
        self.notes: tuple[str, ...] = tuple(made["notes"])
        self.saturated: bool = made["saturated"]
        self.saturation: str = made["saturation"]
        self._figures = {row[0]: Figure(*row) for row in made["rows"]}

    def __getitem__(self, name: str) -> Figure:
        try:
            return self._figures[name]
        except KeyError:
            raise UsageError(f"budget: has no {name!r}; it has {', '.join(self._figures)}") from None

    def __contains__(self, name: object) -> bool:
        return name in self._figures

    def __iter__(self) -> Iterator[str]:
        return iter(self._figures)

    def __len__(self) -> int:
        return len(self._figures)

    def to_pandas(self) -> Any:
        """A DataFrame: index is the name; columns value, unit, doc, reason."""
        return _frame(self._figures, "term", "Budget.to_pandas")

    def __repr__(self) -> str:
        return f"<Budget at {self.temperature_k:g} K: {len(self)} figures>"

    def _repr_html_(self) -> str:
        return _html(self._figures.values(), "term")
