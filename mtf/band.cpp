// SPDX-License-Identifier: Apache-2.0
#include "mtf/band.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mtf/quadrature.h"

namespace mtf {
namespace {

using std::numbers::pi;

// A part in its angle: lambda = begin + (end - begin) (1 - cos a) / 2, a = pi (1 + x) / 2, x in [-1, 1].
struct Part {
  double begin_um, end_um;

  double wavelength_um(double x) const {
    const double sine = std::sin(0.25 * pi * (1.0 + x));
    return std::clamp(begin_um + (end_um - begin_um) * sine * sine, begin_um, end_um);
  }
  /// d lambda / dx.
  double slope_um(double x) const { return 0.25 * pi * (end_um - begin_um) * std::sin(0.5 * pi * (1.0 + x)); }
  double x_of(double wavelength_um) const {
    const double share = std::clamp((wavelength_um - begin_um) / (end_um - begin_um), 0.0, 1.0);
    return (4.0 / pi) * std::asin(std::sqrt(share)) - 1.0;
  }
};

// A panel of the electron rate takes as many nodes as the polynomials through the n nodes turn in it, and what the rate
// itself needs.
int panel_nodes(double begin_x, double end_x, double begin_um, double end_um, int n) {
  const double turns = static_cast<double>(n) * (std::acos(begin_x) - std::acos(end_x)) / pi;
  const double width = (end_um - begin_um) / begin_um;
  return std::min(kMostGaussNodes, static_cast<int>(std::ceil(turns)) + (width > 0.02 ? 20 : width > 1e-3 ? 12 : 8));
}

// Weights of the interpolating rule: the integral of the rate times Lagrange's polynomials in x, in barycentric form.
std::vector<double> rate_weights(const ElectronRate& rate, const Part& part, const GaussRule& rule) {
  const std::size_t n = rule.node.size();
  std::vector<double> barycentric(n), weight(n, 0.0), term(n);
  for (std::size_t i = 0; i < n; ++i)
    barycentric[i] = (i % 2 == 0 ? 1.0 : -1.0) * std::sqrt((1.0 - rule.node[i] * rule.node[i]) * rule.weight[i]);
  const auto add = [&](double x, double amount) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double away = x - rule.node[i];
      if (away == 0.0) {
        weight[i] += amount;
        return;
      }
      sum += term[i] = barycentric[i] / away;
    }
    for (std::size_t i = 0; i < n; ++i) weight[i] += amount * term[i] / sum;
  };
  const auto first = std::upper_bound(rate.breaks_um.begin(), rate.breaks_um.end(), part.begin_um);
  double begin_um = std::max(part.begin_um, rate.breaks_um.front());
  for (auto next = first; next != rate.breaks_um.end() && begin_um < part.end_um; ++next) {
    const double end_um = std::min(*next, part.end_um), begin_x = part.x_of(begin_um), end_x = part.x_of(end_um);
    const GaussRule& panel =
        gauss_legendre(panel_nodes(begin_x, end_x, begin_um, end_um, static_cast<int>(rule.node.size())));
    const double middle = 0.5 * (begin_x + end_x), half = 0.5 * (end_x - begin_x);
    for (std::size_t i = 0; i < panel.node.size(); ++i) {
      const double x = middle + half * panel.node[i];
      add(x, half * panel.weight[i] * part.slope_um(x) * rate.density(part.wavelength_um(x)));
    }
    begin_um = end_um;
  }
  return weight;
}

}  // namespace

WavelengthNodes wavelength_nodes(const Band& band, int n) {
  if (band.rate) return band.rate->nodes(n);
  GaussRule rule = mean_rule(band.lo_um, band.hi_um, n);
  return {std::move(rule.node), std::move(rule.weight)};
}

std::vector<double> parts_of(const Band& band, std::span<const double> kinks_um) {
  std::vector<double> ends{band.lo_um, band.hi_um};
  for (const double kink : kinks_um)
    if (kink > band.lo_um && kink < band.hi_um) ends.push_back(kink);
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return ends;
}

WavelengthNodes part_nodes(const Band& band, double begin_um, double end_um, int n) {
  const GaussRule& rule = gauss_legendre(n);
  const Part part{begin_um, end_um};
  WavelengthNodes nodes;
  for (const double x : rule.node) nodes.wavelength_um.push_back(part.wavelength_um(x));
  if (band.rate) {
    nodes.weight = rate_weights(*band.rate, part, rule);
    return nodes;
  }
  for (std::size_t i = 0; i < rule.node.size(); ++i)
    nodes.weight.push_back(rule.weight[i] * part.slope_um(rule.node[i]) / (band.hi_um - band.lo_um));
  return nodes;
}

BandRule::BandRule(const Band& band, std::vector<double> kinks, int n)
    : band_(band), kinks_(std::move(kinks)), n_(n), whole_(wavelength_nodes(band, n)) {}

const WavelengthNodes& BandRule::at(double r_cy_mm, WavelengthNodes& own) const {
  const auto splits = [&](double kink) { return kink > r_cy_mm * band_.lo_um && kink < r_cy_mm * band_.hi_um; };
  if (std::none_of(kinks_.begin(), kinks_.end(), splits)) return whole_;
  std::vector<double> wavelengths;
  for (const double kink : kinks_) wavelengths.push_back(kink / r_cy_mm);
  const std::vector<double> ends = parts_of(band_, wavelengths);
  own.wavelength_um.clear();
  own.weight.clear();
  for (std::size_t part = 0; part + 1 < ends.size(); ++part) {
    const WavelengthNodes nodes = part_nodes(band_, ends[part], ends[part + 1], n_);
    own.wavelength_um.insert(own.wavelength_um.end(), nodes.wavelength_um.begin(), nodes.wavelength_um.end());
    own.weight.insert(own.weight.end(), nodes.weight.begin(), nodes.weight.end());
  }
  return own;
}

}  // namespace mtf
