// SPDX-License-Identifier: Apache-2.0
#pragma once

// The floor of every filter by transforms: bare FFTW in float, measured plans.

#include <fftw3.h>

#include <algorithm>

#include "mtf/engines/fft/fftw.h"

namespace bench {

using mtf::AlignedBuffer;

/// Forward and inverse real transform, as a user of FFTW would write it.
class BarePair {
 public:
  BarePair(std::int64_t width, std::int64_t height, bool in_place)
      : half_(static_cast<std::size_t>(2 * height * (width / 2 + 1))),
        real_(in_place ? 1 : static_cast<std::size_t>(width * height)) {
    const auto w = static_cast<int>(width), h = static_cast<int>(height);
    float* real = in_place ? half_.data() : real_.data();
    auto* spectrum = reinterpret_cast<fftwf_complex*>(half_.data());
    forward_ = fftwf_plan_dft_r2c_2d(h, w, real, spectrum, FFTW_MEASURE);
    backward_ = fftwf_plan_dft_c2r_2d(h, w, spectrum, real, FFTW_MEASURE);
    std::fill_n(half_.data(), half_.size(), 0.0F);  // zeros stay zeros: the inverse is unnormalised
    std::fill_n(real_.data(), real_.size(), 0.0F);
  }
  ~BarePair() {
    fftwf_destroy_plan(forward_);
    fftwf_destroy_plan(backward_);
  }
  BarePair(const BarePair&) = delete;
  BarePair& operator=(const BarePair&) = delete;
  void forward() const { fftwf_execute(forward_); }
  void both() const {
    fftwf_execute(forward_);
    fftwf_execute(backward_);
  }

 private:
  AlignedBuffer<float> half_, real_;
  fftwf_plan forward_ = nullptr, backward_ = nullptr;
};

}  // namespace bench
