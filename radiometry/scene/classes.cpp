// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/classes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <unordered_map>

#include "mtf/error.h"
#include "mtf/math/word_hash.h"
#include "mtf/parallel.h"

namespace radiometry::scene {
namespace {

/// The terms of the absorbed flux of each side: the direct one at each direction of the sun, then diffuse and
/// long-wave.
class FluxTerms {
 public:
  FluxTerms(std::size_t sides, std::size_t directions) : terms_(sides * (directions + 2), 0.0F) {
    // Every stride-th direction first: the first block that `bound` compares is then spread over the whole day.
    const std::size_t stride = std::max<std::size_t>(1, directions / kBlock);
    for (std::size_t from = 0; from < stride; ++from)
      for (std::size_t d = from; d < directions; d += stride) order_.push_back(d);
  }

  void set(std::size_t side, std::span<const double> direct, double diffuse, double longwave) {
    float* term = terms_.data() + side * width();
    for (std::size_t k = 0; k < order_.size(); ++k) term[k] = static_cast<float>(direct[order_[k]]);
    term[order_.size()] = static_cast<float>(diffuse);
    term[order_.size() + 1] = static_cast<float>(longwave);
  }

  /// The bound of classes.h, or any number of at least `enough` where it is not below that.
  double bound(std::size_t a, std::size_t b, double enough) const {
    const float *p = terms_.data() + a * width(), *q = terms_.data() + b * width();
    const std::size_t n = order_.size();
    const double rest = std::abs(p[n] - q[n]) + std::abs(p[n + 1] - q[n + 1]);
    float worst = 0.0F;
    for (std::size_t begin = 0; begin < n && rest + worst < enough; begin += kBlock)
      for (std::size_t k = begin; k < std::min(n, begin + kBlock); ++k) worst = std::max(worst, std::abs(p[k] - q[k]));
    return rest + worst;
  }

  /// Three numbers of a side that differ by no more than the bound: means of the direct terms over both halves of the
  /// directions, and the other terms.
  std::array<double, 3> summary(std::size_t side) const {
    const float* term = terms_.data() + side * width();
    const std::size_t n = order_.size(), half = n / 2;
    std::array<double, 3> sums{0.0, 0.0, double{term[n]} + term[n + 1]};
    for (std::size_t k = 0; k < n; ++k)
      sums[order_[k] < half ? 0 : 1] += term[k] / static_cast<double>(order_[k] < half ? half : n - half);
    return sums;
  }

 private:
  static constexpr std::size_t kBlock = 16;
  std::size_t width() const { return order_.size() + 2; }
  std::vector<std::size_t> order_;  // of the directions
  std::vector<float> terms_;
};

void check_sizes(std::size_t sides, std::span<const SideFinish> finish, const Views& views, const SunVisibility& sun,
                 std::span<const Vector> to_sun, const FluxAmplitudes& amplitudes) {
  const auto refuse = [](const std::string& what, std::size_t is, std::size_t should) {
    throw mtf::UsageError("classes_of: the number of " + what + " is " + std::to_string(is) + ", it should be " +
                          std::to_string(should) + ".");
  };
  const auto rings = static_cast<std::size_t>(views.rings);
  if (finish.size() != sides) refuse("finishes", finish.size(), sides);
  if (views.size() != sides) refuse("views", views.size(), sides);
  if (sun.directions > 0 && sun.sides() != sides) refuse("sides of the table of the sun", sun.sides(), sides);
  if (to_sun.size() != sun.directions) refuse("directions to the sun", to_sun.size(), sun.directions);
  if (amplitudes.direct.size() != sun.directions) refuse("direct amplitudes", amplitudes.direct.size(), sun.directions);
  if (amplitudes.sky_solar.size() != rings) refuse("rings of solar amplitudes", amplitudes.sky_solar.size(), rings);
  if (amplitudes.sky_longwave.size() != rings)
    refuse("rings of long-wave amplitudes", amplitudes.sky_longwave.size(), rings);
}

FluxTerms flux_terms(const Facets& facets, std::span<const Side> sides, std::span<const SideFinish> finish,
                     const Views& views, const SunVisibility& sun, std::span<const Vector> to_sun,
                     const FluxAmplitudes& amplitudes, int threads) {
  std::vector<Vector> unit;
  for (const Vector& v : to_sun) unit.push_back((1.0 / length(v)) * v);
  const auto rings = static_cast<std::size_t>(views.rings);
  FluxTerms terms(sides.size(), unit.size());
  const auto work = [&](std::int64_t begin, std::int64_t end) {
    std::vector<double> direct(unit.size());
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const Vector normal = (sides[i].back ? -1.0 : 1.0) * facets.facet[sides[i].facet].normal;
      for (std::size_t d = 0; d < unit.size(); ++d)
        direct[d] =
            finish[i].solar_absorptance * amplitudes.direct[d] * std::max(0.0, dot(normal, unit[d])) * sun.share(i, d);
      double solar = views.ground[i] * amplitudes.ground_solar + views.surfaces[i] * amplitudes.surfaces_solar;
      double longwave = views.ground[i] * amplitudes.ground_longwave + views.surfaces[i] * amplitudes.surfaces_longwave;
      for (std::size_t r = 0; r < rings; ++r) {
        solar += views.sky[i * rings + r] * amplitudes.sky_solar[r];
        longwave += views.sky[i * rings + r] * amplitudes.sky_longwave[r];
      }
      terms.set(i, direct, finish[i].solar_absorptance * solar, finish[i].emissivity * longwave);
    }
  };
  mtf::parallel_for(static_cast<std::int64_t>(sides.size()), 1024, threads, work);
  return terms;
}

bool same_finish(const SideFinish& a, const SideFinish& b) {
  return a.key == b.key && a.solar_absorptance == b.solar_absorptance && a.emissivity == b.emissivity;
}

/// Leaders in cubes of the summary, one tolerance wide: those within the tolerance of a side are in its own cube or one
/// of the 26 around it.
class LeaderGrid {
 public:
  explicit LeaderGrid(double width) : width_(width) {}

