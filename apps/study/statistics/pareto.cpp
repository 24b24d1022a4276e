// SPDX-License-Identifier: Apache-2.0
#include "apps/study/statistics/pareto.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace study {
namespace {

constexpr std::size_t kSmall = 32;            // points that are compared each with each
constexpr std::size_t kSmallPairs = 2048;     // the same of two sets
constexpr std::size_t kLeastBatch = 1 << 16;  // points that wait for the next pass of the sort

using Rows = std::vector<std::size_t>;

/// The recursion of Kung, Luccio and Preparata on points that all differ.
struct Maxima {
  const FrontPoints& points;
  std::size_t last = points.objectives - 1;

  double value(std::size_t point, std::size_t objective) const {
    return points.values[point * points.objectives + objective];
  }

  /// `high` is at least as good in all objectives from `from` on.
  bool covers(std::size_t high, std::size_t low, std::size_t from) const {
    for (std::size_t k = from; k <= last; ++k)
      if (value(high, k) < value(low, k)) return false;
    return true;
  }

  /// Drops from `low` what some point of `high` covers in the objectives from `from` on.
  void filter(Rows& low, Rows& high, std::size_t from) const {
    if (low.empty() || high.empty()) return;
    if (from == last) {
      double best = -std::numeric_limits<double>::infinity();
      for (const std::size_t h : high) best = std::max(best, value(h, last));
      std::erase_if(low, [&](std::size_t l) { return value(l, last) <= best; });
    } else if (low.size() * high.size() <= kSmallPairs) {
      std::erase_if(low, [&](std::size_t l) {
        return std::any_of(high.begin(), high.end(), [&](std::size_t h) { return covers(h, l, from); });
      });
    } else if (from + 1 == last) {
      sweep(low, high, from);
    } else {
      split(low, high, from);
    }
  }

  /// Two objectives are left: down the first, the best of the second so far decides.
  void sweep(Rows& low, Rows& high, std::size_t from) const {
    const auto down = [&](std::size_t a, std::size_t b) { return value(a, from) > value(b, from); };
    std::sort(low.begin(), low.end(), down);
    std::sort(high.begin(), high.end(), down);
    double best = -std::numeric_limits<double>::infinity();
    bool any = false;
    auto h = high.begin();
    std::erase_if(low, [&](std::size_t l) {
      for (; h != high.end() && value(*h, from) >= value(l, from); ++h) {
        best = std::max(best, value(*h, last));
        any = true;
      }
      return any && value(l, last) <= best;
    });
  }

  void split(Rows& low, Rows& high, std::size_t from) const {
    std::vector<double> all;
    for (const Rows* set : {&low, &high})
      for (const std::size_t i : *set) all.push_back(value(i, from));
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    const double at = *middle;
    const bool lowest = std::none_of(all.begin(), middle, [&](double v) { return v < at; });
    const auto upper = [&](std::size_t i) { return lowest ? value(i, from) > at : value(i, from) >= at; };
    const auto parts = [&](const Rows& set) {
      std::array<Rows, 2> two;
      for (const std::size_t i : set) two[upper(i) ? 0 : 1].push_back(i);
      return two;
    };
    auto [low_up, low_down] = parts(low);
    auto [high_up, high_down] = parts(high);
    if (low_up.empty() && high_up.empty()) return filter(low, high, from + 1);  // all alike in this objective
    filter(low_up, high_up, from);
    filter(low_down, high_down, from);
    filter(low_down, high_up, from + 1);
    low = std::move(low_up);
    low.insert(low.end(), low_down.begin(), low_down.end());
  }

  /// `sorted`: best first, objective by objective, so that none covers one before it.
  Rows of(std::span<const std::size_t> sorted) const {
    if (sorted.size() <= kSmall) {
      Rows kept;
      for (const std::size_t i : sorted)
        if (std::none_of(kept.begin(), kept.end(), [&](std::size_t k) { return covers(k, i, 0); })) kept.push_back(i);
      return kept;
    }
    Rows top = of(sorted.first(sorted.size() / 2)), bottom = of(sorted.subspan(sorted.size() / 2));
    filter(bottom, top, std::min<std::size_t>(1, last));
    top.insert(top.end(), bottom.begin(), bottom.end());
    return top;
  }
};

}  // namespace

void FrontPoints::add(std::int64_t design, std::span<const double> of) {
  designs.push_back(design);
  values.insert(values.end(), of.begin(), of.end());
}

FrontPoints front_of(const FrontPoints& points) {
  Rows order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto va = points.at(a), vb = points.at(b);
    for (std::size_t k = 0; k < va.size(); ++k)
      if (va[k] != vb[k]) return va[k] > vb[k];
    return points.designs[a] < points.designs[b];
  });
  const auto equal = [&](std::size_t a, std::size_t b) {
    return std::equal(points.at(a).begin(), points.at(a).end(), points.at(b).begin());
  };
  order.erase(std::unique(order.begin(), order.end(), equal), order.end());
  Rows kept = Maxima{points}.of(order);
  std::sort(kept.begin(), kept.end(),
            [&](std::size_t a, std::size_t b) { return points.designs[a] < points.designs[b]; });
  FrontPoints front{.objectives = points.objectives};
  for (const std::size_t i : kept) front.add(points.designs[i], points.at(i));
  return front;
}

void StreamingFront::add(const FrontPoints& points) {
  points_.designs.insert(points_.designs.end(), points.designs.begin(), points.designs.end());
  points_.values.insert(points_.values.end(), points.values.begin(), points.values.end());
  if (points_.size() - known_ < std::max(kLeastBatch, known_)) return;
  points_ = front_of(points_);
  known_ = points_.size();
}

}  // namespace study
