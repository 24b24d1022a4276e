// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/table_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "radiometry/stages/noise/random.h"

namespace radiometry::scene {
namespace {

constexpr std::uint64_t kOtherSet = 0x9e3779b97f4a7c15;  // added to the seed

/// `count` of the numbers below `size` at random, rising; all where there are no more.
std::vector<std::size_t> picked(std::size_t size, std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> numbers(size);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  if (count >= size) return numbers;
  for (std::size_t i = 0; i < count; ++i) {
    const Bits128 bits = philox({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i >> 32), 0, 1}, seed);
    const std::uint64_t word = std::uint64_t{bits[0]} << 32 | bits[1];
    std::swap(numbers[i], numbers[i + word % (size - i)]);
  }
  numbers.resize(count);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

TableError error_of(std::vector<double> differences, std::size_t count) {
  if (differences.empty()) return {.count = count};
  double squares = 0.0;
  for (double& difference : differences) {
    squares += difference * difference;
    difference = std::abs(difference);
  }
  const std::size_t rank = ((differences.size() - 1) * 95 + 99) / 100;
  const auto at = differences.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(differences.begin(), at, differences.end());
  return {std::sqrt(squares / static_cast<double>(differences.size())), *at, count};
}

}  // namespace

ViewError view_error(const Rays& rays, const Receivers& receivers, const Views& made, const ViewOptions& options,
                     std::size_t count, std::span<const std::uint32_t> among) {
  std::vector<std::size_t> numbers = picked(among.empty() ? receivers.size() : among.size(), count, options.seed);
  if (!among.empty())
    for (std::size_t& number : numbers) number = among[number];
  Receivers some;
  for (const std::size_t i : numbers) {
    some.sides.insert(some.sides.end(), receivers[i].begin(), receivers[i].end());
    some.first.push_back(some.sides.size());
  }
  ViewOptions twice = options;
  twice.rays *= 2;
  twice.rays_of = {};
  twice.seed += kOtherSet;
  const Views again = views(rays, some, twice);
  std::vector<double> sky, surfaces;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    sky.push_back(again.sky_share(k) - made.sky_share(numbers[k]));
    surfaces.push_back(again.surfaces[k] - made.surfaces[numbers[k]]);
  }
  return {error_of(std::move(sky), numbers.size()), error_of(std::move(surfaces), numbers.size())};
}

SunError sun_error(const Rays& rays, std::span<const Side> sides, std::span<const SunCheck> checks,
                   const SunVisibility& sun, const SunOptions& options, std::size_t count) {
  const std::vector<std::size_t> numbers = picked(sides.size(), count, options.seed);
  std::vector<Side> some;
  some.reserve(numbers.size());
  for (const std::size_t i : numbers) some.push_back(sides[i]);

  std::vector<Vector> directions;
  for (const SunCheck& check : checks) directions.push_back(check.to_sun);
  SunOptions twice = options;
  twice.points = std::min(255, 2 * options.points);
  twice.seed += kOtherSet;
  const SunVisibility again = sun_visibility(rays, some, directions, twice);

  std::vector<double> differences, largest(numbers.size(), 0.0);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const Vector& normal = rays.facets().facet[some[k].facet].normal;
    for (std::size_t d = 0; d < directions.size(); ++d) {
      const double cosine = (some[k].back ? -1.0 : 1.0) * dot(normal, directions[d]);
      if (cosine <= 0.0 || directions[d][2] <= 0.0) continue;
      const auto [to_sun, entry, share] = checks[d];
      const double before = sun.share(numbers[k], entry), after = share > 0.0 ? sun.share(numbers[k], entry + 1) : 0.0;
      differences.push_back(cosine * (again.share(k, d) - (1.0 - share) * before - share * after));
      largest[k] = std::max(largest[k], std::abs(differences.back()));
    }
  }
  return {error_of(std::move(differences), numbers.size()), error_of(std::move(largest), numbers.size())};
}

}  // namespace radiometry::scene
