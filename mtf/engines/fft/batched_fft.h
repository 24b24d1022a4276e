// SPDX-License-Identifier: Apache-2.0
#pragma once

// Complex Fourier transforms of kLanes sequences side by side. Element n of all sequences is one row of 2 kLanes
// numbers: the real parts, then the imaginary parts; every step of a transform is then arithmetic on whole vectors.
//
// Lengths 2^a 3^b 5^c 7^d 11^e 13^f are transformed in place, steps of one radix after another (decimation in frequency
// forwards, in time backwards), a part that fits the first-level cache at a time. Frequencies stay where the
// steps leave them, k at row place(k); the caller reads them there. Other lengths go to FFTW, where place(k) = k.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mtf/engines/fft/fftw.h"
#include "mtf/engines/fft/lane_steps.h"

namespace mtf {

/// Whether a length has no prime factor above 13. FFTW takes others by sums and convolutions, which round more.
bool in_small_steps(std::int64_t n);

template <class S>
class BatchedFft {
 public:
  BatchedFft() = default;
  /// Tables are kept for the next transform of the same length. `rigor` is FFTW's.
  BatchedFft(std::int64_t n, fft::Rigor rigor);

  std::int64_t length() const { return tables_ ? tables_->length : 0; }
  std::int32_t place(std::int64_t k) const { return tables_->place[static_cast<std::size_t>(k)]; }
  /// x[n] in order -> sum_n x[n] exp(-2 pi i n k / length) at row place(k).
  void forward(S* data) const;
  /// The same, where x[n] is row rows[n] of `from`.
  void forward(const S* from, std::span<const std::int32_t> rows, S* data) const;
  /// X[k] at row place(k) -> sum_k X[k] exp(+2 pi i n k / length) in order.
  void inverse(S* data) const;

 private:
  struct Tables {
    std::int64_t length = 0;
    std::vector<lanes::Step<S>> steps;
    std::vector<std::int32_t> place;
    fft::Split<S> fftw;  ///< for lengths without steps
  };
  static std::shared_ptr<const Tables> make_tables(std::int64_t n, fft::Rigor rigor);
  void forward_from(std::size_t first, S* data) const;
  void inverse_from(std::size_t first, S* data) const;

  std::shared_ptr<const Tables> tables_;
};

extern template class BatchedFft<float>;
extern template class BatchedFft<double>;

}  // namespace mtf
