// SPDX-License-Identifier: Apache-2.0
#pragma once

// Integrals of the optics' OTF over both frequencies, in polar coordinates (formulas: resolution.h):
//   strehl    = int f mean over directions of Re O df x 2 pi / ideal area
//   ensquared = int f mean over directions of [Re O sinc(fx px) sinc(fy py)] df x 2 pi px py
// Radially by the series of otf_series.h, in the directions by the midpoint rule, whose error falls faster than any
// power for a smooth periodic function; radial optics need directions for the pitch alone, without any OTF.

#include <limits>

#include "mtf/otf/otf_parts.h"
#include "mtf/otf/otf_series.h"

namespace mtf {

template <class S>
struct PupilLight {
  S strehl{}, ensquared{};
  double error = 0.0;  ///< both are about 1: absolute
};

/// box_mean of a square pitch and its slope, from a table within 1e-13; f_px below kBoxMeanEnd.
inline constexpr double kBoxMeanEnd = 8.0;
ValueSlope square_box_mean(double f_px);

namespace detail {

/// Mean over the directions of sinc sinc: the pitch's share at a radial frequency.
template <class S>
S box_mean(const S& fx_px, const S& fy_px) {
  if (value_of(fx_px) == value_of(fy_px) && value_of(fx_px) < kBoxMeanEnd)
    return lift(square_box_mean(value_of(fx_px)), S(S(0.5) * (fx_px + fy_px)));
  const int n = 8 + 4 * static_cast<int>(std::ceil(std::max(value_of(fx_px), value_of(fy_px))));
  S sum{};
  for (int i = 0; i < n; ++i) {
    const auto [s, c] = sin_cos_pi((i + 0.5) / (2.0 * n));
    sum += sinc_of(S(fx_px * S(c))) * sinc_of(S(fy_px * S(s)));
  }
  return sum / S(static_cast<double>(n));
}

/// What the integrals make of an error of the OTF: those of the moduli of their kernels.
inline double amplification(double area, double px, double py, double cutoff, bool ensquared, bool radial) {
  double box = ensquared && !radial ? kPi * cutoff * cutoff * px * py : 0.0;  // the sinc are in the series
  if (ensquared && radial) {
    constexpr int n = 64;
    for (int i = 0; i < n; ++i) {
      const double f = cutoff * (i + 0.5) / n;
      box += 2.0 * kPi * f * cutoff / n * std::abs(box_mean(f * px, f * py)) * px * py;
    }
  }
  return std::max({1.0, kPi * cutoff * cutoff / area, box});
}

// What is averaged over the directions at a radial frequency.
inline constexpr std::size_t kMean = 0, kBoxed = 1;

/// `turns`: directions over a half turn, 1 for radial optics.
template <class S>
PupilLight<S> light_of(OtfParts<S>& parts, double cutoff_cy_mm, double tolerance, bool ensquared, int turns,
                       int& evaluations) {
  const Frame<S>& frame = parts.system().frame;
  const S px = frame.pitch_x_um * S(1e-3), py = frame.pitch_y_um * S(1e-3);
  const bool radial = turns == 1;
  std::vector<Freq<S>> f;
  std::vector<Complex<S>> optics;
  std::vector<S> radii;
  Products<S> products;
  const auto evaluate_radial = [&](const std::vector<double>& at, SeriesValues<S, 2>& values) {
    radii.clear();
    for (const double radius : at) radii.push_back(S(radius));
    parts.along(Axis::x, radii, products, true);
    evaluations += static_cast<int>(at.size());
    for (const Complex<S>& h : products.optics) values[kMean].push_back({h.re, S(0)});
  };
  const auto evaluate = [&](const std::vector<double>& at, SeriesValues<S, 2>& values) {
    if (radial) return evaluate_radial(at, values);
    f.clear();
    for (const double radius : at)
      for (int t = 0; t < turns; ++t) {
        const auto [s, c] = sin_cos_pi((t + 0.5) / turns);
        f.push_back({S(radius * c), S(radius * s)});
      }
    parts.optics(f, optics);
    evaluations += static_cast<int>(f.size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      S whole{}, box{};
      for (int t = 0; t < turns; ++t) {
        const std::size_t k = i * static_cast<std::size_t>(turns) + static_cast<std::size_t>(t);
        whole += optics[k].re;
        if (ensquared) box += optics[k].re * sinc_of(S(f[k].x * px)) * sinc_of(S(f[k].y * py));
      }
      values[kMean].push_back({whole / S(static_cast<double>(turns)), S(0)});
      if (ensquared) values[kBoxed].push_back({box / S(static_cast<double>(turns)), S(0)});
    }
  };
  std::vector<SeriesPanel<S, 2>> panels;
  const S area = parts.ideal_area();
  const double amplified = amplification(value_of(area), value_of(px), value_of(py), cutoff_cy_mm, ensquared, radial);
  if (parts.chromatic() && !(parts.band_error() * amplified <= 0.3 * tolerance))
    parts.use_tolerance(0.1 * tolerance / amplified);
  append_series<S, 2>(panels, {0.0, cutoff_cy_mm}, tolerance / amplified, 256, parts.kinks_cy_mm(), evaluate);

  S strehl{}, boxed{};
  double error = 0.0;
  const double widest = std::max(value_of(px), value_of(py));
  for (const SeriesPanel<S, 2>& panel : panels) {
    const double width = panel.map.hi - panel.map.lo;
    const FineNodes& nodes = fine_nodes(panel.degree, ensquared ? widest * width : 0.0);
    const std::vector<S> means = at_nodes(panel.otf[kMean].re, nodes);
    const std::vector<S> boxes = ensquared && !radial ? at_nodes(panel.otf[kBoxed].re, nodes) : std::vector<S>{};
    for (std::size_t i = 0; i < nodes.t.size(); ++i) {
      const double at = panel.map.lo + width * nodes.share[i], weight = 2.0 * kPi * at * width * nodes.weight[i];
      strehl += S(weight) * means[i] / area;
      if (!ensquared) continue;
      const S box = radial ? means[i] * box_mean(S(S(at) * px), S(S(at) * py)) : boxes[i];
      boxed += S(weight) * box * px * py;
    }
    error = std::max(error, panel.error);
  }
  constexpr double kNoNumber = 0.05;  // an energy with a larger error is useless: pitches of hundreds of spots
  if (error * amplified > kNoNumber) boxed = S(std::numeric_limits<double>::quiet_NaN());
  error += parts.chromatic() ? parts.band_error() : 0.0;
  const double known =
      error * (error * amplified > kNoNumber ? amplification(value_of(area), 0.0, 0.0, cutoff_cy_mm, false, radial)
                                             : amplified);
  return {strehl, boxed, known};
}

}  // namespace detail

/// `parts` has a pupil, which ends at the cutoff.
template <class S>
PupilLight<S> pupil_light(OtfParts<S>& parts, double cutoff_cy_mm, double tolerance, bool ensquared, int& evaluations) {
  if (parts.radial_optics()) return detail::light_of(parts, cutoff_cy_mm, tolerance, ensquared, 1, evaluations);
  constexpr int kMostTurns = 512;
  PupilLight<S> light = detail::light_of(parts, cutoff_cy_mm, tolerance, ensquared, 8, evaluations);
  for (int turns = 16;; turns *= 2) {
    PupilLight<S> finer = detail::light_of(parts, cutoff_cy_mm, tolerance, ensquared, turns, evaluations);
    const double change = std::max(std::abs(value_of(finer.strehl) - value_of(light.strehl)),
                                   std::abs(value_of(finer.ensquared) - value_of(light.ensquared)));
    light = finer;
    light.error += change;
    if (change <= tolerance || turns >= kMostTurns) return light;
  }
}

}  // namespace mtf
