// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan_spectral.h"

#include <algorithm>
#include <cmath>

#include "mtf/engines/spectral.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

// H on the engine's frequencies, times its scale.
template <class S>
OtfBlocks<S> make_otf(const OtfSampler& sampler, const SpectralEngine<S>& engine, int threads) {
  const std::int64_t per_block = engine.columns_per_block(), keep = engine.x().keep;
  const auto& terms = engine.y_terms();
  const FrequencyGrid frequencies = engine.frequencies();
  OtfBlocks<S> otf;
  otf.complex = !sampler.is_real();
  otf.blocks = engine.blocks();
  otf.rows = static_cast<std::int64_t>(terms.size());
  otf.data = AlignedBuffer<S>(static_cast<std::size_t>(otf.blocks * otf.rows * kRow));
  std::vector<double> fx(static_cast<std::size_t>(otf.blocks * per_block)), fy(terms.size());
  for (std::size_t i = 0; i < fx.size(); ++i) fx[i] = frequencies.x.cy_mm(static_cast<std::int64_t>(i));
  for (std::size_t j = 0; j < fy.size(); ++j) fy[j] = frequencies.y.cy_mm(terms[j].k);
  const OtfSampler::Grid grid(sampler, fx, fy);
  const S scale = static_cast<S>(engine.otf_scale());
  const bool paired = per_block == kRow;

  parallel_for(otf.rows, 8, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<S> real(fx.size());
    std::vector<Complex<S>> values(otf.complex ? fx.size() : 0);
    for (std::int64_t j = begin; j < end; ++j) {
      if (otf.complex) {
        grid.complex_row(static_cast<std::size_t>(j), std::span(values));
        std::fill(values.begin() + keep, values.end(), Complex<S>{});
      } else {
        grid.real_row(static_cast<std::size_t>(j), std::span(real));
        std::fill(real.begin() + keep, real.end(), S(0));
      }
      for (std::int64_t b = 0; b < otf.blocks; ++b) {
        S* row = otf.row(b, j);
        const auto first = static_cast<std::size_t>(b * per_block);
        if (otf.complex)
          for (std::size_t l = 0; l < kLanes; ++l) {
            row[l] = values[first + l].re * scale;
            row[kLanes + l] = values[first + l].im * scale;
          }
        else if (paired)
          for (std::size_t l = 0; l < kRow; ++l) row[l] = real[first + l] * scale;
        else
          for (std::size_t l = 0; l < kLanes; ++l) row[l] = row[kLanes + l] = real[first + l] * scale;
      }
    }
  });
  return otf;
}

template <class S>
class Filter final : public SpectralFilter {
 public:
  Filter(std::shared_ptr<const SpectralEngine<S>> transforms, OtfBlocks<S> otf)
      : transforms_(std::move(transforms)), otf_(std::move(otf)) {}

  void run(const std::vector<Channel>& channels, int threads) const override {
    transforms_->run(channels, otf_, threads);
  }
  std::int64_t run_bytes(std::int64_t channels, int threads) const override {
    return transforms_->run_bytes(channels, threads);
  }
  std::int64_t filter_bytes() const override { return static_cast<std::int64_t>(otf_.data.size() * sizeof(S)); }
  double largest_gain() const override {
    double squares = 0.0;
    for (std::int64_t r = 0; r < otf_.blocks * otf_.rows; ++r)
      for (std::int64_t l = 0; l < kLanes; ++l) {
        const double re = otf_.row(0, r)[l], im = otf_.row(0, r)[kLanes + l];
        squares = std::max(squares, otf_.complex ? re * re + im * im : std::max(re * re, im * im));
      }
    return std::sqrt(squares) / transforms_->otf_scale();
  }
  const std::shared_ptr<const SpectralEngine<S>>& transforms() const { return transforms_; }

 private:
  std::shared_ptr<const SpectralEngine<S>> transforms_;
  OtfBlocks<S> otf_;
};

template <class S>
std::shared_ptr<const SpectralFilter> make_filter(const OtfSampler& sampler, const AxisJob& x, const AxisJob& y,
                                                  fft::Rigor rigor, int threads, const Engine* relative) {
  std::shared_ptr<const SpectralEngine<S>> transforms;
  if (const auto* filter = dynamic_cast<const Filter<S>*>(relative))
    if (filter->transforms()->x() == x && filter->transforms()->y() == y) transforms = filter->transforms();
  if (!transforms) transforms = std::make_shared<SpectralEngine<S>>(x, y, rigor);
  OtfBlocks<S> otf = make_otf(sampler, *transforms, threads);
  return std::make_shared<Filter<S>>(std::move(transforms), std::move(otf));
}

}  // namespace

std::shared_ptr<const SpectralFilter> make_spectral_filter(const OtfSampler& sampler, const AxisJob& x,
                                                           const AxisJob& y, Precision precision, fft::Rigor rigor,
                                                           int threads, const Engine* relative) {
  return precision == Precision::single_precision ? make_filter<float>(sampler, x, y, rigor, threads, relative)
                                                  : make_filter<double>(sampler, x, y, rigor, threads, relative);
}

}  // namespace mtf
