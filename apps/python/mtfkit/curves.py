# SPDX-License-Identifier: Apache-2.0
"""The OTF of a sensor along a direction: of each component, of each list, and of the whole."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import results

if TYPE_CHECKING:
    import numpy.typing as npt

    Complexes = npt.NDArray[np.complex128]
    Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Column(results.ByValue):
    """The OTF of one component, of one list, or of the whole sensor.

    `otf` has a complex value at each frequency; `error` is what its average over the band may err by, absolute.
    """

    label: str
    kind: str
    stage: str
    doc: str
    real: bool
    otf: Complexes
    error: Floats
    __hash__ = None  # type: ignore[assignment]

    @property
    def mtf(self) -> Floats:
        """The modulus of the OTF."""
        return np.abs(self.otf)


@dataclass(frozen=True, eq=False)
class Curves(results.ByValue):
    """What `mtf curve` gives, bit for bit: columns by their label, the last one being "system".

    `frequency` is in `unit` along `angle_deg`, the angle from +x (columns) to +y (rows). `nyquist`, `cutoff` and `q` are
    in that unit and direction; `cutoff` and `q` are None for a sensor without optics.
    """

    name: str
    unit: str
    angle_deg: float
    nyquist: float
    cutoff: float | None
    q: float | None
    frequency: Floats
    columns: tuple[Column, ...]
    seconds: float = 0.0  #: wall time
    table_error: float = 0.0  #: of components made of functions: what tables in their place err by, absolute
    __hash__ = None  # type: ignore[assignment]

    @property
    def promised(self) -> float:
        """The error of the whole sensor's OTF at any of the frequencies, absolute: of its average over the band, and of
        tables in place of functions. Rounding apart."""
        return float(self.system.error.max(initial=0.0)) + self.table_error

    def __getitem__(self, label: str) -> Column:
        for column in self.columns:
            if column.label == label:
                return column
        raise KeyError(label)

    def __iter__(self) -> Iterator[Column]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def system(self) -> Column:
        """The whole sensor."""
        return self.columns[-1]

    def to_pandas(self) -> Any:
        """A DataFrame of moduli: the index is the frequency, a column for each label; `attrs["units"]`."""
        frame = results.pandas("Curves.to_pandas").DataFrame(
            {column.label: column.mtf for column in self.columns},
            index=results.pandas("Curves.to_pandas").Index(self.frequency, name="frequency"))
        frame.attrs["units"] = {"frequency": self.unit}
        return frame

    def to_xarray(self) -> Any:
        """A complex DataArray with the dimensions (component, frequency); `attrs["units"]` of the frequency."""
        array = results.xarray("Curves.to_xarray").DataArray(
            np.array([column.otf for column in self.columns]), dims=("component", "frequency"),
            coords={"component": [column.label for column in self.columns], "frequency": self.frequency}, name="otf")
        array.coords["frequency"].attrs["units"] = self.unit
        array.attrs.update(units="1", angle_deg=self.angle_deg, long_name=self.name)
        return array

    def plot(self, axes: Any = None) -> Any:
        """Draws the moduli against the frequency with matplotlib, the whole sensor as the thick line, Nyquist as the dotted one.

        In the `axes` given, else in new ones; returns them. Raises MissingLibrary, an ImportError, without matplotlib.
        """
        axes = results.axes_for("Curves.plot", axes)
        for column in self.columns:
            axes.plot(self.frequency, column.mtf, label=column.label, linewidth=2.5 if column is self.system else 1.0)
        if self.frequency.size and self.nyquist <= self.frequency.max():
            axes.axvline(self.nyquist, color="grey", linestyle=":", linewidth=1.0)
        axes.set(xlabel=f"frequency [{self.unit}]", ylabel="MTF", title=self.name)
        axes.legend()
        return axes

    def __repr__(self) -> str:
        labels = ", ".join(column.label for column in self.columns)
        return f"<Curves of {self.name!r}: {labels} at {len(self.frequency)} frequencies [{self.unit}]>"

    def _repr_html_(self) -> str:
        step = max(1, len(self.frequency) // 12)
        rows = [[float(self.frequency[i]), *(float(column.mtf[i]) for column in self.columns)]
                for i in range(0, len(self.frequency), step)]
        return results.html_table([self.unit, *(column.label for column in self.columns)], rows)


def curves_of(made: dict[str, Any], seconds: float = 0.0, table_error: float = 0.0) -> Curves:
    """From what the compiled part returns."""
    columns = tuple(Column(**column) for column in made.pop("columns"))
    return Curves(columns=columns, seconds=seconds, table_error=table_error, **made)
