// SPDX-License-Identifier: Apache-2.0
#pragma once

// Figures of an axis from its series: edge and line spread, integrals of moduli. Part of resolution_impl.h.

#include "mtf/metrics/resolution_impl.h"

namespace mtf {

/// Fills the sums of the edge. Where it is; NaN where that is farther from the origin than nodes resolve. The phase at
/// low frequency only says about where: for a long tail another place, for hundreds of pixels one a turn away.
template <class S>
template <class Otf>
S ResolutionMeter<S>::Impl::place_edge(Axis axis, Otf otf) {
  for (;;) {
    edge.clear(pitch_mm(axis), near());
    for (const detail::AxisPanel<S>& panel : panels) edge.add(panel.series.map, *panel.nodes, panel.*otf);
    const S centre = edge.centre(shift_px);
    const double needed = std::abs(value_of(centre)) + margin_px();
    if (edge.real()) return centre;
    if (needed <= reach_px) {
      edge_left_out = std::max(edge_left_out, left_out);
      return centre;
    }
    // What lies beyond is not to be relied on, not even the place itself.
    if (!make_nodes(axis, std::min(needed + 1.0, 2.0 * reach_px))) {
      edge_lost = true;
      return S(std::numeric_limits<double>::quiet_NaN());
    }
  }
}

template <class S>
void ResolutionMeter<S>::Impl::edge_figures(Axis axis, AxisFigures<S>& figures) {
  using namespace detail;
  const AxisNeeds& n = needs.axis;
  const bool unfiltered = n.unfiltered && parts.digital_filters(axis);
  if (unfiltered) {
    const S centre = place_edge(axis, &AxisPanel<S>::unfiltered);
    if (std::isnan(value_of(centre))) return;
    figures.rer_unfiltered = edge.at(centre + S(0.5)).esf - edge.at(centre - S(0.5)).esf;
  }
  // For a real OTF from the edge on, else from half a pixel before it.
  const S centre = place_edge(axis, &AxisPanel<S>::system);
  if (std::isnan(value_of(centre))) return;
  const std::size_t at_edge = edge.real() ? 0 : 2;
  const EdgeSamples<S> samples = edge.samples(edge.real() ? S(0) : centre - S(0.5), n.overshoot ? 15 : 5);
  const bool edges = n.edge || (n.unfiltered && !unfiltered);
  if (edges) figures.rer = edge.real() ? S(2) * samples.esf[2] - S(1) : S(samples.esf[4] - samples.esf[0]);
  if (n.unfiltered && !unfiltered) figures.rer_unfiltered = figures.rer;
  if (n.overshoot) {
    const std::size_t first = at_edge + 4, last = at_edge + 12;  // 1 to 3 px
    std::size_t top = first;
    bool rises = true;
    for (std::size_t i = first + 1; i <= last; ++i) {
      if (value_of(samples.esf[i]) > value_of(samples.esf[top])) top = i;
      rises = rises && value_of(samples.esf[i]) >= value_of(samples.esf[i - 1]) - 1e-12;  // constant but for rounding
    }
    figures.edge_height = samples.esf[rises ? first + 1 : top];
    const double x = value_of(centre) + edge.kStep_px * static_cast<double>(top - at_edge);
    const bool inside = top > first && top < last;
    figures.overshoot = (inside ? edge.at(edge.top(x)).esf : samples.esf[top]) - S(1);
  }
  if (n.fwhm) {
    if (std::abs(value_of(centre)) > edge.kFurthest_px) {  // the peak may be farther than it is searched
      edge_lost = true;
      return;
    }
    const auto [peak, around] = edge.real() ? typename EdgeSums<S>::Peak{S(0), samples} : edge.peak(value_of(centre));
    const S half = S(0.5) * edge.at(peak).lsf, right = edge.half_width(peak, half, 1.0, around);
    const S left = edge.real() ? right : edge.half_width(peak, half, -1.0, around);
    const double furthest = std::abs(value_of(peak)) + std::max(value_of(left), value_of(right));
    if (!edge.real() && !(furthest <= reach_px)) {
      const double further = 2.0 * reach_px;
      if (make_nodes(axis, furthest + 1.0 < further ? furthest + 1.0 : further)) return edge_figures(axis, figures);
      edge_lost = true;
      figures.fwhm_px = S(std::numeric_limits<double>::quiet_NaN());
      return;
    }
    figures.fwhm_px = right + left;
    const double slope = std::abs(value_of(edge.at(peak + right).slope)), width = value_of(figures.fwhm_px);
    const double error = 2.0 * (series_error + (edge.real() ? 0.0 : line_left_out)) / (slope * width) + near() * near();
    constexpr double kNoNumber = 0.05;  // a width with a larger error is useless: nothing ends the OTF
    if (edge.real() || error <= kNoNumber) {
      figure_error = std::max(figure_error, error);
    } else {
      edge_lost = true;
      figures.fwhm_px = S(std::numeric_limits<double>::quiet_NaN());
    }
  }
}

/// Integral of |P| |Q| over a part of a panel, Q where sampling puts the frequencies: `shift` of them, in sampling
/// frequencies. What follows sampling has zeros and ripples of its own: parts are halved until 2 n nodes agree with n.
template <class S>
template <class Shift>
S ResolutionMeter<S>::Impl::replicas(const detail::AxisPanel<S>& panel, Axis axis, double lo, double hi, Shift shift,
                                     int depth) {
  using namespace detail;
  const S rate = S(2) * parts.system().frame.nyquist_cy_mm(axis), pitch = pitch_mm(axis);
  const double half = 0.5 * (hi - lo), middle = 0.5 * (hi + lo);
  constexpr int kNodes = 8;
  const std::array<const GaussRule*, 2> rules{&gauss_legendre(2 * kNodes), &gauss_legendre(kNodes)};
  std::vector<double> t;
  for (const GaussRule* rule : rules)
    for (const double node : rule->node) t.push_back(middle + half * node);
  const PanelPlaces places = panel.series.map.at(t);
  const ComplexValues<S> before = at_places(panel.series.otf[kPresample], t);
  f.clear();
  for (const double place : places.f) f.push_back(S(place) + S(shift(place)) * rate);
  parts.after(axis, f, products.after_sampling);
  std::array<S, 2> integral{};
  std::size_t i = 0;
  for (std::size_t r = 0; r < rules.size(); ++r)
    for (const double weight : rules[r]->weight) {
      integral[r] +=
          S(weight * half * places.slope[i]) * pitch * modulus(before[i]) * modulus(products.after_sampling[i]);
      ++i;
    }
  const double change = std::abs(value_of(integral[0]) - value_of(integral[1]));
  constexpr int kDeepest = 12;
  if (change <= 0.25 * needs.tolerance || depth >= kDeepest) {
    replica_error += change;
    return integral[0];
  }
  return replicas(panel, axis, lo, middle, shift, depth + 1) + replicas(panel, axis, middle, hi, shift, depth + 1);
}

/// Integrals of |H| and |P|, from zero to zero of each.
template <class S>
void ResolutionMeter<S>::Impl::moduli(Axis axis, AxisFigures<S>& figures) {
  using namespace detail;
  const AxisNeeds& n = needs.axis;
  const bool replicated = n.aliasing || n.spurious, ends = n.spurious && is_reconstructed(parts.system());
  const bool filters = parts.filters(axis);
  const S pitch = pitch_mm(axis), rate = S(2) * parts.system().frame.nyquist_cy_mm(axis);
  const double fs = value_of(rate), nyquist = 0.5 * fs;
  S area{}, in_band{}, beyond{}, whole{}, inside{}, outside{};
  std::vector<double> cuts;
  replica_error = 0.0;
  for (const AxisPanel<S>& panel : panels) {
    const ComplexSeries<S>&h = panel.series.otf[kSystem], &p = panel.series.otf[kPresample];
    const PanelMap& map = panel.series.map;
    cuts.assign({-1.0, 1.0});
    append_zeros(h, panel.system, *panel.nodes, panel.series.error, near(), cuts);
    if (replicated) append_zeros(p, panel.presample, *panel.nodes, panel.series.error, near(), cuts);
    for (const double m : {1.0, 3.0, 5.0})
      if (m * nyquist > map.lo && m * nyquist < map.hi && (m == 1.0 || n.spurious)) cuts.push_back(map.t(m * nyquist));
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t c = 1; c < cuts.size(); ++c) {
      const double half = 0.5 * (cuts[c] - cuts[c - 1]), middle = 0.5 * (cuts[c] + cuts[c - 1]);
      if (half <= 1e-12) continue;
      const bool base = map.f(middle) < nyquist;
      if (!base && !replicated) continue;
      const GaussRule& rule = gauss_legendre(panel.series.degree / 2 + 6);
      const std::size_t count = rule.node.size();
      std::vector<double> t(count);
      for (std::size_t i = 0; i < count; ++i) t[i] = middle + half * rule.node[i];
      const PanelPlaces places = map.at(t);
      const ComplexValues<S> systems = at_places(h, t);
      const ComplexValues<S> presamples = replicated ? at_places(p, t) : ComplexValues<S>{};
      for (std::size_t i = 0; i < count; ++i) {
        const S weight = S(rule.weight[i] * half * places.slope[i]) * pitch, system = modulus(systems[i]);
        if (base) area += S(2) * weight * system;
        if (!replicated) continue;
        whole += weight * system;
        (base ? in_band : beyond) += weight * modulus(presamples[i]);
      }
      if (n.aliasing && !base && filters)
        inside += replicas(panel, axis, cuts[c - 1], cuts[c], [fs](double g) { return -std::round(g / fs); });
      if (ends)
        for (const double k : {-2.0, -1.0, 1.0, 2.0}) {
          const double to = map.f(middle) + k * fs;
          if (std::abs(to) > nyquist) outside += replicas(panel, axis, cuts[c - 1], cuts[c], [k](double) { return k; });
        }
    }
  }
  if (!filters) inside = beyond;
  // Integrals that end at Nyquist move with it: no change of value, but of the derivatives.
  const S moved = (S(0.5) * rate - S(nyquist)) * pitch, edge_of_band = figures.presample_nyquist * moved;
  if (replicated) {
    const double base = std::max(std::min(value_of(in_band), value_of(whole)), 1e-300);
    const double width = value_of(pitch) * panels.back().series.map.hi;
    figure_error = std::max(figure_error, 2.0 * (replica_error + (ends ? 4.0 : 1.0) * series_error * width) / base);
  }
  if (n.area) figures.mtfa = area + S(2) * figures.nyquist * moved;
  if (n.aliasing) {
    figures.aliasing = (beyond - edge_of_band) / (in_band + edge_of_band);
    figures.spurious_in = (inside - figures.nyquist * moved) / whole;
  }
  if (ends) {
    // Where a replica overlaps the base band its part begins or ends: k = -1 at 1 and 3 times Nyquist, k = -2 at 3
    // and 5. Those at 3 cancel.
    f.assign({S(S(0.5) * rate), S(S(2.5) * rate)});
    parts.along(axis, f, products);
    const S ends_move = modulus(products.presample[0]) - S(5) * modulus(products.presample[1]);
    figures.spurious_out = (outside + modulus(products.after_sampling[0]) * ends_move * moved) / whole;
  }
}

}  // namespace mtf
