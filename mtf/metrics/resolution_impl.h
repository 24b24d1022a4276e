// SPDX-License-Identifier: Apache-2.0
#pragma once

// Body of ResolutionMeter<S>. Included where a scalar type is instantiated: resolution.cpp,
// apps/study/design/resolution_jet.cpp.

#include <limits>

#include "mtf/error.h"
#include "mtf/metrics/edge_sums.h"
#include "mtf/metrics/pupil_light.h"
#include "mtf/metrics/resolution.h"
#include "mtf/otf/otf_parts.h"
#include "mtf/otf/otf_series.h"

namespace mtf {
namespace detail {

template <class S>
S modulus(const Complex<S>& h) {
  using std::sqrt;
  if (value_of(h.im) == 0.0) return value_of(h.re) < 0.0 ? S(-h.re) : h.re;
  return sqrt(h.re * h.re + h.im * h.im);
}

inline constexpr std::size_t kSystem = 0, kPresample = 1, kUnfiltered = 2;  ///< OTFs of a panel
inline constexpr std::size_t kOtfs = 3;

/// Both along an axis, and what they are at nodes fine enough for all integrals.
template <class S>
struct AxisPanel {
  SeriesPanel<S, kOtfs> series;
  const FineNodes* nodes = nullptr;
  ComplexValues<S> system, presample, unfiltered;
};

/// A zero between neighbouring nodes lo and hi, where a series has the values h_lo and h_hi of different sign, within
/// about `near`. `values(places)`: many places at once cost little more than one. A straight line is left where what
/// the series bends between nodes no longer counts.
template <class Values>
double find_zero(double lo, double h_lo, double hi, double h_hi, double near, Values values) {
  constexpr std::size_t kPlaces = 8;
  const double bending = 1.0 / (8.0 * (hi - lo));
  while (bending * (hi - lo) * (hi - lo) > near) {
    std::array<double, kPlaces> t{};
    for (std::size_t i = 0; i < kPlaces; ++i) t[i] = lo + (hi - lo) * static_cast<double>(i + 1) / (kPlaces + 1.0);
    const std::vector<double> at = values(t);
    const auto after = std::find_if(at.begin(), at.end(), [&](double h) { return (h > 0.0) != (h_lo > 0.0); });
    const auto i = static_cast<std::size_t>(after - at.begin());
    if (i < kPlaces) hi = t[i], h_hi = at[i];
    if (i > 0) lo = t[i - 1], h_lo = at[i - 1];
  }
  return lo + (hi - lo) * h_lo / (h_lo - h_hi);
}

/// Where a series goes through 0 between the nodes and turns by half a cycle, but for what is below its own error:
/// there its modulus has a kink. Within `near`: integrals up to it err by the square.
template <class S>
void append_zeros(const ComplexSeries<S>& series, const ComplexValues<S>& values, const FineNodes& nodes, double error,
                  double near, std::vector<double>& zeros) {
  for (std::size_t i = 1; i < values.re.size(); ++i) {
    const Complex<S> a = values[i - 1], b = values[i];
    const double re = value_of(a.re), im = value_of(a.im), square = re * re + im * im;
    const double now = value_of(b.re) * re + value_of(b.im) * im;  // of b along a
    if (!(now < 0.0 &&
          std::max(square, value_of(b.re) * value_of(b.re) + value_of(b.im) * value_of(b.im)) > error * error))
      continue;
    const auto parts_along_a = [&](std::span<const double> t) {
      const ComplexValues<S> h = at_places(series, t);
      std::vector<double> parts;
      for (std::size_t k = 0; k < t.size(); ++k) parts.push_back(value_of(h[k].re) * re + value_of(h[k].im) * im);
      return parts;
    };
    zeros.push_back(find_zero(nodes.t[i - 1], square, nodes.t[i], now, near, parts_along_a));
  }
}

}  // namespace detail

template <class S>
struct ResolutionMeter<S>::Impl {
  ResolutionNeeds needs;
  OtfParts<S> parts{};
  std::vector<S> f{};  ///< scratch: frequencies along an axis, cy/mm
  Products<S> products{};
  EdgeSums<S> edge{};
  std::vector<detail::AxisPanel<S>> panels{};
  int evaluations = 0;
  double shift_px = 0.0;       ///< of the image along the axis at hand, about
  double reach_px = 0.0;       ///< how far from the origin the nodes follow the edge
  double left_out = 0.0;       ///< bound of the part of the edge that they do not follow
  double line_left_out = 0.0;  ///< the same of the line, per pixel
  double edge_left_out = 0.0;  ///< the largest of an edge that was measured; no finer series makes it smaller
  bool veiled = false;
  bool edge_lost = false;      ///< it is farther than they can
  double series_error = 0.0;   ///< of the OTF's series
  double replica_error = 0.0;  ///< of integrals over replicas
  double figure_error = 0.0;   ///< of figures from a slope, or from integrals of their own

