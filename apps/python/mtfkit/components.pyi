# SPDX-License-Identifier: Apache-2.0
# Printed by tests/python/component_stub.py from the field tables of the toolkit.
from collections.abc import Mapping
from typing import Any

from mtfkit.quantities import Value

class Component:
    kind: str
    stages: tuple[str, ...]
    parameters: tuple[Mapping[str, Any], ...]
    def __init__(self, *positional: Value, **values: Value) -> None: ...
    def fields(self) -> dict[str, Any]: ...
    def __getattr__(self, name: str) -> Any: ...
    def __setattr__(self, name: str, value: object) -> None: ...
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, tuple[str, dict[str, Any]]]: ...

def class_name(kind: str) -> str: ...
def kinds() -> dict[str, Any]: ...
def classes() -> dict[str, type[Component]]: ...
def component(kind: str, values: Mapping[str, Any] | None = ...) -> Component: ...
def __getattr__(name: str) -> type[Component]: ...
def __dir__() -> list[str]: ...

class AcceleratedMotion(Component):
    def __init__(self, *, velocity: Value = ..., acceleration: Value = ..., rate: Value = ...,
                 angular_acceleration: Value = ..., direction: Value = ..., label: Value = ...) -> None: ...

class Aerosol(Component):
    def __init__(self, *, scattering: Value = ..., path_length: Value = ..., mode: Value = ..., cutoff: Value = ...,
                 particle_radius: Value = ..., wavelength: Value = ..., label: Value = ...) -> None: ...

class Binning(Component):
    def __init__(self, *, columns: Value = ..., rows: Value = ..., spacing: Value = ..., spacing_x: Value = ...,
                 spacing_y: Value = ..., label: Value = ...) -> None: ...

class BirefringentFilter(Component):
    def __init__(self, separation: Value = ..., *, separation_x: Value = ..., separation_y: Value = ...,
                 label: Value = ...) -> None: ...

class Bolometer(Component):
    def __init__(self, time_constant: Value = ..., *, velocity: Value = ..., rate: Value = ..., axis: Value = ...,
                 label: Value = ...) -> None: ...

class Boost(Component):
    def __init__(self, *, gain: Value = ..., peak: Value = ..., axis: Value = ..., label: Value = ...) -> None: ...

class Butterworth(Component):
    def __init__(self, *, cutoff: Value = ..., scan_velocity: Value = ..., scan_rate: Value = ...,
                 pixel_clock: Value = ..., axis: Value = ..., poles: Value = ..., label: Value = ...) -> None: ...

class ChargeTransfer(Component):
    def __init__(self, *, inefficiency: Value = ..., transfers: Value = ..., axis: Value = ..., label: Value = ...) -> None: ...

class CircularFootprint(Component):
    def __init__(self, diameter: Value = ..., *, diameter_x: Value = ..., diameter_y: Value = ..., label: Value = ...) -> None: ...

class Crosstalk(Component):
    def __init__(self, side: Value = ..., *, corner: Value = ..., label: Value = ...) -> None: ...

class Curve(Component):
    def __init__(self, file: Value = ..., *, axis: Value = ..., part: Value = ..., label: Value = ...) -> None: ...

class Defocus(Component):
    def __init__(self, *, waves: Value = ..., distance: Value = ..., focus: Value = ...,
                 wavelength_reference: Value = ..., f_number: Value = ..., obscuration: Value = ...,
                 wavelength: Value = ..., label: Value = ...) -> None: ...

class Diffraction(Component):
    def __init__(self, *, f_number: Value = ..., obscuration: Value = ..., wavelength: Value = ..., label: Value = ...) -> None: ...

class Diffusion(Component):
    def __init__(self, *, absorption_length: Value = ..., depletion_depth: Value = ..., diffusion_length: Value = ...,
                 label: Value = ...) -> None: ...

class DisplayCrt(Component):
    def __init__(self, sigma: Value = ..., *, sigma_x: Value = ..., sigma_y: Value = ..., label: Value = ...) -> None: ...

class DisplayFlatPanel(Component):
    def __init__(self, *, width: Value = ..., width_x: Value = ..., width_y: Value = ..., lcd_pitch: Value = ...,
                 lcd_pitch_x: Value = ..., lcd_pitch_y: Value = ..., label: Value = ...) -> None: ...

class Eye(Component):
    def __init__(self, *, model: Value = ..., magnification: Value = ..., luminance: Value = ..., eyes: Value = ...,
                 field: Value = ..., label: Value = ...) -> None: ...

class Fir(Component):
    def __init__(self, taps: Value = ..., *, label: Value = ...) -> None: ...

class Flow(Component):
    def __init__(self, *, zoom: Value = ..., rotation: Value = ..., shift: Value = ..., shift_x: Value = ...,
                 shift_y: Value = ..., label: Value = ...) -> None: ...

