// SPDX-License-Identifier: Apache-2.0
#include "mtf/survey/survey.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "mtf/engines/kernels.h"
#include "mtf/engines/statistics.h"
#include "mtf/engines/uniform_runs.h"
#include "mtf/math/clones.h"
#include "mtf/math/simd.h"
#include "mtf/math/word_hash.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

constexpr double kSigmaSteps = 1.6;
constexpr double kHalfWidthSigmas = 6.2;  // a Gaussian holds all but 6e-10 of itself within
constexpr std::int64_t kLanes = 8, kVector = 16;

CoarseAxis coarse_axis(Border border, std::int64_t n, double step, double coarse) {
  CoarseAxis axis;
  axis.border = border;
  axis.samples = n;
  axis.step_um = step;
  const bool own = border == Border::reflect || border == Border::periodic;
  const double length = static_cast<double>(own ? n : canvas_length(border, n)) * step;
  axis.count = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(length / coarse - 1e-9)));
  axis.coarse_um = length / static_cast<double>(axis.count);
  axis.origin_um = own ? 0.0 : -static_cast<double>(n) * step;
  return axis;
}

double gaussian_weight(double distance, double sigma) {
  const double z = distance / sigma;
  return std::exp(-0.5 * z * z) / (sigma * 2.5066282746310002);
}

/// A dense run of weights: sum of weight[k] x value[first + k].
struct Stencil {
  std::int64_t first = 0;
  std::vector<float> weight;
};

// Weights of the scene's samples in each coarse sample. The canvas repeats samples, so they add up; a run spans all
// that are touched, which is the whole axis where the canvas closes on itself.
std::vector<Stencil> analysis(const CoarseAxis& axis) {
  std::vector<Stencil> stencils(static_cast<std::size_t>(axis.count));
  const double half_width = kHalfWidthSigmas * axis.sigma_um;
  std::vector<double> weight(static_cast<std::size_t>(axis.samples));
  for (std::int64_t j = 0; j < axis.count; ++j) {
    const double centre = axis.origin_um + (static_cast<double>(j) + 0.5) * axis.coarse_um;
    const auto from = static_cast<std::int64_t>(std::ceil((centre - half_width) / axis.step_um - 0.5));
    const auto to = static_cast<std::int64_t>(std::floor((centre + half_width) / axis.step_um - 0.5));
    std::int64_t lowest = axis.samples, highest = -1;
    for (std::int64_t i = from; i <= to; ++i) {
      const std::int64_t source = border_source(axis.border, i, axis.samples);
      if (source < 0) continue;
      lowest = std::min(lowest, source);
      highest = std::max(highest, source);
      weight[static_cast<std::size_t>(source)] +=
          axis.step_um * gaussian_weight((static_cast<double>(i) + 0.5) * axis.step_um - centre, axis.sigma_um);
    }
    if (highest < lowest) continue;
    // Whole vectors, with zeros after the run or else before it.
    const auto whole = [&] { return (highest - lowest + kVector) / kVector * kVector; };
    highest = std::min(lowest + whole(), axis.samples) - 1;
    lowest = std::max<std::int64_t>(highest + 1 - whole(), 0);
    Stencil& stencil = stencils[static_cast<std::size_t>(j)];
    stencil.first = lowest;
    for (std::int64_t i = lowest; i <= highest; ++i) {
      stencil.weight.push_back(static_cast<float>(weight[static_cast<std::size_t>(i)]));
      weight[static_cast<std::size_t>(i)] = 0.0;
    }
  }
  return stencils;
}

template <std::int64_t n>
MTFKIT_INLINE float added_in_pairs(float* v) {
  if constexpr (n == 1) return v[0];
  for (std::int64_t l = 0; l < n / 2; ++l) v[l] += v[l + n / 2];
  return added_in_pairs<std::max<std::int64_t>(n / 2, 1)>(v);
}