  static constexpr double kBandShare = 0.3;  ///< of the tolerance of an OTF, for its mean over the band

  /// How near to a zero is near enough: values there err by its square, derivatives by itself.
  double near() const { return std::clamp(needs.tolerance, 1e-9, 1e-3); }

  bool needs_edge() const {
    return needs.axis.edge || needs.axis.unfiltered || needs.axis.overshoot || needs.axis.fwhm;
  }
  bool needs_moduli() const { return needs.axis.area || needs.axis.aliasing || needs.axis.spurious; }
  S pitch_mm(Axis axis) const { return parts.system().frame.pitch_um(axis) * S(1e-3); }
  double fill_panels(Axis axis, double cutoff);
  /// What figures of the edge need on both sides of it.
  double margin_px() const { return needs.axis.overshoot || needs.axis.fwhm ? 3.0 : needs_edge() ? 1.0 : 0.0; }
  bool make_nodes(Axis axis, double to_px, bool always = false);
  template <class Otf>
  S place_edge(Axis axis, Otf otf);
  void points(Axis axis, double cutoff, AxisFigures<S>& figures);
  S mtf50(Axis axis);
  void edge_figures(Axis axis, AxisFigures<S>& figures);
  template <class Shift>
  S replicas(const detail::AxisPanel<S>& panel, Axis axis, double lo, double hi, Shift shift, int depth = 0);
  void moduli(Axis axis, AxisFigures<S>& figures);
  double measure_axis(Axis axis, double cutoff, AxisFigures<S>& figures, OtfCurve<S>& curve);
  double amplification(Axis axis, double cutoff) const;
  /// The part of the tolerance that the OTF gets, before it is amplified: what slopes and small bases make of it takes
  /// a factor of about four.
  double for_otf() const {
    const bool divided = needs.axis.fwhm || needs.axis.mtf50 || needs.axis.aliasing || needs.axis.spurious;
    return (divided ? 0.25 : 1.0) * needs.tolerance;
  }
  double band_error() const { return parts.chromatic() ? parts.band_error() : 0.0; }
  void choose_wavelengths(double cutoff);
  Resolution<S> measure_once();
  Resolution<S> measure(const System<S>& system);
};

/// A figure is an integral of H with a kernel of at most 2 over the width in cycles per pixel.
template <class S>
double ResolutionMeter<S>::Impl::amplification(Axis axis, double cutoff) const {
  const double end = cutoff < kInfinity ? cutoff : 2.0 * value_of(parts.system().frame.nyquist_cy_mm(axis));
  return std::max(1.0, 2.0 * value_of(pitch_mm(axis)) * end);
}

/// The series of an axis. Returns the error of what is computed from them.
template <class S>
double ResolutionMeter<S>::Impl::fill_panels(Axis axis, double cutoff) {
  using namespace detail;
  const bool presample = needs.axis.aliasing || needs.axis.spurious;
  const bool unfiltered = needs.axis.unfiltered && parts.digital_filters(axis);
  // A veil (aerosol) or AC coupling takes contrast from all frequencies but 0 itself, a point that no integral sees.
  const double least = 1e-15 * value_of(parts.system().frame.nyquist_cy_mm(axis));
  double largest = 0.0;
  const auto evaluate = [&](const std::vector<double>& at, SeriesValues<S, kOtfs>& values) {
    f.clear();
    for (const double f_cy_mm : at) f.push_back(S(std::max(f_cy_mm, least)));
    parts.along(axis, f, products);
    evaluations += static_cast<int>(at.size());
    largest = 0.0;
    values[kSystem].reserve(at.size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      values[kSystem].push_back(products.presample[i] * products.after_sampling[i]);
      largest = std::max(largest, value_of(modulus(products.presample[i])));
    }
    if (presample) values[kPresample] = products.presample;
    if (!unfiltered) return;
    for (std::size_t i = 0; i < at.size(); ++i)
      values[kUnfiltered].push_back(products.presample[i] * products.readout[i]);
  };
  const double nyquist = value_of(parts.system().frame.nyquist_cy_mm(axis));
  const double pitch = value_of(pitch_mm(axis)), amplified = amplification(axis, cutoff);
  const double share = (parts.chromatic() ? 1.0 - kBandShare : 1.0) * for_otf() / amplified;
  constexpr std::size_t kMostPanels = 256;
  std::vector<SeriesPanel<S, kOtfs>> series;
  double beyond = 0.0;
  if (cutoff < kInfinity) {
    append_series<S, kOtfs>(series, {0.0, cutoff}, share, kMostPanels, parts.kinks_cy_mm(), evaluate);
  } else {
    // Nothing ends the OTF: continue until the rest is too small to count, at most to 2^16 times Nyquist.
    double lo = 0.0, hi = 2.0 * nyquist;
    for (int i = 0; i < 16; ++i, lo = hi, hi *= 2.0) {
      append_series<S, kOtfs>(series, {lo, hi}, share, kMostPanels, parts.kinks_cy_mm(), evaluate);
      // Over the last octave, at frequencies that are not all zeros of one footprint.
      std::vector<double> octave;
      for (int k = 0; k < 29; ++k) octave.push_back(hi * (0.5 + 0.5 * (k + 0.61) / 29.3));
      SeriesValues<S, kOtfs> last;
      evaluate(octave, last);
      beyond = largest;
      if (beyond <= 1e-2 * share) break;
    }
  }
  // Places are about the image, which a phase may have moved: by the group delay at low frequency.
  const double low = 1e-3 / pitch;
  f.assign(1, S(low));
  parts.along(axis, f, products);
  const Complex<S> h_low = products.presample[0] * products.after_sampling[0];
  shift_px = -std::atan2(value_of(h_low.im), value_of(h_low.re)) / (2.0 * kPi * 1e-3);
  panels.clear();
  series_error = 0.0;
  for (SeriesPanel<S, kOtfs>& one : series) {
    series_error = std::max(series_error, one.error);
    panels.emplace_back().series = std::move(one);
  }
  if (!make_nodes(axis, margin_px() + std::abs(shift_px))) make_nodes(axis, margin_px(), true);
  series_error += band_error();
  return series_error * amplified + beyond;
}

/// Nodes of every panel that follow places up to `to_px` from the origin. Panels of high frequencies that would need
/// more than there are may be left to the error, by the bound of their part of the edge; where that is no small number,
/// false, and all as it was.
template <class S>
bool ResolutionMeter<S>::Impl::make_nodes(Axis axis, double to_px, bool always) {
  using namespace detail;
  const auto cycles = [&](const AxisPanel<S>& panel) {
    return to_px * value_of(pitch_mm(axis)) * (panel.series.map.hi - panel.series.map.lo);
  };
  // The edge is 1/2 + 1/pi integral of Im(H exp(2 pi i u x)) / u: both what is left out and what stands in its place,
  // at both ends of a difference.
  double bound = 0.0, line_bound = 0.0;
  for (const AxisPanel<S>& panel : panels) {
    const SeriesPanel<S, kOtfs>& series = panel.series;
    if (nodes_suffice(series.degree, cycles(panel))) continue;
    double largest = 0.0;
    const ComplexValues<S> values = at_nodes(series.otf[kSystem], fine_nodes(series.degree, 0.0));
    for (std::size_t i = 0; i < values.re.size(); ++i)
      largest = std::max(largest, std::hypot(value_of(values.re[i]), values.im.empty() ? 0.0 : value_of(values.im[i])));
    bound += 4.0 / kPi * largest * std::log(series.map.hi / series.map.lo);
    line_bound += 4.0 * largest * value_of(pitch_mm(axis)) * (series.map.hi - series.map.lo);
  }
  constexpr double kMostLeft = 1e-2;
  if (!always && (!(bound <= kMostLeft) || to_px > 2.0 * edge.kFurthest_px)) return false;
  for (AxisPanel<S>& panel : panels) {
    const SeriesPanel<S, kOtfs>& series = panel.series;
    const FineNodes& nodes = fine_nodes(series.degree, cycles(panel));
    panel.nodes = &nodes;
    panel.system = at_nodes(series.otf[kSystem], nodes);
    if (needs.axis.aliasing || needs.axis.spurious) panel.presample = at_nodes(series.otf[kPresample], nodes);
    if (needs.axis.unfiltered && parts.digital_filters(axis))
      panel.unfiltered = at_nodes(series.otf[kUnfiltered], nodes);
  }
  reach_px = to_px;
  left_out = bound;
  line_left_out = line_bound;
  return true;
}

/// The OTF at single frequencies: Nyquist, its replicas, those asked for.
template <class S>
void ResolutionMeter<S>::Impl::points(Axis axis, double cutoff, AxisFigures<S>& figures) {
  using detail::modulus;
  const Frame<S>& frame = parts.system().frame;
  const S nyquist = frame.nyquist_cy_mm(axis);
  const double end = std::min(cutoff, 64.0 * value_of(nyquist));
  f.assign(1, nyquist);
  for (int m = 1; (2 * m + 1) * value_of(nyquist) < end; ++m) f.push_back(S(2 * m + 1) * nyquist);
  const std::size_t folds = f.size();
  for (const SpatialFrequency<double>& at : needs.at)
    f.push_back(SpatialFrequency<S>{S(at.value), at.unit}.cy_mm(frame, axis));
  parts.along(axis, f, products);
  evaluations += static_cast<int>(f.size());
  const auto system = [&](std::size_t i) { return modulus(products.presample[i] * products.after_sampling[i]); };
  figures.nyquist = system(0);
  figures.optics_nyquist = modulus(products.optics[0]);
  figures.detector_nyquist = modulus(products.detector[0]);
  figures.presample_nyquist = modulus(products.presample[0]);
  figures.folded_nyquist = S(0);
  for (std::size_t i = 0; i < folds; ++i) figures.folded_nyquist += S(2) * modulus(products.presample[i]);
  figures.mtf_at.clear();
  for (std::size_t i = folds; i < f.size(); ++i) figures.mtf_at.push_back(system(i));
}

/// First crossing of 1/2 by |H|, on the series; NaN where it stays above, or begins below.
template <class S>
S ResolutionMeter<S>::Impl::mtf50(Axis axis) {
  using namespace detail;
  constexpr double kHalf = 0.5;
  if (!(value_of(modulus(panels.front().series.otf[kSystem].at(-1.0))) > kHalf)) {
    veiled = true;
    return S(std::numeric_limits<double>::quiet_NaN());
  }
  for (const AxisPanel<S>& panel : panels) {
    const ComplexSeries<S>& h = panel.series.otf[kSystem];
    const auto excess = [&](double t) { return value_of(modulus(h.at(t))) - kHalf; };
    const FineNodes& nodes = *panel.nodes;
    double lo = -1.0, h_lo = kHalf, hi = 1.0, h_hi = kHalf;
    for (std::size_t i = 0; i <= nodes.t.size() && h_hi > 0.0; ++i) {
      if (i > 0) lo = hi, h_lo = h_hi;
      hi = i < nodes.t.size() ? nodes.t[i] : 1.0;
      h_hi = i < nodes.t.size() ? value_of(modulus(panel.system[i])) - kHalf : excess(1.0);
    }
    if (h_hi > 0.0) continue;
    // In a panel that begins at f = 0 the value there is above kHalf, which stands for it; the step below mends that.
    const double t = find_zero(lo, h_lo, hi, h_hi, near(), [&](std::span<const double> at) {
      const ComplexValues<S> values = at_places(h, at);
      std::vector<double> excesses;
      for (std::size_t i = 0; i < at.size(); ++i) excesses.push_back(value_of(modulus(values[i])) - kHalf);
      return excesses;
    });
    // One Newton step in S: for its derivatives; the slope by a difference of fourth order.
    constexpr double d = 1e-3;
    const std::array<double, 4> about{t - 2 * d, t - d, t + d, t + 2 * d};
    const ComplexValues<S> values = at_places(h, about);
    const auto modulus_at = [&](std::size_t i) { return value_of(modulus(values[i])); };
    const double slope = (8.0 * (modulus_at(2) - modulus_at(1)) - (modulus_at(3) - modulus_at(0))) / (12.0 * d);
    const S at_half = S(panel.series.map.f(t)) * pitch_mm(axis);
    const double by_px = std::abs(slope / panel.series.map.slope(t)) / value_of(pitch_mm(axis));
    figure_error = std::max(figure_error, series_error / (by_px * value_of(at_half)) + near() * near());
    const S step = (S(kHalf) - modulus(h.at(t))) * S(panel.series.map.slope(t) / slope);
    return at_half + step * pitch_mm(axis);
  }
  return S(std::numeric_limits<double>::quiet_NaN());
}

template <class S>
double ResolutionMeter<S>::Impl::measure_axis(Axis axis, double cutoff, AxisFigures<S>& figures, OtfCurve<S>& curve) {
  using detail::kSystem;
  const S nan(std::numeric_limits<double>::quiet_NaN());
  figures.mtf50_cy_px = figures.mtfa = figures.rer = figures.rer_unfiltered = figures.overshoot = figures.edge_height =
      figures.fwhm_px = nan;
  figures.aliasing = figures.spurious_in = figures.spurious_out = nan;
  points(axis, cutoff, figures);
  if (!needs_edge() && !needs_moduli() && !needs.axis.mtf50 && !needs.curves) return band_error();
  const double error = fill_panels(axis, cutoff);
  curve.clear();
  if (needs.curves)
    for (const auto& panel : panels) curve.add(panel.series.map, panel.series.otf[kSystem]);
  if (needs.axis.mtf50) figures.mtf50_cy_px = mtf50(axis);
  if (needs_edge()) edge_figures(axis, figures);
  if (needs_moduli()) moduli(axis, figures);
  return error;
}

/// A few wavelengths serve all frequencies where they keep the tolerance. Elsewhere the band is split at the kinks of
/// each frequency, which takes more time at a loose tolerance and far less at a tight one. The error of n wavelengths
/// is estimated by the change when n is doubled, at frequencies over the whole range and at those where n would do
/// worst; the error of 2 n is at most half of that change.
template <class S>
void ResolutionMeter<S>::Impl::choose_wavelengths(double cutoff) {
  if (!parts.chromatic()) return;
  constexpr std::size_t kProbes = 16;
  const double end = cutoff < kInfinity ? cutoff : 2.0 * value_of(parts.system().frame.nyquist_cy_mm(Axis::x));
  const double amplified = std::max(amplification(Axis::x, cutoff), needs.y ? amplification(Axis::y, cutoff) : 1.0);
  const double tolerance = kBandShare * for_otf() / amplified;
  f.clear();
  for (std::size_t i = 0; i < kProbes; ++i)
    f.push_back(S(end * (static_cast<double>(i) + 0.5) / static_cast<double>(kProbes)));
  for (const double worst : parts.worst_cy_mm()) f.push_back(S(worst));
  const auto at = [&](int n, double error) {
    parts.use_wavelengths(n, error);
    parts.along(Axis::x, f, products);
    evaluations += static_cast<int>(f.size());
  };
  const auto change = [&](const std::vector<Complex<S>>& before) {
    double most = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i)
      most = std::max(most, std::hypot(value_of(products.presample[i].re) - value_of(before[i].re),
                                       value_of(products.presample[i].im) - value_of(before[i].im)));
    return most;
  };
  constexpr int kMost = 64;
  at(2, kInfinity);  // for every system anew: results do not depend on earlier systems
  for (int n = 4; n <= kMost; n *= 2) {
    const std::vector<Complex<S>> before = products.presample;
    at(n, kInfinity);
    const double error = 0.5 * change(before);
    if (error <= tolerance) return parts.use_wavelengths(n, error);
  }
  // What differs from one frequency to the next as the tolerance allows stays below what the series have to resolve.
  parts.use_tolerance(tolerance / 3.0);
}

