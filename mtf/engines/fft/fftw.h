// SPDX-License-Identifier: Apache-2.0
#pragma once

// All use of FFTW is in this file: one-dimensional transforms of fixed length, one thread each. One lock serialises
// planning (FFTW's planner is not thread-safe); execution is const and re-entrant. Data are aligned to 64 bytes
// (AlignedBuffer).

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mtf/frame.h"
#include "mtf/image.h"
#include "mtf/rigor.h"

namespace mtf::fft {

using mtf::Rigor;

/// Complex sequences side by side, in place, unnormalised: element n of lane l at re[2 n lanes + l] and the same of im,
/// im = re + lanes. For the lengths that BatchedFft leaves to FFTW.
template <class S>
class Split {
 public:
  Split() = default;
  Split(std::int64_t n, int lanes, Rigor rigor);
  void forward(S* re, S* im) const;  ///< sign -1
  void inverse(S* re, S* im) const;  ///< sign +1

 private:
  std::shared_ptr<void> forward_, inverse_;
};

/// n reals -> n/2 + 1 complex numbers, sign -1. `in` is destroyed or not, as FFTW likes; in != out.
class RealForward {
 public:
  RealForward() = default;
  RealForward(std::int64_t n, Rigor rigor);
  void execute(float* in, float* out) const;

 private:
  std::shared_ptr<void> plan_;
};

/// One complex sequence in double, in place, unnormalised: for references.
class ComplexDouble {
 public:
  ComplexDouble() = default;
  ComplexDouble(std::int64_t n, bool forward);
  void execute(Complex<double>* data) const;

 private:
  std::shared_ptr<void> plan_;
};

/// Real two-dimensional transform and back, float, one thread, on memory of its own: the floor of benchmarks.
class RealPair2d {
 public:
  enum class Place { out, in };
  RealPair2d(std::int64_t width, std::int64_t height, Place place, Rigor rigor);
  void execute() const;

 private:
  AlignedBuffer<float> real_, half_;
  std::shared_ptr<void> forward_, backward_;
};

/// In-place complex transform in double, sign +1, unnormalised: for plan-time work on one sequence.
void inverse(std::vector<Complex<double>>& data);

/// Wisdom: what Rigor::measure has learnt, as text to be kept per host. False when the text is not wisdom.
bool import_wisdom(const std::string& text);
std::string export_wisdom();

/// "fftw-3.3.10-sse2-avx".
std::string version();

}  // namespace mtf::fft
