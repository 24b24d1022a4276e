// SPDX-License-Identifier: Apache-2.0
#pragma once

// Digital filter on the detector grid: taps[row][column] is the response to a point of one pixel, centred on its
// middle.
//   otf = sum_jk taps[j][k] exp(-2 pi i (fx px (k - kc) + fy py (j - jc))), periodic in the sampling frequency.
// Complex unless the taps are symmetric about their middle. otf(0) = sum of taps: a gain, kept.

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Fir {
  static constexpr std::string_view kind = "fir";
  static constexpr std::string_view doc = "digital filter by its taps, on the detector grid";
  static constexpr Stages stages{.postsample = true};

  Taps<S> taps;

  static constexpr auto fields() {
    return std::tuple{Field{FieldInfo{.name = "taps",
                                      .lo = -1e6,
                                      .hi = 1e6,
                                      .example = "[[0, -0.25, 0], [-0.25, 2.0, -0.25], [0, -0.25, 0]]",
                                      .doc = "rows of an odd by odd kernel; the response to one bright pixel"},
                            &Fir::taps}};
  }
  bool mirrored(bool in_x, bool in_y) const {
    const std::size_t rows = taps.size(), columns = taps.front().size();
    for (std::size_t j = 0; j < rows; ++j)
      for (std::size_t k = 0; k < columns; ++k)
        if (value_of(taps[j][k]) != value_of(taps[in_y ? rows - 1 - j : j][in_x ? columns - 1 - k : k])) return false;
    return true;
  }
  Traits traits(const Context<S>&) const {
    double sum = 0.0;
    for (const auto& row : taps)
      for (const S& tap : row) sum += value_of(tap);
    return {.even_x = mirrored(true, false),
            .even_y = mirrored(false, true),
            .real = mirrored(true, true),
            .gain = true,
            .dc = sum};
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S ux = f.x * ctx.frame.pitch_x_um * S(2e-3), uy = f.y * ctx.frame.pitch_y_um * S(2e-3);
    const double jc = 0.5 * static_cast<double>(taps.size() - 1),
                 kc = 0.5 * static_cast<double>(taps.front().size() - 1);
    Complex<S> sum{};
    for (std::size_t j = 0; j < taps.size(); ++j) {
      Complex<S> row{};
      for (std::size_t k = 0; k < taps[j].size(); ++k) {
        const Complex<S> phase = phase_of(S(ux * S(static_cast<double>(k) - kc)));
        row = row + Complex<S>{taps[j][k] * phase.re, taps[j][k] * phase.im};
      }
      sum = sum + row * phase_of(S(uy * S(static_cast<double>(j) - jc)));
    }
    // Symmetric taps: the imaginary part is rounding only, and declared zero. Its derivatives are not: a tap may leave
    // the symmetry.
    return {sum.re, mirrored(true, true) ? lift({0.0, 1.0}, sum.im) : sum.im};
  }
  double cutoff_cy_mm(const Context<S>&) const { return kInfinity; }
  double deviation(double, double, const Context<S>&) const {
    double sum = 0.0;
    for (std::size_t j = 0; j < taps.size(); ++j)
      for (std::size_t k = 0; k < taps[j].size(); ++k) {
        const bool centre = 2 * j + 1 == taps.size() && 2 * k + 1 == taps[j].size();
        sum += std::abs(value_of(taps[j][k]) - (centre ? 1.0 : 0.0));
      }
    return sum;
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (taps.empty() || taps.front().empty()) return {{.field = "taps", .text = "empty"}};
    for (const auto& row : taps)
      if (row.size() != taps.front().size()) return {{.field = "taps", .text = "rows of different length"}};
    if (taps.size() % 2 == 0 || taps.front().size() % 2 == 0)
      return {{.field = "taps",
               .text = "rows and columns have to be odd in number, so that the filter has a middle; "
                       "an even kernel would shift the image by half a pixel"}};
    return {};
  }
};

}  // namespace mtf
