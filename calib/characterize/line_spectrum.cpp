// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/line_spectrum.h"

#include "mtf/engines/fft/fftw.h"

namespace calib {

std::vector<double> line_spectrum(mtf::ImageView<const float> plane, LineAxis axis) {
  const bool rows = axis == LineAxis::rows;
  const std::int64_t n = rows ? plane.width : plane.height, lines = rows ? plane.height : plane.width;
  const mtf::fft::RealForward transform(n, mtf::Rigor::estimate);
  const mtf::AlignedBuffer<float> line(static_cast<std::size_t>(n)), out(static_cast<std::size_t>(n + 2));
  std::vector<double> power(static_cast<std::size_t>(n / 2), 0.0);
  for (std::int64_t l = 0; l < lines; ++l) {
    for (std::int64_t i = 0; i < n; ++i) line[static_cast<std::size_t>(i)] = rows ? plane.row(l)[i] : plane.row(i)[l];
    transform.execute(line.data(), out.data());
    for (std::size_t k = 1; k <= power.size(); ++k) {
      const auto re = static_cast<double>(out[2 * k]), im = static_cast<double>(out[2 * k + 1]);
      power[k - 1] += (re * re + im * im) / static_cast<double>(n * lines);
    }
  }
  return power;
}

}  // namespace calib
