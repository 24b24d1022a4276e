// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stray light: what the lens scatters all over the field, and an image of the scene reflected within the lens.
//   glare   L' = (1 - g) L + g mean(L) + o mean(L)
//   ghost   L' = (1 - q) L + q mirrored(L)
// g, the fraction of the light spread evenly over the image, is the veiling glare index of ISO 9358 where the scene
// fills the field; the sum of the image is kept. o is light on top of it, from beyond the field or from surfaces in
// between, as a fraction of the same mean. The ghost of an even number of reflections near the axis is the image turned
// by half a turn about the axis; out of focus it is spread evenly over a square of that side. Light that would come
// from outside of the image has its mean; with the axis in the middle, nothing does and the sum is kept, but for what a
// wide ghost loses over the edges to the mean. Both mix the light of all pixels, so that they need the whole image.

#include "mtf/image.h"
#include "radiometry/stages/optics/focal_plane.h"

namespace radiometry {

struct VeilingGlare {
  double fraction = 0.0;
  double offset = 0.0;

  static constexpr auto fields() {
    return std::tuple{required(&VeilingGlare::fraction, "fraction", 0.0, 1.0, "0.03",
                               "part of the light that is spread evenly over the image"),
                      optional(&VeilingGlare::offset, "offset", 0.0, 100.0, "0.01",
                               "light on top of the image's own, as a part of its mean")};
  }
};

struct Ghost {
  double fraction = 0.0;
  double width_px = 1.0;

  static constexpr auto fields() {
    return std::tuple{
        required(&Ghost::fraction, "fraction", 0.0, 1.0, "0.001", "part of the light in the ghost image"),
        optional(
            &Ghost::width_px, "width", "px", 1.0, 1e6, "\"40 px\"",
            "side of the square that a point of the ghost image is spread over, to the nearest odd number of pixels")};
  }
};

/// The mean of the finite pixels; 0 where there is none.
double finite_mean(mtf::ImageView<const float> image);

/// Adds the glare to an image or a region of one; `mean` is that of the whole image. NaN stays NaN. UsageError for
/// values out of their bounds and a mean that is not finite.
void add_glare(mtf::ImageView<float> image, const VeilingGlare& glare, double mean, int threads = 1);

/// The ghost image alone, of the size of `image`, which holds the samples of a whole grid with its axis. Pixels that
/// are not finite count with the mean. The axis is rounded to half a pixel.
mtf::Image ghost_image(mtf::ImageView<const float> image, const Ghost& ghost, const FocalPlane& detector);

/// image = (1 - fraction) image + fraction x ghosts, of the same size or the same region of both.
void add_ghost(mtf::ImageView<float> image, const Ghost& ghost, mtf::ImageView<const float> ghosts, int threads = 1);

}  // namespace radiometry
