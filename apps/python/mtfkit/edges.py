# SPDX-License-Identifier: Apache-2.0
"""The MTF from edges in images, every number with its standard deviation."""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.arguments import checked
from mtfkit.errors import UsageError
from mtfkit.images import Image
from mtfkit.runs import Run

if TYPE_CHECKING:
    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]
    #: A file, an Image, a 2-D array proportional to light, or a Run whose image is meant.
    ImageLike = Union[str, "os.PathLike[str]", Image, Run, npt.ArrayLike]


class Estimate(results.ByValue):
    """A number with its standard deviation `sd` (NaN where a method knows none)."""

    __slots__ = ("sd", "value")

    def __init__(self, value: float, sd: float) -> None:
        self.value = value
        self.sd = sd

    def __float__(self) -> float:
        return self.value

    def _values(self) -> Any:
        return {"value": self.value, "sd": self.sd}

    def __repr__(self) -> str:
        return f"{self.value:.6g} +- {self.sd:.2g}"


_FIGURES = ("mtf50", "mtf30", "mtf20", "mtf10", "mtf50p", "nyquist", "rer", "overshoot", "fwhm_px", "mtfa",
            "sampling_efficiency")


class Edge(results.ByValue):
    """One edge of an image, as `mtf measure --format json` has it.

    Frequencies are along the normal of the edge in the unit that was asked for, cycles/pixel by default. A figure that
    cannot be determined is None. `outcome` is "measured", or what is wrong, and `reason` says what to change.
    """

    def __init__(self, entry: dict[str, Any], unit: str) -> None:
        self._entry = entry
        self.unit = unit  #: of the frequencies

    __hash__ = None  # type: ignore[assignment]

    @property
    def measured(self) -> bool:
        """True where there is a result."""
        return bool(self._entry["outcome"] == "measured")

    @property
    def outcome(self) -> str:
        """"measured", or in a word what is wrong."""
        return str(self._entry["outcome"])

    @property
    def reason(self) -> str:
        """What is wrong or absent, in a sentence; "" for nothing."""
        return self._entry["reason"] or ""

    @property
    def reasons(self) -> dict[str, str]:
        """Of each figure that is None, why."""
        parts = re.split(r"(?:^|; )(\w[\w.]*): ", self.reason) if self.measured else [""]
        said = dict(zip(parts[1::2], parts[2::2]))
        return {name: said.get(name, self.reason) for name, figure in self.figures.items() if figure is None}

    @property
    def warnings(self) -> list[str]:
        """What to be careful with."""
        return list(self._entry["warnings"])

    @property
    def roi(self) -> tuple[int, int, int, int]:
        """x, y, width, height of the region, in pixels."""
        x, y, width, height = self._entry["roi"]
        return x, y, width, height

    @property
    def angle_deg(self) -> float | None:
        """The angle of the edge's normal, in degrees from +x to +y."""
        angle: float | None = self._entry["angle_deg"]
        return angle

    def _estimate(self, name: str) -> Estimate | None:
        found = self._entry.get(name)
        if found is None:
            return None
        sd = found["sd"]
        return Estimate(found["value"], float("nan") if sd is None else sd)

    @property
    def mtf50(self) -> Estimate | None:
        """The frequency of half contrast."""
        return self._estimate("mtf50")

    @property
    def nyquist(self) -> Estimate | None:
        """The MTF at 0.5 cycles/pixel."""
        return self._estimate("nyquist")

    @property
    def rer(self) -> Estimate | None:
        """The relative edge response, E(0.5 px) - E(-0.5 px)."""
        return self._estimate("rer")

    @property
    def fwhm_px(self) -> Estimate | None:
        """The full width at half maximum of the line spread function, in pixels."""
        return self._estimate("fwhm_px")

    @property
    def figures(self) -> dict[str, Estimate | None]:
        """All figures of merit by name, with those of `contrasts`."""
        names = [name for name, value in self._entry.items()
                 if name in _FIGURES or (name.startswith("mtf") and name[3:].replace(".", "").isdigit())]
        return {name: self._estimate(name) for name in names}

    def _numbers(self, curve: str, part: str) -> Floats:
        table = self._entry.get(curve) or {}
        return np.array([np.nan if v is None else v for v in table.get(part, [])], dtype=np.float64)

    @property
    def frequency(self) -> Floats:
        """Frequencies of `mtf`: 0 to 1 cycles/pixel, in `unit`; empty without a result."""
        return self._numbers("mtf", "frequency")

    @property
    def mtf(self) -> Floats:
        """The MTF at `frequency`."""
        return self._numbers("mtf", "value")

    @property
    def mtf_sd(self) -> Floats:
        """Its standard deviation."""
        return self._numbers("mtf", "sd")

    @property
    def otf(self) -> npt.NDArray[np.complex128]:
        """The complex OTF about the edge's location, at `frequency`."""
        return self._numbers("otf", "re") + 1j * self._numbers("otf", "im")

    @property
    def distance_px(self) -> Floats:
        """Distances from the edge of `esf` and `lsf`, in pixels."""
        return self._numbers("esf", "distance_px")

    @property
    def esf(self) -> Floats:
        """The edge spread function, from 0 to 1."""
        return self._numbers("esf", "value")

    @property
    def lsf(self) -> Floats:
        """The line spread function, per pixel."""
        return self._numbers("lsf", "value")

    @property
    def iso12233(self) -> dict[str, Any] | None:
        """With method="both": what ISO 12233 gives for this edge, and the reasons of the difference with their sizes."""
        return self._entry.get("iso12233")

    def to_dict(self) -> dict[str, Any]:
        """Everything, as the JSON of `mtf measure` has it."""
        return dict(self._entry)

    def to_pandas(self) -> Any:
        """A DataFrame: index frequency, columns mtf and sd; `attrs["units"]`, `attrs["reason"]`."""
        pandas = results.pandas("Edge.to_pandas")
        frame = pandas.DataFrame({"mtf": self.mtf, "sd": self.mtf_sd}, index=pandas.Index(self.frequency, name="frequency"))
        frame.attrs.update(units={"frequency": self.unit}, reason=self.reason)
        return frame

    def plot(self, axes: Any = None) -> Any:
        """Draws the MTF with a band of one standard deviation on each side, with matplotlib.

        In the `axes` given, else in new ones; returns them. Raises UsageError for an edge that could not be measured, and
        MissingLibrary, an ImportError, without matplotlib.
        """
        if not self.measured:
            raise UsageError(f"plot: the edge has no MTF: {self.outcome}: {self.reason}")
        return results.plot_mtf(results.axes_for("Edge.plot", axes), self.frequency, self.mtf, self.mtf_sd, self.unit, f"edge at {self.roi}")

    def __repr__(self) -> str:
        if not self.measured:
            return f"<Edge at {self.roi}: {self.outcome} ({self.reason})>"
        figure = f"MTF50 {self.mtf50!r} {self.unit}" if self.mtf50 is not None else f"no MTF50: {self.reasons.get('mtf50', self.reason)}"
        return f"<Edge at {self.roi}: {figure}>"

    def _repr_html_(self) -> str:
        rows: list[list[object]] = [[name, figure.value, figure.sd, ""] if figure else [name, "-", "-", self.reasons.get(name, self.reason)]
                                    for name, figure in self.figures.items()]
        return results.html_table(["figure", "value", "sd", "reason"], rows or [["outcome", self.outcome, "", self.reason]])


