# SPDX-License-Identifier: Apache-2.0
"""Image files in and out: OpenEXR, PNG, TIFF and, for reading, JPEG."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, results
from mtfkit.errors import DataError, UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

    Plane = npt.NDArray[np.float32]


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
                "what": (self.integer, self.encoding, self._file.storage, self._file.pitch_um)}

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
        """True for values that are stored as whole numbers (PNG, TIFF): they are their counts."""
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
    def sample(self) -> tuple[str, str] | None:
        """The spacing of the samples along x and y that the file states, for `sample=`; None where it states none."""
        pitch = self._file.pitch_um
        return None if pitch is None else (f"{pitch[0]!r} um", f"{pitch[1]!r} um")

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        rows, columns = self.plane(self.names[0]).shape
        return rows, columns

    def plane(self, name: str | None = None) -> Plane:
        """The values of one plane, (rows, columns) of float32: a view that cannot be written, nothing is copied.

        Without a name the image has to have one plane. Raises UsageError for a name that is not there.
        """
        if name is None:
            if len(self.names) != 1:
                raise UsageError(f"{self.path}: has the planes {', '.join(self.names)}; name one of them")
            name = self.names[0]
        return self._file.plane(name)

    def __array__(self, dtype: npt.DTypeLike | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.plane(), dtype=dtype)

    def __repr__(self) -> str:
        rows, columns = self.shape
        return f"<Image {self.path}: {columns} x {rows}, {', '.join(self.names)}, {self._file.storage}>"


def read(path: str | os.PathLike[str], *, channel: str | None = None, layer: str | None = None,
         part: int | None = None) -> Image:
    """Reads OpenEXR, PNG, TIFF or JPEG. Values are linear float32 as stored, integers being their counts.

    `channel` is one full name, `layer` the channels of a layer ("" = those without one), `part` a part of a file of
    several. Raises UsageError where a choice is needed, and lists what there is; DataError for a file that is missing
    or damaged.
    """
    return Image(_core.read(os.fspath(path), channel, layer, part))


def write(path: str | os.PathLike[str], planes: npt.ArrayLike | Mapping[str, npt.ArrayLike], *,
          attributes: Mapping[str, object] | None = None, range: tuple[float, float] | None = None,
          bits: int = 16) -> None:
    """Writes one plane, or planes by name, as the ending says: .exr (float32), .png or .tif (integers).

    `attributes` are stored beside the pixels: texts, pairs of numbers or lists of them; in OpenEXR files names begin
    with "mtf:". `range` gives the values that become 0 and the largest number of PNG and TIFF, by default the extremes;
    `bits` is 8 or 16. The file appears whole or not at all. Raises UsageError for what is no 2-D array of numbers, and
    DataError where the file cannot be written.
    """
    integers = not os.fspath(path).lower().endswith(".exr")
    if range is not None and not integers:
        raise UsageError("range: is for PNG and TIFF; OpenEXR has the values themselves")
    named = planes if isinstance(planes, Mapping) else {"Y": planes}
    text: dict[str, str] = {}
    pairs: dict[str, tuple[float, float]] = {}
    lists: dict[str, list[float]] = {}
    for name, value in (attributes or {}).items():
        if isinstance(value, str):
            text[name] = value
        elif isinstance(value, tuple) and len(value) == 2:
            pairs[name] = (float(value[0]), float(value[1]))
        elif isinstance(value, (list, np.ndarray)):
            lists[name] = [float(one) for one in value]
        else:
            text[name] = str(value)
    if bits not in (8, 16):
        raise UsageError(f"bits: {bits} is not 8 or 16")
    for name, plane in named.items():
        single = _core.plane(plane, f"write: plane '{name}'")
        if np.isinf(single).any() and not np.isinf(np.asarray(plane)).any():
            raise DataError(f"{os.fspath(path)}: plane '{name}' has numbers beyond 3.4e38, the largest of float32")
        if integers and not np.isfinite(single).all():
            raise DataError(f"{os.fspath(path)}: plane '{name}' has NaN or infinite values, for which there are no whole numbers")
    _core.write(os.fspath(path), list(named.items()), text, pairs, lists, [], range, bits)
