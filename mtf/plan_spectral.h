// SPDX-License-Identifier: Apache-2.0
#pragma once

// The spectral engine with one OTF: what a plan of an FFT method runs.

#include <memory>

#include "mtf/engines/spectral.h"
#include "mtf/sample.h"

namespace mtf {

class SpectralFilter final : public Engine {
 public:
  SpectralFilter(std::shared_ptr<const SpectralEngine> transforms, OtfBlocks otf)
      : transforms_(std::move(transforms)), otf_(std::move(otf)) {}

  void run(const std::vector<Channel>& channels, int threads) const override {
    transforms_->run(channels, otf_, threads);
  }
  std::int64_t run_bytes(std::int64_t channels, int threads) const override {
    return transforms_->run_bytes(channels, threads);
  }
  std::int64_t filter_bytes() const override { return static_cast<std::int64_t>(otf_.data.size()) * 4; }
  /// Largest |H| over the frequencies in use.
  double largest_gain() const;
  const std::shared_ptr<const SpectralEngine>& transforms() const { return transforms_; }

 private:
  std::shared_ptr<const SpectralEngine> transforms_;
  OtfBlocks otf_;
};

/// The filter of a sampler's OTF. Shares the transforms of `relative` (may be null) where that one has the same axes.
std::shared_ptr<const SpectralFilter> make_spectral_filter(const OtfSampler& sampler, const AxisJob& x,
                                                           const AxisJob& y, fft::Rigor rigor, int threads,
                                                           const Engine* relative);

}  // namespace mtf
