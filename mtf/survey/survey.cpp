// SPDX-License-Identifier: Apache-2.0
#include "mtf/survey/survey.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "mtf/engines/statistics.h"
#include "mtf/engines/uniform_runs.h"
#include "mtf/math/word_hash.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

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
