// SPDX-License-Identifier: Apache-2.0
#pragma once

// The geometry that every component shares, and the only conversions between focal plane, object space and pixels.
//
// Canonical spatial frequency: cycles/mm at the focal plane, +x right along columns, +y down along rows.
//   cy/mrad = cy/mm x focal_length_mm / 1000        (small angles: x = focal length x angle)
//   cy/px   = cy/mm x pitch_um / 1000               (per axis)
//   Hz      = cy/mm x speed_um_s / 1000             (speed of the scan over the focal plane)
// Templates over the scalar S (double, float, ceres::Jet), so that fits differentiate through focal length and pitch.

#include <optional>

#include "mtf/quantity.h"

namespace mtf {

template <class S>
struct Complex {
  S re{};
  S im{};
  friend Complex operator*(const Complex& a, const Complex& b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  friend Complex operator+(const Complex& a, const Complex& b) { return {a.re + b.re, a.im + b.im}; }
};

/// Spatial frequency in cycles/mm at the focal plane.
template <class S>
struct Freq {
  S x{};
  S y{};
};

enum class Axis { x, y };

template <class S>
struct Frame {
  S focal_length_mm{};
  S pitch_x_um{};
  S pitch_y_um{};
  S integration_time_s{};
  int columns = 0;  ///< detector format; 0 = as many whole pitches as the scene holds
  int rows = 0;

  S pitch_um(Axis axis) const { return axis == Axis::x ? pitch_x_um : pitch_y_um; }
  bool square() const { return pitch_x_um == pitch_y_um; }
  S nyquist_cy_mm(Axis axis) const { return S(500.0) / pitch_um(axis); }
  S cy_per_mrad(const S& f_cy_mm) const { return f_cy_mm * focal_length_mm * S(1e-3); }
  S cy_per_px(const S& f_cy_mm, Axis axis) const { return f_cy_mm * pitch_um(axis) * S(1e-3); }
  S cy_mm_from_mrad(const S& f_cy_mrad) const { return f_cy_mrad * S(1e3) / focal_length_mm; }
  S cy_mm_from_px(const S& f_cy_px, Axis axis) const { return f_cy_px * S(1e3) / pitch_um(axis); }
  S cy_mm_from_hz(const S& f_hz, const S& speed_um_s) const { return f_hz * S(1e3) / speed_um_s; }
  S um_from_urad(const S& angle_urad) const { return angle_urad * focal_length_mm * S(1e-3); }
};

/// What turns time in the electronics into place in the image: exactly one of the speed of a scanning detector over
/// the focal plane, its angular rate in object space, or the pixels read per second along a line of a staring array.
template <class S>
struct Scan {
  std::optional<S> velocity_um_s;
  std::optional<S> rate_urad_s;
  std::optional<S> pixel_clock_hz;

  int given() const { return velocity_um_s.has_value() + rate_urad_s.has_value() + pixel_clock_hz.has_value(); }
  /// 0 when none is given.
  S speed_um_s(const Frame<S>& frame, Axis axis) const {
    if (velocity_um_s) return *velocity_um_s;
    if (rate_urad_s) return frame.um_from_urad(*rate_urad_s);
    return pixel_clock_hz ? S(*pixel_clock_hz * frame.pitch_um(axis)) : S(0);
  }
};

template <Dimension dimension>
inline constexpr bool kIsExtent =
    dimension == Dimension::length || dimension == Dimension::angle || dimension == Dimension::pixel;

/// A size in the image that is given as a focal-plane length, as an object angle, or in pixels, and stays what it was
/// given as: an angle keeps its meaning when the focal length changes. The value is held in the unit it was written in.
template <class S>
struct Extent {
  S value{};
  const Unit* unit = nullptr;

  Extent() = default;
  Extent(const S& number, const Unit* its_unit) : value(number), unit(its_unit) {}
  template <Dimension dimension>
  requires kIsExtent<dimension> Extent(const QuantityOf<dimension>& given)
      : Extent(S(given.quantity().value), given.quantity().unit) {}

  S um(const Frame<S>& frame, Axis axis) const {
    const S base = value * S(unit->factor);
    if (unit->dimension == Dimension::angle) return frame.um_from_urad(base);
    if (unit->dimension == Dimension::pixel) return base * frame.pitch_um(axis);
    return base;
  }
};

/// Extent per axis: one value for both axes, or x and y apart.
template <class S>
struct AxisPair {
  Extent<S> x;
  Extent<S> y;
  bool split = false;  ///< written as name_x and name_y; otherwise y repeats x

  AxisPair() = default;
  AxisPair(const Extent<S>& along_x, const Extent<S>& along_y, bool apart = true)
      : x(along_x), y(along_y), split(apart) {}
  template <Dimension dimension>
  requires kIsExtent<dimension> AxisPair(const QuantityOf<dimension>& both) : x(both) {}

  bool given() const { return x.unit != nullptr; }
  S x_um(const Frame<S>& frame) const { return x.um(frame, Axis::x); }
  S y_um(const Frame<S>& frame) const { return (split ? y : x).um(frame, Axis::y); }
  /// The same length along x and y whatever the frame: pixels are so only when they are square.
  bool isotropic(const Frame<S>& frame) const { return !given() || x_um(frame) == y_um(frame); }
};

/// A spatial frequency in the unit it was written in (cy/mm, cy/mrad, cy/px); of electronics also a temporal one (Hz,
/// kHz ...), which becomes spatial by its scan.
template <class S>
struct SpatialFrequency {
  S value{};
  const Unit* unit = nullptr;

  SpatialFrequency() = default;
  SpatialFrequency(const S& number, const Unit* its_unit) : value(number), unit(its_unit) {}
  template <Dimension dimension>
  requires(dimension == Dimension::frequency || dimension == Dimension::temporal)
      SpatialFrequency(const QuantityOf<dimension>& given)
      : SpatialFrequency(S(given.quantity().value), given.quantity().unit) {}

  bool temporal() const { return unit != nullptr && unit->dimension == Dimension::temporal; }
  S cy_mm(const Frame<S>& frame, Axis axis, const Scan<S>& scan = {}) const {
    if (temporal()) return frame.cy_mm_from_hz(S(value * S(unit->factor)), scan.speed_um_s(frame, axis));
    if (unit->name == "cy/mrad") return frame.cy_mm_from_mrad(value);
    if (unit->name == "cy/px") return frame.cy_mm_from_px(value, axis);
    return value;
  }
};

/// What several components share; a component's own value wins.
template <class S>
struct Optics {
  std::optional<S> f_number;
  std::optional<S> aperture_mm;  ///< entrance pupil diameter: f_number = focal length / aperture
  std::optional<S> obscuration;  ///< linear ratio, inner / outer diameter
  std::optional<S> wavelength_um;
};

/// The path through the air, for components that state no path of their own; [atmosphere] of a sensor file gives it.
template <class S>
struct PathAir {
  std::optional<S> path_length_m;
  std::optional<S> scattering;  ///< optical depth of what the aerosol scatters along it
};

/// A place in the image: its distance from the optical axis at the focal plane.
template <class S>
struct Place {
  S x_um{};
  S y_um{};
};

/// Everything outside a component that its OTF depends on. `wavelength_um` is the node of the band average, or the
/// monochromatic wavelength of the system.
template <class S>
struct Context {
  Frame<S> frame;
  Optics<S> optics;
  S wavelength_um{};
  PathAir<S> air{};
  Place<S> place{};
};

}  // namespace mtf
