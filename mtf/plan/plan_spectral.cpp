// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/plan_parts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/device/device_filter.h"
#include "mtf/engines/fft/spectral.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

// Writes rows of an OTF to its blocks. Where the lines are rows, a row of H is one row of each block; where they are
// columns, it is a column of one block. Values beyond those that are kept are zero.
template <class S>
class OtfRow {
 public:
  OtfRow(const FactoredOtf& sampler, const FactoredOtf::Grid& grid, const SpectralEngine<S>& engine,
         const OtfBlocks<S>& otf)
      : grid_(&grid),
        otf_(&otf),
        columns_(engine.lines() == Lines::columns),
        cosine_(engine.columns_per_block() == kRow),
        width_(engine.columns_per_block()),
        keep_(static_cast<std::size_t>(columns_ ? otf.rows : engine.x().keep)),
        scale_(static_cast<S>(engine.otf_scale())) {
    const auto count = columns_ ? keep_ : static_cast<std::size_t>(engine.blocks() * width_);
    if (sampler.is_real()) {
      up_.resize(count);
      down_.resize(count);
    } else {
      complex_up_.resize(count);
      complex_down_.resize(count);
    }
  }

  void write(std::int64_t j) {
    if (complex_up_.empty())
      cosine_ ? real_parts(j) : real_exponentials(j);
    else
      cosine_ ? complex_parts(j) : complex_exponentials(j);
  }

 private:
  // Both real columns that pass as one complex one are multiplied alike.
  void real_exponentials(std::int64_t j) {
    real_row(j);
    for (const std::int64_t half : {0, kLanes}) put(0, j, half, [&](std::size_t i) { return scale_ * up_[i]; });
  }

  void complex_exponentials(std::int64_t j) {
    complex_row(j);
    put(0, j, [&](std::size_t i) { return scale_ * complex_up_[i].re; });
    put(0, j, kLanes, [&](std::size_t i) { return scale_ * complex_up_[i].im; });
  }

  // The real parts are ee and oo, the imaginary ones eo and oe: H(fx, fy) = ee + oo + i (eo + oe) and
  // H(fx, -fy) = ee - oo + i (oe - eo).
  void real_parts(std::int64_t j) {
    if (otf_->parts.size() == 1) {
      real_row(j);
      return put(0, j, [&, scale = sign(0) * scale_](std::size_t i) { return scale * up_[i]; });
    }
    grid_->real_rows(static_cast<std::size_t>(j), std::span(up_).first(keep_), std::span(down_).first(keep_));
    const S half = S(0.5) * scale_;
    put(0, j, [&](std::size_t i) { return half * (up_[i] + down_[i]); });
    put(1, j, [&](std::size_t i) { return half * (down_[i] - up_[i]); });
  }

