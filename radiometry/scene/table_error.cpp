// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/table_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "radiometry/stages/noise/random.h"

namespace radiometry::scene {
namespace {

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

}  // namespace

TableError error_of(std::vector<double> differences, double variance, std::size_t count) {
  if (differences.empty()) return {.count = count};
  double squares = 0.0;
  for (double& difference : differences) {
    squares += difference * difference;
    difference = std::abs(difference);
  }
  const std::size_t rank = ((differences.size() - 1) * 95 + 99) / 100;
  const auto at = differences.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(differences.begin(), at, differences.end());
  const double chance = variance / (static_cast<double>(count) * static_cast<double>(count));
  return {std::sqrt(squares / static_cast<double>(differences.size()) + chance), std::sqrt(*at * *at + chance), count};
}

std::vector<ViewOptions> other_sets(const ViewOptions& options) {
  constexpr int kEnough = 2048, kSets = 8;
  ViewOptions other = options;
  other.rays_of = {};
  const int sets = options.rays < kEnough ? 1 : kSets;
  other.rays = 2 * options.rays / sets;
  std::vector<ViewOptions> all;
  for (int s = 0; s < sets; ++s) {
    other.seed += kOtherSet;
    all.push_back(other);
  }
  return all;
}

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
  std::vector<OtherSets> sky(numbers.size()), surfaces(numbers.size());
  for (const ViewOptions& set : other_sets(options)) {
    const Views again = views(rays, some, set);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      sky[k].add(again.sky_share(k));
      surfaces[k].add(again.surfaces[k]);
    }
  }
  const auto error = [&](const std::vector<OtherSets>& others, const auto& share) {
    std::vector<double> differences;
    double variance = 0.0;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      differences.push_back(others[k].mean - share(numbers[k]));
      variance += others[k].variance();
    }
    return error_of(std::move(differences), variance, numbers.size());
  };
  return {error(sky, [&](std::size_t i) { return made.sky_share(i); }),
          error(surfaces, [&](std::size_t i) { return made.surfaces[i]; })};
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
  return {error_of(std::move(differences), 0.0, numbers.size()), error_of(std::move(largest), 0.0, numbers.size())};
}

}  // namespace radiometry::scene
