// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a plan has to know of a scene that need not fit memory, in one pass over bands of its rows.

#include <functional>
#include <optional>

#include "mtf/engines/statistics.h"
#include "mtf/plan/plan.h"
#include "mtf/survey/coarse.h"

namespace mtf {

/// Fills `out` with the window of one channel that starts at (x, y) and has the size of `out`; it lies within the
/// scene. Called from several threads at once.
using ReadWindow = std::function<void(std::size_t channel, std::int64_t x, std::int64_t y, ImageView<float> out)>;

/// The window reader of planes in memory, which have to outlive it.
ReadWindow windows_of(std::span<const ImageView<const float>> planes);

struct SurveyOptions {
  Border border = Border::reflect;
  double border_value = 0.0;
  std::int64_t every = 0;        ///< scene samples for one of the coarse image; 0: no coarse image
  std::int64_t band_rows = 512;  ///< rows that are read together
  int threads = 0;
  std::function<void(std::int64_t row)> progress = nullptr;  ///< called with the first row of a band that begins
};

struct Survey {
  Statistics statistics;
  double canvas_norm = 0.0;       ///< as canvas_norm of mtf/engines/statistics.h
  double shift = 0.0;             ///< value that was subtracted from the samples of the coarse image
  std::uint64_t fingerprint = 0;  ///< of all samples in their order: tells one scene from another
  Image coarse;                   ///< on coarse_grid(); empty when not asked for or where pixels are not finite

  /// As summarise() of mtf/plan/plan.h.
  std::optional<SceneSummary> summary(Border border, double border_value) const;
};

/// The same numbers for any number of threads and rows a band, up to rounding those of mtf/engines/statistics.h.
Survey survey(const ReadWindow& read, std::size_t channel, const SampleGrid& scene, const SurveyOptions& options);

/// The same for the channels first .. first + count - 1 in one pass: a file is decoded once for all of them. Each needs
/// running sums of its coarse image meanwhile, 8 bytes a coarse sample.
std::vector<Survey> survey_channels(const ReadWindow& read, std::size_t first, std::size_t count,
                                    const SampleGrid& scene, const SurveyOptions& options);

}  // namespace mtf
