// SPDX-License-Identifier: Apache-2.0
#pragma once

// Narcissus: the cold detector sees itself reflected by the lens, where the warm surroundings should be.
//   background' = background (1 - d p(r / w))
//   Gaussian   p(t) = 2^(-t^2)        flat top   p(t) = 2^(-t^8)
// background = mean electrons of warm optics and stop in a pixel, d = depth, the part of them that is missing on the
// axis, w = radius at which half of it is, r and w in half diagonals of the detector (focal_plane.h). The scene's own
// light is not changed. (Howard and Abel, Appl. Opt. 21, 3393 (1982).)

#include "mtf/image.h"
#include "radiometry/stages/optics/focal_plane.h"

namespace radiometry {

enum class NarcissusProfile { gaussian, flat_top };
inline constexpr std::array<std::string_view, 2> kNarcissusProfileNames{"gaussian", "flat_top"};
constexpr std::span<const std::string_view> words(NarcissusProfile) { return kNarcissusProfileNames; }

struct Narcissus {
  double depth = 0.0;
  double radius = 0.25;
  NarcissusProfile profile = NarcissusProfile::gaussian;

  static constexpr auto fields() {
    return std::tuple{
        required(&Narcissus::depth, "depth", 0.0, 1.0, "0.02", "part of the background that is missing on the axis"),
        optional(&Narcissus::radius, "radius", 1e-6, 1e6, "0.3",
                 "radius of half the depth, in half diagonals of the detector"),
        optional(&Narcissus::profile, "profile", "\"flat_top\"", "gaussian, or flat_top")};
  }

  bool operator==(const Narcissus&) const = default;
};

/// Electrons that are missing in each pixel of a region, per electron of background: d p(r / w). The map is made once
/// for a sequence. Throws UsageError for values out of their bounds and a region outside of the detector.
void narcissus_map(mtf::ImageView<float> map, const Narcissus& narcissus, const FocalPlane& detector,
                   Origin origin = {});

}  // namespace radiometry
