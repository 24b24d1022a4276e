// SPDX-License-Identifier: Apache-2.0
#pragma once

// One axis of the spectral engine: how an image axis becomes frequencies, and how filtered frequencies become detector
// samples. Either `Resampling` samples the same trigonometric polynomial:
//   fold   the canvas is a whole number of pitches: frequencies that alias onto one another are added, then one
//          transform of the detector's length gives the samples;
//   chirp  any other ratio: the polynomial is evaluated at the detector centres (Bluestein's chirp transform).

#include <cstdint>
#include <span>
#include <vector>

#include "mtf/border.h"
#include "mtf/engines/fft/batched_fft.h"
#include "mtf/engines/fft/lane_kernels.h"
#include "mtf/engines/fft/parity.h"
#include "mtf/grid.h"
#include "mtf/image.h"

namespace mtf {

enum class Resampling { fold, chirp };

/// What is transformed first, and last again: the rows of an image, or its columns. The result is the same to rounding;
/// columns are faster where more of them than of the rows are uniform (line_groups.h).
enum class Lines { rows, columns };

struct AxisTransform {
  bool operator==(const AxisTransform&) const = default;
  FrequencyAxis frequency;  ///< basis, canvas length, scene step
  Border border{};
  std::int64_t samples = 0;  ///< image samples of the scene
  std::int64_t outputs = 0;  ///< detector samples wanted, from the shared corner
  double pitch_um = 0.0;
  Resampling resampling{};
  std::int64_t out_length = 0;  ///< fold: length of the detector transform
  std::int64_t keep = 0;        ///< frequencies with |k| < keep are used, the others are zero
  bool odd = false;             ///< cosine: the OTF has parts that are odd along this axis and make cosines sines

  /// Phase advance of frequency 1 per detector sample, and at detector sample 0, in turns.
  double turns_per_output() const { return pitch_um / frequency.period_um(); }
  double turns_at_first() const;
};

/// Image sample that stands at each position of the canvas of an axis in the fourier basis; -1 for a constant border.
/// The right continuation comes after the image, the left one at the end of the canvas.
std::vector<std::int64_t> canvas_sources(const AxisTransform& job);

/// Contribution of one frequency to the input of the inverse transform: target += factor x OTF x source.
struct Term {
  std::int32_t k = 0;       ///< signed frequency
  std::int32_t source = 0;  ///< transform row (fourier) or k (cosine)
  std::int32_t target = 0;
  std::int32_t otf = 0;  ///< row of the OTF
  double re = 1.0, im = 0.0;
};

/// Signed frequencies k of the rows of an OTF: those that are kept; in the cosine basis those that are not negative.
std::vector<std::int64_t> otf_frequencies(const AxisTransform& job);

/// All terms of an axis, of a part of the OTF. A sine is a cosine whose frequency counts from the far end, with
/// alternating signs: sin(pi k (j + 1/2) / n) = (-1)^j cos(pi (n - k) (j + 1/2) / n). The terms of the odd parity make
/// those cosines where they fold, and the sines themselves where they chirp.
std::vector<Term> axis_terms(const AxisTransform& job, Parity parity);

/// Length of the transform that `target` counts in: out_length for fold, the chirp's convolution length else.
std::int64_t inverse_length(const AxisTransform& job);

/// What float rounds off in a filter between these axes, rms in units of 2^-24 of the canvas's rms: a pair of
/// transforms about 0.4 units for each doubling of its length (measured in tests), where the chirp passes through twice
/// as many; then the OTF.
double rounding_units(const AxisTransform& x, const AxisTransform& y);

/// Bluestein evaluation of sum_k g_k exp(2 pi i k (t0 + j t)), |k| < keep, j = 0 .. outputs-1, on lanes. The input
/// holds g_k at row k + keep - 1, times the factors of its terms.
template <class S>
class Chirp {
 public:
  Chirp() = default;
  Chirp(const AxisTransform& job, fft::Rigor rigor);
  void run(S* data) const;  ///< inverse_length rows in, outputs rows out, in place

 private:
  std::int64_t outputs_ = 0;
  BatchedFft<S> transform_;
  std::vector<S> kernel_, after_;
};

extern template class Chirp<float>;
extern template class Chirp<double>;

/// Rotation exp(2 pi i turns), the argument reduced first.
Complex<double> rotation(long double turns);

/// exp(-i pi k / 2n), k = 0 .. n-1, real and imaginary part: between the transform of n samples in Makhoul's order and
/// their cosines.
template <class S>
std::vector<S> cosine_twiddles(std::int64_t n);

/// An axis at work on kLanes lines at once: samples -> frequencies, and filtered frequencies ->
/// detector samples. Real lines come in pairs, as the real and imaginary parts of one lane; where everything is
/// real-linear with real factors (the cosine basis, where the parts of an OTF are real) they pass through as they are,
/// else `coefficients` takes them apart.
template <class S>
class AxisPass {
 public:
  /// `apart`: the frequencies leave the pass as coefficients and come back later (the x axis, on both sides of the
  /// column passes); otherwise they are filtered in place.
  AxisPass(const AxisTransform& job, bool apart, fft::Rigor rigor);

  const AxisTransform& job() const { return job_; }
  /// Rows of a work area.
  std::int64_t rows() const { return std::max(job_.frequency.length, inverse_length(job_)); }
  /// Rows of the coefficients of one frequency: a line's real coefficient, or a complex one each of both lines.
  int rows_per_coefficient() const { return cosine() ? 1 : 2; }

  /// Sample at each place of the canvas, continued by the border rule; n stands for the value of a constant border.
  std::span<const std::int32_t> canvas() const { return canvas_; }
  /// Transforms samples 0 .. n (rows in order) at their places.
  void forward(const S* samples, std::span<const std::int32_t> canvas, S* work) const {
    forward_.forward(samples, canvas, work);
  }
  /// Coefficients of k = 0 .. keep-1 from what `forward` left.
  void coefficients(const S* work, S* to) const;

  /// From what `forward` left, or from coefficients, through a part of the OTF (null for none) to samples: those of
  /// the odd parity only where the job has it. Uses both work areas and returns the one that holds sample j in row
  /// out_rows()[j]. `from` may be `work`.
  S* inverse(Parity parity, const S* from, const S* otf, bool complex_otf, S* target, S* work) const;
  std::span<const std::int32_t> out_rows() const { return out_rows_; }

 private:
  bool cosine() const { return job_.frequency.basis == Basis::cosine; }
  lanes::FoldTerm<S> source_of(std::int64_t k) const;

  /// What the inverse transform takes as its input.
  struct InverseInput {
    std::vector<lanes::FoldTerm<S>> terms;
    std::vector<std::int32_t> zeros;  ///< target rows without a term
  };
  InverseInput inverse_input(Parity parity, bool apart) const;

  AxisTransform job_;
  std::vector<S> twiddles_, out_twiddles_;  ///< exp(-i pi k / 2n), cosine basis
  std::vector<std::int32_t> canvas_;
  std::vector<std::int32_t> out_rows_;   ///< by output
  std::vector<std::int32_t> out_place_;  ///< cosine: rows of the inverse's frequencies
  InverseInput even_, odd_;
  std::vector<lanes::FoldTerm<S>> coefficients_;
  lanes::Source source_{};
  BatchedFft<S> forward_, inverse_;
  Chirp<S> chirp_;
};

extern template class AxisPass<float>;
extern template class AxisPass<double>;

}  // namespace mtf
