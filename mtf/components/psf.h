// SPDX-License-Identifier: Apache-2.0
#pragma once

// A point spread function by its samples, as measured from a point source or computed by another program.
//   otf = sum_jk s[j][k] exp(-2 pi i (fx dx (k - kc) + fy dy (j - jc))) / sum_jk s[j][k]
//   otf = 0 for |fx| >= 1/(2 dx) or |fy| >= 1/(2 dy)
// s = samples[row][column] in any unit, dx, dy = step; rows run along +y, columns along +x, the origin is the middle
// sample (jc, kc). Complex unless the samples are symmetric about it; a shift is kept in the phase. From half a cycle
// per sample on samples say nothing. As valid as they are dense, and as they reach out to where the PSF has ended: a
// part e of the light that lies beyond them makes the otf wrong by up to 2 e/(1 + e) (both sums lack it). e is that of
// the tails of the line spreads, l(x) ~ x^-q, q of their outermost samples but from 3/2 to 2, with which diffraction
// ends (a steeper fall may be that towards a dark ring); up to e = 0.1 it is a warning with the bound, beyond an error.
// (Papoulis, Systems and Transforms with Applications in Optics, ch. 5: sampling of band-limited functions.)

#include <algorithm>

#include "mtf/components/field.h"

namespace mtf {

template <class S>
struct Psf {
  static constexpr std::string_view kind = "psf";
  static constexpr std::string_view doc = "point spread function by its samples";
  static constexpr Stages stages{.presample = true};
  static constexpr std::size_t kMostSamples = 1025;  ///< along an axis
  static constexpr double kMostBeyond = 0.1;         ///< of the light, beyond the samples

  Taps<S> samples{};
  AxisPair<S> step{};
  Choice part{0, kSensorPartNames};

