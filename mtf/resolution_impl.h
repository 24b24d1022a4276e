// SPDX-License-Identifier: Apache-2.0
#pragma once

// Body of ResolutionMeter<S>. Included where a scalar type is instantiated: resolution.cpp,
// apps/study/resolution_jet.cpp.

#include <limits>

#include "mtf/edge_sums.h"
#include "mtf/error.h"
#include "mtf/otf_parts.h"
#include "mtf/otf_series.h"
#include "mtf/pupil_light.h"
#include "mtf/resolution_parts.h"

namespace mtf {

template <class S>
struct ResolutionMeter<S>::Impl {
  ResolutionNeeds needs;
  OtfParts<S> parts{};
  std::vector<Freq<S>> f{};
  Products<S> products{}, replicas{};
  EdgeSums<S> edge{};
  std::vector<detail::AxisPanel<S>> panels{};
  int evaluations = 0;

  bool needs_edge() const { return needs.axis.edge || needs.axis.overshoot || needs.axis.fwhm; }
  bool needs_moduli() const { return needs.axis.area || needs.axis.aliasing || needs.axis.spurious; }
  S pitch_mm(Axis axis) const { return parts.system().frame.pitch_um(axis) * S(1e-3); }
  static Freq<S> along(Axis axis, const S& f_cy_mm) {
    return axis == Axis::x ? Freq<S>{f_cy_mm, S(0)} : Freq<S>{S(0), f_cy_mm};
  }
  double fill_panels(Axis axis, double cutoff);
  void points(Axis axis, double cutoff, AxisFigures<S>& figures);
  S mtf50(Axis axis) const;
  void edge_figures(Axis axis, AxisFigures<S>& figures);
  void moduli(Axis axis, AxisFigures<S>& figures);
  double measure_axis(Axis axis, double cutoff, AxisFigures<S>& figures, OtfCurve<S>& curve);
  double choose_wavelengths(double cutoff);
  Resolution<S> measure(const System<S>& system);
};

/// The series of an axis. Returns the error of what is computed from them.
template <class S>
double ResolutionMeter<S>::Impl::fill_panels(Axis axis, double cutoff) {
  using namespace detail;
  const bool presample = needs.axis.aliasing || needs.axis.spurious;
  double largest = 0.0;
  const auto evaluate = [&](const std::vector<double>& at, SeriesValues<S, 2>& values) {
    f.clear();
    for (const double f_cy_mm : at) f.push_back(along(axis, S(f_cy_mm)));
    parts.all(f, products);
    evaluations += static_cast<int>(at.size());
    largest = 0.0;
    values[kSystem].reserve(at.size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      values[kSystem].push_back(products.presample[i] * products.after[i]);
      largest = std::max(largest, value_of(modulus(products.presample[i])));
    }
    if (presample) values[kPresample] = products.presample;
  };
  const double nyquist = value_of(parts.system().frame.nyquist_cy_mm(axis));
  // A figure is an integral of H with a kernel of at most 2 over the width in cycles per pixel.
  const double pitch = value_of(pitch_mm(axis));
  const double amplified = std::max(1.0, 2.0 * pitch * (cutoff < kInfinity ? cutoff : 2.0 * nyquist));
  const double share = (parts.chromatic() ? 0.7 : 1.0) * needs.tolerance / amplified;  // the band has the rest
  constexpr std::size_t kMostPanels = 256;
  std::vector<SeriesPanel<S, 2>> series;
  double beyond = 0.0;
  if (cutoff < kInfinity) {
    std::vector<double> breaks{0.0, cutoff};
    for (const double kink : parts.kinks_cy_mm()) breaks.push_back(kink);
    std::sort(breaks.begin(), breaks.end());
    for (std::size_t i = 1; i < breaks.size(); ++i)
      if (breaks[i] - breaks[i - 1] > 1e-9 * cutoff)
        append_series<S, 2>(series, {breaks[i - 1], breaks[i]}, share, kMostPanels, evaluate);
  } else {
    // Nothing ends the OTF: go on until what is left is too little to count, at most to 2^16 times Nyquist.
    double lo = 0.0, hi = 2.0 * nyquist;
    for (int i = 0; i < 16; ++i, lo = hi, hi *= 2.0) {
      append_series<S, 2>(series, {lo, hi}, share, kMostPanels, evaluate);
      const double end[] = {hi};
      SeriesValues<S, 2> last;
      evaluate({end, end + 1}, last);
      beyond = largest;
      if (beyond <= 1e-2 * share) break;
    }
  }
  const double reach_px = needs.axis.overshoot ? 3.0 : needs_edge() ? 1.0 : 0.0;
  double error = 0.0;
  panels.clear();
  for (SeriesPanel<S, 2>& one : series) {
    const double width = pitch * (one.map.hi - one.map.lo);
    error = std::max(error, one.error);
    const FineNodes& nodes = fine_nodes(one.degree, reach_px * width);
    ComplexValues<S> system = at_nodes(one.otf[kSystem], nodes), before;
    if (presample) before = at_nodes(one.otf[kPresample], nodes);
    panels.push_back({std::move(one), &nodes, std::move(system), std::move(before)});
  }
  return error * amplified + beyond;
}

/// The OTF at single frequencies: Nyquist, its replicas, those asked for.
template <class S>
void ResolutionMeter<S>::Impl::points(Axis axis, double cutoff, AxisFigures<S>& figures) {
  using detail::modulus;
  const Frame<S>& frame = parts.system().frame;
  const S nyquist = frame.nyquist_cy_mm(axis);
  const double end = std::min(cutoff, 64.0 * value_of(nyquist));
  f.assign(1, along(axis, nyquist));
  for (int m = 1; (2 * m + 1) * value_of(nyquist) < end; ++m) f.push_back(along(axis, S(2 * m + 1) * nyquist));
  const std::size_t folds = f.size();
  for (const SpatialFrequency<double>& at : needs.at)
    f.push_back(along(axis, SpatialFrequency<S>{S(at.value), at.unit}.cy_mm(frame, axis)));
  parts.all(f, products);
  evaluations += static_cast<int>(f.size());
  const auto system = [&](std::size_t i) { return modulus(products.presample[i] * products.after[i]); };
  figures.nyquist = system(0);
  figures.optics_nyquist = modulus(products.optics[0]);
  figures.detector_nyquist = modulus(products.detector[0]);
  figures.presample_nyquist = modulus(products.presample[0]);
  figures.folded_nyquist = S(0);
  for (std::size_t i = 0; i < folds; ++i) figures.folded_nyquist += S(2) * modulus(products.presample[i]);
  figures.mtf_at.clear();
  for (std::size_t i = folds; i < f.size(); ++i) figures.mtf_at.push_back(system(i));
}

/// First crossing of 1/2 by |H|, on the series; NaN where it stays above.
template <class S>
S ResolutionMeter<S>::Impl::mtf50(Axis axis) const {
  using namespace detail;
  constexpr double kHalf = 0.5;
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
    const double t = find_zero(lo, h_lo, hi, h_hi, 1e-7, excess);
    // One Newton step in S: for its derivatives; the slope by a difference of fourth order.
    const double d = 1e-3,
                 slope = (8.0 * (excess(t + d) - excess(t - d)) - (excess(t + 2 * d) - excess(t - 2 * d))) / (12.0 * d);
    const S step = (S(kHalf) - modulus(h.at(t))) * S(panel.series.map.slope(t) / slope);
    return (S(panel.series.map.f(t)) + step) * pitch_mm(axis);
  }
  return S(std::numeric_limits<double>::quiet_NaN());
}

