// SPDX-License-Identifier: Apache-2.0
#pragma once

// Radial distortion of the lens.
//   r' = r (1 + k1 r^2 + k2 r^4 + k3 r^6),   out(at r') = in(at r), along the same direction from the axis
// r = where an ideal lens puts a point, r' = where this one does, both in half diagonals of the field (focal_plane.h).
// k1 < 0 is a barrel, k1 > 0 a cushion; k1 + k2 + k3 is the distortion in the corner, ISO 9039. Applied to the radiance
// of the oversampled scene, before any OTF. Radiance is moved, not scaled: a flat scene stays flat, and what a place of
// the image gets is the radiance of the direction that it sees. (Brown, Photogramm. Eng. 32, 444 (1966).)
// The scene is interpolated by cubic convolution, Keys' a = -1/2 (IEEE Trans. ASSP-29, 1153 (1981)), whose MTF is
// `distortion_mtf`. It is low where the scene is hardly oversampled, 0 at its Nyquist frequency; with 4 samples a pixel
// 0.9915 at the Nyquist frequency of the pixels. Where a barrel compresses the image, detail of the scene beyond its
// own Nyquist frequency aliases as with any sampling.

#include <vector>

#include "mtf/border.h"
#include "mtf/image.h"
#include "radiometry/stages/optics/focal_plane.h"

namespace radiometry {

struct Distortion {
  double k1 = 0.0, k2 = 0.0, k3 = 0.0;

  static constexpr auto fields() {
    return std::tuple{optional(&Distortion::k1, "k1", -100.0, 100.0, "-0.05",
                               "coefficient of r^2, r = 1 at half the diagonal; barrel below 0"),
                      optional(&Distortion::k2, "k2", -100.0, 100.0, "-0.05", "coefficient of r^4"),
                      optional(&Distortion::k3, "k3", -100.0, 100.0, "-0.05", "coefficient of r^6")};
  }
};

/// r' / r at an ideal radius r.
double distorted_part(const Distortion& distortion, double r);

/// r / r' at places r' of the image up to `most`, for many places.
class UndistortedRadius {
 public:
  /// Throws UsageError for coefficients or `most` out of bounds, and when the polynomial folds over before it comes to
  /// `most`: two points of the scene would fall on one place and places further out would see none.
  UndistortedRadius(const Distortion& distortion, double most);
  double part(double distorted) const;

 private:
  double solve(double distorted, double start) const;

  Distortion distortion_;
  double most_;
  double limit_;               ///< an ideal radius that lies at `most` or beyond; below it r' rises
  std::vector<double> start_;  ///< r at evenly spaced r' up to `most`, to begin from
};

/// The region `out`, from `origin` on, of the distorted whole `scene` on `grid`. Beyond the scene the image follows the
/// rule `border`, with `border_value` where that is constant; NaN spreads over the samples it takes part in. The two
/// images do not overlap. Throws UsageError as above and for a scene that is not the grid's.
void distort(mtf::ImageView<const float> scene, const Distortion& distortion, const FocalPlane& grid,
             mtf::ImageView<float> out, Origin origin = {}, mtf::Border border = mtf::Border::reflect,
             float border_value = 0.0F, int threads = 1);

/// The MTF of the interpolation along an axis at a frequency in cycles per sample, the lowest over all places between
/// two samples; at most the product of both axes' for any direction.
double distortion_mtf(double frequency_cy_sample);

}  // namespace radiometry
