// SPDX-License-Identifier: Apache-2.0
#pragma once

// The spectral engine with one OTF: what a plan of an FFT method runs.

#include <memory>

#include "mtf/engines/engine.h"
#include "mtf/engines/fft/axis.h"
#include "mtf/otf/factored_otf.h"

namespace mtf {

/// Of everything between the images, which are float32: in double_precision only their storage rounds.
enum class Precision { single_precision, double_precision };

class SpectralFilter : public Engine {
 public:
  /// Largest |H| over the frequencies in use.
  virtual double largest_gain() const = 0;
};

/// What is to be done by transforms.
struct SpectralWork {
  AxisTransform x, y;
  Precision precision = Precision::single_precision;
  Lines lines = Lines::rows;  ///< columns: where both axes are in the same basis
};

/// The filter of a sampler's OTF, which for double_precision should have no tables (table_share = 0). x in the cosine
/// basis needs y in it, and both `odd` where the OTF is not even along them. Shares the transforms of `earlier` (may
/// be null) where that one has the same axes, lines and precision.
std::shared_ptr<const SpectralFilter> make_spectral_filter(const FactoredOtf& sampler, const SpectralWork& work,
                                                           fft::Rigor rigor, int threads, const Engine* earlier);

}  // namespace mtf
