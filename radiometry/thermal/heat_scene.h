// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene that is ready for its heat balance: its weather over time, its surfaces, and the tree that rays are traced
// in.

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "radiometry/heat/surface_loss.h"
#include "radiometry/scene/rays.h"
#include "radiometry/thermal/surroundings.h"

namespace radiometry::thermal {

struct Checkpoint;

struct HeatOptions {
  double tolerance_k = 0.1;  ///< of the worst facet at any output, with the tables of shadows, views and exchange given
  int directions = 36;       ///< of the table of shadows, a day
  int rays = 128;            ///< of each side of a facet, at least (rays_of)
  int sun_points = 4;        ///< of each facet
  std::uint64_t sun_seed = 0;  ///< another one gives other points
  std::size_t patches = 500;   ///< that surfaces exchange radiation by, at most
  bool every_facet = false;    ///< no facets are solved as one but those that others cover
  /// Temperatures of those facets alone that the camera of the scene can see (seen_facets), which it has to
  /// have.
  bool seen = false;
  bool verify = false;  ///< the realised error too, by runs at a tenth of the tolerance; all facets for tables
  int threads = 0;      ///< 0: all cores; results do not depend on it
  /// On how many of `all` facets the errors of tables are measured.
  std::size_t measured(std::size_t all) const { return verify ? all : 2000; }
  /// A scene of few facets has more of them, half a million in all: they cost a tenth of a second, and nothing averages
  /// the errors of two facets that see each other.
  int rays_of(std::size_t facets) const {
    constexpr std::size_t kAll = 1U << 19, kMost = 1U << 16;
    return std::max(rays, static_cast<int>(std::min(kMost, kAll / std::max<std::size_t>(facets, 1))));
  }
  /// Asked after each day; false ends the run with the outputs that are finished.
  std::function<bool()> go_on{};
  /// Gets what a run that is killed can go on from, after a day where `keep_every_s` have passed since the last time.
  std::function<void(const Checkpoint&)> keep{};
  double keep_every_s = 10.0;
  /// Where an earlier run of the same inputs and options was ended (run/solve_units.h); it is continued from there.
  const Checkpoint* from = nullptr;
};

struct HeatScene {
  ThermalScene input;  ///< as given, without the facets, which `rays` has
  Surroundings surroundings;
  /// As input.materials; those of pairs follow once more, adiabatic, for facets without an opposite one.
  std::vector<Material> material;
  scene::Rays rays;  ///< with the facets
  std::vector<std::pair<std::string, double>> timing_ms;
  std::vector<std::string> warnings;
  std::vector<std::uint32_t> opposite{};  ///< of each facet of a pair, else kNone (heat_scene.cpp); empty: no pairs

  std::vector<bool> seen{};  ///< of each facet, where only those that the camera sees are asked for; else empty

  const scene::Facets& facets() const { return rays.facets(); }
  const Region& region_of(std::uint32_t facet) const { return input.regions[input.region_of[facet]]; }
  /// The temperature that a facet has been given, at seconds from the start of the run.
  double given_k(std::uint32_t facet, double time_s) const {
    return region_of(facet).given_k(facet, std::min(input.start_s + time_s, input.last_s()));
  }
  /// Whether the temperature of the facet is asked for.
  bool is_seen(std::uint32_t facet) const { return seen.empty() || seen[facet]; }
  /// Whether the facet is solved with two exposed sides.
  bool is_sheet(std::uint32_t facet) const;
  /// The facet on the other side of its wall, kNone without.
  std::uint32_t opposite_of(std::uint32_t facet) const;
  /// Index into `material`, for a facet of a region with one.
  std::size_t material_of(std::uint32_t facet) const;
};

/// What a value is told by that the model of a heat balance does not hold for, with the first time and the extreme:
/// "convection mcadams: wind of 60 m/s, from 2026-06-21T12:00:00Z on ...".
std::string text_of(const heat::Validity& validity, const heat::Beyond& beyond, double start_s,
                    const std::string& where);

/// Of each facet, whether a camera can see it: whether it is met first by a straight line from its position, in
/// whichever direction, since a scene file does not limit the field of view.
std::vector<bool> seen_facets(const HeatScene& scene, const scene::Point& camera_m, int threads);

/// Checks the scene, and makes what its heat balance needs. Throws UsageError as require_valid and require_weather, and
/// where what the camera sees is asked for and there is none, or it sees nothing.
HeatScene prepare_heat(ThermalScene scene, const HeatOptions& options);

}  // namespace radiometry::thermal