  void complex_parts(std::int64_t j) {
    const std::vector<OtfPart>& parts = otf_->parts;
    const auto real = std::count_if(parts.begin(), parts.end(), [](const OtfPart& part) { return part.is_real(); });
    const bool both_real = real == 2, both_imaginary = parts.size() - static_cast<std::size_t>(real) == 2;
    complex_row(j);
    if (both_real || both_imaginary)
      grid_->complex_row(static_cast<std::size_t>(j), std::span(complex_down_).first(keep_), true);
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const bool along_y = (columns_ ? parts[p].x : parts[p].y) == Parity::odd;  // of the image
      const auto part = [&](bool both, auto value) {
        const S scale = sign(p) * (both ? S(0.5) : S(1.0)) * scale_, mirrored = !both ? S(0) : along_y ? S(-1) : S(1);
        put(p, j, [&](std::size_t i) { return scale * (value(complex_up_[i]) + mirrored * value(complex_down_[i])); });
      };
      if (parts[p].is_real())
        part(both_real, [](const Complex<S>& h) { return h.re; });
      else
        part(both_imaginary, [](const Complex<S>& h) { return h.im; });
    }
  }

  S sign(std::size_t part) const { return otf_->parts[part] == OtfPart{} ? S(1.0) : S(-1.0); }
  void real_row(std::int64_t j) { grid_->real_row(static_cast<std::size_t>(j), std::span(up_).first(keep_)); }
  void complex_row(std::int64_t j) {
    grid_->complex_row(static_cast<std::size_t>(j), std::span(complex_up_).first(keep_));
  }
  // `half`: where in a row of kRow the numbers of exponentials start.
  void put(std::size_t part, std::int64_t j, const auto& value) const { put(part, j, 0, value); }
  void put(std::size_t part, std::int64_t j, std::int64_t half, const auto& value) const {
    if (columns_) {
      S* to = otf_->row(part, j / width_, 0) + half + j % width_;
      for (std::size_t i = 0; i < keep_; ++i, to += kRow) *to = value(i);
      return;
    }
    for (std::int64_t b = 0; b < otf_->blocks; ++b) {
      S* to = otf_->row(part, b, j) + half;
      const auto first = static_cast<std::size_t>(b * width_);
      for (std::size_t l = 0; l < static_cast<std::size_t>(width_); ++l) to[l] = value(first + l);
    }
  }

  const FactoredOtf::Grid* grid_;
  const OtfBlocks<S>* otf_;
  bool columns_, cosine_;
  std::int64_t width_;  ///< frequencies of a block
  std::size_t keep_;    ///< values of a row
  S scale_;
  std::vector<S> up_, down_;  // at fy and -fy
  std::vector<Complex<S>> complex_up_, complex_down_;
};

// H on the engine's frequencies, times its scale.
template <class S>
OtfBlocks<S> make_otf(const FactoredOtf& sampler, const SpectralEngine<S>& engine, int threads) {
  const bool columns = engine.lines() == Lines::columns;
  OtfBlocks<S> otf = engine.make_blocks(columns ? sampler.parities().swapped() : sampler.parities());
  std::vector<double> along, across;
  for (std::int64_t k = 0; k < engine.x().keep; ++k) along.push_back(engine.x().frequency.cy_mm(k));
  for (const std::int64_t k : otf_frequencies(engine.y())) across.push_back(engine.y().frequency.cy_mm(k));
  const std::int64_t width = engine.columns_per_block();
  if (columns && engine.x().keep % width > 0)
    for (std::size_t p = 0; p < otf.parts.size(); ++p)
      std::fill_n(otf.row(p, otf.blocks - 1, 0), otf.rows * kRow, S(0));
  const std::int64_t rows = columns ? engine.x().keep : otf.rows, together = columns ? width : 8;
  const FactoredOtf::Grid grid(sampler, columns ? across : along, columns ? along : across);
  parallel_for(rows, together, threads, [&](std::int64_t begin, std::int64_t end) {
    OtfRow<S> row(sampler, grid, engine, otf);
    for (std::int64_t j = begin; j < end; ++j) row.write(j);
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
    S square = 0;
    for (std::int64_t b = 0; b < otf_.blocks; ++b)
      for (std::int64_t r = 0; r < otf_.rows; ++r) square = std::max(square, largest_square(b, r));
    return std::sqrt(static_cast<double>(square)) / transforms_->otf_scale();
  }
  const std::shared_ptr<const SpectralEngine<S>>& transforms() const { return transforms_; }

 private:
  // Of |H|^2 in a row of a block; of H(fx, fy) and H(fx, -fy) where the parts tell them apart.
  S largest_square(std::int64_t block, std::int64_t row) const {
    S largest = 0;
    if (otf_.complex) {
      const S* h = otf_.row(0, block, row);
      for (int l = 0; l < kLanes; ++l) largest = std::max(largest, h[l] * h[l] + h[kLanes + l] * h[kLanes + l]);
      return largest;
    }
    static constexpr std::array<S, kRow> kNone{};
    const S *even = kNone.data(), *odd_x = even, *odd_y = even, *odd = even;
    for (std::size_t p = 0; p < otf_.parts.size(); ++p) {
      const auto [x, y] = otf_.parts[p];
      (x == Parity::even   ? y == Parity::even ? even : odd_y
       : y == Parity::even ? odd_x
                           : odd) = otf_.row(p, block, row);
    }
    for (int l = 0; l < kRow; ++l) {
      const S re = even[l] - odd[l], im = odd_x[l] + odd_y[l], mirrored_re = even[l] + odd[l],
              mirrored_im = odd_x[l] - odd_y[l];
      largest = std::max({largest, re * re + im * im, mirrored_re * mirrored_re + mirrored_im * mirrored_im});
    }
    return largest;
  }

  std::shared_ptr<const SpectralEngine<S>> transforms_;
  OtfBlocks<S> otf_;  // on loan from the transforms
};

template <class S>
std::shared_ptr<const SpectralFilter> make_filter(const FactoredOtf& sampler, const SpectralWork& work,
                                                  fft::Rigor rigor, int threads, const Engine* earlier) {
  const bool rows = work.lines == Lines::rows;
  const AxisTransform &x = rows ? work.x : work.y, &y = rows ? work.y : work.x;
  std::shared_ptr<const SpectralEngine<S>> transforms;
  if (const auto* filter = dynamic_cast<const Filter<S>*>(earlier)) {
    const SpectralEngine<S>& other = *filter->transforms();
    if (other.x() == x && other.y() == y && other.lines() == work.lines) transforms = filter->transforms();
  }
  if (!transforms) transforms = std::make_shared<SpectralEngine<S>>(x, y, work.lines, rigor);
  OtfBlocks<S> otf = make_otf(sampler, *transforms, threads);
  return std::make_shared<Filter<S>>(std::move(transforms), std::move(otf));
}

}  // namespace

