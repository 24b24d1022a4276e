// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/classes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "mtf/error.h"
#include "mtf/math/word_hash.h"
#include "mtf/parallel.h"

namespace radiometry::scene {
namespace {

constexpr double kLargestFlux_w_m2 = 1e7;

/// The terms of the absorbed flux of each side: the direct one at each direction of the sun, diffuse and long-wave.
class FluxTerms {
 public:
  static constexpr std::size_t kBlock = 16;

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

  /// The last two terms of a side and the first direct ones, a cache line of them: enough to reject most leaders.
  using Head = std::array<float, kBlock>;
  Head head(std::size_t side) const {
    const float* term = terms_.data() + side * width();
    Head head{term[order_.size()], term[order_.size() + 1]};
    std::copy(term, term + std::min(order_.size(), kBlock - 2), head.begin() + 2);
    return head;
  }
  /// False only where the bound is `enough` or more, to rounding.
  static bool may_be_below(const Head& a, const Head& b, double enough) {
    const float left = static_cast<float>(enough) - std::abs(a[0] - b[0]) - std::abs(a[1] - b[1]);
    int beyond = left < 0.0F ? 1 : 0;
    for (std::size_t k = 2; k < kBlock; ++k) beyond += std::abs(a[k] - b[k]) > left ? 1 : 0;
    return beyond == 0;
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
  std::size_t width() const { return order_.size() + 2; }
  std::vector<std::size_t> order_;  // of the directions
  std::vector<float> terms_;
};

void check_inputs(std::size_t sides, std::span<const SideFinish> finish, const Views& views, const SunVisibility& sun,
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

  const auto check_flux = [](double flux) {
    if (!(std::abs(flux) <= kLargestFlux_w_m2))
      throw mtf::UsageError("classes_of: an amplitude is " + std::to_string(flux) +
                            " W/m2, it must be a number of at most 1e6.");
  };
  for (const auto* list : {&amplitudes.direct, &amplitudes.sky_solar, &amplitudes.sky_longwave})
    std::for_each(list->begin(), list->end(), check_flux);
  for (const double flux :
       {amplitudes.ground_solar, amplitudes.ground_longwave, amplitudes.surfaces_solar, amplitudes.surfaces_longwave})
    check_flux(flux);
  for (const SideFinish& side : finish)
    if (!(side.solar_absorptance >= 0.0 && side.solar_absorptance <= 1.0 && side.emissivity >= 0.0 &&
          side.emissivity <= 1.0))
      throw mtf::UsageError("classes_of: absorptance " + std::to_string(side.solar_absorptance) + " or emissivity " +
                            std::to_string(side.emissivity) + " is not from 0 to 1.");
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

/// Cubes in the space of summaries; the origin is in the middle of one.
using Cube = std::array<std::int64_t, 3>;

Cube cube_of(const std::array<double, 3>& summary, double width) {
  Cube cube;
  for (std::size_t k = 0; k < 3; ++k) cube[k] = static_cast<std::int64_t>(std::floor(summary[k] / width + 0.5));
  return cube;
}

/// Leaders in cubes one tolerance wide: those within the tolerance of a side are in its cube or the 26 around it.
class LeaderGrid {
 public:
  struct Leader {
    FluxTerms::Head head;
    std::uint32_t of_class;
  };

  explicit LeaderGrid(double width) : width_(width) {}

  void add(const std::array<double, 3>& summary, std::uint32_t key, const Leader& leader) {
    cubes_[name(cube_of(summary, width_), key)].push_back(leader);
  }

  template <class Work>
  void for_each_near(const std::array<double, 3>& summary, std::uint32_t key, const Work& work) const {
    const Cube middle = cube_of(summary, width_);
    for (std::int64_t k = 0; k < 27; ++k) {
      const auto found =
          cubes_.find(name({middle[0] + k % 3 - 1, middle[1] + k / 3 % 3 - 1, middle[2] + k / 9 - 1}, key));
      if (found == cubes_.end()) continue;
      for (const Leader& leader : found->second) work(leader);
    }
  }

 private:
  /// Cubes whose hashes are equal share a list: that costs time, no more.
  static std::uint64_t name(const Cube& cube, std::uint32_t key) {
    std::uint64_t hash = mtf::mixed(mtf::kWordHashStart, key);
    for (const std::int64_t k : cube) hash = mtf::mixed(hash, static_cast<std::uint64_t>(k));
    return hash ^ hash >> 32;
  }

  double width_;
  std::unordered_map<std::uint64_t, std::vector<Leader>> cubes_;
};

using Finish = std::tuple<std::uint32_t, double, double>;

/// Sides of the same finish in the same cube are together. Ends where there are more than `most`.
Classes cubes_as_classes(std::span<const SideFinish> finish, std::span<const std::array<double, 3>> summaries,
                         double width, std::size_t most) {
  std::map<std::pair<Finish, Cube>, std::uint32_t> known;
  Classes classes{.bound_w_m2 = width};
  for (std::uint32_t i = 0; i < finish.size() && classes.size() <= most; ++i) {
    const Finish of_side{finish[i].key, finish[i].solar_absorptance, finish[i].emissivity};
    const auto [at, fresh] =
        known.try_emplace({of_side, cube_of(summaries[i], width)}, static_cast<std::uint32_t>(classes.leader.size()));
    if (fresh) classes.leader.push_back(i);
    classes.class_of.push_back(at->second);
  }
  return classes;
}

}  // namespace

Classes classes_of(const Facets& facets, std::span<const Side> sides, std::span<const SideFinish> finish,
                   const Views& views, const SunVisibility& sun, std::span<const Vector> to_sun,
                   const FluxAmplitudes& amplitudes, double tolerance_w_m2, int threads) {
  check_inputs(sides.size(), finish, views, sun, to_sun, amplitudes);
  if (!(tolerance_w_m2 >= 0.0) || !std::isfinite(tolerance_w_m2))
    throw mtf::UsageError("classes_of: the tolerance is " + std::to_string(tolerance_w_m2) +
                          " W/m2, it must be 0 or more.");
  Classes classes{.class_of = std::vector<std::uint32_t>(sides.size())};
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
  std::uint32_t joined = kNone;
  for (std::uint32_t i = 0; i < sides.size(); ++i) {
    const std::array<double, 3> summary = terms.summary(i);
    const FluxTerms::Head head = terms.head(i);
    double best = tolerance_w_m2;
    const auto consider = [&](std::uint32_t candidate) {
      const std::uint32_t leader = classes.leader[candidate];
      if (!same_finish(finish[i], finish[leader])) return;
      const double bound = terms.bound(i, leader, best);
      if (bound < best) best = bound, joined = candidate;
    };
    // Sides that follow each other are often neighbours: with the class of the last one, most others are soon rejected.
    const std::uint32_t last = std::exchange(joined, kNone);
    if (last != kNone) consider(last);
    grid.for_each_near(summary, finish[i].key, [&](const LeaderGrid::Leader& candidate) {
      if (FluxTerms::may_be_below(head, candidate.head, best)) consider(candidate.of_class);
    });
    if (joined == kNone) {
      joined = static_cast<std::uint32_t>(classes.size());
      grid.add(summary, finish[i].key, {head, joined});
      classes.leader.push_back(i);
    } else {
      classes.bound_w_m2 = std::max(classes.bound_w_m2, best);
    }
    classes.class_of[i] = joined;
  }
  return classes;
}

Classes patches_of(const Facets& facets, std::span<const Side> sides, std::span<const SideFinish> finish,
                   const Views& views, const SunVisibility& sun, std::span<const Vector> to_sun,
                   const FluxAmplitudes& amplitudes, std::size_t most, int threads) {
  check_inputs(sides.size(), finish, views, sun, to_sun, amplitudes);
  const FluxTerms terms = flux_terms(facets, sides, finish, views, sun, to_sun, amplitudes, threads);
  std::vector<std::array<double, 3>> summaries;
  for (std::size_t i = 0; i < sides.size(); ++i) summaries.push_back(terms.summary(i));

  constexpr double kNarrow_w_m2 = 1e-3, kWide_w_m2 = 100.0 * kLargestFlux_w_m2;  // all in one cube
  Classes patches = cubes_as_classes(finish, summaries, kWide_w_m2, most);
  if (patches.size() > most)
    throw mtf::UsageError("patches_of: the sides have more than " + std::to_string(most) +
                          " different finishes: allow more patches.");
  double narrow = kNarrow_w_m2, wide = kWide_w_m2;  // bisected to 2 %, in the logarithm
  while (wide > 1.02 * narrow) {
    const double width = std::sqrt(narrow * wide);
    Classes trial = cubes_as_classes(finish, summaries, width, most);
    if (trial.size() > most) {
      narrow = width;
    } else {
      wide = width;
      patches = std::move(trial);
    }
  }
  return patches;
}

}  // namespace radiometry::scene
