// SPDX-License-Identifier: Apache-2.0
#pragma once

// The spectral engine: filter by an OTF and sample on the detector grid, in three passes over one buffer.
//   1. lines forward     kRow image rows at once, a row a lane -> coefficients of the kept x frequencies
//   2. columns           blocks of kLanes complex columns, each in cache: transform, multiply by the OTF, fold to the
//                        detector grid, inverse transform
//   3. lines inverse     x coefficients, folded -> detector rows
// Rows that are uniform take no transform, neither forwards nor, where the filter brings next to nothing to them,
// backwards: mtf/engines/fft/line_groups.h chooses, and the engine transforms the groups of rows that it is given.
// Where an image has uniform columns instead, its columns are the lines, and x and y change places from end to end.
// Columns beyond the cutoff never exist, border rows are never transformed twice, and the inverse works on the detector
// grid only. Threads share groups of rows and blocks; every result is independent of their number.
//
// Buffer and OTF are stored block by block: numbers [block][row][kRow]. In the cosine basis a row holds kRow real x
// coefficients (the first kLanes and the last kLanes pass through the complex column transforms as one number, which is
// exact because everything there is real-linear with real factors); in the fourier basis kLanes complex ones, real
// parts first.
//
// A mirrored scene is a sum of C cos(a) cos(b), a and b the phases of an x and a y frequency. With the OTF in its parts
// by parity along x and y, H = ee + oo + i (eo + oe) (real because psf is: H(-f) = conj H(f)), it comes out as
//   sum C (ee cos(a) cos(b) - eo cos(a) sin(b) - oe sin(a) cos(b) - oo sin(a) sin(b)).
// So columns are transformed once and come back once a part; of the x frequencies the cosines and the sines, in a
// buffer each, once a row.
//
// What the y transforms of pass 2 leave does not depend on the OTF. For a channel with a KeptPlane it is written there,
// block by block, and later runs of the same engine on that plane begin with the multiplication. (To keep the
// coefficients of pass 1 instead would take as much memory and leave a third of the forward work.)
//
// Images are float32; S is the type of everything between them.

#include <array>
#include <memory>
#include <vector>

#include "mtf/engines/buffer_pool.h"
#include "mtf/engines/engine.h"
#include "mtf/engines/fft/axis.h"
#include "mtf/engines/fft/line_groups.h"
#include "mtf/engines/kept_plane.h"
#include "mtf/engines/kernels.h"
#include "mtf/image.h"

namespace mtf {

/// The parts of an OTF that these axes take, in the order of kOtfParts; a single one where x is in the fourier basis.
std::vector<OtfPart> otf_parts(const AxisTransform& x, const AxisTransform& y, const Parities& parities);

/// OTF values in the engine's layout, times 1/(transform lengths): numbers [part][block][row][kRow], where all
/// parts but ee have the sign of the sum above.
template <class S>
struct OtfBlocks {
  bool complex = false;  ///< multiplies lane by lane (fourier basis along x); else number by number
  std::vector<OtfPart> parts;
  std::int64_t blocks = 0;
  std::int64_t rows = 0;  ///< y frequencies
  BufferPool::Loan<S> data;

  std::int64_t size() const { return static_cast<std::int64_t>(parts.size()) * blocks * rows * kRow; }
  S* row(std::size_t part, std::int64_t block, std::int64_t r) const {
    return data.data() + ((static_cast<std::int64_t>(part) * blocks + block) * rows + r) * kRow;
  }
};

template <class S>
class SpectralEngine {
 public:
  /// The axis along the lines and the one across them: x and y of the image, or y and x with Lines::columns.
  /// x.basis cosine needs y.basis cosine, y.odd needs x.basis cosine.
  SpectralEngine(const AxisTransform& x, const AxisTransform& y, Lines lines, fft::Rigor rigor);

