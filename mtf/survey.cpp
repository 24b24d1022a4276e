// SPDX-License-Identifier: Apache-2.0
#include "mtf/survey.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "mtf/engines/clones.h"
#include "mtf/engines/kernels.h"
#include "mtf/error.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

// Moments of the finite samples of one row about its own mean: they combine without cancellation.
struct Row {
  double mean = 0.0, squares = 0.0, min = 0.0, max = 0.0, first = 0.0, last = 0.0;
  std::int64_t finite = 0, first_bad = -1;
  std::uint64_t fingerprint = 0;
};

// FNV-1a over words: Fowler, Noll, Vo; for telling scenes apart, not against malice.
std::uint64_t mixed(std::uint64_t hash, std::uint64_t word) { return (hash ^ word) * 1099511628211ULL; }

std::uint64_t fingerprint_of(const float* values, std::int64_t n) {
  std::uint64_t hash = 1469598103934665603ULL;
  for (std::int64_t x = 0; x < n; ++x) {
    std::uint32_t word = 0;
    std::memcpy(&word, values + x, sizeof word);
    hash = mixed(hash, word);
  }
  return hash;
}

// Lanes of partial sums: the same order on every machine.
MTFKIT_CLONES double squares_about(const float* values, std::int64_t n, double mean) {
  constexpr std::int64_t lanes = 8;
  std::array<double, lanes> sums{};
  std::int64_t x = 0;
  for (; x + lanes <= n; x += lanes)
    for (std::int64_t l = 0; l < lanes; ++l) {
      const double d = values[x + l] - mean;
      sums[static_cast<std::size_t>(l)] += d * d;
    }
  double sum = 0.0;
  for (; x < n; ++x) sum += (values[x] - mean) * (values[x] - mean);
  for (const double s : sums) sum += s;
  return sum;
}

Row row_moments(const float* values, std::int64_t n) {
  Row row;
  row.fingerprint = fingerprint_of(values, n);
  row.first = values[0];
  row.last = values[n - 1];
  if (const kernels::RowSummary quick = kernels::summarise_row(values, n); std::isfinite(quick.sum)) {
    row.min = quick.min;
    row.max = quick.max;
    row.finite = n;
    row.mean = row.min == row.max ? row.min : quick.sum / static_cast<double>(n);
    row.squares = squares_about(values, n, row.mean);
    return row;
  }
  double sum = 0.0;
  for (std::int64_t x = 0; x < n; ++x) {
    const double v = values[x];
    if (!std::isfinite(v)) {
      if (row.first_bad < 0) row.first_bad = x;
      continue;
    }
    if (row.finite++ == 0) row.min = row.max = v;
    row.min = std::min(row.min, v);
    row.max = std::max(row.max, v);
    sum += v;
  }
  if (row.finite == 0) return row;
  row.mean = row.min == row.max ? row.min : sum / static_cast<double>(row.finite);
  for (std::int64_t x = 0; x < n; ++x)
    if (const double d = values[x] - row.mean; std::isfinite(d)) row.squares += d * d;
  return row;
}

double square(double x) { return x * x; }

Statistics statistics_of(const std::vector<Row>& rows, std::int64_t width) {
  Statistics s;
  double sum = 0.0;
  std::int64_t finite = 0;
  for (std::size_t y = 0; y < rows.size(); ++y) {
    const Row& row = rows[y];
    if (row.first_bad >= 0 && s.first_x < 0) s.first_x = row.first_bad, s.first_y = static_cast<std::int64_t>(y);
    s.not_finite += width - row.finite;
    if (row.finite == 0) continue;
    s.min = finite == 0 ? row.min : std::min(s.min, row.min);
    s.max = finite == 0 ? row.max : std::max(s.max, row.max);
    finite += row.finite;
    sum += row.mean * static_cast<double>(row.finite);
  }
  if (finite == 0) return s;
  s.mean = s.min == s.max ? s.min : sum / static_cast<double>(finite);
  const double scale = std::max(s.max - s.mean, s.mean - s.min);  // 1e-30 squared is none
  if (scale == 0.0) return s;
  double squares = 0.0;
  for (const Row& row : rows)
    if (row.finite > 0)
      squares += row.squares / scale / scale + static_cast<double>(row.finite) * square((row.mean - s.mean) / scale);
  s.std = scale * std::sqrt(squares / static_cast<double>(finite));
  return s;
}