  static constexpr auto fields() {
    return std::tuple{required(&Psf::samples, "samples", -1e12, 1e12,
                               "[[0, 0, 0.01, 0, 0], [0, 0.05, 0.15, 0.04, 0], [0.01, 0.15, 0.6, 0.16, 0.02], "
                               "[0, 0.04, 0.15, 0.05, 0], [0, 0, 0.01, 0, 0]]",
                               "rows of the PSF, odd by odd, in any unit; the middle one is its origin"),
                      required(&Psf::step, "step", 1e-6, 1e9, "\"2 um\"", "spacing of the samples, per axis"),
                      Field{&Psf::part, kPartInfo}};
  }
  Traits traits(const Context<S>&) const {
    const auto [sum, absolute] = sums();
    return {.even_x = mirrored(true, false),
            .even_y = mirrored(false, true),
            .real = mirrored(true, true),
            .gain = absolute > sum};
  }
  /// What does not depend on the frequency is done once: for many frequencies at one context.
  auto evaluator(const Context<S>& ctx) const {
    return [table = table(ctx)](const Freq<S>& f) {
      if (!table.holds(f)) return Complex<S>{};
      const std::vector<Complex<T>> y = table.phases_y(T(f.y));
      Complex<T> sum{};
      for (std::size_t k = 0; k < table.columns; ++k) sum = sum + table.column(k, y) * table.phase_x(T(f.x), k);
      return table.normalised(sum);
    };
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const { return evaluator(ctx)(f); }
  auto rows(std::span<const S> fx, const Context<S>& ctx) const {
    Table table = this->table(ctx);
    std::vector<Complex<T>> x(fx.size() * table.columns);
    for (std::size_t k = 0; k < table.columns; ++k)
      for (std::size_t i = 0; i < fx.size(); ++i)
        if (table.holds({fx[i], S(0)})) x[k * fx.size() + i] = table.phase_x(T(fx[i]), k);
    return [table = std::move(table), x = std::move(x), n = fx.size()](const S& fy, std::span<Complex<S>> h) {
      std::vector<Complex<T>> sum(h.size());
      if (table.holds({S(0), fy})) {
        const std::vector<Complex<T>> y = table.phases_y(T(fy));
        for (std::size_t k = 0; k < table.columns; ++k) {
          const Complex<T> weight = table.column(k, y);
          for (std::size_t i = 0; i < h.size(); ++i) sum[i] = sum[i] + weight * x[k * n + i];
        }
      }
      for (std::size_t i = 0; i < h.size(); ++i) h[i] = h[i] * table.normalised(sum[i]);
    };
  }
  /// Where it ends along the axes.
  std::vector<double> kinks_cy_mm(const Context<S>& ctx) const {
    const double x = 500.0 / value_of(step.x_um(ctx.frame)), y = 500.0 / value_of(step.y_um(ctx.frame));
    return {std::min(x, y), std::max(x, y)};
  }
  /// |1 - exp(-2 pi i a)| = 2 sin(pi |a|) for each sample.
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    const double x = fx * value_of(step.x_um(ctx.frame)) * 1e-3, y = fy * value_of(step.y_um(ctx.frame)) * 1e-3;
    double bound = x < 0.5 && y < 0.5 ? 0.0 : 1.0, sum = 0.0;
    const double middle_j = 0.5 * (static_cast<double>(samples.size()) - 1.0),
                 middle_k = 0.5 * (static_cast<double>(samples.front().size()) - 1.0);
    for (std::size_t j = 0; j < samples.size(); ++j)
      for (std::size_t k = 0; k < samples[j].size(); ++k) {
        const double turns =
            std::abs(static_cast<double>(k) - middle_k) * x + std::abs(static_cast<double>(j) - middle_j) * y;
        sum += std::abs(value_of(samples[j][k])) * 2.0 * sin_pi(std::min(0.5, turns));
      }
    return std::max(bound, sum / sums().plain);
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    const auto fault = [](std::string text) {
      return std::vector<Problem>{{.field = "samples", .text = std::move(text)}};
    };
    if (samples.empty() || samples.front().empty()) return fault("empty");
    for (const auto& row : samples)
      if (row.size() != samples.front().size()) return fault("rows of different length");
    if (samples.size() % 2 == 0 || samples.front().size() % 2 == 0)
      return fault("rows and columns have to be odd in number, so that the PSF has an origin, the middle sample");
    if (std::max(samples.size(), samples.front().size()) > kMostSamples)
      return fault("more than " + std::to_string(kMostSamples) + " samples along an axis");
    const auto [sum, absolute] = sums();
    if (!(sum > 0.1 * absolute))
      return fault("their sum, by which they are divided, is " + format_double(sum) + ", and that of their sizes " +
                   format_double(absolute) + "; a PSF is positive but for noise and rings");
    // What is left at the highest frequency that they hold would be folded by the sampling.
    const double x = 499.0 / value_of(step.x_um(ctx.frame)), y = 499.0 / value_of(step.y_um(ctx.frame));
    double left = 0.0;
    for (const Freq<S>& f : {Freq<S>{S(x), S(0)}, Freq<S>{S(0), S(y)}}) {
      const Complex<S> h = otf(f, ctx);
      left = std::max(left, std::hypot(value_of(h.re), value_of(h.im)));
    }
    std::vector<Problem> problems;
    if (left > 0.05)
      problems.push_back(
          {.error = false,
           .field = "step",
           .text = "the MTF of the samples is still " + format_double(left) +
                   " at half a cycle per sample, beyond which it is taken to be 0; sample the PSF more finely"});
    const double beyond = light_beyond(), bound = 2.0 * beyond / (1.0 + beyond);
    if (bound > 1e-3)
      problems.push_back(
          {.error = beyond > kMostBeyond,
           .field = "samples",
           .text =
               "they end before the PSF does: beyond them lies about " + three_digits(100.0 * beyond) +
               " % of the light that they hold, by the fall of the outermost ones, and makes the MTF wrong by up to " +
               three_digits(std::min(1.0, bound)) + "; give samples further out"});
    return problems;
  }

 private:
  using T = std::conditional_t<std::is_same_v<S, float>, double, S>;