template <class S>
void ResolutionMeter<S>::Impl::edge_figures(Axis axis, AxisFigures<S>& figures) {
  using namespace detail;
  const AxisNeeds& n = needs.axis;
  edge.clear(pitch_mm(axis));
  for (const AxisPanel<S>& panel : panels) {
    const PanelMap& map = panel.series.map;
    const double width = map.hi - map.lo;
    for (std::size_t i = 0; i < panel.nodes->t.size(); ++i)
      edge.add(map.lo + width * panel.nodes->share[i], width * panel.nodes->weight[i], panel.system[i]);
  }
  // For a real OTF from the edge on, else from half a pixel before it.
  const S centre = edge.centre();
  const std::size_t at_edge = edge.real() ? 0 : 2;
  const EdgeSamples<S> samples = edge.samples(edge.real() ? S(0) : centre - S(0.5), n.overshoot ? 15 : 5);
  if (n.edge) figures.rer = edge.real() ? S(2) * samples.esf[2] - S(1) : S(samples.esf[4] - samples.esf[0]);
  if (n.overshoot) {
    const std::size_t first = at_edge + 4, last = at_edge + 12;  // 1 to 3 px
    std::size_t top = first;
    bool rises = true;
    for (std::size_t i = first + 1; i <= last; ++i) {
      if (value_of(samples.esf[i]) > value_of(samples.esf[top])) top = i;
      rises = rises && value_of(samples.esf[i]) >= value_of(samples.esf[i - 1]);
    }
    figures.edge_height = samples.esf[rises ? first + 1 : top];
    const double x = value_of(centre) + edge.kStep_px * static_cast<double>(top - at_edge);
    const bool inside = top > first && top < last;
    figures.overshoot = (inside ? edge.at(edge.top(x)).esf : samples.esf[top]) - S(1);
  }
  if (n.fwhm) {
    const S peak = edge.real() ? S(0) : edge.peak(value_of(centre)), half = S(0.5) * edge.at(peak).lsf;
    double inside = 0.0;  // a real lsf falls from its middle: the samples say about where
    if (edge.real())
      for (std::size_t i = 1; i < samples.lsf.size() && value_of(samples.lsf[i]) > value_of(half); ++i)
        inside = edge.kStep_px * static_cast<double>(i);
    const S right = edge.half_width(peak, half, 1.0, inside);
    figures.fwhm_px = edge.real() ? S(2) * right : S(right + edge.half_width(peak, half, -1.0, 0.0));
  }
}

