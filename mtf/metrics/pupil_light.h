// SPDX-License-Identifier: Apache-2.0
#pragma once

// Integrals of the optics' OTF over both frequencies, in polar coordinates (formulas: resolution.h):
//   strehl    = int f mean over directions of Re O df x 2 pi / ideal area
//   ensquared = int f mean over directions of [Re O sinc(fx px) sinc(fy py)] df x 2 pi px py
// Radially by the series of otf_series.h, in the directions by the midpoint rule, whose error falls faster than any
// power for a smooth periodic function; radial optics need directions for the pitch alone, without any OTF. Over a band
// the integrals of each wavelength are averaged: up to a cutoff of its own an OTF has no kinks of other wavelengths,
// and its integrals are so smooth over the band that a few wavelengths do.

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

/// What the integral of the energy makes of an error of an OTF up to the cutoff: that of the modulus of its kernel.
inline double box_amplification(double px, double py, double cutoff, bool radial) {
  if (!radial) return kPi * cutoff * cutoff * px * py;  // the sinc are in the series
  constexpr int n = 64;
  double box = 0.0;
  for (int i = 0; i < n; ++i) {
    const double f = cutoff * (i + 0.5) / n;
    box += 2.0 * kPi * f * cutoff / n * std::abs(box_mean(f * px, f * py)) * px * py;
  }
  return box;
}

// What is averaged over the directions at a radial frequency.
inline constexpr std::size_t kMean = 0, kBoxed = 1;

/// Integrals over the frequencies, at one wavelength or averaged over a band.
template <class S>
struct LightSums {
  S whole{}, boxed{}, ideal{};
  double error = 0.0;        ///< of what is about 1: whole / ideal, and boxed
  double whole_error = 0.0;  ///< of whole / ideal alone
};

/// `box_amplified`: box_amplification of a cutoff at least as large; 0 where no energy is asked for. `turns`:
/// directions over a half turn, 1 for radial optics.
template <class S>
LightSums<S> sums_at(const OtfParts<S>& parts, const typename OtfParts<S>::OpticsAt& at, double tolerance,
                     double box_amplified, int turns, int& evaluations) {
  const bool ensquared = box_amplified > 0.0;
  const Frame<S>& frame = parts.system().frame;
  const S px = frame.pitch_x_um * S(1e-3), py = frame.pitch_y_um * S(1e-3);
  const bool radial = turns == 1;
  const auto directions = static_cast<std::size_t>(turns);
  std::vector<Freq<S>> f;
  std::vector<Complex<S>> optics;
  const auto evaluate = [&](const std::vector<double>& radii, SeriesValues<S, 2>& values) {
    f.clear();
    for (const double radius : radii)
      for (int t = 0; t < turns; ++t) {
        const SinCos turn = radial ? SinCos{0.0, 1.0} : sin_cos_pi((t + 0.5) / turns);
        f.push_back({S(radius * turn.cos), S(radius * turn.sin)});
      }
    parts.optics(at, f, optics);
    evaluations += static_cast<int>(f.size());
    for (std::size_t i = 0; i < optics.size(); i += directions) {
      S whole{}, box{};
      for (std::size_t k = i; k < i + directions; ++k) {
        whole += optics[k].re;
        if (ensquared && !radial) box += optics[k].re * sinc_of(S(f[k].x * px)) * sinc_of(S(f[k].y * py));
      }
      values[kMean].push_back({whole / S(static_cast<double>(turns)), S(0)});
      if (ensquared && !radial) values[kBoxed].push_back({box / S(static_cast<double>(turns)), S(0)});
    }
  };
  const double cutoff = at.cutoff_cy_mm;
  const double whole_amplified = std::max(1.0, kPi * cutoff * cutoff / value_of(at.ideal_area));
  const double amplified = std::max(whole_amplified, box_amplified);
  std::vector<SeriesPanel<S, 2>> panels;
  append_series<S, 2>(panels, {0.0, cutoff}, tolerance / amplified, 256, at.kinks_cy_mm, evaluate);

  LightSums<S> sums{.ideal = at.ideal_area};
  double error = 0.0;
  const double widest = std::max(value_of(px), value_of(py));
  for (const SeriesPanel<S, 2>& panel : panels) {
    const double width = panel.map.hi - panel.map.lo;
    const FineNodes& nodes = fine_nodes(panel.degree, ensquared ? widest * width : 0.0);
    const std::vector<S> means = at_nodes(panel.otf[kMean].re, nodes);
    const std::vector<S> boxes = ensquared && !radial ? at_nodes(panel.otf[kBoxed].re, nodes) : std::vector<S>{};
    for (std::size_t i = 0; i < nodes.t.size(); ++i) {
      const double radius = panel.map.lo + width * nodes.share[i],
                   weight = 2.0 * kPi * radius * width * nodes.weight[i];
      sums.whole += S(weight) * means[i];
      if (!ensquared) continue;
      const S box = radial ? means[i] * box_mean(S(S(radius) * px), S(S(radius) * py)) : boxes[i];
      sums.boxed += S(weight) * box * px * py;
    }
    error = std::max(error, panel.error);
  }
  sums.error = error * amplified;
  sums.whole_error = error * whole_amplified;
  return sums;
}

