// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pixels of a point source as residuals: pixel = background + flux x psf(x - x0, y - y0), the transform of H taken
// as a sum over a grid of frequencies of step 1 / period: that is the PSF repeated every `period` pixels, four times
// the region, so that of its neighbours only what a PSF has left at three regions' distance counts. Its own unknowns:
// x0, y0 (px), flux, background.

#include "calib/data_block.h"
#include "calib/fit.h"

namespace calib {

class SpotBlock {
 public:
  /// Throws UsageError for a region larger than 64 pixels a side.
  explicit SpotBlock(const SpotData& data);

  std::size_t condition() const { return data_->condition; }
  const SpotData& data() const { return *data_; }
  /// Pixels with a value; too few, or no light above the background: `reason` says so.
  std::size_t pixels() const { return pixels_; }
  const std::string& reason() const { return reason_; }
  void set_robust(bool robust) { robust_ = robust; }
  void scale_noise(double factor) {
    sd_ *= std::sqrt(factor);
    scale_ *= factor;
  }
  double noise_scale() const { return scale_; }
  std::vector<double> start() const { return {x0_, y0_, flux_, background_}; }
  NormalMatrix normal(const Sensors& sensors, std::span<const double> own) const;
  std::vector<Residual> residuals(const Sensors& sensors, std::span<const double> own) const;

 private:
  /// The PSF, its slopes by x0 and y0, its derivatives by the parameters, at every pixel of the region.
  std::vector<std::vector<double>> images(const Sensors& sensors, double x0, double y0) const;

  const SpotData* data_;
  bool robust_ = false;
  std::size_t pixels_ = 0;
  std::string reason_;
  double x0_ = 0.0, y0_ = 0.0, flux_ = 0.0, background_ = 0.0, sd_ = 1.0, scale_ = 1.0;
};

}  // namespace calib