  struct Sums {
    double plain = 0.0, absolute = 0.0;
  };
  Sums sums() const {
    Sums s;
    for (const auto& row : samples)
      for (const S& sample : row) {
        s.plain += value_of(sample);
        s.absolute += std::abs(value_of(sample));
      }
    return s;
  }
  /// Light beyond the samples over that within, along both axes.
  double light_beyond() const {
    std::vector<double> across_x(samples.front().size()), across_y(samples.size());
    for (std::size_t j = 0; j < samples.size(); ++j)
      for (std::size_t k = 0; k < samples[j].size(); ++k) {
        across_x[k] += value_of(samples[j][k]);
        across_y[j] += value_of(samples[j][k]);
      }
    double beyond = 0.0;
    for (auto* line : {&across_x, &across_y}) {
      if (line->size() == 1) continue;  // no blur along it
      for (int side = 0; side < 2; ++side) {
        beyond += tail(*line);
        std::reverse(line->begin(), line->end());
      }
    }
    return beyond / sums().plain;
  }
  /// Of a line spread beyond its last sample: the integral of m (x/x2)^-q from half a step beyond it on. x is counted
  /// from the peak, m and the q of its fall come from the means of the outermost quarter of the samples and of as many
  /// before them.
  static double tail(const std::vector<double>& line) {
    const auto peak = std::max_element(line.begin(), line.end());
    const auto n = static_cast<std::size_t>(line.end() - peak) - 1, band = std::max<std::size_t>(1, n / 4);
    if (n == 0) return kInfinity;
    const auto mean = [&](std::size_t last) {  // of `band` samples up to the one at that distance
      double sum = 0.0;
      for (std::size_t i = 0; i < band; ++i) sum += peak[static_cast<std::ptrdiff_t>(last - i)];
      return std::abs(sum) / static_cast<double>(band);
    };
    const auto middle = [&](std::size_t last) {
      return std::max(0.5, static_cast<double>(last) - 0.5 * (static_cast<double>(band) - 1.0));
    };
    const double outer = mean(n), inner = mean(n - band), x_2 = middle(n), x_1 = middle(n - band);
    if (outer == 0.0) return 0.0;
    const double q = std::clamp(std::log(inner / outer) / std::log(x_2 / x_1), 1.5, 2.0);
    return outer * x_2 * std::pow((static_cast<double>(n) + 0.5) / x_2, 1.0 - q) / (q - 1.0);
  }
  bool mirrored(bool in_x, bool in_y) const { return mirrored_taps(samples, in_x, in_y); }

  /// Samples by columns, with their steps in mm.
  struct Table {
    std::size_t rows = 0, columns = 0;
    std::vector<T> sample{};  ///< [column * rows + row]
    T step_x_mm{}, step_y_mm{}, sum{};
    bool real = false;

    bool holds(const Freq<S>& f) const {
      return std::abs(value_of(f.x)) * value_of(step_x_mm) < 0.5 && std::abs(value_of(f.y)) * value_of(step_y_mm) < 0.5;
    }
    static Complex<T> phase(const T& cycles, std::size_t i, std::size_t n) {
      return phase_of(T(cycles * T(2.0 * static_cast<double>(i) - static_cast<double>(n - 1))));
    }
    Complex<T> phase_x(const T& fx, std::size_t k) const { return phase(fx * step_x_mm, k, columns); }
    std::vector<Complex<T>> phases_y(const T& fy) const {
      std::vector<Complex<T>> phases;
      for (std::size_t j = 0; j < rows; ++j) phases.push_back(phase(fy * step_y_mm, j, rows));
      return phases;
    }
    /// Sum of column k over the rows, with their phases.
    Complex<T> column(std::size_t k, const std::vector<Complex<T>>& y) const {
      Complex<T> sum_of_rows{};
      for (std::size_t j = 0; j < rows; ++j)
        sum_of_rows = sum_of_rows + Complex<T>{sample[k * rows + j] * y[j].re, sample[k * rows + j] * y[j].im};
      return sum_of_rows;
    }
    /// Symmetric samples: the imaginary part is rounding only, and declared zero. Its derivatives are not: a sample may
    /// leave the symmetry.
    Complex<S> normalised(const Complex<T>& h) const {
      const T re = h.re / sum, im = h.im / sum;
      return {S(re), real ? S(lift({0.0, 1.0}, im)) : S(im)};
    }
  };
  Table table(const Context<S>& ctx) const {
    Table t{.rows = samples.size(),
            .columns = samples.front().size(),
            .step_x_mm = T(step.x_um(ctx.frame)) * T(1e-3),
            .step_y_mm = T(step.y_um(ctx.frame)) * T(1e-3),
            .sum = T(0),
            .real = mirrored(true, true)};
    for (std::size_t k = 0; k < t.columns; ++k) {
      T column(0);  // in the order of the OTF, so that this is 1 at zero to the last digit
      for (std::size_t j = 0; j < t.rows; ++j) {
        t.sample.push_back(T(samples[j][k]));
        column = column + t.sample.back();
      }
      t.sum = t.sum + column;
    }
    return t;
  }
};

}  // namespace mtf
