// SPDX-License-Identifier: Apache-2.0
#pragma once

// What every component header needs: fields with units, the row of a field table, and rows and helpers that several
// components share.

#include <array>
#include <limits>
#include <string>

#include "mtf/component.h"
#include "mtf/math/special.h"
#include "mtf/quantity.h"

namespace mtf {

// The dimensional fields of a component that are plain numbers inside. A field holds its number in the unit that ends
// its name, and only a quantity of that dimension sets it, in any unit:
//   OptionalIn<S, micrometres> distance_um;    ...{.distance_um = 0.03_mm}    holds 30
// Lengths on the focal plane that may also be angles or pixels are Extents (mtf/frame.h).

/// `unit` is the function that makes a quantity of a number in the unit: degrees, micrometres (mtf/quantity.h).
template <class S, auto unit>
struct NumberIn {
  using Given = decltype(unit(1.0));
  S value{};

  NumberIn() = default;
  NumberIn(const Given& quantity) : value(S(quantity / unit(1.0))) {}
};

/// The same for a number that may be left out. It is read as a std::optional.
template <class S, auto unit>
struct OptionalIn : std::optional<S> {
  using Given = decltype(unit(1.0));

  OptionalIn() = default;
  OptionalIn(std::nullopt_t) {}
  OptionalIn(const Given& quantity) : std::optional<S>(S(quantity / unit(1.0))) {}
};

/// The type of the row of a member; libraries add those of their own types of members.
template <class T>
inline constexpr FieldType kTypeOf = std::is_enum_v<T> ? FieldType::word : FieldType::number;
template <class T>
inline constexpr FieldType kTypeOf<std::optional<T>> = kTypeOf<T>;
template <class S>
inline constexpr FieldType kTypeOf<AxisPair<S>> = FieldType::size;
template <class S>
inline constexpr FieldType kTypeOf<SpatialFrequency<S>> = FieldType::frequency;
template <class S>
inline constexpr FieldType kTypeOf<std::vector<S>> = FieldType::numbers;
template <class S>
inline constexpr FieldType kTypeOf<std::vector<std::vector<S>>> = FieldType::rows;
template <>
inline constexpr FieldType kTypeOf<int> = FieldType::whole;
template <>
inline constexpr FieldType kTypeOf<bool> = FieldType::flag;
template <>
inline constexpr FieldType kTypeOf<Choice> = FieldType::word;
template <>
inline constexpr FieldType kTypeOf<std::string> = FieldType::file;
template <class S>
inline constexpr FieldType kTypeOf<CurveSum<S>> = FieldType::file;

template <class Value>
constexpr std::span<const std::string_view> words_of(const Value*) {
  if constexpr (requires { words(Value{}); })
    return words(Value{});
  else
    return {};
}
template <class Value>
constexpr std::span<const std::string_view> words_of(const std::optional<Value>*) {
  return words_of(static_cast<const Value*>(nullptr));
}

/// A row and where its value lives, whose type gives the row its type where it states none, for an enum E words(E), and
/// the dimension of what has no one unit.
template <class Member>
struct Field : FieldInfo {
  Member member;

  constexpr Field(Member where, FieldInfo row) : FieldInfo(row), member(where) { set_type(where); }