template <class S>
Resolution<S> ResolutionMeter<S>::Impl::measure_once() {
  Resolution<S> result;
  const double cutoff = result.cutoff_cy_mm = parts.cutoff_cy_mm();
  figure_error = 0.0;
  edge_lost = veiled = false;
  edge_left_out = 0.0;
  choose_wavelengths(cutoff);
  double error = measure_axis(Axis::x, cutoff, result.x, result.curve_x);
  if (needs.y) error = std::max(error, measure_axis(Axis::y, cutoff, result.y, result.curve_y));
  result.strehl = result.ensquared = S(std::numeric_limits<double>::quiet_NaN());
  if ((needs.strehl || needs.ensquared) && parts.pupil() != nullptr) {
    const PupilLight<S> light = pupil_light(parts, needs.tolerance, needs.ensquared, evaluations);
    if (needs.strehl) result.strehl = light.strehl;
    if (needs.ensquared) result.ensquared = light.ensquared;
    error = std::max(error, light.error);
  }
  result.wavelengths = parts.chromatic() ? parts.wavelengths() : 1;
  result.error = std::max(error, figure_error);
  result.edge_lost = edge_lost;
  result.veiled = veiled;
  result.evaluations = evaluations;
  return result;
}

/// Figures that a slope or a small base makes more uncertain than the OTF itself need a better OTF.
template <class S>
Resolution<S> ResolutionMeter<S>::Impl::measure(const System<S>& system) {
  parts.set(system);
  evaluations = 0;
  const double wanted = needs.tolerance;
  Resolution<S> result = measure_once();
  constexpr double kTightest = 1e-13;
  for (int again = 0; again < 2 && result.error > wanted && needs.tolerance > kTightest; ++again) {
    needs.tolerance = std::max(kTightest, 0.5 * needs.tolerance * std::max(wanted / result.error, 1e-4));
    result = measure_once();
  }
  needs.tolerance = wanted;
  result.error = std::max(result.error, edge_left_out);
  return result;
}

template <class S>
ResolutionMeter<S>::ResolutionMeter(ResolutionNeeds needs) : impl_(new Impl{.needs = std::move(needs)}) {
  const double tolerance = impl_->needs.tolerance;
  if (!(tolerance >= 1e-12 && tolerance <= 0.1))
    throw UsageError("tolerance " + format_double(tolerance) + ": figures of merit take 1e-12 to 0.1");
}
template <class S>
ResolutionMeter<S>::~ResolutionMeter() = default;
template <class S>
ResolutionMeter<S>::ResolutionMeter(ResolutionMeter&&) noexcept = default;
template <class S>
Resolution<S> ResolutionMeter<S>::measure(const System<S>& system) {
  return impl_->measure(system);
}

}  // namespace mtf

#include "mtf/metrics/resolution_figures.h"
