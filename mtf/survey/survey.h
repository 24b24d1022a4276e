// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a plan has to know of a scene that need not fit memory, in one pass over bands of its rows: its statistics and
// a coarse image.
//
// The coarse image of the whole canvas is for the far part of a split OTF (mtf/otf/split.h):
//   c_J = sum_i u_i g(x_i - X_J) step,   out(x) = sum_J w_J g(x - X_J) coarse step,   w = far filter of c
// with a Gaussian g of 1.6 coarse steps, so that g^ g^ = exp(-q). What aliases on the coarse grid is below 2e-8 of the
// scene's contrast: at the coarse Nyquist frequency g^ is exp(-2 (pi 1.6 / 2)^2) = 3e-6, applied twice.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "mtf/border.h"
#include "mtf/engines/statistics.h"
#include "mtf/grid.h"
#include "mtf/image.h"
#include "mtf/otf/split.h"
#include "mtf/plan/plan.h"

namespace mtf {

/// One axis: `samples` of the scene, `count` coarse ones over the same canvas.
struct CoarseAxis {
  Border border{};  ///< of the scene
  std::int64_t samples = 0, count = 0;
  double step_um = 0.0, coarse_um = 0.0, sigma_um = 0.0;
  double origin_um = 0.0;  ///< outer corner of coarse sample 0

  /// Reflect repeats by mirroring; every other border is written out as one period of its canvas.
  Border coarse_border() const { return border == Border::reflect ? Border::reflect : Border::periodic; }
};

/// The coarse grid: about one sample for `every` x `every` of the scene, coarser where the axes differ in step.
struct CoarseGrid {
  CoarseAxis x, y;
  SampleGrid grid() const { return {x.count, y.count, x.coarse_um, y.coarse_um}; }
  /// Of both Gaussians together.
  double split_sigma_um() const { return 1.4142135623730951 * x.sigma_um; }
};
CoarseGrid coarse_grid(const SampleGrid& scene, Border border, std::int64_t every);

/// Error of the coarse image and of reading it, relative to the canvas.
inline constexpr double kCoarseError = 5e-8;

/// Adds the interpolated values of the coarse image `w`, and `offset`, to `out`, sample (0, 0) at (x_um, y_um).
void add_interpolated(const CoarseGrid& grid, ImageView<const float> w, double x_um, double y_um, double step_x_um,
                      double step_y_um, double offset, ImageView<float> out);

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
