# SPDX-License-Identifier: Apache-2.0
"""Image files in and out: OpenEXR, ENVI, PNG, TIFF and, for reading, JPEG, FITS, PGM, PPM and BMP."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, quantities, results
from mtfkit.arguments import checked
from mtfkit.errors import DataError, UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

    Plane = npt.NDArray[np.float32]


class SpacedPlane(np.ndarray):  # type: ignore[type-arg]
    """Values of a file with the spacing that it states, `sample`: an array as any other, which `simulate`, `compile` and
    `write` take with its spacing.

    Rectangles of it keep it, and what is computed of it value by value. All else has None, as every second row.
    """

    sample: tuple[str, str] | None = None

    def _spaced(self, made: Any) -> Any:
        made.sample = self.sample
        return made

    def __getitem__(self, index: Any) -> Any:
        made = super().__getitem__(index)
        cuts = index if isinstance(index, tuple) else (index,)
        whole = len(cuts) <= 2 and all(isinstance(cut, slice) and cut.step in (None, 1) for cut in cuts)
        return self._spaced(made) if whole and isinstance(made, SpacedPlane) and made.ndim == 2 else made

    def __array_wrap__(self, made: Any, context: Any = None) -> Any:
        if made.ndim == 0:
            return made[()]
        made = super().__array_wrap__(made, context)
        same = context is not None and made.shape == self.shape and all(
            given.sample == self.sample for given in context[1] if isinstance(given, SpacedPlane))
        return self._spaced(made) if same else made

    def copy(self, order: Any = "C") -> Any:
        """As of any array."""
        return self._spaced(super().copy(order))

    def astype(self, *arguments: Any, **named: Any) -> Any:
        """As of any array."""
        made = super().astype(*arguments, **named)
        return self._spaced(made) if isinstance(made, SpacedPlane) else made

    def __reduce__(self) -> Any:
        made: Any = super().__reduce__()
        return *made[:2], (made[2], self.sample)

    def __setstate__(self, state: Any) -> None:
        values, self.sample = state
        super().__setstate__(values)


def stated_um(sample: tuple[str, str]) -> tuple[float, float]:
    """A spacing that a plane states, along x and y in um."""
    return _core.length_um(sample[0]), _core.length_um(sample[1])


def same_um(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether two spacings are one, but for rounding."""
    return bool(np.allclose(one, other, rtol=1e-6, atol=0))


def sample_of(planes: Iterable[object], sample: quantities.Value) -> quantities.Value:
    """The spacing that the caller gives, else that of the planes themselves. Raises UsageError where theirs differ."""
    if sample is not None:
        return sample
    stated = [plane.sample for plane in planes if isinstance(plane, SpacedPlane) and plane.sample]
    for other in stated[1:]:
        if not same_um(stated_um(stated[0]), stated_um(other)):
            raise UsageError("sample: planes state spacings of {:.6g} x {:.6g} um and {:.6g} x {:.6g} um; give planes of one spacing, or "
                             "sample= for all of them".format(*stated_um(stated[0]), *stated_um(other)))
    return stated[0] if stated else None


#: Units of the quantities of scenes.
_UNITS = {"radiance": "W.m^-2.sr^-1", "photon_radiance": "ph.s^-1.m^-2.sr^-1", "temperature": "K", "counts": "counts"}


@dataclass(frozen=True, eq=False)
class CountTemperatures(results.ByValue):
    """Temperatures in K of an image of counts, pixel by pixel, NaN where there is none.

    `sd_k` is the standard deviation of first order that the stated ones leave, and `shares` the part of each of these in
    its variance, by name; both are NaN where the first order does not hold. `low_k` and `high_k` are the ends of 95 %, which
    hold there too; NaN where some of the temperatures there are none. Nothing of all this is there (None, {}) where no
    standard deviation is stated. What the camera itself errs is not in it.
    """

    temperature_k: npt.NDArray[np.float64]
    sd_k: npt.NDArray[np.float64] | None
    low_k: npt.NDArray[np.float64] | None
    high_k: npt.NDArray[np.float64] | None
    shares: dict[str, npt.NDArray[np.float64]]
    __hash__ = None  # type: ignore[assignment]


