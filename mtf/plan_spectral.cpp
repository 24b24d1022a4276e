// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan_spectral.h"

#include <algorithm>
#include <cmath>

#include "mtf/engines/spectral.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

// One row of an OTF, in the order of the blocks: blocks x kRow numbers of each part. Values beyond those that are kept
// are zero.
template <class S>
class OtfRow {
 public:
  OtfRow(const OtfSampler& sampler, const OtfSampler::Grid& grid, const SpectralEngine<S>& engine)
      : grid_(&grid),
        engine_(&engine),
        real_(sampler.is_real()),
        keep_(static_cast<std::size_t>(engine.x().keep)),
        scale_(static_cast<S>(engine.otf_scale())) {
    const auto count = static_cast<std::size_t>(engine.blocks() * engine.columns_per_block());
    if (real_) {
      up_.resize(count);
      down_.resize(count);
    } else {
      complex_up_.resize(count);
      complex_down_.resize(count);
    }
  }

  /// Row j of part p to to[p].
  void write(std::size_t j, std::span<S* const> to) {
    const bool cosine = engine_->columns_per_block() == kRow;
    if (real_)
      cosine ? real_parts(j, to) : real_exponentials(j, to[0]);
    else
      cosine ? complex_parts(j, to) : complex_exponentials(j, to[0]);
  }

 private:
  // Both real columns that pass as one complex one are multiplied alike.
  void real_exponentials(std::size_t j, S* to) {
    grid_->real_row(j, std::span(up_).first(keep_));
    for (std::size_t i = 0; i < up_.size(); i += kLanes, to += kRow)
      for (std::size_t l = 0; l < kLanes; ++l) to[l] = to[kLanes + l] = scale_ * up_[i + l];
  }

  void complex_exponentials(std::size_t j, S* to) {
    grid_->complex_row(j, std::span(complex_up_).first(keep_));
    for (std::size_t i = 0; i < complex_up_.size(); i += kLanes, to += kRow)
      for (std::size_t l = 0; l < kLanes; ++l) {
        to[l] = scale_ * complex_up_[i + l].re;
        to[kLanes + l] = scale_ * complex_up_[i + l].im;
      }
  }

  // What is odd along y in a real OTF is odd along x too.
  void real_parts(std::size_t j, std::span<S* const> to) {
    if (to.size() == 1) {
      grid_->real_row(j, std::span(up_).first(keep_));
      for (std::size_t i = 0; i < up_.size(); ++i) to[0][i] = scale_ * up_[i];
      return;
    }
    grid_->real_rows(j, std::span(up_).first(keep_), std::span(down_).first(keep_));
    for (std::size_t i = 0; i < up_.size(); ++i) {
      to[0][i] = S(0.5) * scale_ * (up_[i] + down_[i]);
      to[1][i] = S(0.5) * scale_ * (down_[i] - up_[i]);
    }
  }

  // What is odd along one axis only is imaginary.
  void complex_parts(std::size_t j, std::span<S* const> to) {
    grid_->complex_row(j, std::span(complex_up_).first(keep_));
    if (to.size() < 4) {
      for (std::size_t i = 0; i < complex_up_.size(); ++i) to[0][i] = scale_ * complex_up_[i].re;
      for (std::size_t i = 0; to.size() > 1 && i < complex_up_.size(); ++i) to[1][i] = -scale_ * complex_up_[i].im;
      return;
    }
    grid_->complex_row(j, std::span(complex_down_).first(keep_), true);
    const S half = S(0.5) * scale_;
    for (std::size_t i = 0; i < complex_up_.size(); ++i) {
      const Complex<S> up = complex_up_[i], down = complex_down_[i];
      to[0][i] = half * (up.re + down.re);   // even along both axes
      to[1][i] = half * (down.im - up.im);   // odd along y
      to[2][i] = -half * (up.im + down.im);  // odd along x
      to[3][i] = half * (down.re - up.re);
    }
  }