/// Integrals of |H| and |P|, from zero to zero of each.
template <class S>
void ResolutionMeter<S>::Impl::moduli(Axis axis, AxisFigures<S>& figures) {
  using namespace detail;
  const AxisNeeds& n = needs.axis;
  const bool replicated = n.aliasing || n.spurious, ends = n.spurious && ends_after_sampling(parts.system());
  const S pitch = pitch_mm(axis), rate = S(2) * parts.system().frame.nyquist_cy_mm(axis);
  const double fs = value_of(rate), nyquist = 0.5 * fs;
  S area{}, in_band{}, beyond{}, whole{}, inside{}, outside{};
  std::vector<double> cuts;
  for (const AxisPanel<S>& panel : panels) {
    const ComplexSeries<S>&h = panel.series.otf[kSystem], &p = panel.series.otf[kPresample];
    const PanelMap& map = panel.series.map;
    cuts.assign({-1.0, 1.0});
    append_zeros(h, panel.system, *panel.nodes, panel.series.error, cuts);
    if (replicated) append_zeros(p, panel.presample, *panel.nodes, panel.series.error, cuts);
    for (const double m : {1.0, 3.0, 5.0})
      if (m * nyquist > map.lo && m * nyquist < map.hi && (m == 1.0 || n.spurious)) cuts.push_back(map.t(m * nyquist));
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t c = 1; c < cuts.size(); ++c) {
      const double half = 0.5 * (cuts[c] - cuts[c - 1]), middle = 0.5 * (cuts[c] + cuts[c - 1]);
      if (half <= 0.0) continue;
      const bool base = map.f(middle) < nyquist;
      if (!base && !replicated) continue;
      const GaussRule& rule = gauss_legendre(panel.series.degree / 2 + 6);
      const std::size_t count = rule.node.size();
      std::vector<S> before(count), weight(count);
      std::vector<double> at(count), t(count);
      for (std::size_t i = 0; i < count; ++i) t[i] = middle + half * rule.node[i];
      const ComplexValues<S> systems = at_places(h, t);
      const ComplexValues<S> presamples = replicated ? at_places(p, t) : ComplexValues<S>{};
      for (std::size_t i = 0; i < count; ++i) {
        const PanelPlace place = map.at(t[i]);
        at[i] = place.f;
        weight[i] = S(rule.weight[i] * half * place.slope) * pitch;
        const S system = modulus(systems[i]);
        if (base) area += S(2) * weight[i] * system;
        if (!replicated) continue;
        before[i] = modulus(presamples[i]);
        whole += weight[i] * system;
        (base ? in_band : beyond) += weight[i] * before[i];
      }
      const auto replica = [&](auto shift, auto counts, S& sum) {
        f.clear();
        for (const double node : at) f.push_back(along(axis, S(node) + S(shift(node)) * rate));
        parts.after(f, replicas.after);
        for (std::size_t i = 0; i < count; ++i)
          if (counts(at[i] + shift(at[i]) * fs)) sum += weight[i] * before[i] * modulus(replicas.after[i]);
      };
      if (n.aliasing && !base)
        replica([fs](double node) { return -std::round(node / fs); }, [](double) { return true; }, inside);
      if (ends)
        for (const double k : {-2.0, -1.0, 1.0, 2.0})
          replica([k](double) { return k; }, [nyquist](double to) { return std::abs(to) > nyquist; }, outside);
    }
  }
  // Integrals that end at Nyquist move with it: no change of value, but of the derivatives.
  const S moved = (S(0.5) * rate - S(nyquist)) * pitch, edge_of_band = figures.presample_nyquist * moved;
  if (n.area) figures.mtfa = area + S(2) * figures.nyquist * moved;
  if (n.aliasing) {
    figures.aliasing = (beyond - edge_of_band) / (in_band + edge_of_band);
    figures.spurious_in = (inside - figures.nyquist * moved) / whole;
  }
  if (ends) figures.spurious_out = outside / whole;
}