class Image(results.ByValue):
    """An image file in memory, as it was stored: planes of float32 by name, and what the file says of them.

    Made by `read`. `sensor.simulate(image)` gives what the file itself would give. Images pickle; two are equal when their
    planes and all that the file says are, wherever it lies.
    """

    __slots__ = ("_file",)

    def __init__(self, file: _core.ImageFile) -> None:
        self._file = file

    def _values(self) -> Any:
        return {"planes": {name: self._file.plane(name) for name in self.names}, "attributes": self.attributes,
                "what": (self.integer, self.encoding, self._file.storage, self._file.pitch_um, self.notes)}

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return Image, (self._file,)

    @property
    def path(self) -> str:
        """The file it was read from."""
        return self._file.path

    @property
    def names(self) -> list[str]:
        """Names of the planes: "Y", or "R", "G", "B", or those that the file gives."""
        return self._file.names

    @property
    def integer(self) -> bool:
        """True for values that are stored as whole numbers: they are their counts."""
        return self._file.integer

    @property
    def attributes(self) -> dict[str, str]:
        """What the file says beside the pixels, as text."""
        return self._file.attributes

    @property
    def encoding(self) -> str:
        """The curve between light and stored values that the file states: "srgb", "gamma:2.2", ...; "" for none."""
        return self._file.encoding

    @property
    def notes(self) -> list[str]:
        """What the file holds and is not read, and what else to know of its values: "read as page 1 of 3: ..."."""
        return self._file.notes

    @property
    def sample(self) -> tuple[str, str] | None:
        """The spacing of the samples along x and y that the file states, for `sample=`; None where it states none."""
        pitch = self._file.pitch_um
        return None if pitch is None else (f"{pitch[0]!r} um", f"{pitch[1]!r} um")

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        rows, columns = self.plane(self.names[0]).shape
        return rows, columns

    @checked
    def plane(self, name: str | None = None) -> Plane:
        """The values of one plane, (rows, columns) of float32: a view that cannot be written, nothing is copied.

        Its `sample` is the spacing that the file states, which `simulate`, `compile` and `write` take from it.
        Without a name the image has to have one plane. Raises UsageError for a name that is not there.
        """
        if name is None:
            if len(self.names) != 1:
                raise UsageError(f"{self.path}: has the planes {', '.join(self.names)}; name one of them")
            name = self.names[0]
        values = self._file.plane(name)
        if self.sample is None:
            return values
        plane = values.view(SpacedPlane)
        plane.sample = self.sample
        return plane

    @checked
    def temperatures(self, **assumed: quantities.Value) -> CountTemperatures:
        """Temperatures of the counts of a thermal camera, by what its file says, with the uncertainty that is stated here.

        Keywords are numbers in place of those of the file, standard deviations, or both: `emissivity="0.95 +- 0.02"`,
        `surroundings="+- 2 K"`, `distance`, `air_temperature`, `relative_humidity`, `window_transmission`, `window_temperature`.
        Raises UsageError for keywords that are none of these, numbers that cannot be, and files without constants of a camera.
        """
        plane = self.plane()
        counts, place = np.unique(np.asarray(plane, dtype=np.float64), return_inverse=True)
        names, numbers = _core.count_temperatures(self.attributes, [f"{key}={words}" for key, words in assumed.items()], counts)
        temperature, holds, sd, low, high, *shares = (column[place].reshape(plane.shape) for column in numbers)
        if not names:
            return CountTemperatures(temperature, None, None, None, {})
        sd, *shares = (np.where(holds == 1.0, values, np.nan) for values in (sd, *shares))
        return CountTemperatures(temperature, sd, low, high, dict(zip(names, shares)))

    def __array__(self, dtype: npt.DTypeLike | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.plane(), dtype=dtype)

    def __repr__(self) -> str:
        rows, columns = self.shape
        return f"<Image {self.path}: {columns} x {rows}, {', '.join(self.names)}, {self._file.storage}>"


@checked
def read(path: str | os.PathLike[str], *, channel: str | None = None, layer: str | None = None,
         part: int | None = None) -> Image:
    """Reads an image of any format of `mtf info --formats`. Values are linear float32 as stored, integers being their counts.

    `channel` is one full name, `layer` the channels of a layer ("" = those without one), `part` a part of a file of
    several. Raises UsageError where a choice is needed, and lists what there is; DataError for a file that is missing
    or damaged.
    """
    return Image(_core.read(os.fspath(path), channel, layer, None if part is None else quantities.count(part, "part", 0)))


#: Attributes that files of these formats have by themselves.
_OWN = frozenset(("channels", "chunkCount", "compression", "dataWindow", "displayWindow", "lineOrder", "name", "pixelAspectRatio",
                  "screenWindowCenter", "screenWindowWidth", "tiles", "type", "version"))


