// SPDX-License-Identifier: Apache-2.0
#pragma once

// The spectral engine: filter by an OTF and sample on the detector grid, in three passes over one buffer.
//   1. rows forward      kRow image rows at once, a row a lane -> coefficients of the kept x frequencies
//   2. columns           blocks of kLanes complex columns, each in cache: transform, multiply by the OTF, fold to the
//                        detector grid, inverse transform
//   3. rows inverse      x coefficients, folded -> detector rows
// Columns beyond the cutoff never exist, border rows are never transformed twice, and the inverse works on the detector
// grid only. Threads share groups of rows and blocks; every result is independent of their number.
//
// Buffer and OTF are stored block by block: numbers [block][row][kRow]. In the cosine basis a row holds kRow real x
// coefficients (the first kLanes and the last kLanes pass through the complex column transforms as one number, which is
// exact because everything there is real-linear with real factors); in the fourier basis kLanes complex ones, real
// parts first.
//
// Images are float32; S is the type of everything between them.

#include <vector>

#include "mtf/engines/axis_pass.h"
#include "mtf/engines/buffer_pool.h"
#include "mtf/engines/engine.h"
#include "mtf/image.h"

namespace mtf {

/// OTF values in the engine's layout, times 1/(transform lengths).
template <class S>
struct OtfBlocks {
  bool complex = false;
  std::int64_t blocks = 0;
  std::int64_t rows = 0;  ///< terms of the y axis
  AlignedBuffer<S> data;

  S* row(std::int64_t block, std::int64_t r) const { return data.data() + (block * rows + r) * kRow; }
};

template <class S>
class SpectralEngine {
 public:
  /// x.basis cosine needs y.basis cosine and a real OTF.
  SpectralEngine(const AxisJob& x, const AxisJob& y, fft::Rigor rigor);

  FrequencyGrid frequencies() const { return {x().frequency, y().frequency}; }
  const AxisJob& x() const { return x_.job(); }
  const AxisJob& y() const { return y_.job(); }
  /// x frequencies per block: kRow cosines or kLanes complex exponentials.
  std::int64_t columns_per_block() const { return kRow / x_.rows_per_coefficient(); }
  std::int64_t blocks() const { return (x().keep + columns_per_block() - 1) / columns_per_block(); }
  const std::vector<Term>& y_terms() const { return y_.terms(); }
  /// Factor that the OTF has to carry: the inverse of what the unnormalised transforms multiply.
  double otf_scale() const;
  /// Bytes of buffers that one run of `channels` planes takes.
  std::int64_t run_bytes(std::int64_t channels, int threads) const;

  /// Filters all channels with one OTF, read once. Const and re-entrant.
  void run(const std::vector<Channel>& channels, const OtfBlocks<S>& otf, int threads) const;

 private:
  void rows_forward(const Channel& channel, S* buffer, int threads) const;
  void columns(const std::vector<Channel>& channels, const std::vector<S*>& buffers, const OtfBlocks<S>& otf,
               int threads) const;
  void rows_inverse(const Channel& channel, const S* buffer, int threads) const;
  void column_block(const Channel& channel, const OtfBlocks<S>& otf, std::int64_t block, S* data, S* work,
                    S* target) const;
  /// Calls tile(coefficients of kLanes lines, rows in the buffer) for all kLanes lines x kLanes numbers of a group.
  void for_tiles(auto* coefficients, auto* buffer, std::int64_t first_row, const auto& tile) const;

  std::int64_t block_rows() const;        ///< rows of one block of the buffer
  std::int64_t coefficient_rows() const;  ///< rows of the coefficients of one group of lines
  std::int64_t line_stride() const;
  S level(const Channel& channel) const {
    return static_cast<S>((channel.border_value - channel.mean) * channel.scale);
  }

  AxisPass<S> x_, y_;
  mutable BufferPool pool_;
};

extern template class SpectralEngine<float>;
extern template class SpectralEngine<double>;

}  // namespace mtf