OtfBlocks<float> make_otf_blocks(const FactoredOtf& sampler, const SpectralEngine<float>& engine, int threads) {
  return make_otf(sampler, engine, threads);
}

std::shared_ptr<const SpectralFilter> make_device_spectral_filter(const FactoredOtf& sampler, const AxisTransform& x,
                                                                  const AxisTransform& y,
                                                                  const std::shared_ptr<const Device>& device,
                                                                  int threads) {
  std::vector<double> along, across;
  for (std::int64_t k = 0; k < x.keep; ++k) along.push_back(x.frequency.cy_mm(k));
  for (const std::int64_t k : otf_frequencies(y)) across.push_back(y.frequency.cy_mm(k));
  const auto columns = along.size(), rows = across.size();
  DeviceOtf otf{.complex = !sampler.is_real(), .values = {}};
  otf.values.resize(columns * rows * (otf.complex ? 2 : 1));
  const FactoredOtf::Grid grid(sampler, std::move(along), std::move(across));
  parallel_for(static_cast<std::int64_t>(rows), 8, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Complex<float>> row(otf.complex ? columns : 0);
    for (auto j = static_cast<std::size_t>(begin); j < static_cast<std::size_t>(end); ++j) {
      if (!otf.complex) {
        grid.real_row(j, std::span(otf.values).subspan(j * columns, columns));
        continue;
      }
      grid.complex_row(j, std::span(row));
      float* to = otf.values.data() + 2 * j * columns;
      for (const Complex<float>& h : row) *to++ = h.re, *to++ = h.im;
    }
  });
  return make_device_filter(device, x, y, std::move(otf));
}

std::shared_ptr<const SpectralFilter> make_spectral_filter(const FactoredOtf& sampler, const SpectralWork& work,
                                                           fft::Rigor rigor, int threads, const Engine* earlier) {
  return work.precision == Precision::single_precision ? make_filter<float>(sampler, work, rigor, threads, earlier)
                                                       : make_filter<double>(sampler, work, rigor, threads, earlier);
}

}  // namespace mtf
