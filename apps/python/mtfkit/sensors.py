# SPDX-License-Identifier: Apache-2.0
"""A sensor: a value that never changes, made of a sensor file or of keywords."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mtfkit import _core, functions, quantities, results
from mtfkit.arguments import checked
from mtfkit.budgets import Budget
from mtfkit.components import Component
from mtfkit.curves import Curves, curves_of
from mtfkit.custom import Custom, General, Sampled
from mtfkit.errors import UsageError
from mtfkit.findings import Finding, Findings
from mtfkit.sensor_values import Part, part, parts, summary, value_of
from mtfkit.sensor_parts import ComponentLike, Functions, component_lines, table_lines, write_sensor
from mtfkit.plans import compile_plan
from mtfkit.simulation import run_simulation

if TYPE_CHECKING:
    import numpy.typing as npt

    from mtfkit.edges import ImageLike
    from mtfkit.fits import CurveData, Fit
    from mtfkit.plans import Plan
    from mtfkit.runs import Run
    from mtfkit.simulation import SceneLike

Table = Mapping[str, Any]
FieldPoint = Sequence[float] | None  # (x, y) in half diagonals of the detector; None: the optical axis

_SUCH_AS = ("mtfkit.Sensor(frame=dict(focal_length=\"100 mm\", pitch=\"15 um\"), optics=dict(aperture=\"50 mm\", wavelength=\"4 um\"), "
            "presample=[\"diffraction\"])")


class Sensor:
    """A sensor, as a sensor file describes it. It never changes; `replace` gives another one.

    Every keyword is a table of the sensor file with the keys of `mtf config kinds` (frame, scene, optics, band, detector,
    adc, noise, ...); presample, readout and postsample are lists of components. Lengths, angles, times and all else that
    has a unit are texts ("15 um") or pairs (15, "um"). Raises UsageError with every mistake.

    >>> import mtfkit as mk
    >>> sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0, wavelength="4 um"),
    ...                    presample=["diffraction", mk.Footprint(width="15 um"), mk.Jitter(rms="20 urad")])
    >>> round(float(sensor.mtf(1e3 / 30)), 4)
    0.3875
    """

    __slots__ = ("_canonical", "_file", "_own")
    _file: _core.SensorFile
    _canonical: str | None
    _own: Functions

    @checked
    def __init__(self, *positional: object, name: str = "", frame: Table | None = None, scene: Table | None = None, optics: Table | None = None,
                 band: Table | None = None, presample: Sequence[ComponentLike] = (),
                 readout: Sequence[ComponentLike] = (), postsample: Sequence[ComponentLike] = (), **tables: Table) -> None:
        if positional:
            raise UsageError(f"Sensor: {quantities.shown(positional[0])} has no name; write {_SUCH_AS}; a file is read by "
                             "mtfkit.Sensor.load(file)")
        for key, given in tables.items():
            if not isinstance(given, Mapping):
                raise UsageError(f"Sensor: {key}={quantities.shown(given)} is no table of a sensor file; write {_SUCH_AS}, with the keys "
                                 "that mtfkit.kinds() and `mtf config kinds` list")
        if frame is None:
            raise UsageError(f"Sensor: needs frame; write {_SUCH_AS}")
        lines = ["schema = 2"]
        if name:
            lines += [f"name = {quantities.toml(name, 'name')}"]
        lines += [""]
        for key, table in {"frame": frame, "scene": scene, "optics": optics, "band": band, **tables}.items():
            if table is not None:
                lines += table_lines(key, table)
        self._take(lines, "sensor", Functions(), {"presample": presample, "readout": readout, "postsample": postsample})

    def _take(self, lines: list[str], file: str, own: Functions, lists: Mapping[str, Sequence[ComponentLike]]) -> None:
        """The sensor of these lines and further components."""
        for stage, components in lists.items():
            if not isinstance(components, Sequence) or isinstance(components, (str, bytes)):
                raise UsageError(f"{stage}: is a list of components; write [{quantities.shown(components)}]")
            for index, component in enumerate(components):
                lines += component_lines(stage, index, component)
                if isinstance(component, (Custom, Sampled, General)):
                    own = own.with_one(stage, component)
        self._set(_read("\n".join(lines), file), own)

    def _set(self, file: _core.SensorFile, own: Functions) -> None:
        object.__setattr__(self, "_file", file)
        object.__setattr__(self, "_canonical", None)
        object.__setattr__(self, "_own", own)

    @classmethod
    def _of(cls, file: _core.SensorFile, own: Functions | None = None) -> Sensor:
        sensor = object.__new__(cls)
        sensor._set(file, own or Functions())
        return sensor

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Sensor never changes; sensor.replace({{\"{name}\": ...}}) gives another one")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("a Sensor never changes")

    @classmethod
    @checked
    def load(cls, path: str | os.PathLike[str]) -> Sensor:
        """The sensor of a file. Raises UsageError with every error as a "file:line:column" line, DataError when the file
        cannot be read."""
        return cls.parse(_core.read_text(os.fspath(path)), file=os.fspath(path))

    @classmethod
    @checked
    def parse(cls, text: str, *, file: str = "sensor") -> Sensor:
        """The sensor of a text. `file` is what messages call it, and files that it names are relative to its folder."""
        return cls._of(_read(text, file))

    @classmethod
    def starter(cls) -> Sensor:
        """The commented sensor that `mtf config init` writes."""
        return cls.parse(_core.starter_config(), file="starter")

    @checked
    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the sensor file, with the comments that it has. Where files that it names would not be found from the
        new place, it is written anew with their right names and without comments. The file appears whole or not at all.
        """
        write_sensor(self._file, self._own, os.fspath(path))

    @property
    def text(self) -> str:
        """The sensor file, with its comments."""
        return self._file.text

    @property
    def file(self) -> str:
        """The file it was read from, or what messages call it."""
        return self._file.file

    @property
    def name(self) -> str:
        """`name` of the sensor file."""
        return self._file.name

    @property
    def sha256(self) -> str:
        """Of the text, 64 hex digits; reports of simulations state it."""
        return self._file.sha256

    @checked
    def __getitem__(self, name: str) -> Any:
        """The value that the sensor states by that name, one of those that `replace` takes: `sensor["jitter.rms"]`.

        As the file has it: a text with its unit, a number, a list. None where the sensor leaves a parameter at its default,
        which `explain` says. `sensor.jitter.rms` is the same. Raises UsageError for a name that the sensor does not have,
        with the nearest one.
        """
        return value_of(self._file, name)

    def __contains__(self, name: object) -> bool:
        """Whether the sensor has a parameter of that name."""
        try:
            return isinstance(name, str) and (self[name], True)[1]
        except UsageError:
            return False

    __iter__ = None  # names are read one by one

    def __getattr__(self, name: str) -> Part:
        if name.startswith("_"):
            raise AttributeError(name)
        return part(self._file, name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *parts(self._file)]

    def replace(self, values: Mapping[str, quantities.Value]) -> Sensor:
        """Another sensor with these values, by the names that studies, schedules and `explain` use.

        `sensor.replace({"jitter.rms": "60 urad", "optics.f_number": 4})`; `presample[1].rms` and `wavefront.zernike[3]`
        are names too, and so is any key of a table, "scene.border" or "adc.bits", whether the sensor has it or not.
        Comments, order and units of all else stay; the values are set one after the other, and each has to make a sensor.
        Raises UsageError for a name that the sensor does not have (with the nearest one) and for values that cannot be.
        """
        if not isinstance(values, Mapping):
            raise UsageError("replace: give a dictionary, such as {\"jitter.rms\": \"60 urad\"}")
        return Sensor._of(self._file.replaced([(name, quantities.words(value, name)) for name, value in values.items()]),
                          self._own)

    @checked
    def append(self, *, presample: Sequence[ComponentLike] = (), readout: Sequence[ComponentLike] = (),
               postsample: Sequence[ComponentLike] = (), **tables: Table) -> Sensor:
        """Another sensor with further components at the ends of its lists, and further tables.

        `sensor.append(presample=[mk.Jitter(rms="20 urad"), mk.custom(otf, cutoff="60 cy/mm")], adc=dict(bits=14))`. Raises
        UsageError for what is no component, and for a table that the sensor has already.
        """
        sensor = object.__new__(Sensor)
        lines = [self.text, *(line for key, table in tables.items() for line in table_lines(key, table))]
        sensor._take(lines, self.file, self._own, {"presample": presample, "readout": readout, "postsample": postsample})
        return sensor

    def otf(self, fx: npt.ArrayLike, fy: npt.ArrayLike = 0.0, *, unit: str = "cy/mm", field: FieldPoint = None) -> Any:
        """The OTF at the frequencies (fx, fy): complex128 of their common shape, a complex number for plain numbers.

        `unit` is cy/mm at the focal plane, cy/mrad or cy/px; +x is along columns, +y along rows. `field` is a place in the
        image, (x, y) from the optical axis in half diagonals of the detector, where the OTF changes over the field; by
        default the axis.
        """
        place = self._field_point(field)
        x, y = quantities.frequency_pair(fx, fy)
        values = _core.otf(self._file, x.ravel(), y.ravel(), unit, place).reshape(x.shape)
        if self._functions:
            values = values * functions.product(self._file, self._functions, x, y, unit)
        return values[()]

    def mtf(self, fx: npt.ArrayLike, fy: npt.ArrayLike = 0.0, *, unit: str = "cy/mm", field: FieldPoint = None) -> Any:
        """The modulus of `otf`: float64 of the same shape."""
        return np.abs(self.otf(fx, fy, unit=unit, field=field))

    def curves(self, frequency: npt.ArrayLike | None = None, *, angle: quantities.Value = 0,
               unit: str = "cy/mm", field: FieldPoint = None) -> Curves:
        """The OTF of every component, of each list and of the whole along one direction, as `mtf curve`, bit for bit.

        `frequency` is in `unit`, by default 61 values to the smaller of cutoff and twice Nyquist; `angle` is from +x to
        +y, "45 deg"; `field` as in `otf`.
        """
        place = self._field_point(field)
        values = [] if frequency is None else np.atleast_1d(quantities.frequencies(frequency, "frequency")).ravel().tolist()
        if frequency is not None and not values:
            raise UsageError("frequency: is empty; leave it out for 61 values to the cutoff or twice Nyquist")
        made = results.timed(_core.curves, self._file, values, quantities.angle_deg(angle), unit, place)
        curves = curves_of(*made, self._own.error)
        return functions.with_functions(curves, self._file, self._functions) if self._functions else curves

    def _field_point(self, field: FieldPoint) -> tuple[float, float] | None:
        """The numbers of a field point; without one a warning where one OTF does not serve the whole image."""
        if field is None:
            self._say_axis(5)
            return None
        try:
            x, y = (float(value) for value in field)
        except (TypeError, ValueError):
            raise UsageError("field: give a place (x, y), from the optical axis in half diagonals of the detector") from None
        return x, y

    def _say_axis(self, level: int = 4) -> None:
        """Warns where one OTF does not serve the whole image, of what speaks of the optical axis alone."""
        if self._file.over_field:
            warnings.warn(f"the OTF changes over the field by {self._file.over_field}: this is that of the optical axis", stacklevel=level)

    def explain(self) -> results.Text:
        """What every number becomes after units and defaults, and the stages of the chain, as `mtf config explain`."""
        return results.Text(self._file.explain() + functions.explained(self._functions))

    def check(self) -> Findings:
        """Warnings and notes about this sensor, as `mtf config check`; true when nothing is wrong."""
        return Findings((*(Finding(**finding) for finding in self._file.check()), *functions.findings(self._functions)))

    def budget(self, *, temperature: quantities.Value = "300 K") -> Budget:
        """Electrons, noise terms and sensitivity for a surface of that temperature, as `mtf budget`, bit for bit.

        Raises UsageError for a sensor without [detector].
        """
        self._say_axis()
        kelvin = quantities.kelvin(temperature)
        return Budget(kelvin, *results.timed(self._file.budget, kelvin))

    def simulate(self, scene: SceneLike, *, sample: quantities.Value = None, quantity: str | None = None,
                 beside: Mapping[str, npt.ArrayLike] | None = None, tolerance: float | None = None,
                 nan: str = "refuse", stage: str | None = None, seed: int | None = None, frame: int = 0,
                 frames: Iterable[int] | None = None,
                 schedule: str | os.PathLike[str] | Sequence[tuple[int, str, quantities.Value]] | None = None,
                 roi: tuple[int, int, int, int] | None = None, memory: int | None = None,
                 rigor: str = "estimate", out: str | os.PathLike[str] | None = None,
                 range: tuple[float, float] | None = None, device: str = "cpu", threads: int = 0,
                 progress: Any = None) -> Run:
        """The image that the sensor makes of a scene, as `mtf simulate`, bit for bit.

        `scene`: the name of a file ("frame.%04d.exr" for a sequence), an Image, a 2-D array of physical values, or a
        dictionary of planes of one size. An array has `quantity` "radiance" (W m-2 sr-1), "photon_radiance",
        "temperature" (K) or "counts", by default that of [scene], else radiance; its samples are `sample` apart, by
        default as [scene] says. `beside` are planes that [scene] names, of emissivity or range.

        `tolerance` is the rms error allowed, as a share of the scene's standard deviation. `nan` is "refuse", "fill" or
        "propagate". `stage` is the place in the chain of a sensor with [detector]: "radiance", "irradiance", "watts",
        "electrons", "volts", "dn", "display". `seed` and `frame` choose the noise; `frames` (a range or numbers with
        one step) makes a sequence, with a `schedule` of (frame, parameter, value) or its CSV file. `roi` is x, y, width,
        height in pixels; `memory` in bytes makes tiles of a file. `out` writes a file in place of images in memory, PNG
        and TIFF with `range`. `device` is "cpu", "auto" or the id or a part of the name of one of `mtfkit.devices()`, taken
        where it is faster. `threads` 0 = all cores, the result is the same for any; `progress` is called with the
        share done. Ctrl-C ends the run.

        Raises UsageError for a request that cannot be met (ToleranceError, with what can be kept), DataError for NaN
        pixels and files.
        """
        sensor = self if seed is None else self.replace({"noise.seed": seed})
        return run_simulation(sensor, scene, sample=sample, quantity=quantity, beside=beside, tolerance=tolerance, nan=nan,
                              stage=stage, frame=frame, frames=frames, schedule=schedule, roi=roi, memory=memory,
                              rigor=rigor, out=out, range=range, device=device, threads=threads, progress=progress)

    @checked
    def compile(self, scene: npt.ArrayLike | tuple[int, int], *, sample: quantities.Value = None,
                quantity: str | None = None, tolerance: float | None = None, stage: str | None = None,
                rigor: str = "estimate", device: str = "cpu", threads: int = 0) -> Plan:
        """A plan that filters many scenes of one size: `plan(scene, out=image)`.

        `scene` is a shape (rows, columns), or a typical scene: then the promise counts its contrast and its rounding to
        float32. All else as `simulate`. Of a sensor with [detector] the plan is its whole chain.
        """
        return compile_plan(self, scene, sample=sample, quantity=quantity, tolerance=tolerance, stage=stage, rigor=rigor,
                            device=device, threads=threads)

    def fit(self, *, edges: Sequence[ImageLike] = (), free: Mapping[str, Any] | Iterable[str] | None = None,
            curves: Sequence[CurveData] = (), spots: Sequence[ImageLike] = (), **options: Any) -> Fit:
        """This sensor's parameters from images of edges, curves and images of point sources: see `mtfkit.fit`."""
        from mtfkit.fits import fit

        return fit(self, edges=edges, free=free, curves=curves, spots=spots, **options)

    def _table_error(self, samples_per_pixel: float) -> float:
        """What tables in place of functions cost an image, as a share of the scene's standard deviation."""
        return functions.table_error(self._file, self._own.error, samples_per_pixel)

    @property
    def _functions(self) -> tuple[General, ...]:
        return self._own.general

    def _key(self) -> str:
        if self._canonical is None:
            object.__setattr__(self, "_canonical", self._file.canonical("/mtfkit/sensor.toml") + "".join(self._file.contents))
        assert self._canonical is not None
        return self._canonical

    def __eq__(self, other: object) -> bool:
        """The same values, whatever the comments, the order and the units of the texts, and the same contents of the files that
        they name, when they were read; general functions are the same where 2000 values are."""
        if not isinstance(other, Sensor):
            return NotImplemented
        return self._key() == other._key() and self._functions == other._functions

    def __hash__(self) -> int:
        return hash((self._key(), self._functions))

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self.text, os.path.abspath(self.file) if os.path.exists(self.file) else self.file, self._own)

    def __repr__(self) -> str:
        return summary(self._file, self.name or self.file, [one.label for one in self._functions])

    def _repr_html_(self) -> str:
        return self.explain()._repr_html_()


def _read(text: str, file: str) -> _core.SensorFile:
    """The sensor of a text. What it names is where it is now, wherever the process goes and the sensor is taken."""
    made = _core.SensorFile(text, file)
    return made if len(made.files) == 1 or os.path.isabs(file) else _core.SensorFile(text, os.path.abspath(file))


def _unpickled(text: str, file: str, own: Functions) -> Sensor:
    return Sensor._of(_core.SensorFile(text, file), own)
