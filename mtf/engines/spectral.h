// SPDX-License-Identifier: Apache-2.0
#pragma once

// The spectral engine: filter by an OTF and sample on the detector grid, in three passes over one buffer.
//   1. rows forward      real rows -> coefficients of the kept x frequencies
//   2. columns           blocks of kLanes complex columns, each in cache: transform, multiply by the OTF, fold to the
//                        detector grid, inverse transform
//   3. rows inverse      x coefficients, folded -> detector rows
// Columns beyond the cutoff never exist, border rows are never transformed twice, and the inverse works on the detector
// grid only. Threads share rows and blocks; every result is independent of their number.
//
// The buffer and the OTF are stored block by block: floats [block][row][kRowFloats]. In the cosine basis a row holds 2
// kLanes real x coefficients (a pair of neighbours passes through the complex column transforms as one number, which is
// exact because everything there is real-linear with real factors); in the fourier basis kLanes complex ones.

#include <vector>

#include "mtf/engines/axis.h"
#include "mtf/engines/engine.h"
#include "mtf/image.h"

namespace mtf {

/// OTF values in the engine's layout, times 1/(transform lengths).
struct OtfBlocks {
  bool complex = false;
  std::int64_t blocks = 0;
  std::int64_t rows = 0;  ///< terms of the y axis
  AlignedBuffer<float> data;

  float* row(std::int64_t block, std::int64_t r) const { return data.data() + (block * rows + r) * kRowFloats; }
};

class SpectralEngine {
 public:
  /// x.basis cosine needs y.basis cosine and a real OTF.
  SpectralEngine(const AxisJob& x, const AxisJob& y, fft::Rigor rigor);

  FrequencyGrid frequencies() const { return {x_.frequency, y_.frequency}; }
  const AxisJob& x() const { return x_; }
  const AxisJob& y() const { return y_; }
  /// x frequencies per block: 2 kLanes cosines or kLanes complex exponentials.
  std::int64_t columns_per_block() const;
  std::int64_t blocks() const;
  const std::vector<Term>& y_terms() const { return y_terms_; }
  /// Factor that the OTF has to carry: the inverse of what the unnormalised transforms multiply.
  double otf_scale() const;
  /// Bytes of buffers that one run of `channels` planes allocates.
  std::int64_t run_bytes(std::int64_t channels, int threads) const;

  /// Filters all channels with one OTF, read once. Const and re-entrant.
  void run(const std::vector<Channel>& channels, const OtfBlocks& otf, int threads) const;

 private:
  void rows_forward(const Channel& channel, float* buffer, int threads) const;
  void columns(const std::vector<Channel>& channels, const std::vector<AlignedBuffer<float>>& buffers,
               const OtfBlocks& otf, int threads) const;
  void rows_inverse(const Channel& channel, const float* buffer, int threads) const;
  void column_block(const Channel& channel, const OtfBlocks& otf, std::int64_t block, float* data, float* work,
                    float* target) const;
  void row_from_coefficients(const Channel& channel, const float* coefficients, float* work, float* out) const;

  void load_columns(const Channel& channel, std::int64_t block, const float* data, float* work) const;

  std::int64_t block_rows() const;  ///< rows of one block of the buffer
  std::int64_t work_rows() const;

  AxisJob x_, y_;
  std::vector<Term> x_terms_, y_terms_;
  bool x_folds_ = false;                           ///< false: x terms keep their place and sign
  std::vector<std::int32_t> x_source_, y_source_;  ///< canvas position -> image sample, -1 = constant level
  std::vector<float> x_twiddles_, y_twiddles_, x_out_twiddles_, y_out_twiddles_;
  fft::RealForward x_forward_;
  fft::RealInverse x_inverse_;
  fft::Lanes y_forward_, y_inverse_;
  Chirp x_chirp_, y_chirp_;
};

}  // namespace mtf