template <class S>
double ResolutionMeter<S>::Impl::measure_axis(Axis axis, double cutoff, AxisFigures<S>& figures, OtfCurve<S>& curve) {
  using detail::kSystem;
  const S nan(std::numeric_limits<double>::quiet_NaN());
  figures.mtf50_cy_px = figures.mtfa = figures.rer = figures.overshoot = figures.edge_height = figures.fwhm_px = nan;
  figures.aliasing = figures.spurious_in = figures.spurious_out = nan;
  points(axis, cutoff, figures);
  if (!needs_edge() && !needs_moduli() && !needs.axis.mtf50 && !needs.curves) return 0.0;
  const double error = fill_panels(axis, cutoff);
  curve.clear();
  if (needs.curves)
    for (const auto& panel : panels) curve.add(panel.series.map, panel.series.otf[kSystem]);
  if (needs.axis.mtf50) figures.mtf50_cy_px = mtf50(axis);
  if (needs_edge()) edge_figures(axis, figures);
  if (needs_moduli()) moduli(axis, figures);
  return error;
}

/// As many wavelengths as the presample OTF needs; the change when their number was last doubled.
template <class S>
double ResolutionMeter<S>::Impl::choose_wavelengths(double cutoff) {
  if (!parts.chromatic()) return 0.0;
  constexpr std::size_t kProbes = 16;
  const double end = cutoff < kInfinity ? cutoff : 2.0 * value_of(parts.system().frame.nyquist_cy_mm(Axis::x));
  f.clear();
  for (std::size_t i = 0; i < kProbes; ++i)
    f.push_back(along(Axis::x, S(end * (static_cast<double>(i) + 0.5) / static_cast<double>(kProbes))));
  const auto at = [&](int n) {
    parts.set_wavelengths(n);
    parts.all(f, products);
    evaluations += static_cast<int>(f.size());
  };
  const auto change = [&](const std::vector<Complex<S>>& before) {
    double most = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i)
      most = std::max(most, std::hypot(value_of(products.presample[i].re) - value_of(before[i].re),
                                       value_of(products.presample[i].im) - value_of(before[i].im)));
    return most;
  };
  constexpr int kMost = 256;
  for (int n = 2;; n *= 2) {  // from the start for every system: a result has no memory
    at(n);
    const std::vector<Complex<S>> before = products.presample;
    at(2 * n);
    const double difference = change(before);
    if (difference <= 0.3 * needs.tolerance || 2 * n >= kMost) return difference;
  }
}

template <class S>
Resolution<S> ResolutionMeter<S>::Impl::measure(const System<S>& system) {
  parts.set(system);
  evaluations = 0;
  Resolution<S> result;
  const double cutoff = result.cutoff_cy_mm = parts.cutoff_cy_mm();
  const double wavelengths = choose_wavelengths(cutoff);
  result.wavelengths = parts.chromatic() ? parts.wavelengths() : 1;
  double error = measure_axis(Axis::x, cutoff, result.x, result.curve_x);
  if (needs.y) error = std::max(error, measure_axis(Axis::y, cutoff, result.y, result.curve_y));
  result.strehl = result.ensquared = S(std::numeric_limits<double>::quiet_NaN());
  if ((needs.strehl || needs.ensquared) && parts.pupil() != nullptr) {
    const PupilLight<S> light = pupil_light(parts, cutoff, needs.tolerance, needs.ensquared, evaluations);
    if (needs.strehl) result.strehl = light.strehl;
    if (needs.ensquared) result.ensquared = light.ensquared;
    error = std::max(error, light.error);
  }
  result.error = error + wavelengths;
  result.evaluations = evaluations;
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