  void add(const std::array<double, 3>& summary, std::uint32_t key, std::uint32_t leader) {
    cubes_[name(cube(summary), key)].push_back(leader);
  }

  template <class Work>
  void for_each_near(const std::array<double, 3>& summary, std::uint32_t key, const Work& work) const {
    const std::array<std::int64_t, 3> middle = cube(summary);
    for (std::int64_t k = 0; k < 27; ++k) {
      const auto found =
          cubes_.find(name({middle[0] + k % 3 - 1, middle[1] + k / 3 % 3 - 1, middle[2] + k / 9 - 1}, key));
      if (found == cubes_.end()) continue;
      for (const std::uint32_t leader : found->second) work(leader);
    }
  }

 private:
  std::array<std::int64_t, 3> cube(const std::array<double, 3>& summary) const {
    std::array<std::int64_t, 3> at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = static_cast<std::int64_t>(std::floor(summary[k] / width_));
    return at;
  }
  /// Cubes whose hashes are equal share a list: that costs time, no more.
  static std::uint64_t name(const std::array<std::int64_t, 3>& at, std::uint32_t key) {
    std::uint64_t hash = mtf::mixed(mtf::kWordHashStart, key);
    for (const std::int64_t k : at) hash = mtf::mixed(hash, static_cast<std::uint64_t>(k));
    return hash ^ hash >> 32;
  }

  double width_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cubes_;
};

}  // namespace

Classes classes_of(const Facets& facets, std::span<const Side> sides, std::span<const SideFinish> finish,
                   const Views& views, const SunVisibility& sun, std::span<const Vector> to_sun,
                   const FluxAmplitudes& amplitudes, double tolerance_w_m2, int threads) {
  check_sizes(sides.size(), finish, views, sun, to_sun, amplitudes);
  if (!(tolerance_w_m2 >= 0.0) || !std::isfinite(tolerance_w_m2))
    throw mtf::UsageError("classes_of: the tolerance is " + std::to_string(tolerance_w_m2) +
                          " W/m2, it must be 0 or more.");
  Classes classes{.class_of = std::vector<std::uint32_t>(sides.size()), .leader = {}};
  if (tolerance_w_m2 == 0.0) {
    for (std::uint32_t i = 0; i < sides.size(); ++i) {
      classes.class_of[i] = i;
      classes.leader.push_back(i);
    }
    return classes;
  }

  const FluxTerms terms = flux_terms(facets, sides, finish, views, sun, to_sun, amplitudes, threads);
  // Wider than the tolerance by the rounding of the terms, which are single, in the summary.
  LeaderGrid grid(tolerance_w_m2 * (1.0 + 1e-3) + 1e-3);
  for (std::uint32_t i = 0; i < sides.size(); ++i) {
    const std::array<double, 3> summary = terms.summary(i);
    double best = tolerance_w_m2;
    std::uint32_t joined = kNone;
    grid.for_each_near(summary, finish[i].key, [&](std::uint32_t candidate) {
      const std::uint32_t leader = classes.leader[candidate];
      if (!same_finish(finish[i], finish[leader])) return;
      const double bound = terms.bound(i, leader, best);
      if (bound < best) best = bound, joined = candidate;
    });
    if (joined == kNone) {
      joined = static_cast<std::uint32_t>(classes.size());
      grid.add(summary, finish[i].key, joined);
      classes.leader.push_back(i);
    } else {
      classes.bound_w_m2 = std::max(classes.bound_w_m2, best);
    }
    classes.class_of[i] = joined;
  }
  return classes;
}

}  // namespace radiometry::scene