// Each sample counts as often as the canvas repeats it (mtf/statistics.cpp).
double canvas_norm_of(const std::vector<Row>& rows, std::int64_t width, const SurveyOptions& options, double mean) {
  const auto height = static_cast<std::int64_t>(rows.size());
  const auto n = static_cast<double>(width);
  const double copies = options.border == Border::reflect ? 2.0 : 1.0;
  double sum = 0.0;
  for (std::int64_t y = 0; y < height; ++y) {
    const Row& row = rows[static_cast<std::size_t>(y)];
    double along = copies * (row.squares + n * square(row.mean - mean));
    double weight = copies;
    if (options.border == Border::replicate) {
      along += n * (square(row.first - mean) + square(row.last - mean));
      weight += (y == 0 ? static_cast<double>(height) : 0.0) + (y == height - 1 ? static_cast<double>(height) : 0.0);
    }
    sum += weight * along;
  }
  const double area = n * static_cast<double>(height);
  if (options.border == Border::constant) sum += 8.0 * area * square(options.border_value - mean);
  return std::sqrt(sum / area);
}

// What is gathered of one channel.
class Gathered {
 public:
  Gathered(const ReadWindow& read, std::size_t channel, const SampleGrid& scene, const SurveyOptions& options)
      : width_(scene.width), rows_(static_cast<std::size_t>(scene.height)) {
    if (options.every == 0) return;
    Image first(width_, 1);
    read(channel, 0, 0, first.view());
    const CoarseGrid grid = coarse_grid(scene, options.border, options.every);
    coarse_.emplace(grid,
                    options.border == Border::constant ? options.border_value : row_moments(first.data(), width_).mean);
    along_ = Image(grid.x.count, std::min(options.band_rows, scene.height));
  }
  // Row `y` of the band that begins at row `first`. From several threads.
  void add_row(std::int64_t first, std::int64_t y, const float* row) {
    rows_[static_cast<std::size_t>(first + y)] = row_moments(row, width_);
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
    for (const Row& row : rows_) result.fingerprint = mixed(result.fingerprint, row.fingerprint);
    result.canvas_norm = canvas_norm_of(rows_, width_, options, result.statistics.mean);
    if (coarse_ && result.statistics.not_finite == 0) {
      result.shift = coarse_->shift();
      result.coarse = coarse_->image();
    }
    return result;
  }

 private:
  std::int64_t width_;
  std::vector<Row> rows_;
  std::optional<CoarseScene> coarse_;
  Image along_;
};

}  // namespace

ReadWindow windows_of(std::span<const ImageView<const float>> planes) {
  return [planes](std::size_t channel, std::int64_t x, std::int64_t y, ImageView<float> out) {
    for (std::int64_t j = 0; j < out.height; ++j)
      std::memcpy(out.row(j), planes[channel].row(y + j) + x, static_cast<std::size_t>(out.width) * sizeof(float));
  };
}

std::optional<SceneSummary> Survey::summary(Border border, double border_value) const {
  if (statistics.std == 0.0) return std::nullopt;
  const double level = border == Border::constant ? std::abs(border_value) : 0.0;
  return SceneSummary{statistics.std, std::max({std::abs(statistics.min), std::abs(statistics.max), level}),
                      canvas_norm};
}

Survey survey(const ReadWindow& read, std::size_t channel, const SampleGrid& scene, const SurveyOptions& options) {
  return std::move(survey_channels(read, channel, 1, scene, options).front());
}

std::vector<Survey> survey_channels(const ReadWindow& read, std::size_t first, std::size_t count,
                                    const SampleGrid& scene, const SurveyOptions& options) {
  std::vector<Gathered> channels;
  for (std::size_t c = 0; c < count; ++c) channels.emplace_back(read, first + c, scene, options);
  for (std::int64_t top = 0; top < scene.height; top += options.band_rows) {
    if (options.progress) options.progress(top);
    const std::int64_t rows = std::min(options.band_rows, scene.height - top);
    // All that is to be done with a row while it is in the caches.
    parallel_for(rows, 16, options.threads, [&](std::int64_t begin, std::int64_t end) {
      Image row(scene.width, 1);
      for (std::int64_t y = begin; y < end; ++y)
        for (std::size_t c = 0; c < count; ++c) {
          read(first + c, 0, top + y, row.view());
          channels[c].add_row(top, y, row.data());
        }
    });
    for (Gathered& channel : channels) channel.end_band(top, rows, options.threads);
  }
  std::vector<Survey> surveys;
  for (const Gathered& channel : channels) surveys.push_back(channel.survey(options));
  return surveys;
}

}  // namespace mtf
