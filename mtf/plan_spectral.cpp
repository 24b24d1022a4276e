// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan_spectral.h"

#include <algorithm>
#include <cmath>

#include "mtf/engines/kernels.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

// H on the engine's frequencies, times its scale.
OtfBlocks make_otf(const OtfSampler& sampler, const SpectralEngine& engine, int threads) {
  const std::int64_t per_block = engine.columns_per_block(), keep = engine.x().keep;
  const auto& terms = engine.y_terms();
  const FrequencyGrid frequencies = engine.frequencies();
  OtfBlocks otf;
  otf.complex = !sampler.is_real();
  otf.blocks = engine.blocks();
  otf.rows = static_cast<std::int64_t>(terms.size());
  otf.data = AlignedBuffer<float>(static_cast<std::size_t>(otf.blocks * otf.rows * kRowFloats));
  std::vector<double> fx(static_cast<std::size_t>(otf.blocks * per_block)), fy(terms.size());
  for (std::size_t i = 0; i < fx.size(); ++i) fx[i] = frequencies.x.cy_mm(static_cast<std::int64_t>(i));
  for (std::size_t j = 0; j < fy.size(); ++j) fy[j] = frequencies.y.cy_mm(terms[j].k);
  const OtfSampler::Grid grid(sampler, fx, fy);
  const auto scale = static_cast<float>(engine.otf_scale());
  const bool paired = per_block == kRowFloats;

  parallel_for(otf.rows, 8, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> real(fx.size());
    std::vector<Complex<float>> values(otf.complex ? fx.size() : 0);
    for (std::int64_t j = begin; j < end; ++j) {
      if (otf.complex) {
        grid.complex_row(static_cast<std::size_t>(j), values);
        std::fill(values.begin() + keep, values.end(), Complex<float>{});
      } else {
        grid.real_row(static_cast<std::size_t>(j), real);
        std::fill(real.begin() + keep, real.end(), 0.0F);
      }
      for (std::int64_t b = 0; b < otf.blocks; ++b) {
        float* row = otf.row(b, j);
        const auto first = static_cast<std::size_t>(b * per_block);
        if (otf.complex)
          for (std::size_t l = 0; l < kLanes; ++l) {
            row[2 * l] = values[first + l].re * scale;
            row[2 * l + 1] = values[first + l].im * scale;
          }
        else if (paired)
          for (std::size_t l = 0; l < kRowFloats; ++l) row[l] = real[first + l] * scale;
        else
          for (std::size_t l = 0; l < kLanes; ++l) row[2 * l] = row[2 * l + 1] = real[first + l] * scale;
      }
    }
  });
  return otf;
}

}  // namespace

double SpectralFilter::largest_gain() const {
  double squares = 0.0;
  for (std::size_t i = 0; i + 1 < otf_.data.size(); i += 2) {
    const double re = otf_.data[i], im = otf_.data[i + 1];
    squares = std::max(squares, otf_.complex ? re * re + im * im : std::max(re * re, im * im));
  }
  return std::sqrt(squares) / transforms_->otf_scale();
}

std::shared_ptr<const SpectralFilter> make_spectral_filter(const OtfSampler& sampler, const AxisJob& x,
                                                           const AxisJob& y, fft::Rigor rigor, int threads,
                                                           const Engine* relative) {
  std::shared_ptr<const SpectralEngine> transforms;
  if (const auto* filter = dynamic_cast<const SpectralFilter*>(relative))
    if (filter->transforms()->x() == x && filter->transforms()->y() == y) transforms = filter->transforms();
  if (!transforms) transforms = std::make_shared<SpectralEngine>(x, y, rigor);
  OtfBlocks otf = make_otf(sampler, *transforms, threads);
  return std::make_shared<SpectralFilter>(std::move(transforms), std::move(otf));
}

}  // namespace mtf