  const OtfSampler::Grid* grid_;
  const SpectralEngine<S>* engine_;
  bool real_;
  std::size_t keep_;
  S scale_;
  std::vector<S> up_, down_;  // at fy and -fy
  std::vector<Complex<S>> complex_up_, complex_down_;
};

// H on the engine's frequencies, times its scale. Some rows at a time go to the blocks, which lie far apart.
template <class S>
OtfBlocks<S> make_otf(const OtfSampler& sampler, const SpectralEngine<S>& engine, int threads) {
  constexpr std::int64_t kTogether = 8;
  OtfBlocks<S> otf = engine.make_blocks(sampler.is_real());
  std::vector<double> fx, fy;
  for (std::int64_t k = 0; k < engine.x().keep; ++k) fx.push_back(engine.x().frequency.cy_mm(k));
  for (const std::int64_t k : otf_frequencies(engine.y())) fy.push_back(engine.y().frequency.cy_mm(k));
  const OtfSampler::Grid grid(sampler, std::move(fx), std::move(fy));

  parallel_for(otf.rows, kTogether, threads, [&](std::int64_t begin, std::int64_t end) {
    OtfRow<S> row(sampler, grid, engine);
    const std::int64_t numbers = otf.blocks * kRow;
    const auto parts = static_cast<std::int64_t>(otf.parts.size());
    const AlignedBuffer<S> strip(static_cast<std::size_t>(parts * kTogether * numbers));
    const auto strip_row = [&](std::size_t p, std::int64_t j) {
      return strip.data() + (static_cast<std::int64_t>(p) * kTogether + j - begin) * numbers;
    };
    std::vector<S*> to(otf.parts.size());
    for (std::int64_t j = begin; j < end; ++j) {
      for (std::size_t p = 0; p < to.size(); ++p) to[p] = strip_row(p, j);
      row.write(static_cast<std::size_t>(j), to);
    }
    for (std::size_t p = 0; p < to.size(); ++p)
      for (std::int64_t b = 0; b < otf.blocks; ++b)
        for (std::int64_t j = begin; j < end; ++j) std::copy_n(strip_row(p, j) + b * kRow, kRow, otf.row(p, b, j));
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
  std::int64_t filter_bytes() const override { return otf_.size() * static_cast<std::int64_t>(sizeof(S)); }
  double largest_gain() const override {
    double squares = 0.0;
    for (std::int64_t b = 0; b < otf_.blocks; ++b)
      for (std::int64_t r = 0; r < otf_.rows; ++r)
        for (std::int64_t l = 0; l < kRow; ++l) squares = std::max(squares, square(b, r, l));
    return std::sqrt(squares) / transforms_->otf_scale();
  }
  const std::shared_ptr<const SpectralEngine<S>>& transforms() const { return transforms_; }

 private:
  // |H|^2 of one number of a row; of H(fx, fy) and H(fx, -fy) the larger one.
  double square(std::int64_t block, std::int64_t row, std::int64_t lane) const {
    const S* first = otf_.row(0, block, row);
    if (otf_.complex) return lane < kLanes ? std::pow(first[lane], 2.0) + std::pow(first[lane + kLanes], 2.0) : 0.0;
    double re = 0.0, im = 0.0, mirrored_re = 0.0, mirrored_im = 0.0;
    for (std::size_t p = 0; p < otf_.parts.size(); ++p) {
      const auto [x, y] = otf_.parts[p];
      const double h = p == 0 ? first[lane] : -otf_.row(p, block, row)[lane];
      (x == y ? re : im) += h;
      (x == y ? mirrored_re : mirrored_im) += y == Parity::even ? h : -h;
    }
    return std::max(re * re + im * im, mirrored_re * mirrored_re + mirrored_im * mirrored_im);
  }

  std::shared_ptr<const SpectralEngine<S>> transforms_;
  OtfBlocks<S> otf_;  // on loan from the transforms
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
