# SPDX-License-Identifier: Apache-2.0
"""The air by itself: transmission and thermal radiance of a line of sight, the sky, as `mtf atmosphere`."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.arguments import checked
from mtfkit.errors import UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]

__all__ = ["BandAverage", "Line", "Sky", "line", "sky"]


@dataclass(frozen=True, eq=False)
class BandAverage(results.ByValue):
    """Averages over a band, weighted by a blackbody and, for a sensor file, by its response.

    `transmission` is that of the blackbody's light, `contrast_transmission` that of a small difference of temperature,
    `path_radiance` in `path_radiance_unit` is NaN where the model has no emission. `components` are transmissions.
    """

    wavelength_um: tuple[float, float]
    transmission: float
    contrast_transmission: float
    path_radiance: float
    path_radiance_unit: str
    components: dict[str, float]
    __hash__ = None  # type: ignore[assignment]


def _numbers(values: Sequence[float | None]) -> Floats:
    return np.array([np.nan if v is None else v for v in values], dtype=np.float64)


class Line(results.ByValue):
    """The spectrum of a line of sight, rising in wavenumber, and its averages in bands."""

    def __init__(self, report: dict[str, Any], seconds: float) -> None:
        self.report = report  #: the JSON of `mtf atmosphere`
        self.seconds = seconds  #: wall time
        self.air = str(report["air"])  #: in words
        self.bands = tuple(BandAverage(
            wavelength_um=(band["wavelength_um"][0], band["wavelength_um"][1]), transmission=band["transmission"],
            contrast_transmission=band["contrast_transmission"],
            path_radiance=float("nan") if band["path_radiance"] is None else band["path_radiance"],
            path_radiance_unit=band["path_radiance_unit"], components=band["components"]) for band in report["bands"])

    __hash__ = None  # type: ignore[assignment]

    @property
    def wavenumber_cm(self) -> Floats:
        """Wavenumbers in cm^-1."""
        return _numbers(self.report["wavenumber_cm-1"])

    @property
    def wavelength_um(self) -> Floats:
        """The same as wavelengths, falling."""
        return np.asarray(1e4 / self.wavenumber_cm, dtype=np.float64)

    @property
    def transmittance(self) -> Floats:
        """The transmittance of the whole line."""
        return _numbers(self.report["transmittance"])

    @property
    def path_radiance(self) -> Floats:
        """Thermal radiance of the path in W m-2 sr-1 per cm-1; NaN above 3500 cm-1, where the model has none."""
        return _numbers(self.report["path_radiance_W_m-2_sr-1_per_cm-1"])

    @property
    def components(self) -> dict[str, Floats]:
        """Transmittances of the absorbers and of what scatters."""
        return {name: _numbers(values) for name, values in self.report["components"].items()}

    @property
    def limits(self) -> list[str]:
        """What the model is not good for here."""
        return list(self.report["limits"])

    def to_pandas(self) -> Any:
        """A DataFrame: index wavelength [um], columns transmittance, path_radiance and the components."""
        pandas = results.pandas("Line.to_pandas")
        frame = pandas.DataFrame({"transmittance": self.transmittance, "path_radiance": self.path_radiance,
                                  **self.components}, index=pandas.Index(self.wavelength_um, name="wavelength_um"))
        frame.attrs["units"] = {"path_radiance": "W.m^-2.sr^-1.cm"}
        return frame

    def __repr__(self) -> str:
        return f"<Line through {self.air}: {', '.join(f'{b.transmission:.4f}' for b in self.bands)}>"


class Sky(results.ByValue):
    """The radiance of the sky over the zenith angle, and the flux that a horizontal plane gets."""

    def __init__(self, report: dict[str, Any], seconds: float) -> None:
        self.report = report  #: the JSON of `mtf atmosphere --sky`
        self.seconds = seconds  #: wall time
        self.longwave_w_m2 = float(report["longwave_w_m2"])  #: long-wave flux on a horizontal plane

    __hash__ = None  # type: ignore[assignment]

    @property
    def zenith_angle_deg(self) -> Floats:
        """Zenith angles of `radiance`."""
        return _numbers(self.report["zenith_angle_deg"])

    @property
    def radiance(self) -> Floats:
        """Radiance in W m-2 sr-1 over all wavelengths of the model."""
        return _numbers(self.report["radiance_W_m-2_sr-1"])

    def __repr__(self) -> str:
        return f"<Sky: {self.longwave_w_m2:.4g} W m-2 on a horizontal plane>"

    def in_band(self, band: int = 0) -> Floats:
        """Radiance in W m-2 sr-1 in one of the bands."""
        return _numbers(self.report["bands"][band]["radiance_W_m-2_sr-1"])


def _settings(settings: dict[str, Any]) -> list[tuple[str, str]]:
    known = [row["name"] for table in _core.kinds()["tables"] if table["name"] == "atmosphere" for row in table["parameters"]]
    for name in settings:
        if name not in known:
            import difflib

            near = difflib.get_close_matches(name, known, 1)
            raise UsageError(f"{name}: unknown key of [atmosphere]" + (f"; did you mean {near[0]!r}?" if near else "")
                             + f" (known: {', '.join(known)})")
    return [(name, quantities.words(value, name)) for name, value in settings.items()]


def _bands(bands: Sequence[tuple[quantities.Value, quantities.Value]]) -> str:
    if not isinstance(bands, (list, tuple)):
        raise UsageError(f"bands: {quantities.shown(bands)} is no list of bands; write [(\"8 um\", \"12 um\")]")
    return ",".join(":".join(map(repr, quantities.band_um(band, f"bands[{number}]"))) for number, band in enumerate(bands))


@checked
def line(file: str | os.PathLike[str] = "", *, bands: Sequence[tuple[quantities.Value, quantities.Value]] = (),
         source_temperature: quantities.Value = "300 K", tolerance: float = 0.0, **settings: quantities.Value) -> Line:
    """The air along a line of sight, as `mtf atmosphere`, number for number.

    `settings` are keys of [atmosphere]: model, haze, visibility, sensor_altitude, zenith_angle, range, ...; `file` is a
    sensor or scene file whose [atmosphere] they change. `bands` are pairs of wavelengths, by default that of the sensor,
    or four usual ones. Raises UsageError for air and lines that cannot be.

    >>> import mtfkit as mk
    >>> line = mk.air.line(model="mid_latitude_summer", range="2 km", bands=[("8 um", "12 um")])
    >>> 0.5 < line.bands[0].transmission < 0.8
    True
    """
    start = time.perf_counter()
    made = _core.atmosphere(os.fspath(file), _settings(settings), _bands(bands),
                            quantities.kelvin(source_temperature, "source_temperature"), tolerance, False, None, None)
    return Line(json.loads(made), time.perf_counter() - start)


@checked
def sky(file: str | os.PathLike[str] = "", *, bands: Sequence[tuple[quantities.Value, quantities.Value]] = (),
        cloud_cover: float | None = None, cloud_temperature: quantities.Value = None, tolerance: float = 0.0,
        **settings: quantities.Value) -> Sky:
    """The sky over that air, as `mtf atmosphere --sky`; clouds are black, of `cloud_temperature`."""
    kelvin = None if cloud_temperature is None else quantities.kelvin(cloud_temperature, "cloud_temperature")
    if (cloud_cover is None) != (kelvin is None):
        raise UsageError("clouds: give cloud_cover and cloud_temperature, or neither")
    start = time.perf_counter()
    made = _core.atmosphere(os.fspath(file), _settings(settings), _bands(bands), 300.0, tolerance, True, cloud_cover, kelvin)
    return Sky(json.loads(made), time.perf_counter() - start)