// Partial sums, added in pairs: the same order on every machine.
MTFKIT_CLONES float dot(const float* a, const float* b, std::int64_t n) {
  using Lanes = float __attribute__((vector_size(kVector * sizeof(float)), aligned(4), may_alias));
  Lanes even{}, odd{};
  std::int64_t i = 0;
  for (; i + 2 * kVector <= n; i += 2 * kVector) {
    const auto *p = reinterpret_cast<const Lanes*>(a + i), *q = reinterpret_cast<const Lanes*>(b + i);
    even += p[0] * q[0];
    odd += p[1] * q[1];
  }
  if (i + kVector <= n) {
    even += *reinterpret_cast<const Lanes*>(a + i) * *reinterpret_cast<const Lanes*>(b + i);
    i += kVector;
  }
  std::array<float, kVector> sums;
  *reinterpret_cast<Lanes*>(sums.data()) = even + odd;
  float sum = added_in_pairs<kVector>(sums.data());
  for (; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

bool all_zero(const float* p, std::int64_t n) {
  return std::all_of(p, p + n, [](float v) { return v == 0.0F; });
}

MTFKIT_CLONES void add_scaled(float* __restrict to, const float* __restrict from, float factor, std::int64_t n) {
  for (std::int64_t i = 0; i < n; ++i) to[i] += factor * from[i];
}
MTFKIT_CLONES void add_scaled(double* __restrict to, const float* __restrict from, double factor, std::int64_t n) {
  for (std::int64_t i = 0; i < n; ++i) to[i] += factor * from[i];
}

// Weights of the coarse samples `low` .. at evenly spaced positions; every run has the same length.
struct Synthesis {
  std::int64_t low = 0, span = 0, taps = 0;
  std::vector<std::int64_t> start;  // of each position, from `low`
  std::vector<float> weight;        // taps a position
};

Synthesis synthesis(const CoarseAxis& axis, double first_um, double step_um, std::int64_t count) {
  Synthesis s;
  const double half_width = kHalfWidthSigmas * axis.sigma_um;
  s.taps = (static_cast<std::int64_t>(std::ceil(2.0 * half_width / axis.coarse_um)) + 1 + kLanes - 1) / kLanes * kLanes;
  for (std::int64_t i = 0; i < count; ++i) {
    const double x = first_um + static_cast<double>(i) * step_um - axis.origin_um;
    const auto from = static_cast<std::int64_t>(std::ceil((x - half_width) / axis.coarse_um - 0.5));
    s.start.push_back(from);
    for (std::int64_t k = 0; k < s.taps; ++k) {
      const double centre = (static_cast<double>(from + k) + 0.5) * axis.coarse_um;
      s.weight.push_back(static_cast<float>(axis.coarse_um * gaussian_weight(x - centre, axis.sigma_um)));
    }
  }
  s.low = s.start.front();
  s.span = s.start.back() + s.taps - s.low;
  for (std::int64_t& start : s.start) start -= s.low;
  return s;
}

MTFKIT_CLONES void interpolate_row(const float* row, const Synthesis& s, double offset, float* out, std::int64_t n) {
  for (std::int64_t x = 0; x < n; ++x) {
    const float* from = row + s.start[static_cast<std::size_t>(x)];
    const float* weight = s.weight.data() + x * s.taps;
    std::array<float, kLanes> lanes{};
    for (std::int64_t k = 0; k < s.taps; k += kLanes)
      for (std::int64_t l = 0; l < kLanes; ++l) lanes[static_cast<std::size_t>(l)] += from[k + l] * weight[k + l];
    double sum = offset;
    for (const float lane : lanes) sum += lane;
    out[x] = static_cast<float>(out[x] + sum);
  }
}

std::uint64_t fingerprint_of(const float* values, std::int64_t n) {
  constexpr std::int64_t kStreams = 4;  // side by side: a multiplication waits for the one before
  std::array<std::uint64_t, kStreams> hashes;
  hashes.fill(kWordHashStart);
  std::int64_t x = 0;
  for (; x + 2 * kStreams <= n; x += 2 * kStreams) {
    std::array<std::uint64_t, kStreams> words;
    std::memcpy(words.data(), values + x, sizeof words);
    for (std::size_t k = 0; k < kStreams; ++k) hashes[k] = mixed(hashes[k], words[k]);
  }
  for (; x < n; ++x) hashes[0] = mixed(hashes[0], std::bit_cast<std::uint32_t>(values[x]));
  for (std::size_t k = 1; k < kStreams; ++k) hashes[0] = mixed(hashes[0], hashes[k]);
  return hashes[0];
}

/// Sums c while the scene is read row by row. `shift` is subtracted from all samples: the value of a constant border
/// where there is one, else any value of the scene.
class CoarseScene {
 public:
  /// The shift is rounded to float. Rows that equal it cost next to nothing.
  CoarseScene(const CoarseGrid& grid, double shift)
      : grid_(grid),
        shift_(static_cast<float>(shift)),
        x_(analysis(grid.x)),
        y_(analysis(grid.y)),
        sum_(static_cast<std::size_t>(grid.x.count * grid.y.count)) {}
  /// The sums of one row of the scene along x, as many as the coarse image is wide. From any thread.
  void sum_along_x(std::span<const float> row, std::span<float> along) const {
    const auto n = static_cast<std::int64_t>(row.size());
    std::vector<float> centred(row.size());
    kernels::center(row.data(), n, shift_, 1.0, centred.data());
    // Ends of a row that equal the shift, as all of the row may do, add nothing.
    std::int64_t first = 0, last = n;
    while (first < last && all_zero(centred.data() + first, std::min(kVector, last - first))) first += kVector;
    while (last > first && all_zero(centred.data() + std::max(last - kVector, first), std::min(kVector, last - first)))
      last -= kVector;
    for (std::size_t j = 0; j < along.size(); ++j) {
      const Stencil& s = x_[j];
      const auto count = static_cast<std::int64_t>(s.weight.size());
      const bool outside = s.first >= last || s.first + count <= first;
      along[j] = outside ? 0.0F : dot(centred.data() + s.first, s.weight.data(), count);
    }
  }
  /// Takes such sums of the rows first .. first + along.height - 1; they may come in any order, each row once.
  void add(std::int64_t first, ImageView<const float> along, int threads) {
    const std::int64_t width = grid_.x.count;
    parallel_for_each(grid_.y.count, 16, threads, [&](std::int64_t j) {
      const Stencil& s = y_[static_cast<std::size_t>(j)];
      const std::int64_t from = std::max(first, s.first);
      const std::int64_t to = std::min(first + along.height, s.first + static_cast<std::int64_t>(s.weight.size()));
      double* sums = sum_.data() + j * width;
      for (std::int64_t y = from; y < to; ++y) {
        const double w = s.weight[static_cast<std::size_t>(y - s.first)];
        const float* row = along.row(y - first);
        if (w != 0.0 && !all_zero(row, width)) add_scaled(sums, row, w, width);
      }
    });
  }
  double shift() const { return shift_; }
  /// c about the shift.
  Image image() const {
    Image image(grid_.x.count, grid_.y.count);
    for (std::size_t i = 0; i < sum_.size(); ++i) image.data()[i] = static_cast<float>(sum_[i]);
    return image;
  }

 private:
  CoarseGrid grid_;
  double shift_;
  std::vector<Stencil> x_, y_;
  std::vector<double> sum_;
};

// The sums over one channel.
class ChannelSums {
 public:
  ChannelSums(const ReadWindow& read, std::size_t channel, const SampleGrid& scene, const SurveyOptions& options)
      : width_(scene.width),
        rows_(static_cast<std::size_t>(scene.height)),
        fingerprints_(static_cast<std::size_t>(scene.height)) {
    if (options.every == 0) return;
    Image first(width_, 1);
    read(channel, 0, 0, first.view());
    // Sums are about a value that a quarter of the first row has, if there is one: samples with that value add nothing.
    // Values near the largest float are summed about 0, so that no difference overflows.
    const CoarseGrid grid = coarse_grid(scene, options.border, options.every);
    UniformRuns flat(std::as_const(first).view());
    double shift = row_moments(first.data(), width_).mean;
    if (flat.any() && 4 * std::count(flat.classify_row(0), flat.classify_row(0) + flat.groups(), 1) >= flat.groups())
      shift = flat.value(1);
    if (std::abs(shift) > 1e30) shift = 0.0;
    coarse_.emplace(grid, options.border == Border::constant ? options.border_value : shift);
    along_ = Image(grid.x.count, std::min(options.band_rows, scene.height));
  }
  // Row `y` of the band that begins at row `first`. From several threads.
  void add_row(std::int64_t first, std::int64_t y, const float* row) {
    rows_[static_cast<std::size_t>(first + y)] = row_moments(row, width_);
    fingerprints_[static_cast<std::size_t>(first + y)] = fingerprint_of(row, width_);
    if (coarse_)
      coarse_->sum_along_x({row, static_cast<std::size_t>(width_)},
                           {along_.view().row(y), static_cast<std::size_t>(along_.width())});
  }
  void end_band(std::int64_t first, std::int64_t count, int threads) {
    if (coarse_) coarse_->add(first, {along_.data(), along_.width(), count, along_.width()}, threads);
  }
  Survey survey(const SurveyOptions& options) const {
    Survey result;
    result.statistics = statistics_of(rows_, width_);
    for (const std::uint64_t row : fingerprints_) result.fingerprint = mixed(result.fingerprint, row);
    result.canvas_norm = canvas_norm_of(rows_, width_, options.border, options.border_value, result.statistics.mean);
    if (coarse_ && result.statistics.not_finite == 0) {
      result.shift = coarse_->shift();
      result.coarse = coarse_->image();
    }
    return result;
  }

 private:
  std::int64_t width_;
  std::vector<RowMoments> rows_;
  std::vector<std::uint64_t> fingerprints_;
  std::optional<CoarseScene> coarse_;
  Image along_;
};

}  // namespace

CoarseGrid coarse_grid(const SampleGrid& scene, Border border, std::int64_t every) {
  const double coarse = static_cast<double>(every) * std::max(scene.step_x_um, scene.step_y_um);
  CoarseGrid grid{coarse_axis(border, scene.width, scene.step_x_um, coarse),
                  coarse_axis(border, scene.height, scene.step_y_um, coarse)};
  // One round Gaussian for both axes keeps the split a function of |f|.
  grid.x.sigma_um = grid.y.sigma_um = kSigmaSteps * std::max(grid.x.coarse_um, grid.y.coarse_um);
  return grid;
}

void add_interpolated(const CoarseGrid& grid, ImageView<const float> w, double x_um, double y_um, double step_x_um,
                      double step_y_um, double offset, ImageView<float> out) {
  const Synthesis sx = synthesis(grid.x, x_um, step_x_um, out.width);
  const Synthesis sy = synthesis(grid.y, y_um, step_y_um, out.height);
  // The part of the coarse image that is read, its border rule resolved.
  Image local(sx.span, sy.span);
  for (std::int64_t j = 0; j < sy.span; ++j)
    for (std::int64_t i = 0; i < sx.span; ++i)
      local.at(i, j) = w.at(border_source(grid.x.coarse_border(), sx.low + i, grid.x.count),
                            border_source(grid.y.coarse_border(), sy.low + j, grid.y.count));
  std::vector<float> row(static_cast<std::size_t>(sx.span));
  for (std::int64_t y = 0; y < out.height; ++y) {
    std::fill(row.begin(), row.end(), 0.0F);
    for (std::int64_t k = 0; k < sy.taps; ++k)
      add_scaled(row.data(), local.view().row(sy.start[static_cast<std::size_t>(y)] + k),
                 sy.weight[static_cast<std::size_t>(y * sy.taps + k)], sx.span);
    interpolate_row(row.data(), sx, offset, out.row(y), out.width);
  }
}

ReadWindow windows_of(std::span<const ImageView<const float>> planes) {
  return [planes](std::size_t channel, std::int64_t x, std::int64_t y, ImageView<float> out) {
    copy(part_of(planes[channel], {x, y, out.width, out.height}), out);
  };
}

std::optional<SceneSummary> Survey::summary(Border border, double border_value) const {
  if (statistics.std == 0.0) return std::nullopt;
  const double beyond = border == Border::constant ? std::abs(border_value) : 0.0;
  return SceneSummary{statistics.std, std::max({std::abs(statistics.min), std::abs(statistics.max), beyond}),
                      canvas_norm};
}

Survey survey(const ReadWindow& read, std::size_t channel, const SampleGrid& scene, const SurveyOptions& options) {
  return std::move(survey_channels(read, channel, 1, scene, options).front());
}

std::vector<Survey> survey_channels(const ReadWindow& read, std::size_t first, std::size_t count,
                                    const SampleGrid& scene, const SurveyOptions& options) {
  std::vector<ChannelSums> channels;
  for (std::size_t c = 0; c < count; ++c) channels.emplace_back(read, first + c, scene, options);
  for (std::int64_t top = 0; top < scene.height; top += options.band_rows) {
    if (options.progress) options.progress(top);
    const std::int64_t rows = std::min(options.band_rows, scene.height - top);
    // Everything that needs a row is done while the row is in the caches.
    parallel_for(rows, 16, options.threads, [&](std::int64_t begin, std::int64_t end) {
      Image row(scene.width, 1);
      for (std::int64_t y = begin; y < end; ++y)
        for (std::size_t c = 0; c < count; ++c) {
          read(first + c, 0, top + y, row.view());
          channels[c].add_row(top, y, row.data());
        }
    });
    for (ChannelSums& channel : channels) channel.end_band(top, rows, options.threads);
  }
  std::vector<Survey> surveys;
  for (const ChannelSums& channel : channels) surveys.push_back(channel.survey(options));
  return surveys;
}

}  // namespace mtf
