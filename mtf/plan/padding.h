// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "mtf/grid.h"
#include "mtf/otf/factored_otf.h"

namespace mtf {

/// Length of the periodic canvas of one axis, and what its wrap-around costs.
struct CanvasLength {
  std::int64_t length = 0;
  double bound = 0.0;  ///< wrap-around error, rms relative to the scene's std; 0 when the canvas is the defined one
};

struct CanvasRequest {
  Axis axis{};
  Border border{};
  std::int64_t samples = 0;
  double step_um = 0.0;
  double other_nyquist_cy_mm = 0.0;  ///< of the other axis
  double pitch_um = 0.0;             ///< a length that is a whole number of pitches is preferred
  double norm = 1.0;                 ///< canvas_norm / std of the scene, x sqrt(samples per output)
  double budget = 0.0;
  std::int64_t longest = std::numeric_limits<std::int64_t>::max();  ///< longer ones are of no use
};

/// Where the computation of tails may stop: once they exceed `sum` beyond `distance` samples.
struct TailLimit {
  std::int64_t distance = 0;
  double sum = std::numeric_limits<double>::infinity();
};

/// tails[d] = largest sum of |kernel| at distances beyond d samples, over sections of the OTF; a canvas of `length`.
/// For a kernel longer than that, the error of the OTF between the canvas's frequencies is added to every tails[d].
/// Values below `noise` count as none: the rounding of the OTF's floats, spread over the whole canvas.
std::vector<double> kernel_tails(const FactoredOtf& sampler, const CanvasRequest& request, std::int64_t length,
                                 double noise = 0.0, const TailLimit& limit = {});

/// The kernels that kernel_tails() looks at: those of a sum of OTFs are sums of them.
struct SectionKernels {
  SectionKernels(const FactoredOtf& sampler, const CanvasRequest& request, std::int64_t length);
  std::vector<Complex<double>> values;  ///< [section][place]
  std::vector<Complex<double>> beyond;  ///< of each section, outside the canvas
  double rounding = 0.0;                ///< of that
};
/// kernel_tails() of the sum of weight[i] times the OTF of kernels[i].
std::vector<double> tails_of_sum(std::span<const SectionKernels> kernels, std::span<const double> weight, double noise);

/// The defined canvas (mtf/border.h) or, where the tails of the point spread beyond it fit the budget, a shorter
/// smooth one. The tails are those of the OTF itself: for fourteen frequencies of the other axis the kernel along this
/// axis is summed from outside, the largest sum counts; for outputs that stand between two samples the kernel is the
/// one shifted by half a sample, whose tails are longer. A canvas longer than the longest of use is not sought: the
/// answer is then the defined one. A filter error e = t * u obeys |e| <= sum|t| |u| (Young), hence the bound.
CanvasLength choose_canvas(const FactoredOtf& sampler, const CanvasRequest& request);

}  // namespace mtf
