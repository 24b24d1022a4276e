// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf/otf_series.h"

#include <map>
#include <memory>
#include <mutex>

#include "mtf/math/simd.h"
#include "mtf/math/special.h"

namespace mtf {
namespace {

double share_at(double t) { return PanelMap{0.0, 1.0}.f(t); }

ChebyshevPoints make_points(int degree) {
  ChebyshevPoints points{{}, chebyshev_transform(degree)};
  for (int j = 0; j <= degree; ++j) points.share.push_back(share_at(cos_pi(static_cast<double>(j) / degree)));
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

/// `block(first)` for blocks of kVectors vectors, which need not wait for one another; vector v of a block starts at
/// first[v]. The last ones end at `count`: they do some again, to the same bits.
constexpr std::size_t kVectors = 4;
template <std::size_t size, class Block>
MTFKIT_INLINE void in_blocks(std::size_t count, Block block) {
  for (std::size_t begin = 0; begin < count; begin += kVectors * size) {
    std::size_t first[kVectors];
    for (std::size_t v = 0; v < kVectors; ++v) first[v] = std::min(begin + v * size, count - size);
    block(first);
  }
}

struct Products {
  template <int Bytes>
  static MTFKIT_INLINE void run(const double* matrix, std::span<const double> factor, std::span<double> result) {
    using V = simd::Vector<double, Bytes>;
    constexpr std::size_t size = Bytes / sizeof(double);
    if (size > 1 && result.size() < size) return run<sizeof(double)>(matrix, factor, result);
    in_blocks<size>(result.size(), [&](const std::size_t(&first)[kVectors]) {
      V sum[kVectors] = {};
      const double* row = matrix;
      for (const double f : factor) {
        for (std::size_t v = 0; v < kVectors; ++v) sum[v] += simd::load<V>(row + first[v]) * f;
        row += result.size();
      }
      for (std::size_t v = 0; v < kVectors; ++v) simd::store(sum[v], result.data() + first[v]);
    });
  }
};

struct Clenshaw {
  template <int Bytes>
  static MTFKIT_INLINE void run(std::span<const double> coefficient, std::span<const double> t, double* value) {
    using V = simd::Vector<double, Bytes>;
    constexpr std::size_t size = Bytes / sizeof(double);
    if (size > 1 && t.size() < size) return run<sizeof(double)>(coefficient, t, value);
    in_blocks<size>(t.size(), [&](const std::size_t(&first)[kVectors]) {
      V x[kVectors], b1[kVectors] = {}, b2[kVectors] = {};
      for (std::size_t v = 0; v < kVectors; ++v) x[v] = simd::load<V>(t.data() + first[v]);
      for (std::size_t k = coefficient.size(); k-- > 1;)
        for (std::size_t v = 0; v < kVectors; ++v) {
          const V b = 2.0 * x[v] * b1[v] + (coefficient[k] - b2[v]);
          b2[v] = b1[v];
          b1[v] = b;
        }
      for (std::size_t v = 0; v < kVectors; ++v)
        simd::store(V(x[v] * b1[v] + (coefficient[0] - b2[v])), value + first[v]);
    });
  }
};

/// In whole groups of lanes.
double nodes_wanted(int degree, double cycles) {
  const double k = 0.5 * kPi * kPi * cycles;  // largest change of phase per unit of t; nodes: see quadrature.h
  return 8.0 * std::ceil((0.5 * degree + 0.5 * k + 2.0 * std::cbrt(k) + 8.0) / 8.0);
}

}  // namespace

PanelPlaces PanelMap::at(std::span<const double> t) const {
  PanelPlaces places{std::vector<double>(t.size()), std::vector<double>(t.size())};
  std::vector<double> turns(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) turns[i] = 0.125 * (1.0 + t[i]);
  sin_cos_turns(turns, places.f, places.slope);
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double s = places.f[i], c = places.slope[i];
    places.f[i] = lo + (hi - lo) * s * s;
    places.slope[i] = 0.5 * kPi * (hi - lo) * s * c;
  }
  return places;
}

/// c_k = 2/n sum of v_j cos(pi j k / n), half of it where j is 0 or n, and where k is.
std::vector<double> chebyshev_transform(int degree) {
  std::vector<double> transform;
  const auto half_at_ends = [degree](int i) { return i == 0 || i == degree ? 0.5 : 1.0; };
  for (int j = 0; j <= degree; ++j)
    for (int k = 0; k <= degree; ++k)
      transform.push_back(2.0 / degree * half_at_ends(j) * half_at_ends(k) *
                          cos_pi(static_cast<double>(j * k % (2 * degree)) / degree));
  return transform;
}

const ChebyshevPoints& chebyshev_points(int degree) {
  static const std::array points{make_points(kLeastDegree), make_points(2 * kLeastDegree), make_points(kMostDegree)};
  return points[degree == kLeastDegree ? 0 : degree == kMostDegree ? 2 : 1];
}

bool nodes_suffice(int degree, double cycles) { return nodes_wanted(degree, cycles) <= kMostGaussNodes; }

const FineNodes& fine_nodes(int degree, double cycles) {
  const int count = static_cast<int>(std::min<double>(kMostGaussNodes, nodes_wanted(degree, cycles)));
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

void add_products(const double* matrix, std::span<const double> factor, std::span<double> result) {
  simd::run<Products>(matrix, factor, result);
}

void chebyshev_sums(std::span<const double> coefficient, std::span<const double> t, std::span<double> value) {
  simd::run<Clenshaw>(coefficient, t, value.data());
}

}  // namespace mtf