class Footprint(Component):
    def __init__(self, *, width: Value = ..., width_x: Value = ..., width_y: Value = ..., fill_factor: Value = ...,
                 label: Value = ...) -> None: ...

class Gaussian(Component):
    def __init__(self, sigma: Value = ..., *, sigma_x: Value = ..., sigma_y: Value = ..., part: Value = ...,
                 label: Value = ...) -> None: ...

class Halo(Component):
    def __init__(self, *, fraction: Value = ..., width: Value = ..., width_x: Value = ..., width_y: Value = ...,
                 profile: Value = ..., label: Value = ...) -> None: ...

class ImageIntensifier(Component):
    def __init__(self, *, frequency: Value = ..., index: Value = ..., label: Value = ...) -> None: ...

class Interpolation(Component):
    def __init__(self, kernel: Value = ..., *, a: Value = ..., label: Value = ...) -> None: ...

class Jitter(Component):
    def __init__(self, rms: Value = ..., *, rms_x: Value = ..., rms_y: Value = ..., roll: Value = ...,
                 label: Value = ...) -> None: ...

class LinearMotion(Component):
    def __init__(self, *, travel: Value = ..., travel_x: Value = ..., travel_y: Value = ..., velocity: Value = ...,
                 rate: Value = ..., direction: Value = ..., label: Value = ...) -> None: ...

class PolygonFootprint(Component):
    def __init__(self, *, vertices: Value = ..., unit_length: Value = ..., unit_length_x: Value = ...,
                 unit_length_y: Value = ..., label: Value = ...) -> None: ...

class Psf(Component):
    def __init__(self, *, samples: Value = ..., step: Value = ..., step_x: Value = ..., step_y: Value = ...,
                 part: Value = ..., label: Value = ...) -> None: ...

class RandomWavefront(Component):
    def __init__(self, rms: Value = ..., *, wavelength_reference: Value = ..., correlation: Value = ...,
                 correlation_length: Value = ..., aperture: Value = ..., wavelength: Value = ..., label: Value = ...) -> None: ...

class RcHighpass(Component):
    def __init__(self, cutoff: Value = ..., *, scan_velocity: Value = ..., scan_rate: Value = ...,
                 pixel_clock: Value = ..., axis: Value = ..., dc: Value = ..., label: Value = ...) -> None: ...

class RcLowpass(Component):
    def __init__(self, cutoff: Value = ..., *, scan_velocity: Value = ..., scan_rate: Value = ...,
                 pixel_clock: Value = ..., axis: Value = ..., label: Value = ...) -> None: ...

class RmsWavefront(Component):
    def __init__(self, rms: Value = ..., *, wavelength_reference: Value = ..., f_number: Value = ...,
                 wavelength: Value = ..., label: Value = ...) -> None: ...

class SampleAndHold(Component):
    def __init__(self, width: Value = ..., *, width_x: Value = ..., width_y: Value = ..., axis: Value = ...,
                 label: Value = ...) -> None: ...

class Tdi(Component):
    def __init__(self, *, stages: Value = ..., slip: Value = ..., slip_x: Value = ..., slip_y: Value = ...,
                 clock_phases: Value = ..., axis: Value = ..., label: Value = ...) -> None: ...

class Turbulence(Component):
    def __init__(self, *, fried_parameter: Value = ..., wavelength_reference: Value = ..., exposure: Value = ...,
                 alpha: Value = ..., aperture: Value = ..., constant: Value = ..., wavelength: Value = ...,
                 profile: Value = ..., wave: Value = ..., cn2: Value = ..., path_length: Value = ...,
                 wind: Value = ..., ground_cn2: Value = ..., target_altitude: Value = ...,
                 sensor_altitude: Value = ..., zenith_angle: Value = ..., label: Value = ...) -> None: ...

class Unsharp(Component):
    def __init__(self, amount: Value = ..., *, size: Value = ..., sigma: Value = ..., label: Value = ...) -> None: ...

class Vibration(Component):
    def __init__(self, amplitude: Value = ..., *, amplitude_x: Value = ..., amplitude_y: Value = ...,
                 direction: Value = ..., average: Value = ..., cycles: Value = ..., period: Value = ...,
                 phase: Value = ..., label: Value = ...) -> None: ...

class Wavefront(Component):
    def __init__(self, *, w020: Value = ..., w040: Value = ..., w131: Value = ..., w222: Value = ...,
                 w311: Value = ..., zernike: Value = ..., numbering: Value = ..., orientation: Value = ...,
                 vignetting_rim: Value = ..., vignetting_shift: Value = ..., wavelength_reference: Value = ...,
                 f_number: Value = ..., obscuration: Value = ..., wavelength: Value = ..., label: Value = ...) -> None: ...