def _stored(attributes: Mapping[str, object] | None) -> tuple[dict[str, str], dict[str, tuple[float, float]], dict[str, list[float]]]:
    text: dict[str, str] = {}
    pairs: dict[str, tuple[float, float]] = {}
    lists: dict[str, list[float]] = {}
    for name, value in (attributes or {}).items():
        what = f"attributes[{name!r}]"
        if name in _OWN:
            continue
        if isinstance(value, tuple) and len(value) == 2 and not isinstance(value[0], str):
            pairs[name] = (quantities.number(value[0], what), quantities.number(value[1], what))
        elif isinstance(value, (list, np.ndarray)):
            lists[name] = quantities.numbers(value, what).ravel().tolist()
        else:
            text[name] = str(value)
    return text, pairs, lists


@checked
def write(path: str | os.PathLike[str], planes: Image | npt.ArrayLike | Mapping[str, npt.ArrayLike], *,
          sample: quantities.Value = None, quantity: str | None = None, attributes: Mapping[str, object] | None = None,
          range: tuple[float, float] | None = None, bits: int = 16) -> None:
    """Writes one plane, planes by name, or an Image, as the ending says: .exr or .hdr (ENVI; float32), .png or .tif (integers).

    `sample` is the spacing of the samples at the focal plane, "3.75 um" or a pair for x and y, and `quantity` what the
    values are ("radiance", "photon_radiance", "temperature", "counts"): `read` and `sensor.simulate` take both from the file.
    `attributes` are stored beside the pixels: texts, pairs of numbers or lists of them. Those of an Image are kept, and
    `sample`, `quantity` and `attributes` change them: `write(path, read(file))` and reading that gives the attributes again,
    in all of these formats; what OpenEXR's own header says is left out of them. PNG and TIFF hold one or three planes of whole
    numbers: those of an Image of counts as they are, else counts whose scale is in the attributes `gain` and `offset`.

    `range` gives the values that become 0 and the largest number of PNG and TIFF, by default the extremes, for an Image of
    counts the counts themselves; `bits` is 8 or 16. The file appears whole or not at all. Raises UsageError for what is no
    2-D array of numbers, and DataError where the file cannot be written.
    """
    integers = not os.fspath(path).lower().endswith((".exr", ".hdr", ".img"))
    if range is not None and not integers:
        raise UsageError("range: is for PNG and TIFF; OpenEXR and ENVI have the values themselves")
    if bits not in (8, 16):
        raise UsageError(f"bits: {bits} is not 8 or 16")
    if isinstance(planes, Image):
        attributes = {**planes.attributes, **(attributes or {})}
        values: dict[str, npt.ArrayLike] = {name: planes._file.plane(name) for name in planes.names}
        if integers and planes.integer and range is None:
            bits = 8 if planes._file.storage == "8-bit" else bits
            gain, offset = (float(attributes.get(name, one)) for name, one in (("gain", "1"), ("offset", "0")))  # type: ignore[arg-type]
            range = (offset, offset + gain * (255.0 if bits == 8 else 65535.0))
            values = {name: (gain * np.asarray(plane, dtype=np.float64) + offset) for name, plane in values.items()}
        planes = values
    named = planes if isinstance(planes, Mapping) else {"Y": planes}
    if "mtf:pixelPitch" not in (attributes or {}):
        sample = sample_of(named.values(), sample)
    for name in named:
        if not isinstance(name, str):
            raise UsageError(f"planes: {quantities.shown(name)} is no name of a plane; give a dictionary by name")
    text, pairs, lists = _stored({name: value for name, value in (attributes or {}).items()
                                  if not integers or name not in ("gain", "offset")})
    if sample is not None:
        words = quantities.sample_words(sample)
        assert words is not None
        text.pop("mtf:pixelPitch", None)
        pairs["mtf:pixelPitch"] = (1e-6 * quantities.micrometres(words[0], "sample"), 1e-6 * quantities.micrometres(words[1], "sample"))
    if quantity is not None:
        if quantity not in _UNITS:
            raise UsageError(f"quantity: {quantity!r} is not known (one of {', '.join(_UNITS)})")
        text.update({"mtf:quantity": quantity, "mtf:units": _UNITS[quantity]})
    for name, plane in named.items():
        single = _core.plane(plane, f"planes: '{name}'")
        if np.isinf(single).any() and not np.isinf(np.asarray(plane)).any():
            raise DataError(f"{os.fspath(path)}: plane '{name}' has numbers beyond 3.4e38, the largest of float32")
        if integers and not np.isfinite(single).all():
            raise DataError(f"{os.fspath(path)}: plane '{name}' has NaN or infinite values, for which there are no whole numbers")
    _core.write(os.fspath(path), list(named.items()), text, pairs, lists, [], range, bits)
