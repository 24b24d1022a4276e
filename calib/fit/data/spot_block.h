// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pixels of a point source as residuals: pixel = unit x (background + flux x psf(x - x0, y - y0)), the transform of
// H taken as a sum over a grid of frequencies of step 1 / period: that is the PSF repeated every `period` pixels, the
// region and as much again, or what the spot's width asks for if that is more. Frequencies that differ by a cycle per
// pixel have the same phases at all pixels, so they are added up before the transform. Of a large region only the
// surroundings of the peak are used. Its own unknowns: x0, y0 (px), flux and background in units of the peak's light.
// The variance of a pixel is that of the rim, and where the residuals show it a gain times the light above it.

#include "calib/fit/data/data_block.h"
#include "calib/fit/fit.h"

namespace calib {

class SpotBlock {
 public:
  explicit SpotBlock(const SpotData& data);

  /// Index of what it sees (Sensors::place); that of its condition unless it is set.
  std::size_t place() const { return place_; }
  void set_place(std::size_t place) { place_ = place; }
  const SpotData& data() const { return *data_; }
  /// The middle of its light, px.
  double x_px() const { return x0_; }
  double y_px() const { return y0_; }
  /// The part of the data's region that is used.
  const Roi& roi() const { return roi_; }
  bool cut() const { return roi_.width < data_->roi.width || roi_.height < data_->roi.height; }
  /// sd of a Gaussian as wide as the spot at half its peak.
  double width_px() const { return width_px_; }
  /// Takes the pixels with a value. `reason` says when there are too few, no light above the background, or a saturated
  /// peak.
  std::size_t pixels() const { return pixels_; }
  const std::string& reason() const { return reason_; }
  void set_robust(bool robust) { robust_ = robust; }
  void scale_noise(double factor) {
    sd_ *= std::sqrt(factor);
    gain_ *= factor;
    scale_ *= factor;
  }
  /// Estimates the gain from the residuals at these values. Returns whether it has changed enough to fit again.
  bool update_noise(const Sensors& sensors, std::span<const double> own);
  double noise_scale() const { return scale_; }
  std::vector<double> start() const { return {x0_, y0_, flux_, background_}; }
  NormalMatrix normal(const Sensors& sensors, std::span<const double> own) const;
  std::vector<Residual> residuals(const Sensors& sensors, std::span<const double> own) const;

 private:
  /// The PSF, its slopes by x0 and y0, its derivatives by the parameters, at every pixel of the region.
  std::vector<std::vector<double>> images(const Sensors& sensors, double x0, double y0) const;
  double sd_at(double light) const { return std::sqrt(sd_ * sd_ + gain_ * std::max(0.0, light)); }
  /// Rows of the least-squares problem before they are weighted: derivatives by the own unknowns and the parameters,
  /// what is left of the pixel, and the light that the model has there.
  struct PixelRow {
    std::int64_t x = 0, y = 0;
    std::vector<double> slopes{};
    double left = 0.0, light = 0.0;
  };
  std::vector<PixelRow> rows(const Sensors& sensors, std::span<const double> own) const;
  void find_peak();
  void measure_rim();
  void start_from_light();
  std::size_t period_px(double top_cy_px) const;

  const SpotData* data_;
  std::size_t place_;
  bool robust_ = false;
  std::size_t pixels_ = 0;
  std::string reason_;
  Roi roi_{};
  std::int64_t peak_x_ = 0, peak_y_ = 0;
  double width_px_ = 1.0;
  double unit_ = 1.0;  ///< light of the peak; the numbers below are in it
  double x0_ = 0.0, y0_ = 0.0, flux_ = 0.0, background_ = 0.0, sd_ = 1.0, gain_ = 0.0, scale_ = 1.0;
};

}  // namespace calib
