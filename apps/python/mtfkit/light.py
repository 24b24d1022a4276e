# SPDX-License-Identifier: Apache-2.0
"""Blackbodies: at a wavelength, in a band, through curves. Relative errors stay below 2e-15 from 1 K to 1e9 K.

Arguments are arrays of plain numbers in the unit that their names say, and broadcast. `flux` is "watts" (W) or "photons"
(photons per second); at 0 K every radiance is 0, a negative temperature or wavelength gives NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities
from mtfkit.arguments import checked
from mtfkit.errors import UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["BandResponse", "band_derivative", "band_radiance", "band_temperature", "brightness_temperature", "log_planck",
           "planck", "planck_derivative"]


def _at_wavelength(what: str, wavelength_um: npt.ArrayLike, other: npt.ArrayLike, flux: str) -> Any:
    name = "radiance" if what == "brightness_temperature" else "temperature_k"
    a, b = quantities.broadcast(wavelength_um, "wavelength_um", other, name)
    return _core.blackbody(what, flux, a.ravel(), b.ravel()).reshape(a.shape)[()]


@checked
def planck(wavelength_um: npt.ArrayLike, temperature_k: npt.ArrayLike, *, flux: str = "watts") -> Any:
    """Spectral radiance of a blackbody: W (or photons s-1) m-2 sr-1 um-1. Raises UsageError for another flux.

    >>> import mtfkit as mk
    >>> round(float(mk.light.planck(10.0, 300.0)), 3)
    9.924
    """
    return _at_wavelength("planck", wavelength_um, temperature_k, flux)


@checked
def log_planck(wavelength_um: npt.ArrayLike, temperature_k: npt.ArrayLike, *, flux: str = "watts") -> Any:
    """The natural logarithm of `planck`, also where that is too small for a double."""
    return _at_wavelength("log_planck", wavelength_um, temperature_k, flux)


@checked
def planck_derivative(wavelength_um: npt.ArrayLike, temperature_k: npt.ArrayLike, *, flux: str = "watts") -> Any:
    """The derivative of `planck` by the temperature, per K."""
    return _at_wavelength("planck_derivative", wavelength_um, temperature_k, flux)


@checked
def brightness_temperature(wavelength_um: npt.ArrayLike, radiance: npt.ArrayLike, *, flux: str = "watts") -> Any:
    """The temperature in K of the blackbody of that spectral radiance: the inverse of `planck`."""
    return _at_wavelength("brightness_temperature", wavelength_um, radiance, flux)


def _in_band(what: str, band: tuple[quantities.Value, quantities.Value], other: npt.ArrayLike, flux: str) -> Any:
    values = quantities.numbers(other, "radiance" if what == "temperature" else "temperature_k")
    lo, hi = quantities.band_um(band, "band")
    return _core.blackbody_band(what, flux, lo, hi, values.ravel()).reshape(values.shape)[()]


@checked
def band_radiance(band: tuple[quantities.Value, quantities.Value], temperature_k: npt.ArrayLike, *,
                  flux: str = "watts") -> Any:
    """Radiance of a blackbody in a band, ("3.4 um", "4.8 um"): W (or photons s-1) m-2 sr-1."""
    return _in_band("radiance", band, temperature_k, flux)


@checked
def band_derivative(band: tuple[quantities.Value, quantities.Value], temperature_k: npt.ArrayLike, *,
                    flux: str = "watts") -> Any:
    """The derivative of `band_radiance` by the temperature, per K."""
    return _in_band("derivative", band, temperature_k, flux)


@checked
def band_temperature(band: tuple[quantities.Value, quantities.Value], radiance: npt.ArrayLike, *,
                     flux: str = "watts") -> Any:
    """The temperature in K of the blackbody of that radiance in the band: the inverse of `band_radiance`."""
    return _in_band("temperature", band, radiance, flux)


class BandResponse:
    """A product of curves over a band: filter x optics x quantum efficiency, each (wavelength_um, value).

    Between samples a curve is a straight line, and outside its range it is 0. Raises UsageError for curves that do not
    rise or have nothing in common with the band.
    """

    def __init__(self, band: tuple[quantities.Value, quantities.Value],
                 curves: Sequence[tuple[npt.ArrayLike, npt.ArrayLike]] = ()) -> None:
        lo, hi = quantities.band_um(band, "band")
        if not isinstance(curves, (list, tuple)):
            raise UsageError(f"curves: {quantities.shown(curves)} is no list of curves; write [(wavelength_um, value)]")
        given = []
        for number, curve in enumerate(curves):
            if not isinstance(curve, (list, tuple)) or len(curve) != 2:
                raise UsageError(f"curves[{number}]: {quantities.shown(curve)} is no curve; write (wavelength_um, value), two arrays")
            w, v = (quantities.numbers(part, f"curves[{number}]").ravel().tolist() for part in curve)
            given.append((w, v))
        self._given = (lo, hi, given)
        self._response = _core.BandResponse(lo, hi, given)

    def __reduce__(self) -> tuple[Any, ...]:
        lo, hi, curves = self._given
        return BandResponse, ((f"{lo!r} um", f"{hi!r} um"), curves)

    def __eq__(self, other: object) -> bool:
        """The same band and curves."""
        if not isinstance(other, BandResponse):
            return NotImplemented
        return self._given == other._given

    def __hash__(self) -> int:
        return hash(self._given[:2])

    def __repr__(self) -> str:
        lo, hi = self.range_um
        return f"<BandResponse {lo:g} to {hi:g} um, integral {self.integral_um:.6g} um>"

    @property
    def range_um(self) -> tuple[float, float]:
        """The wavelengths that band and curves have in common."""
        return self._response.range_um

    @property
    def integral_um(self) -> float:
        """The integral of the product, in um."""
        return self._response.integral_um

    @checked
    def radiance(self, temperature_k: npt.ArrayLike, *, flux: str = "watts") -> Any:
        """The weighted radiance of a blackbody: W (or photons s-1) m-2 sr-1."""
        return self._of(temperature_k, flux, False)

    @checked
    def derivative(self, temperature_k: npt.ArrayLike, *, flux: str = "watts") -> Any:
        """Its derivative by the temperature, per K."""
        return self._of(temperature_k, flux, True)

    def _of(self, temperature_k: npt.ArrayLike, flux: str, derivative: bool) -> Any:
        values = quantities.numbers(temperature_k, "temperature_k")
        return self._response.radiance(flux, values.ravel(), derivative).reshape(values.shape)[()]
