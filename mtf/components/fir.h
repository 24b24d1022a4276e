// SPDX-License-Identifier: Apache-2.0
#pragma once

// Digital filter on the detector grid: taps[row][column] is the response to a point of one pixel, centred on its middle
// tap (row jc, column kc).
//   otf = sum_jk taps[j][k] exp(-2 pi i (fx px (k - kc) + fy py (j - jc)))
// px, py = pitch; rows run along +y, columns along +x. Complex unless the taps are symmetric about their middle.
// Periodic in the sampling frequency. otf(0) = sum of taps: a gain, kept; |otf| may exceed 1. Exact for a linear
// filter. (Oppenheim and Schafer, Discrete-Time Signal Processing, ch. 2.)

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Fir {
  static constexpr std::string_view kind = "fir";
  static constexpr std::string_view doc = "digital filter by its taps, on the detector grid";
  static constexpr Stages stages{.postsample = true};
  static constexpr SensorPart part = SensorPart::electronics;

  Taps<S> taps{};

  static constexpr auto fields() {
    return std::tuple{required(&Fir::taps, "taps", -1e6, 1e6, "[[0, -0.25, 0], [-0.25, 2.0, -0.25], [0, -0.25, 0]]",
                               "rows of an odd by odd kernel; the response to one bright pixel")};
  }
  bool mirrored(bool in_x, bool in_y) const { return mirrored_taps(taps, in_x, in_y); }
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
  /// Phase of sample i of n along an axis, about the middle one.
  static Complex<S> phase(const S& f, const S& pitch_um, std::size_t i, std::size_t n) {
    return phase_of(S(f * pitch_um * S(2e-3) * S(static_cast<double>(i) - 0.5 * static_cast<double>(n - 1))));
  }
  /// Sum of column k over the rows, with their phases.
  Complex<S> column(std::size_t k, std::span<const Complex<S>> row_phases) const {
    Complex<S> sum{};
    for (std::size_t j = 0; j < taps.size(); ++j)
      sum = sum + Complex<S>{taps[j][k] * row_phases[j].re, taps[j][k] * row_phases[j].im};
    return sum;
  }
  std::vector<Complex<S>> row_phases(const S& fy, const Context<S>& ctx) const {
    std::vector<Complex<S>> phases(taps.size());
    for (std::size_t j = 0; j < phases.size(); ++j) phases[j] = phase(fy, ctx.frame.pitch_y_um, j, phases.size());
    return phases;
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const std::vector<Complex<S>> phases = row_phases(f.y, ctx);
    const std::size_t columns = taps.front().size();
    Complex<S> sum{};
    for (std::size_t k = 0; k < columns; ++k)
      sum = sum + column(k, phases) * phase(f.x, ctx.frame.pitch_x_um, k, columns);
    // Symmetric taps: the imaginary part is rounding only, and declared zero. Its derivatives are not: a tap may leave
    // the symmetry.
    return {sum.re, mirrored(true, true) ? lift({0.0, 1.0}, sum.im) : sum.im};
  }
  auto rows(std::span<const S> fx, const Context<S>& ctx) const {
    const std::size_t n = fx.size(), columns = taps.front().size();
    std::vector<Complex<S>> along_x(n * columns);
    for (std::size_t k = 0; k < columns; ++k)
      for (std::size_t i = 0; i < n; ++i) along_x[k * n + i] = phase(fx[i], ctx.frame.pitch_x_um, k, columns);
    return [*this, n, real = mirrored(true, true), x = std::move(along_x), ctx](const S& fy, std::span<Complex<S>> h) {
      const std::vector<Complex<S>> phases = row_phases(fy, ctx);
      std::vector<Complex<S>> sum(h.size());
      for (std::size_t k = 0; k < taps.front().size(); ++k) {
        const Complex<S> weight = column(k, phases);
        for (std::size_t i = 0; i < h.size(); ++i) sum[i] = sum[i] + weight * x[k * n + i];
      }
      for (std::size_t i = 0; i < h.size(); ++i)
        h[i] = h[i] * Complex<S>{sum[i].re, real ? lift({0.0, 1.0}, sum[i].im) : sum[i].im};
    };
  }
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
               .text = "rows and columns have to be odd in number, so that the filter has a middle; an even kernel "
                       "would shift the image by half a pixel"}};
    return {};
  }
};

}  // namespace mtf