/// About the error of a Gauss rule of n nodes for a function, from what the polynomial through its values at the nodes
/// of another one, about half as many, misses there. The rule is exact for polynomials of four times that degree, so
/// that what is small against the function counts in second order. A function that goes up and down between the nodes
/// is missed at some of them, whatever its mean.
inline double rule_error(std::span<const double> few, std::span<const double> at_few, std::span<const double> nodes,
                         std::span<const double> at_nodes) {
  const double lo = nodes.front(), width = nodes.back() - nodes.front();
  double missed = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    double value = 0.0;  // Lagrange's formula
    for (std::size_t k = 0; k < few.size(); ++k) {
      double basis = 1.0;
      for (std::size_t m = 0; m < few.size(); ++m)
        if (m != k) basis *= ((nodes[i] - lo) / width - (few[m] - lo) / width) / ((few[k] - few[m]) / width);
      value += basis * at_few[k];
    }
    missed = std::max(missed, std::abs(value - at_nodes[i]));
    largest = std::max(largest, std::abs(at_nodes[i]));
  }
  return missed * std::min(1.0, 2.0 * missed / std::max(largest, 1e-300));
}

/// Integrals over a band, and their values at its wavelengths.
template <class S>
struct BandSums {
  LightSums<S> mean;
  std::vector<double> whole, boxed;
};

template <class S>
PupilLight<S> light_of(OtfParts<S>& parts, double tolerance, bool ensquared, int turns, int& evaluations) {
  constexpr double kBandShare = 0.5;
  constexpr double kNoNumber = 0.05;  // an energy with a larger error is useless: pitches of hundreds of spots
  const auto light = [](const LightSums<S>& sums) {
    const bool useless = sums.error > kNoNumber;
    return PupilLight<S>{sums.whole / sums.ideal, useless ? S(std::numeric_limits<double>::quiet_NaN()) : sums.boxed,
                         useless ? sums.whole_error : sums.error};
  };
  const Frame<S>& frame = parts.system().frame;
  const bool chromatic = parts.chromatic_optics();
  const auto shortest = parts.optics_at(chromatic ? parts.system().band->lo_um : 0.0);
  const double box = !ensquared
                         ? 0.0
                         : box_amplification(1e-3 * value_of(frame.pitch_x_um), 1e-3 * value_of(frame.pitch_y_um),
                                             shortest.cutoff_cy_mm, turns == 1);
  if (!chromatic) return light(sums_at(parts, shortest, tolerance, box, turns, evaluations));
  const auto over = [&](const WavelengthNodes& nodes) {
    BandSums<S> sums;
    for (std::size_t w = 0; w < nodes.weight.size(); ++w) {
      const S weight(nodes.weight[w]);
      const LightSums<S> one = sums_at(parts, parts.optics_at(nodes.wavelength_um[w]), (1.0 - kBandShare) * tolerance,
                                       box, turns, evaluations);
      sums.mean.whole += weight * one.whole;
      sums.mean.boxed += weight * one.boxed;
      sums.mean.ideal += weight * one.ideal;
      sums.mean.error = std::max(sums.mean.error, one.error);
      sums.mean.whole_error = std::max(sums.mean.whole_error, one.whole_error);
      sums.whole.push_back(value_of(one.whole));
      sums.boxed.push_back(value_of(one.boxed));
    }
    return sums;
  };
  constexpr int kLeast = 4, kMost = 64;
  BandSums<S> before = over(parts.band_nodes(kLeast));
  for (int n = 2 * kLeast;; n *= 2) {
    const std::vector<double>&few = parts.band_nodes(n / 2).wavelength_um, &nodes = parts.band_nodes(n).wavelength_um;
    BandSums<S> sums = over(parts.band_nodes(n));
    double error = rule_error(few, before.whole, nodes, sums.whole) / value_of(sums.mean.ideal);
    if (ensquared && sums.mean.error <= kNoNumber)
      error = std::max(error, rule_error(few, before.boxed, nodes, sums.boxed));
    if (error <= kBandShare * tolerance || n == kMost) {
      PupilLight<S> result = light(sums.mean);
      result.error += error;
      return result;
    }
    before = std::move(sums);
  }
}

}  // namespace detail

/// `parts` has a pupil.
template <class S>
PupilLight<S> pupil_light(OtfParts<S>& parts, double tolerance, bool ensquared, int& evaluations) {
  if (parts.radial_optics()) return detail::light_of(parts, tolerance, ensquared, 1, evaluations);
  constexpr int kMostTurns = 512;
  PupilLight<S> light = detail::light_of(parts, tolerance, ensquared, 8, evaluations);
  for (int turns = 16;; turns *= 2) {
    PupilLight<S> finer = detail::light_of(parts, tolerance, ensquared, turns, evaluations);
    const double change = std::max(std::abs(value_of(finer.strehl) - value_of(light.strehl)),
                                   std::abs(value_of(finer.ensquared) - value_of(light.ensquared)));
    light = finer;
    light.error += change;
    if (change <= tolerance || turns >= kMostTurns) return light;
  }
}

}  // namespace mtf
