// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/padding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "mtf/engines/fft/axis.h"
#include "mtf/math/clones.h"

namespace mtf {
namespace {

constexpr int kEven = 9, kLow = 5, kSections = kEven + kLow;
constexpr std::int64_t kShortest = 32;      // below this the defined canvas costs nothing
constexpr std::int64_t kLongest = 1 << 20;  // canvases beyond this are not analysed

// Where the OTF is cut: evenly up to Nyquist, and at low frequencies, each a quarter of the one before, for what passes
// these alone (an eye far away passes nothing at 0 and nothing at an eighth of Nyquist).
std::vector<double> sections(double nyquist_cy_mm) {
  std::vector<double> f;
  for (int s = 0; s < kEven; ++s) f.push_back(nyquist_cy_mm * s / (kEven - 1));
  for (int s = 0; s < kLow; ++s) f.push_back(f[static_cast<std::size_t>(s == 0 ? 1 : kEven + s - 1)] / 4.0);
  return f;
}

// Frequencies, relative to Nyquist, at which a kernel is tested: from the square roots of 3, 5, 7 and 11, so that no
// distance is close to a whole number of periods of all four.
constexpr std::array kTestedAt{0.732050807568877, 0.236067977499790, 0.064575131106459, 0.013266499161422};

// The kernel's transform at `turns` per sample, between the frequencies of its canvas. It is the OTF there when the
// canvas holds the kernel; an echo at a whole number of canvases lies on the kernel's middle and shows nowhere else.
Complex<double> transform_at(const std::vector<Complex<double>>& kernel, double turns) {
  const Complex<double> ahead = rotation(-static_cast<long double>(turns)), back{ahead.re, -ahead.im};
  const std::size_t n = kernel.size(), half = n / 2;
  Complex<double> right{}, left{};
  for (std::size_t d = half; d > 0; --d) right = (right + kernel[d]) * ahead;
  for (std::size_t d = n - half - 1; d > 0; --d) left = (left + kernel[n - d]) * back;
  const double scale = 1.0 / static_cast<double>(n);
  const Complex<double> sum = kernel[0] + right + left;
  return {scale * sum.re, scale * sum.im};
}

// Calls visit(kernel, beyond) for the kernel of each section and, where outputs stand between two samples, the one
// shifted by half a sample, until it returns false. The transforms are not normalised. `beyond`: of the kernel, outside
// the canvas, at one frequency.
void for_sections(const FactoredOtf& sampler, const CanvasRequest& request, std::int64_t length, const auto& visit) {
  const FrequencyAxis along{Basis::fourier, length, request.step_um};
  const std::vector<double> across = sections(request.other_nyquist_cy_mm);
  const auto n = static_cast<std::size_t>(length);
  std::vector<double> f(n);
  for (std::size_t r = 0; r < n; ++r) f[r] = along.cy_mm(along.signed_index(static_cast<std::int64_t>(r)));
  for (const double share : kTestedAt) f.push_back(share * 500.0 / request.step_um);
  const bool x = request.axis == Axis::x;
  const FactoredOtf::Grid grid(sampler, x ? f : across, x ? across : f);
  std::vector<std::vector<Complex<double>>> spectra(kSections, std::vector<Complex<double>>(f.size()));
  std::vector<Complex<float>> row(x ? f.size() : kSections);
  for (std::size_t j = 0; !x && j < f.size(); ++j) {
    grid.complex_row(j, row);
    for (std::size_t s = 0; s < kSections; ++s) spectra[s][j] = {row[s].re, row[s].im};
  }
  const bool on_samples = std::abs(std::remainder(request.pitch_um / request.step_um - 1.0, 2.0)) < 1e-9;  // odd ratios
  std::vector<Complex<double>> half_sample(n);
  for (std::size_t r = 0; !on_samples && r < n; ++r)
    half_sample[r] = rotation(static_cast<long double>(0.5 * f[r] * request.step_um * 1e-3));
  for (std::size_t s = 0; s < kSections; ++s) {
    if (x) {
      grid.complex_row(s, row);
      for (std::size_t i = 0; i < f.size(); ++i) spectra[s][i] = {row[i].re, row[i].im};
    }
    Complex<double> beyond{};
    for (const bool between : {false, true}) {
      if (between && on_samples) break;
      std::vector<Complex<double>> kernel(spectra[s].begin(), spectra[s].begin() + length);
      for (std::size_t r = 0; between && r < n; ++r) kernel[r] = kernel[r] * half_sample[r];
      fft::inverse(kernel);
      if (!between) {
        const std::size_t p = s % kTestedAt.size();  // one for each section
        const Complex<double> here = transform_at(kernel, 0.5 * kTestedAt[p]), otf = spectra[s][n + p];
        beyond = {here.re - otf.re, here.im - otf.im};
      }
      if (!visit(kernel, beyond)) return;
    }
  }
}

MTFKIT_CLONES void moduli_of(const Complex<double>* __restrict values, std::size_t count, double* __restrict moduli) {
  for (std::size_t i = 0; i < count; ++i)
    moduli[i] = std::sqrt(values[i].re * values[i].re + values[i].im * values[i].im);
}

/// sum[i] = the sum over k of weight[k] from[k][i], in lots that stay in registers.
MTFKIT_CLONES void weighted_sum(std::span<const double* const> from, const double* weight, std::size_t count,
                                double* sum) {
  constexpr std::size_t kLanes = 8, kLot = 8 * kLanes;
  using Lanes [[gnu::vector_size(kLanes * sizeof(double))]] = double;
  std::size_t i = 0;
  for (; i + kLot <= count; i += kLot) {
    Lanes lot[kLot / kLanes]{};
    for (std::size_t k = 0; k < from.size(); ++k)
      for (std::size_t v = 0; v < kLot / kLanes; ++v) {
        Lanes one;
        std::memcpy(&one, from[k] + i + v * kLanes, sizeof one);
        lot[v] += weight[k] * one;
      }
    std::memcpy(sum + i, lot, sizeof lot);
  }
  for (; i < count; ++i) {
    sum[i] = 0.0;
    for (std::size_t k = 0; k < from.size(); ++k) sum[i] += weight[k] * from[k][i];
  }
}

// Raises tails to those of one kernel.
void raise_tails(std::span<const Complex<double>> kernel, double beyond, double silent, std::vector<double>& tails) {
  const std::size_t n = kernel.size();
  std::vector<double> moduli(n);
  moduli_of(kernel.data(), n, moduli.data());
  double sum = beyond * static_cast<double>(n);
  tails.back() = std::max(tails.back(), beyond);
  for (std::size_t d = n / 2; d-- > 0;) {
    // Distances d + 1 to both sides; the middle of an even canvas is both.
    for (const std::size_t i : {d + 1, n - d - 1})
      if (moduli[i] > silent) sum += moduli[i];
    tails[d] = std::max(tails[d], sum / static_cast<double>(n));
  }
}

// Of the values of the OTF that are compared: tables and floats.
double compared_rounding(const FactoredOtf& sampler) { return 2.0 * sampler.table_error() + 0x1p-22 * sampler.gain(); }

}  // namespace

std::vector<double> kernel_tails(const FactoredOtf& sampler, const CanvasRequest& request, std::int64_t length,
                                 double noise, const TailLimit& limit) {
  std::vector<double> tails(static_cast<std::size_t>(length) / 2 + 1, 0.0);
  const double rounding = compared_rounding(sampler);
  for_sections(sampler, request, length, [&](std::span<const Complex<double>> kernel, const Complex<double>& beyond) {
    raise_tails(kernel, std::max(0.0, std::hypot(beyond.re, beyond.im) - rounding), noise * static_cast<double>(length),
                tails);
    return tails[static_cast<std::size_t>(limit.distance)] <= limit.sum;
  });
  return tails;
}

SectionKernels::SectionKernels(const FactoredOtf& sampler, const CanvasRequest& request, std::int64_t length)
    : rounding(compared_rounding(sampler)) {
  for_sections(sampler, request, length, [&](std::span<const Complex<double>> kernel, const Complex<double>& outside) {
    values.insert(values.end(), kernel.begin(), kernel.end());
    beyond.push_back(outside);
    return true;
  });
}

std::vector<double> tails_of_sum(std::span<const SectionKernels> kernels, std::span<const double> weight,
                                 double noise) {
  const std::size_t count = kernels.front().beyond.size(), n = kernels.front().values.size() / count;
  std::vector<double> tails(n / 2 + 1, 0.0);
  std::vector<Complex<double>> kernel(n);
  std::vector<const double*> from(kernels.size());
  for (std::size_t s = 0; s < count; ++s) {
    Complex<double> beyond{};
    double rounding = 0.0;
    for (std::size_t m = 0; m < kernels.size(); ++m) {
      from[m] = reinterpret_cast<const double*>(kernels[m].values.data() + s * n);
      beyond = beyond + Complex<double>{weight[m], 0.0} * kernels[m].beyond[s];
      rounding += std::abs(weight[m]) * kernels[m].rounding;
    }
    weighted_sum(from, weight.data(), 2 * n, reinterpret_cast<double*>(kernel.data()));
    raise_tails(kernel, std::max(0.0, std::hypot(beyond.re, beyond.im) - rounding), noise * static_cast<double>(n),
                tails);
  }
  return tails;
}

CanvasLength choose_canvas(const FactoredOtf& sampler, const CanvasRequest& request) {
  const std::int64_t n = request.samples, defined = canvas_length(request.border, n);
  if (request.border == Border::periodic || n < kShortest || defined > kLongest || request.budget <= 0.0)
    return {defined, 0.0};
  const double scale = 2.0 * request.norm, allowed = request.budget / scale;
  const std::int64_t most = (std::clamp(request.longest, n, defined) - n) / 2;
  const std::vector<double> tails = kernel_tails(sampler, request, next_smooth(2 * defined), 0.0, {most, allowed});
  const auto fits = [&](std::int64_t d) { return tails[static_cast<std::size_t>(d)] <= allowed; };
  if (!fits(most)) return {defined, 0.0};
  std::int64_t pad = 0;
  while (!fits(pad)) ++pad;
  const std::int64_t least = next_smooth(n + 2 * pad);
  if (least >= defined) return {defined, 0.0};

  std::int64_t length = least;
  for (std::int64_t m = least; m < defined && static_cast<double>(m) <= 1.1 * static_cast<double>(least); ++m) {
    const double pitches = static_cast<double>(m) * request.step_um / request.pitch_um;
    if (!is_smooth(m) || !is_whole(pitches)) continue;
    length = m;
    break;
  }
  return {length, scale * tails[static_cast<std::size_t>(std::min<std::int64_t>((length - n) / 2, defined - 1))]};
}

}  // namespace mtf
