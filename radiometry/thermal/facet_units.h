// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is solved: units. A unit is a set of facets of one material whose absorbed flux is nearly the same all the time
// (radiometry/scene/classes.h); the one that leads it is solved for all. Sides of units exchange radiation through
// patches, coarser sets of nearly equal flux. Rays of sides are traced once, with each side a patch of its own: what is
// merged, they tell.

#include "radiometry/scene/classes.h"
#include "radiometry/scene/exchange.h"
#include "radiometry/scene/table_error.h"
#include "radiometry/thermal/heat_scene.h"

namespace radiometry::thermal {

/// A side of a unit, as the balance needs it.
struct UnitSide {
  scene::Vector normal{};
  std::size_t sun_row = 0;         ///< of Units::sun
  double sky = 1.0, ground = 0.0;  ///< shares of the view
  double absorptance = 0.0, emissivity = 0.0;
  double source_w_m2 = 0.0;  ///< of the layers, as Material has it
};

struct Unit {
  std::uint32_t leader = 0;                 ///< the facet that is solved for all
  std::uint32_t region = 0;                 ///< of that facet
  std::optional<std::uint32_t> material{};  ///< absent: black, of given temperature
  bool given = false;                       ///< its temperature is given
  UnitSide front;
  std::optional<UnitSide> back{};  ///< of sheets and pairs
  bool paired = false;             ///< its back is the front of another unit
  std::size_t receiver = 0;        ///< of the front in Units::views
  std::size_t back_receiver = 0;   ///< of the back: the next for a sheet, for a pair that of the opposite unit's front

  bool has_own_back() const { return back && !paired; }
};

struct Units {
  std::vector<Unit> unit;              ///< by material; those of given temperature last
  std::vector<std::uint32_t> unit_of;  ///< of each facet
  scene::SunVisibility sun;            ///< of all sides
  scene::Views views;                  ///< of receivers: fronts and backs of units
  scene::Exchange exchange;
  std::vector<std::uint32_t> patch_of_side;  ///< as radiometry/scene/views.h has it
  double bound_w_m2 = 0.0;                   ///< largest difference of absorbed flux between a facet and its unit
  scene::ViewError view_error;               ///< shares, of units
  scene::SunError sun_error;                 ///< shares of the direct normal irradiance, of facets
  /// Facets that are asked for whose fronts lie inside other solids and see nothing else: one unit for each finish.
  std::vector<std::uint32_t> covered;
  double rays_ms = 0.0, classes_ms = 0.0, error_ms = 0.0;

  bool has_sheets() const { return exchange.receivers() > unit.size(); }
};

/// Calls `visit(receiver, unit, side)` for all sides of all units, where the side is `unit.front` or `*unit.back`; the
/// back of a pair belongs to another unit.
template <class Visit>
void for_receivers(const Units& units, const Visit& visit) {
  for (const Unit& unit : units.unit) {
    visit(unit.receiver, unit, unit.front);
    if (unit.has_own_back()) visit(unit.back_receiver, unit, *unit.back);
  }
}

/// The fronts of all facets, then the backs of sheets; where the back of each facet stands: for a pair, the front of
/// the opposite facet.
struct Sides {
  std::vector<scene::Side> sides;
  std::vector<std::uint32_t> back_of;  ///< of each facet, kNone without
};
Sides sides_of(const HeatScene& scene);

/// `tolerance_w_m2`: the largest difference of absorbed flux within a unit. `like`: units of the same facets and rays,
/// whose patches are taken.
Units units_of(const HeatScene& scene, const HeatOptions& options, double tolerance_w_m2, const Units* like = nullptr);

/// The units that stand for all: some of every patch, evenly through the order of the units, and of every material
/// those whose direct light changes most from one direction of the sun to the next. All that are asked for, where that
/// is not many fewer. The result is of each unit.
std::vector<bool> sampled_units(const Units& units, const HeatScene& scene);

/// Those whose temperatures are asked for (HeatScene::seen), the sample, and more of the patches that no one asks for,
/// evenly, since these are known by them alone. All but units of given temperature, where all are asked for.
std::vector<bool> solved_units(const Units& units, const HeatScene& scene);

}  // namespace radiometry::thermal
