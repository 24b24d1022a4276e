// SPDX-License-Identifier: Apache-2.0
#pragma once

// The Pareto front: designs that no other design beats in one objective without losing in another. Found by divide and
// conquer over the objectives (Kung, Luccio and Preparata, J. ACM 22, 469, 1975), O(n log n) for two and three, so that
// fronts of 1e5 designs take no time; designs stream through in batches, memory grows with the front alone.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace study {

/// Designs with their objectives, larger being better in each.
struct FrontPoints {
  std::size_t objectives = 0;  ///< at least 1
  std::vector<std::int64_t> designs{};
  std::vector<double> values{};  ///< [point][objective], none of them NaN

  std::size_t size() const { return designs.size(); }
  std::span<const double> at(std::size_t point) const {
    return std::span(values).subspan(point * objectives, objectives);
  }
  void add(std::int64_t design, std::span<const double> of);
};

/// Returns the designs that no other dominates, in the order of their numbers. Of designs that are equal in every
/// objective the one of the lowest number stays: so the front is the same for any order and any batches.
FrontPoints front_of(const FrontPoints& points);

/// The front of points that come in batches.
class StreamingFront {
 public:
  explicit StreamingFront(std::size_t objectives) : points_{.objectives = objectives} {}
  void add(const FrontPoints& points);
  FrontPoints result() const { return front_of(points_); }

 private:
  FrontPoints points_;     // the front of all but the last of them
  std::size_t known_ = 0;  // size of the front that they begin with
};

}  // namespace study