class Edges(tuple[Edge, ...]):
    """The edges of an image, best first, with what was left out and why."""

    table: str  #: what `mtf measure` prints
    notes: list[str]  #: what was done to the values, and which edges are left out
    seconds: float  #: wall time

    def __new__(cls, edges: Sequence[Edge], table: str, notes: list[str], seconds: float) -> Edges:
        made = super().__new__(cls, edges)  # type: ignore[arg-type]
        made.table = table
        made.notes = notes
        made.seconds = seconds
        return made

    def to_pandas(self) -> Any:
        """A DataFrame with a line for each edge: outcome, reason, angle, figures with their sd."""
        lines = []
        for edge in self:
            line: dict[str, Any] = {"outcome": edge.outcome, "reason": edge.reason, "angle_deg": edge.angle_deg}
            line.update(zip(("x", "y", "width", "height"), edge.roi))
            for name, figure in edge.figures.items():
                line[name], line[f"{name}_sd"] = (figure.value, figure.sd) if figure else (None, None)
            lines.append(line)
        return results.pandas("Edges.to_pandas").DataFrame(lines)

    def __reduce__(self) -> tuple[Any, ...]:
        return Edges, (tuple(self), self.table, self.notes, self.seconds)

    def _repr_html_(self) -> str:
        return results.Text(self.table)._repr_html_()


