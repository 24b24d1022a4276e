// SPDX-License-Identifier: Apache-2.0
#pragma once

// What spoils real images of edges, done to the images of made_edges.h: hot pixels, values cut off at a floor, a second
// edge, noise that neighbouring pixels share.

#include "tests/calib/made_edges.h"

namespace made {

/// Adds `more` to a share of the pixels, chosen at random.
void heat_pixels(mtf::Image& image, double share, double more, std::uint64_t seed);
/// Values below `floor` become it, as those of a converter without an offset.
void cut_off_below(mtf::Image& image, double floor);
/// A parallel edge of the same blur and of another contrast, on the bright side.
void add_second_edge(mtf::Image& image, const Scene& scene, const Step& step, double apart_px, double contrast);
/// The noise is drawn again and blurred by a Gaussian of `sd_px`, and has the deviation of the scene's after that.
void correlate_noise(mtf::Image& image, const Scene& scene, const Step& step, double sd_px);
/// The noise is drawn again on every second pixel, as on the sites of green in a Bayer mosaic; the others have the mean
/// of their four neighbours.
void interpolate_noise(mtf::Image& image, const Scene& scene, const Step& step);
/// The noise is drawn again and its cosine coefficients in blocks of 8 x 8 pixels are rounded, the more coarsely the
/// higher their frequency, as JPEG does.
void compress_noise(mtf::Image& image, const Scene& scene, const Step& step);

}  // namespace made