 private:
  template <class Owner, class Value>
  constexpr void set_type(Value Owner::*) {
    if (type == FieldType::number) type = kTypeOf<Value>;
    if (dimension == Dimension::none && type == FieldType::size) dimension = Dimension::extent;
    if (dimension == Dimension::none && type == FieldType::frequency) dimension = Dimension::frequency;
    if (const auto own = words_of(static_cast<const Value*>(nullptr)); !own.empty()) words = own;
  }
};

// The cells of a row after its member: `optional(&T::width_um, "width", "um", 0.0, 1e6, "\"14 um\"", "of a pixel")`.
template <class Owner, class Value, class... Cells>
constexpr Field<Value Owner::*> required(Value Owner::*member, const Cells&... cells) {
  return {member, required_row(cells...)};
}
template <class Owner, class Value, class... Cells>
constexpr Field<Value Owner::*> optional(Value Owner::*member, const Cells&... cells) {
  return {member, optional_row(cells...)};
}
template <class Owner, class Value, class... Cells>
constexpr Field<Value Owner::*> shared(Value Owner::*member, const Cells&... cells) {
  return {member, shared(required_row(cells...))};
}

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Rows that several tables share, word for word.
inline constexpr FieldInfo kFNumberInfo = shared(required_row("f_number", 0.1, 1e4, "2.0", "focal length / aperture"));
inline constexpr FieldInfo kWavelengthInfo =
    shared(required_row("wavelength", "um", 0.01, 1e5, "\"4.0 um\"", "fixed wavelength instead of the band"));

inline constexpr FieldInfo kObscurationInfo =
    below(shared(required_row("obscuration", 0.0, 1.0, "0.3", "central obscuration, inner / outer diameter")));
/// Overlaps of a narrower ring by quadrature would be differences without digits.
inline constexpr double kLargestObscuration = 0.999;
inline constexpr FieldInfo kQuadratureObscurationInfo =
    shared(required_row("obscuration", 0.0, kLargestObscuration, "0.3", "central obscuration, inner / outer diameter"));
inline constexpr FieldInfo kWavelengthReferenceInfo =
    optional_row("wavelength_reference", "um", 0.01, 1e5, "\"0.6328 um\"",
                 "wavelength at which the waves are stated; without it they hold at every wavelength");

/// For a component of which the user alone knows the part of the sensor: blur by its size, a measured curve.
inline constexpr std::array<std::string_view, 7> kSensorPartNames{"unspecified", "optics",      "path",   "detector",
                                                                  "motion",      "electronics", "display"};
inline constexpr FieldInfo kPartInfo =
    optional_row("part", "\"optics\"",
                 "part of the sensor whose blur this is: figures of the optics or the detector alone count it there");

/// The shared optics of a field marked Presence::shared; a component's own value wins. Evaluated only after check().
template <class S>
S f_number_of(const std::optional<S>& own, const Context<S>& ctx) {
  if (own) return *own;
  if (ctx.optics.f_number) return *ctx.optics.f_number;
  if (ctx.optics.aperture_mm) return ctx.frame.focal_length_mm / *ctx.optics.aperture_mm;
  return S(0);
}

/// Entrance pupil diameter in mm; 0 when nobody gives one.
template <class S>
S aperture_of(const std::optional<S>& own, const Context<S>& ctx) {
  if (own) return *own;
  if (ctx.optics.aperture_mm) return *ctx.optics.aperture_mm;
  return ctx.optics.f_number ? S(ctx.frame.focal_length_mm / *ctx.optics.f_number) : S(0);
}

template <class S>
S obscuration_of(const std::optional<S>& own, const Context<S>& ctx) {
  return own ? *own : ctx.optics.obscuration.value_or(S(0));
}

/// What the bounds of the field say of the component's own value, for the shared one.
template <class S>
std::vector<Problem> check_quadrature_obscuration(const std::optional<S>& own, const Context<S>& ctx) {
  const double e = value_of(obscuration_of(own, ctx));
  if (e <= value_of(S(kLargestObscuration))) return {};
  return {{.field = "obscuration",
           .text = format_double(e) + " from [optics] is above " + format_double(kLargestObscuration)}};
}

/// nu = f lambda N, the frequency relative to the incoherent cutoff 1/(lambda N).
/// Conditioning: nu carries the relative rounding of three factors, about 3 x 2^-53; near the cutoff the MTF falls as
/// (1 - nu)^1.5, so its relative error there is 1.5 x 3 x 2^-53 / (1 - nu).
template <class S>
S relative_frequency(const S& f_cy_mm, const S& wavelength_um, const S& f_number) {
  return f_cy_mm * (wavelength_um * S(1e-3)) * f_number;
}

/// An aberration in waves at the wavelength in use: the same path difference is fewer of longer waves.
template <class S>
S waves_at(const S& waves, const std::optional<S>& wavelength_reference_um, const S& wavelength_um) {
  return wavelength_reference_um ? S(waves * *wavelength_reference_um / wavelength_um) : waves;
}

inline constexpr std::array<std::string_view, 2> kAxisNames{"x", "y"};
inline constexpr FieldInfo kAxisInfo = optional_row("axis", "\"x\"", "axis of the scan or readout");
inline Axis axis_of(const Choice& choice) { return choice.index == 0 ? Axis::x : Axis::y; }

/// Component of f along an axis.
template <class S>
const S& along(const Freq<S>& f, Axis axis) {
  return axis == Axis::x ? f.x : f.y;
}

inline constexpr FieldInfo kDirectionInfo =
    optional_row("direction", "deg", -360.0, 360.0, "\"30 deg\"", "from +x (right) to +y (down)");

/// (cos, sin) of a direction, exact at multiples of 90 degrees. The angle is divided in double: rounded to float after
/// the division, it would turn the frequencies by up to pi x 2^-24, which costs the phase of a motion over n cycles an
/// error of n times 2 pi^2 x 2^-24.
template <class S>
Freq<S> unit_vector(const S& direction_deg) {
  constexpr double kSlope = kPi / 180.0;
  const auto [sine, cosine] = sin_cos_pi(value_of(direction_deg) / 180.0);
  return {lift({cosine, -kSlope * sine}, direction_deg), lift({sine, kSlope * cosine}, direction_deg)};
}

/// Of a motion in a straight line: that it leaves y or x alone, and whether it goes to and fro alike.
inline Traits motion_traits(bool in_x, bool in_y, bool even) {
  return {.separable = in_x || in_y,
          .even_x = in_y || (in_x && even),
          .even_y = in_x || (in_y && even),
          .flat_x = in_y,
          .flat_y = in_x,
          .real = even};
}

/// Of what acts along an axis alone; `even`: without a phase.
inline Traits axis_traits(const Choice& axis, bool even) {
  return motion_traits(axis.index == 0, axis.index != 0, even);
}

/// Whether rows of taps are the same read from right to left, or from the last one to the first, or both.
template <class S>
bool mirrored_taps(const Taps<S>& taps, bool in_x, bool in_y) {
  const std::size_t rows = taps.size(), columns = taps.front().size();
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t k = 0; k < columns; ++k)
      if (value_of(taps[j][k]) != value_of(taps[in_y ? rows - 1 - j : j][in_x ? columns - 1 - k : k])) return false;
  return true;
}

/// Bound of |1 - sinc| up to x: monotone to 1, never above 1 + 0.2173 (the deepest side lobe).
inline double sinc_deviation(double x) { return x < 1.0 ? 1.0 - sinc(x).value : 1.2173; }

}  // namespace mtf
