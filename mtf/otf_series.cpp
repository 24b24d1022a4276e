// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf_series.h"

#include <map>
#include <memory>
#include <mutex>

#include "mtf/engines/clones.h"

namespace mtf {
namespace {

double share_at(double t) { return PanelMap{0.0, 1.0}.f(t); }

/// c_k = 2/n sum of v_j cos(pi j k / n), half of it where j is 0 or n, and where k is.
ChebyshevPoints make_points(int degree) {
  ChebyshevPoints points;
  const auto half_at_ends = [degree](int i) { return i == 0 || i == degree ? 0.5 : 1.0; };
  for (int j = 0; j <= degree; ++j) {
    points.share.push_back(share_at(cos_pi(static_cast<double>(j) / degree)));
    for (int k = 0; k <= degree; ++k)
      points.transform.push_back(2.0 / degree * half_at_ends(j) * half_at_ends(k) *
                                 cos_pi(static_cast<double>(j * k % (2 * degree)) / degree));
  }
  return points;
}

FineNodes make_nodes(int degree, int count) {
  const GaussRule& rule = gauss_legendre(count);
  FineNodes nodes;
  for (std::size_t i = rule.node.size(); i-- > 0;) {
    const double t = rule.node[i];
    nodes.t.push_back(t);
    nodes.share.push_back(share_at(t));
    nodes.weight.push_back(rule.weight[i] * PanelMap{0.0, 1.0}.slope(t));
  }
  const std::size_t n = nodes.t.size();
  nodes.basis.assign(n, 1.0);
  nodes.basis.insert(nodes.basis.end(), nodes.t.begin(), nodes.t.end());
  for (int k = 2; k <= degree; ++k)
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t end = nodes.basis.size();
      nodes.basis.push_back(2.0 * nodes.t[i] * nodes.basis[end - n] - nodes.basis[end - 2 * n]);
    }
  return nodes;
}

}  // namespace

const ChebyshevPoints& chebyshev_points(int degree) {
  static const std::array<ChebyshevPoints, 3> points{make_points(16), make_points(32), make_points(64)};
  return points[degree == 16 ? 0 : degree == 32 ? 1 : 2];
}

const FineNodes& fine_nodes(int degree, double cycles) {
  const double k = 0.5 * kPi * kPi * cycles;  // largest change of phase per unit of t; nodes: see quadrature.h
  const double wanted = 0.5 * degree + 0.5 * k + 2.0 * std::cbrt(k) + 8.0;
  const int count = static_cast<int>(std::min<double>(kMostGaussNodes, 8.0 * std::ceil(wanted / 8.0)));
  // One table for each degree and number of nodes; threads keep what they found, so that the lock is taken once.
  static std::mutex lock;
  static std::map<std::pair<int, int>, std::unique_ptr<const FineNodes>> tables;
  thread_local std::map<std::pair<int, int>, const FineNodes*> known;
  const FineNodes*& found = known[{degree, count}];
  if (found != nullptr) return *found;
  const std::lock_guard guard(lock);
  auto& table = tables[{degree, count}];
  if (!table) table = std::make_unique<const FineNodes>(make_nodes(degree, count));
  found = table.get();
  return *found;
}

MTFKIT_CLONES
void add_products(const double* matrix, std::span<const double> factor, std::span<double> result) {
  double* sum = result.data();
  const std::size_t count = result.size();
  for (const double f : factor) {
    for (std::size_t i = 0; i < count; ++i) sum[i] += matrix[i] * f;
    matrix += count;
  }
}

MTFKIT_CLONES
void chebyshev_sums(std::span<const double> coefficient, std::span<const double> t, std::span<double> value) {
  constexpr std::size_t kLanes = 8;
  for (std::size_t first = 0; first < t.size(); first += kLanes) {
    const std::size_t count = std::min(kLanes, t.size() - first);
    double x[kLanes] = {}, b1[kLanes] = {}, b2[kLanes] = {};
    for (std::size_t i = 0; i < count; ++i) x[i] = t[first + i];
    for (std::size_t k = coefficient.size(); k-- > 1;)
      for (std::size_t i = 0; i < kLanes; ++i) {
        const double b = 2.0 * x[i] * b1[i] - b2[i] + coefficient[k];
        b2[i] = b1[i];
        b1[i] = b;
      }
    for (std::size_t i = 0; i < count; ++i) value[first + i] = x[i] * b1[i] - b2[i] + coefficient[0];
  }
}

}  // namespace mtf
