// SPDX-License-Identifier: Apache-2.0
#pragma once

// One axis of the spectral engine at work on kLanes lines at once: samples -> frequencies, and filtered frequencies ->
// detector samples. Real lines come in pairs, as the real and imaginary parts of one lane; where everything is
// real-linear with real factors (the cosine basis, where the parts of an OTF are real) they pass through as they are,
// else `coefficients` takes them apart.

#include <span>
#include <vector>

#include "mtf/engines/fft/axis.h"
#include "mtf/engines/fft/lane_kernels.h"

namespace mtf {

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
