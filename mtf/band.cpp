// SPDX-License-Identifier: Apache-2.0
#include "mtf/band.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "mtf/math/quadrature.h"

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

// Blocks are a binary tree in the order of a heap: the first is all of the band, those of i are 2 i + 1 and 2 i + 2.
constexpr std::size_t kLeaves = 256;
constexpr int kBlockNodes = 20;

// A block that lies a width of its own within the part by its rule, which half-integer powers at the part's ends do not
// disturb there: what is left of them is 5.8^-20. Of others the halves, and at last the panels.
void add_block(const ElectronRate& rate, std::size_t index, const Part& part, int n, LagrangeWeights& sum) {
  const ElectronRate::Block& block = rate.blocks()[index];
  const double width = block.end_um - block.begin_um;
  if (block.end_um <= part.begin_um || block.begin_um >= part.end_um) return;
  if (block.begin_um >= part.begin_um + width && block.end_um <= part.end_um - width) {
    const double turns = n * (std::acos(part.x_of(block.begin_um)) - std::acos(part.x_of(block.end_um))) / pi;
    if (turns < 4.0) {  // faster polynomials are too much for the rule
      for (std::size_t i = 0; i < block.rule.weight.size(); ++i)
        sum.add(part.x_of(block.rule.wavelength_um[i]), block.rule.weight[i]);
      return;
    }
  }
  const std::size_t first = 2 * index + 1;
  if (first < rate.blocks().size()) {
    add_block(rate, first, part, n, sum);
    add_block(rate, first + 1, part, n, sum);
    return;
  }
  add_panels(rate, part, std::max(part.begin_um, block.begin_um), std::min(part.end_um, block.end_um), n, sum);
}

std::vector<double> rate_weights(const ElectronRate& rate, const Part& part, const GaussRule& rule) {
  const int n = static_cast<int>(rule.node.size());
  LagrangeWeights sum(rule);
  if (rate.blocks().empty())
    add_panels(rate, part, part.begin_um, part.end_um, n, sum);
  else
    add_block(rate, 0, part, n, sum);
  return sum.weight;
}

}  // namespace

ElectronRate::ElectronRate(std::function<WavelengthNodes(int n)> nodes,
                           std::function<double(double wavelength_um)> density, std::vector<double> breaks_um)
    : nodes_(std::move(nodes)), density_(std::move(density)), breaks_um_(std::move(breaks_um)) {
  if (breaks_um_.size() < kLeaves) return;  // panels are as quick
  const GaussRule& rule = gauss_legendre(kBlockNodes);
  const double lo = breaks_um_.front(), width = breaks_um_.back() - lo;
  blocks_.resize(2 * kLeaves - 1);
  for (std::size_t i = blocks_.size(); i-- > 0;) {
    std::size_t of = 1;  // blocks at this depth
    while (i + 1 >= 2 * of) of *= 2;
    const auto end_at = [&](std::size_t k) {
      return k == of ? breaks_um_.back() : lo + width * static_cast<double>(k) / static_cast<double>(of);
    };
    const Straight map{end_at(i + 1 - of), end_at(i + 2 - of)};
    LagrangeWeights sum(rule);
    if (of == kLeaves)
      add_panels(*this, map, map.begin_um, map.end_um, kBlockNodes, sum);
    else  // exact: the halves have rules for polynomials of the same degree
      for (const std::size_t half : {2 * i + 1, 2 * i + 2})
        for (std::size_t k = 0; k < rule.node.size(); ++k)
          sum.add(map.x_of(blocks_[half].rule.wavelength_um[k]), blocks_[half].rule.weight[k]);
    Block& block = blocks_[i];
    block = {map.begin_um, map.end_um, {}};
    for (const double x : rule.node) block.rule.wavelength_um.push_back(map.wavelength_um(x));
    block.rule.weight = std::move(sum.weight);
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