def regions_of(roi: Any) -> list[list[int]]:
    """One region or several, x, y, width, height each. Raises UsageError."""
    if roi is None:
        return []
    try:
        rows = np.atleast_2d(np.asarray(roi))
    except ValueError:
        rows = np.empty(0)
    if rows.ndim != 2 or rows.shape[1] != 4 or rows.dtype.kind not in "iu":
        raise UsageError(f"roi: {quantities.shown(roi)} is not (x, y, width, height) in pixels, or a list of them")
    regions: list[list[int]] = rows.tolist()
    return regions


def image_argument(image: ImageLike, name: str = "image") -> Any:
    """What the compiled part takes of an image."""
    if image is None or isinstance(image, (bytes, type, bool, int, float, complex, dict, set)):
        raise UsageError(f"{name}: {quantities.shown(image)} is no image; give a file, an Image, a Run or a 2-D array")
    if isinstance(image, os.PathLike):
        return os.fspath(image)
    if isinstance(image, Image):
        return image._file
    if isinstance(image, Run):
        return image.image
    return image


@checked
def measure(image: ImageLike, *, roi: Sequence[int] | Sequence[Sequence[int]] | None = None, method: str = "regression",
            unit: str = "cy/px", pitch: quantities.Value = None, focal_length: quantities.Value = None,
            contrasts: Sequence[float] = (), channel: str | None = None, encoding: str = "", bayer: str = "",
            pattern: str = "", mask: str | os.PathLike[str] = "", order: int | None = None, circle: bool = False,
            most: int = 64, min_length: float = 20.0, min_cnr: float = 8.0, noise_sd: float | None = None,
            saturation: float | None = None, threads: int = 0) -> Edges:
    """The edges of an image, best first, as `mtf measure`, bit for bit.

    Values have to be proportional to light; NaN pixels are no data. An array of uint8 or uint16 has steps of 1 and is
    clipped at its largest number, others are taken as they are. `roi` is one or more of (x, y, width, height), by
    default what is found. `method` is "regression" (unbiased, with standard deviations), "iso12233" (as other programs),
    or "both" with the reasons of the difference. `unit`: cy/px, cy/mm or lp/mm (needs `pitch`), cy/mrad (and
    `focal_length`), lw/ph. `contrasts` adds the frequencies of these contrasts, 0.35 as figure "mtf35". `channel`,
    `encoding`, `bayer`, `pattern`, `mask` say what of a file is measured; `order` and `circle` the shape of the edge;
    `most`, `min_length` (pixels) and `min_cnr` which edges are found.

    What cannot be measured is an Edge with its reason, never an exception. Raises UsageError for wrong arguments and
    DataError for files that cannot be read.
    """
    regions = regions_of(roi)
    words = {"channel": channel, "encoding": encoding, "bayer": bayer, "pattern": pattern, "mask": os.fspath(mask),
             "regions": regions, "most": quantities.count(most, "most"), "min_length_px": min_length, "min_cnr": min_cnr, "noise_sd": noise_sd,
             "saturation": saturation}
    order = None if order is None else quantities.count(order, "order")
    pitch_um = None if pitch is None else quantities.micrometres(pitch, "pitch")
    focal_mm = None if focal_length is None else quantities.micrometres(focal_length, "focal_length") * 1e-3
    start = time.perf_counter()
    made, table, notes = _core.measure(image_argument(image), words, method, order, circle, unit, pitch_um, focal_mm,
                                       list(contrasts), quantities.thread_count(threads))
    report = json.loads(made)
    return Edges([Edge(entry, report["unit"]) for entry in report["edges"]], table, notes,
                 time.perf_counter() - start)
