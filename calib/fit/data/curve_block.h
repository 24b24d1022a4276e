// SPDX-License-Identifier: Apache-2.0
#pragma once

// The MTF curve of another instrument as residuals: |H(f)| / |H(0)| along its direction, or Re H where the curve itself
// goes below zero. Nothing of its own is unknown.

#include "calib/fit/data/data_block.h"
#include "calib/fit/fit.h"

namespace calib {

class CurveBlock {
 public:
  /// Throws UsageError for sizes that differ, numbers that are not finite, negative frequencies, sd not above 0.
  explicit CurveBlock(const CurveData& data);

  /// Index of what it sees (Sensors::place): the optical axis under its condition.
  std::size_t place() const { return data_->condition; }
  const CurveData& data() const { return *data_; }
  /// In the curve's unit.
  std::span<const PixelFreq> frequencies() const { return f_; }
  void set_robust(bool robust) { robust_ = robust; }
  void scale_noise(double factor) { noise_factor_ *= std::sqrt(factor); }
  double noise_scale() const { return noise_factor_ * noise_factor_; }
  std::vector<double> start() const { return {}; }
  NormalMatrix normal(const Sensors& sensors, std::span<const double> own) const;
  std::vector<Residual> residuals(const Sensors& sensors, std::span<const double> own) const;

 private:
  double sd(std::size_t i) const { return noise_factor_ * (data_->sd.size() == 1 ? data_->sd[0] : data_->sd[i]); }

  const CurveData* data_;
  bool robust_ = false;
  bool signed_ = false;
  double noise_factor_ = 1.0;
  std::vector<PixelFreq> f_;
};

}  // namespace calib
