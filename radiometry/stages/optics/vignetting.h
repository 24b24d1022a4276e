// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fall-off of the irradiance from the axis to the edge of the field.
//   factor = cos^4(theta) x max(0, 1 + a2 r^2 + a4 r^4 + a6 r^6),   tan(theta) = distance from the axis / focal length
// r in half diagonals of the detector (focal_plane.h). cos^4 is that of an ideal lens on a plane detector; what edges
// of lenses cut away on top, the vignetting, is given by a polynomial, as a map of factors from a file, one a pixel, or
// by the pupil of the component wavefront: the share of its area that is left (mtf/field/throughput.h).
// Factors multiply the irradiance of everything that comes through the lens, before the shot noise. (Smith, Modern
// Optical Engineering, ch. 9.)

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "mtf/image.h"
#include "radiometry/stages/optics/focal_plane.h"

namespace radiometry {

enum class VignettingOf { numbers, wavefront };
inline constexpr std::array<std::string_view, 2> kVignettingOfNames{"numbers", "wavefront"};
constexpr std::span<const std::string_view> words(VignettingOf) { return kVignettingOfNames; }

struct Vignetting {
  VignettingOf of = VignettingOf::numbers;
  bool cos4 = true;
  double a2 = 0.0, a4 = 0.0, a6 = 0.0;
  std::string map{};  ///< file of factors in place of the polynomial

  static constexpr auto fields() {
    return std::tuple{
        optional(&Vignetting::of, "of", "\"wavefront\"",
                 "numbers: a2, a4, a6 or map, as unless given; wavefront: vignetting_rim of that component"),
        optional(&Vignetting::cos4, "cos4", "false", "whether the irradiance falls with cos^4 of the field angle"),
        optional(&Vignetting::a2, "a2", -100.0, 100.0, "-0.15",
                 "coefficient of r^2 in the vignetting, r = 1 at half the diagonal"),
        optional(&Vignetting::a4, "a4", -100.0, 100.0, "-0.15", "coefficient of r^4"),
        optional(&Vignetting::a6, "a6", -100.0, 100.0, "-0.15", "coefficient of r^6"),
        optional(&Vignetting::map, "map", "\"flat.exr\"", "image of factors, one a pixel, instead of a2, a4, a6")};
  }

  bool operator==(const Vignetting&) const = default;
};

/// cos^4 of an angle, from the square of its tangent.
template <class S>
S cos4_factor(const S& squared_tangent) {
  const S cos2 = S(1) / (S(1) + squared_tangent);
  return cos2 * cos2;
}

/// The factors of a region of the detector; made once for a sequence and applied by multiply_by (fixed_pattern.h).
/// `given`: the same region of the map that the settings name; empty without one. Throws UsageError for settings out of
/// their bounds, a map together with a polynomial, a map missing, of another size, with factors that are negative or
/// not finite, and a focal length that is not above 0.
void vignetting_map(mtf::ImageView<float> factors, const Vignetting& vignetting, const FocalPlane& detector,
                    double focal_length_mm, Origin origin = {}, mtf::ImageView<const float> given = {},
                    int threads = 1);

}  // namespace radiometry
