// SPDX-License-Identifier: Apache-2.0
#pragma once

// One axis of the spectral engine: how an image axis becomes frequencies, and how filtered frequencies become detector
// samples. The same trigonometric polynomial is sampled in both ways of `Resampling`:
//   fold   the canvas is a whole number of pitches: frequencies that alias onto one another are added, then one
//          transform of the detector's length gives the samples;
//   chirp  any other ratio: the polynomial is evaluated at the detector centres (Bluestein's chirp transform).

#include <cstdint>
#include <vector>

#include "mtf/border.h"
#include "mtf/engines/lanes.h"
#include "mtf/grid.h"
#include "mtf/image.h"

namespace mtf {

enum class Resampling { fold, chirp };

struct AxisJob {
  bool operator==(const AxisJob&) const = default;
  FrequencyAxis frequency;  ///< basis, canvas length, scene step
  Border border{};
  std::int64_t samples = 0;  ///< image samples of the scene
  std::int64_t outputs = 0;  ///< detector samples wanted, from the shared corner
  double pitch_um = 0.0;
  Resampling resampling{};
  std::int64_t out_length = 0;  ///< fold: length of the detector transform
  std::int64_t keep = 0;        ///< frequencies with |k| < keep are used, the others are zero

  /// Phase advance of frequency 1 per detector sample, and at detector sample 0, in turns.
  double turns_per_output() const { return pitch_um / frequency.period_um(); }
  double turns_at_first() const;
};

/// Contribution of one frequency to the input of the inverse transform: target += factor x otf row x source.
struct Term {
  std::int32_t k = 0;       ///< signed frequency
  std::int32_t source = 0;  ///< transform row (fourier) or k (cosine)
  std::int32_t target = 0;
  double re = 1.0, im = 0.0;
};

/// All terms of a column axis (every signed frequency kept). The OTF has one row a term, in this order.
std::vector<Term> column_terms(const AxisJob& job);

/// Length of the transform that `target` counts in: out_length for fold, the chirp's convolution length else.
std::int64_t inverse_length(const AxisJob& job);

/// Bluestein evaluation of sum_k g_k exp(2 pi i k (t0 + j t)), |k| < keep, j = 0 .. outputs-1, on lanes. The input
/// holds g_k at row k + keep - 1, times the factors of its terms.
template <class S>
class Chirp {
 public:
  Chirp() = default;
  Chirp(const AxisJob& job, fft::Rigor rigor);
  void run(S* data) const;  ///< inverse_length rows in, outputs rows out, in place

 private:
  std::int64_t outputs_ = 0;
  LaneTransform<S> transform_;
  std::vector<S> kernel_, after_;
};

extern template class Chirp<float>;
extern template class Chirp<double>;

/// Rotation exp(2 pi i turns), the argument reduced first.
Complex<double> rotation(long double turns);

}  // namespace mtf
