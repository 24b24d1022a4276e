// SPDX-License-Identifier: Apache-2.0
#pragma once

// Monte-Carlo study of the fit: scatter against the Cramer-Rao bound, coverage of the stated intervals. The bound comes
// from differences of noise-free images in the parameter and in the edge's own unknowns (offset, angle, two plateaus),
// not from the fit's derivatives. Starting values are those of measure_edge on each noisy image.

#include <cstdint>
#include <string>
#include <vector>

#include "calib/fit/fit.h"
#include "tests/calib/made_edges.h"

namespace fit_study {

/// Gaussian of MTF50 0.30, sigma unknown; or diffraction f/8 and a square pixel, with the f-number unknown, or out of
/// focus by 0.3 waves, unknown, as `defocus` or as a term of `wavefront`.
enum class Model { gaussian, camera, defocus, wavefront };

struct Case {
  std::string name;
  Model model = Model::gaussian;
  std::int64_t rows = 100;  ///< length of the edge
  double cnr = 60.0;
  double sagitta_px = 0.0;
  double quantum = 0.0;
};
std::vector<Case> cases();

struct Outcome {
  int draws = 0, failed = 0, flagged_wrong = 0;
  double bound = 0.0;                                           ///< Cramer-Rao sd of the parameter, relative
  double bound_mtf50 = 0.0;                                     ///< and of MTF50
  double bias = 0.0, sd = 0.0, stated = 0.0;                    ///< of the parameter, relative
  double bias_mtf50 = 0.0, sd_mtf50 = 0.0, stated_mtf50 = 0.0;  ///< of MTF50, relative
  double cover68 = 0.0, cover95 = 0.0, cover68_mtf50 = 0.0, cover95_mtf50 = 0.0;
  double rms_mtf = 0.0;  ///< mean over the draws of the rms error of the MTF from 0 to 0.5 cycles/px
  double ms = 0.0;       ///< median processor time of a fit, one thread, without the measurement
};
Outcome run(const Case& one, int draws, std::uint64_t seed);

}  // namespace fit_study
