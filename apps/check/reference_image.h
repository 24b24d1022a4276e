// SPDX-License-Identifier: Apache-2.0
#pragma once

// The definition of a plan's result, evaluated slowly and in double: discrete Fourier sums over the whole periodic
// canvas, the exact OTF at every frequency, and the trigonometric polynomial at every detector centre. No FFT, no
// padding choice, no cosine basis, no folding: an independent computation of every image of the engine.

#include <cmath>
#include <complex>
#include <functional>
#include <vector>

#include "mtf/border.h"
#include "mtf/grid.h"
#include "mtf/image.h"
#include "mtf/system.h"

namespace apps::check {

using Otf = std::function<std::complex<double>(double fx, double fy)>;

inline Otf otf_of(const mtf::System<double>& system, mtf::Stage stage) {
  return [&system, stage](double fx, double fy) {
    const mtf::Complex<double> h = system.otf(stage, {fx, fy});
    return std::complex<double>(h.re, h.im);
  };
}

struct ReferenceAxis {
  std::int64_t samples, outputs, length;
  std::vector<std::int64_t> k;                  // signed
  std::vector<double> weight, f;                // f in cycles/mm
  std::vector<std::complex<double>> analysis;   // [k][canvas position], exp(-2 pi i k i / length)
  std::vector<std::complex<double>> synthesis;  // [output][k]

  ReferenceAxis(mtf::Border border, std::int64_t n, double step, std::int64_t out, double pitch)
      : samples(n), outputs(out), length(mtf::canvas_length(border, n)) {
    const double period = static_cast<double>(length) * step;
    for (std::int64_t i = -(length / 2); i <= length / 2; ++i) {
      k.push_back(i);
      weight.push_back(2 * std::abs(i) == length ? 0.5 : 1.0);
      f.push_back(static_cast<double>(i) / period * 1e3);
    }
    for (const std::int64_t q : k)
      for (std::int64_t i = 0; i < length; ++i)
        analysis.push_back(
            std::polar(1.0, -2.0 * M_PI * static_cast<double>(q * i % length) / static_cast<double>(length)));
    for (std::int64_t j = 0; j < outputs; ++j) {
      const double x = (static_cast<double>(j) + 0.5) * pitch - 0.5 * step;
      for (const std::int64_t q : k)
        synthesis.push_back(std::polar(1.0, 2.0 * M_PI * static_cast<double>(q) * x / period));
    }
  }
};

/// The filtered, sampled image, row-major, out.width x out.height. `scene(column, row)` is the sample there.
template <class Scene>
std::vector<double> reference_image(const Scene& scene, const mtf::SampleGrid& in, const mtf::SampleGrid& out,
                                    const Otf& otf, mtf::Border border, double border_value = 0.0) {
  using C = std::complex<double>;
  const ReferenceAxis ax(border, in.width, in.step_x_um, out.width, out.step_x_um);
  const ReferenceAxis ay(border, in.height, in.step_y_um, out.height, out.step_y_um);
  const auto nx = ax.k.size(), ny = ay.k.size();
  std::vector<C> rows(static_cast<std::size_t>(ay.length) * nx);
  for (std::int64_t y = 0; y < ay.length; ++y)
    for (std::size_t q = 0; q < nx; ++q) {
      C sum = 0.0;
      const std::int64_t sy = mtf::border_source(border, y, in.height);
      for (std::int64_t x = 0; x < ax.length; ++x) {
        const std::int64_t sx = mtf::border_source(border, x, in.width);
        sum += (sx < 0 || sy < 0 ? border_value : scene(sx, sy)) *
               ax.analysis[q * static_cast<std::size_t>(ax.length) + static_cast<std::size_t>(x)];
      }
      rows[static_cast<std::size_t>(y) * nx + q] = sum;
    }
  std::vector<C> spectrum(ny * nx);
  for (std::size_t p = 0; p < ny; ++p)
    for (std::size_t q = 0; q < nx; ++q) {
      C sum = 0.0;
      for (std::int64_t y = 0; y < ay.length; ++y)
        sum += rows[static_cast<std::size_t>(y) * nx + q] *
               ay.analysis[p * static_cast<std::size_t>(ay.length) + static_cast<std::size_t>(y)];
      spectrum[p * nx + q] = sum * otf(ax.f[q], ay.f[p]) * ax.weight[q] * ay.weight[p] /
                             (static_cast<double>(ax.length) * static_cast<double>(ay.length));
    }
  std::vector<C> half(static_cast<std::size_t>(out.height) * nx);
  for (std::int64_t j = 0; j < out.height; ++j)
    for (std::size_t q = 0; q < nx; ++q) {
      C sum = 0.0;
      for (std::size_t p = 0; p < ny; ++p)
        sum += spectrum[p * nx + q] * ay.synthesis[static_cast<std::size_t>(j) * ny + p];
      half[static_cast<std::size_t>(j) * nx + q] = sum;
    }
  std::vector<double> image;
  for (std::int64_t j = 0; j < out.height; ++j)
    for (std::int64_t i = 0; i < out.width; ++i) {
      C sum = 0.0;
      for (std::size_t q = 0; q < nx; ++q)
        sum += half[static_cast<std::size_t>(j) * nx + q] * ax.synthesis[static_cast<std::size_t>(i) * nx + q];
      image.push_back(sum.real());
    }
  return image;
}

inline std::vector<double> reference_image(const mtf::Image& scene, const mtf::SampleGrid& in,
                                           const mtf::SampleGrid& out, const Otf& otf, mtf::Border border,
                                           double border_value = 0.0) {
  const auto sample = [&](std::int64_t x, std::int64_t y) { return static_cast<double>(scene.at(x, y)); };
  return reference_image(sample, in, out, otf, border, border_value);
}

}  // namespace apps::check