  const AxisTransform& x() const { return x_.job(); }
  const AxisTransform& y() const { return y_.job(); }
  Lines lines() const { return lines_; }
  /// x frequencies per block: kRow cosines or kLanes complex exponentials.
  std::int64_t columns_per_block() const { return kRow / x_.rows_per_coefficient(); }
  std::int64_t blocks() const { return (x().keep + columns_per_block() - 1) / columns_per_block(); }
  /// Memory for an OTF, uninitialised; the engine has to outlive it.
  OtfBlocks<S> make_blocks(const Parities& parities) const;
  /// Factor that the OTF has to carry: the inverse of what the unnormalised transforms multiply.
  double otf_scale() const;
  /// Bytes of buffers that one run of `channels` planes takes, at most.
  std::int64_t run_bytes(std::int64_t channels, int threads) const;

  /// Filters all channels with one OTF, read once. Const and re-entrant.
  void run(const std::vector<Channel>& channels, const OtfBlocks<S>& otf, int threads) const;

 private:
  /// Coefficients of one plane: of the cosines along x (or the exponentials), and of the sines where there are any.
  struct Buffers {
    S* even = nullptr;
    S* odd = nullptr;
    std::int64_t rows = 0;  ///< of a block
    Buffers of_block(std::int64_t block) const {
      const std::int64_t first = block * rows * kRow;
      return {even + first, odd == nullptr ? nullptr : odd + first, rows};
    }
  };
  /// A channel between the passes.
  struct Plane {
    Channel channel;
    Buffers buffers;
    LineGroups input = {};
    double std = 0.0;                             ///< of the image, scaled
    S* spectrum = nullptr;                        ///< of a plane that is kept
    bool known = false;                           ///< the spectrum is there, and nothing in the buffers
    bool even = true, odd = false;                ///< along x, of what comes back in the buffers
    std::vector<std::int32_t> canvas = {};        ///< of the columns beyond the first block: uniform lines as zeros
    std::vector<std::int64_t> over_uniform = {};  ///< groups of filtered lines that may be negligible
    std::vector<double> energies = {};            ///< of those: [group][block]
  };
  KeptSpectrum::Key key_of(const Channel& channel) const {
    return {name_, channel.mean, channel.scale, channel.border_value};
  }
  Plane recall(const Channel& channel, const Buffers& buffers) const;
  Plane read(const Channel& channel, const Buffers& buffers, int threads) const;
  kernels::Moments lines_forward(const Plane& plane, int threads) const;
  kernels::Moments uniform_forward(const Plane& plane, std::int64_t begin, std::int64_t end) const;
  void columns(std::vector<Plane>& planes, const OtfBlocks<S>& otf, int threads) const;
  void lines_inverse(const Plane& plane, int threads) const;
  void uniform_inverse(const Plane& plane, const std::vector<std::int64_t>& groups, int threads) const;
  kernels::Moments load(const Channel& channel, std::int64_t begin, std::int64_t end, S* samples) const;
  void store(const Channel& channel, std::int64_t begin, std::int64_t end, const S* samples) const;
  void column_block(const Plane& plane, const OtfBlocks<S>& otf, std::int64_t block,
                    const std::array<S*, 3>& areas) const;
  void add_energies(Plane& plane, std::int64_t block) const;
  std::vector<std::int32_t> canvas_without_uniform(const LineGroups& input) const;
  LineGroups output_of(const Plane& plane) const;
  /// Calls tile(coefficients of kLanes lines, rows in the buffer) for all kLanes lines x kLanes numbers of a group.
  void for_tiles(auto* coefficients, auto* buffer, std::int64_t rows, std::int64_t first_row, const auto& tile) const;

  std::int64_t coefficient_rows() const;  ///< rows of the coefficients of one group of lines
  std::int64_t line_stride() const;
  S border_sample(const Channel& channel) const {
    return static_cast<S>((channel.border_value - channel.mean) * channel.scale);
  }

  AxisPass<S> x_, y_;
  Lines lines_;
  mutable BufferPool pool_;
  std::shared_ptr<const void> name_ = std::make_shared<const char>();  ///< by which what is kept knows this engine
};

extern template class SpectralEngine<float>;
extern template class SpectralEngine<double>;

}  // namespace mtf
