// SPDX-License-Identifier: Apache-2.0
#include "mtf/band.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
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
  return std::min(kMostGaussNodes, static_cast<int>(std::ceil(turns)) + (width > 0.02 ? 20 : width > 1e-3 ? 12 : 5));
}

// Integrals of a weight times Lagrange's polynomials through the nodes of a Gauss rule, in barycentric form.
class LagrangeWeights {
 public:
  explicit LagrangeWeights(const GaussRule& rule) : node_(&rule.node), weight(rule.node.size(), 0.0) {
    for (std::size_t i = 0; i < rule.node.size(); ++i)
      barycentric_.push_back((i % 2 == 0 ? 1.0 : -1.0) *
                             std::sqrt((1.0 - rule.node[i] * rule.node[i]) * rule.weight[i]));
    term_.resize(rule.node.size());
  }
  void add(double x, double amount) {
    const std::vector<double>& node = *node_;
    double sum = 0.0;
    for (std::size_t i = 0; i < node.size(); ++i) {
      const double away = x - node[i];
      if (away == 0.0) {
        weight[i] += amount;
        return;
      }
      sum += term_[i] = barycentric_[i] / away;
    }
    for (std::size_t i = 0; i < node.size(); ++i) weight[i] += amount * term_[i] / sum;
  }

 private:
  const std::vector<double>* node_;
  std::vector<double> barycentric_, term_;

 public:
  std::vector<double> weight;
};

// The rate from begin to end, panel by panel. `x_of(lambda)`, `lambda_of(x)` and `slope(x)` = d lambda / dx.
template <class Map>
void add_panels(const ElectronRate& rate, const Map& map, double begin_um, double end_um, int n, LagrangeWeights& sum) {
  const std::vector<double>& breaks = rate.breaks_um();
  begin_um = std::max(begin_um, breaks.front());
  auto next = std::upper_bound(breaks.begin(), breaks.end(), begin_um);
  for (; next != breaks.end() && begin_um < end_um; ++next) {
    const double to_um = std::min(*next, end_um), begin_x = map.x_of(begin_um), end_x = map.x_of(to_um);
    const GaussRule& panel = gauss_legendre(panel_nodes(begin_x, end_x, begin_um, to_um, n));
    const double middle = 0.5 * (begin_x + end_x), half = 0.5 * (end_x - begin_x);
    for (std::size_t i = 0; i < panel.node.size(); ++i) {
      const double x = middle + half * panel.node[i];
      sum.add(x, half * panel.weight[i] * map.slope_um(x) * rate.density(map.wavelength_um(x)));
    }
    begin_um = to_um;
  }
}

/// lambda = middle + half x.
struct Straight {
  double begin_um, end_um;
  double wavelength_um(double x) const { return begin_um + 0.5 * (end_um - begin_um) * (1.0 + x); }
  double slope_um(double) const { return 0.5 * (end_um - begin_um); }
  double x_of(double wavelength_um) const {
    return std::clamp(2.0 * (wavelength_um - begin_um) / (end_um - begin_um) - 1.0, -1.0, 1.0);
  }
};

// Blocks that lie well within the part by their own rules: half-integer powers at its ends are smooth there. The others
// panel by panel.
std::vector<double> rate_weights(const ElectronRate& rate, const Part& part, const GaussRule& rule) {
  const int n = static_cast<int>(rule.node.size());
  LagrangeWeights sum(rule);
  double done_um = part.begin_um;
  for (const ElectronRate::Block& block : rate.blocks()) {
    const double width = block.end_um - block.begin_um;
    if (block.begin_um < part.begin_um + width || block.end_um > part.end_um - width) continue;
    const double turns = n * (std::acos(part.x_of(block.begin_um)) - std::acos(part.x_of(block.end_um))) / pi;
    if (turns > 4.0) continue;  // polynomials of high degree turn too fast for its rule
    add_panels(rate, part, done_um, block.begin_um, n, sum);
    for (std::size_t i = 0; i < block.rule.weight.size(); ++i)
      sum.add(part.x_of(block.rule.wavelength_um[i]), block.rule.weight[i]);
    done_um = block.end_um;
  }
  add_panels(rate, part, done_um, part.end_um, n, sum);
  return sum.weight;
}

}  // namespace

ElectronRate::ElectronRate(std::function<WavelengthNodes(int n)> nodes,
                           std::function<double(double wavelength_um)> density, std::vector<double> breaks_um)
    : nodes_(std::move(nodes)), density_(std::move(density)), breaks_um_(std::move(breaks_um)) {
  constexpr int kNodes = 20;  // the next half-integer power is a block's width away: 5.8^-20
  constexpr std::size_t kBlocks = 48, kWorthIt = 4 * kBlocks;
  if (breaks_um_.size() < kWorthIt) return;
  const GaussRule& rule = gauss_legendre(kNodes);
  const double lo = breaks_um_.front(), step = (breaks_um_.back() - lo) / static_cast<double>(kBlocks);
  for (std::size_t i = 0; i < kBlocks; ++i) {
    const Straight map{lo + step * static_cast<double>(i),
                       i + 1 < kBlocks ? lo + step * static_cast<double>(i + 1) : breaks_um_.back()};
    LagrangeWeights sum(rule);
    add_panels(*this, map, map.begin_um, map.end_um, kNodes, sum);
    Block block{map.begin_um, map.end_um, {}};
    for (const double x : rule.node) block.rule.wavelength_um.push_back(map.wavelength_um(x));
    block.rule.weight = std::move(sum.weight);
    blocks_.push_back(std::move(block));
  }
}

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
  const double sum = std::accumulate(own.weight.begin(), own.weight.end(), 0.0);
  for (double& weight : own.weight) weight /= sum;
  return own;
}

}  // namespace mtf
