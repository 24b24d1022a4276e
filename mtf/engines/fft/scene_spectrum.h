// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the contrast of one scene lies in frequency, so that a plan can say what leaving something out costs this very
// scene, not the worst one of its standard deviation: by Parseval the squared rms error of an OTF error D is the sum of
// |D|^2 times the power of the scene's canvas. The power is kept in cells of the half-plane fx >= 0; D is taken at its
// largest corner of a cell. Frequencies that alias onto one another add as amplitudes at worst: the rms of each alias
// zone is taken, and the zones add linearly (Minkowski).

#include <memory>
#include <span>
#include <vector>

#include "mtf/border.h"
#include "mtf/image.h"

namespace mtf {

class SceneSpectrum {
 public:
  static constexpr int kCells = 64;  ///< from 0 to the scene's Nyquist frequency, per axis
  static constexpr int kColumns = kCells + 1, kRows = 2 * kCells + 1;  ///< corners: fx = 0 .. N, fy = -N .. N

  /// Power of every cell, relative to the variance of the image: [row][column], 2 kCells x kCells.
  SceneSpectrum(std::int64_t width, std::int64_t height, Border border, std::vector<double> power)
      : width_(width), height_(height), border_(border), power_(std::move(power)) {}

  /// Whether it can be that of a scene of this size and border.
  bool is_of(std::int64_t width, std::int64_t height, Border border) const {
    return width == width_ && height == height_ && border == border_;
  }
  SceneSpectrum with_power(std::vector<double> power) const { return {width_, height_, border_, std::move(power)}; }

  /// Corner i of an axis in cycles/mm.
  static double corner_cy_mm(int i, double nyquist_cy_mm) { return nyquist_cy_mm * static_cast<double>(i) / kCells; }

  /// rms over the detector samples, relative to the scene's std, of an OTF error whose moduli at the corners are
  /// `error` (kRows x kColumns), for `ratio_x`, `ratio_y` samples a pitch.
  double rms_error(std::span<const double> error, double ratio_x, double ratio_y) const;
  const std::vector<double>& power() const { return power_; }

  /// What `rms_error` could be at most for a scene whose canvas has unit rms: the largest error of each alias zone,
  /// zones added as squares.
  static double worst_error(std::span<const double> error, double ratio_x, double ratio_y);

 private:
  std::int64_t width_, height_;
  Border border_;
  std::vector<double> power_;
};

/// Spectrum of an image with its border, for those whose canvas is not much larger than the image: reflect (by cosine
/// transforms of its own size) and periodic. Null for the other borders, for flat images and for those that have pixels
/// that are not finite. The same bits for any `threads`.
std::shared_ptr<const SceneSpectrum> scene_spectrum(ImageView<const float> scene, Border border, int threads = 0);

/// One spectrum for several planes, each cell the largest of theirs: errors that hold for every one of them. Null when
/// one of them is null, or there are none.
std::shared_ptr<const SceneSpectrum> largest_of(std::span<const std::shared_ptr<const SceneSpectrum>> spectra);

}  // namespace mtf
