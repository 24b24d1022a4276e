// SPDX-License-Identifier: Apache-2.0
// Hull and what is fixed to it: fenders, skirts, stowage, lamps, exhaust. Engine deck: a plate with louvres and two
// fans.
#include "apps/scene/vehicle/vehicle_parts.h"

namespace apps::scene {
namespace {

// The same on the left and on the right.
void box_on_both_sides(SolidBuilder& solids, Range x, Range y, Range z) {
  solids.box(x, y, z);
  solids.box(x, {-y.to, -y.from}, z);
}

void add_skirts(SolidBuilder& solids) {
  constexpr int plates = 6;
  constexpr double length = 0.93, gap = 0.015;
  for (int i = 0; i < plates; ++i) {
    const double from = -2.86 + i * length;
    box_on_both_sides(solids, {from, from + length - gap}, {1.575, 1.595}, {0.70, 1.16});
  }
}

void add_stowage(SolidBuilder& solids) {
  // Boxes and tools along the edges of the roof; their feet stand 5 mm in the hull.
  for (const Range x : {Range{-1.32, -0.52}, Range{-0.47, 0.33}, Range{0.38, 1.02}}) {
    solids.tapered_box(x, {1.595, 1.80}, {1.29, 1.53}, {x.from + 0.01, x.to - 0.01}, {1.595, 1.75});
    solids.tapered_box(x, {1.595, 1.80}, {-1.29, -1.53}, {x.from + 0.01, x.to - 0.01}, {1.595, 1.75});
  }
  for (const double y : {-1.21, 1.21}) {
    solids.cylinder(Axis::x, {y, 1.64}, 0.03, {-1.25, 0.95});         // tow bars
    solids.cylinder(Axis::x, {y * 0.96, 1.63}, 0.02, {-1.05, 0.55});  // cleaning rods
  }
}

void add_front(SolidBuilder& solids) {
  for (const double side : {-1.0, 1.0}) {
    const double y = 1.22 * side;
    solids.cylinder(Axis::x, {y, 1.36}, 0.09, {2.20, 2.52});       // lamps
    solids.box({2.14, 2.30}, {y - 0.13, y + 0.13}, {1.20, 1.44});  // and their mounts
    const double hook = 0.62 * side;
    solids.box({2.88, 3.10}, {hook - 0.05, hook + 0.05}, {0.86, 1.00});  // tow hooks
    solids.box({-3.52, -3.36}, {hook - 0.05, hook + 0.05}, {0.80, 0.94});
  }
  solids.cylinder(Axis::z, {1.21, 0.60}, 0.21, {1.59, 1.67});  // driver's hatch and its periscopes
  for (const double y : {0.44, 0.60, 0.76}) solids.box({1.43, 1.49}, {y - 0.06, y + 0.06}, {1.585, 1.68});
  solids.box({1.80, 1.84}, {-1.10, 1.10}, {1.38, 1.47});  // wave deflector on the glacis
}

void add_rear(SolidBuilder& solids) {
  for (const double side : {-1.0, 1.0}) {
    const double y = 1.22 * side;
    solids.box({-3.56, -3.40}, {y - 0.20, y + 0.20}, {1.18, 1.42});  // exhaust housings with their pipes
    for (const double at : {-0.08, 0.08})
      solids.draw(ring({y + at, 1.30}, 0.045, 0.06, solids.cell()), Axis::x, {-3.62, -3.54});
    solids.box({-3.50, -3.39}, {0.36 * side - 0.24, 0.36 * side + 0.24}, {1.12, 1.46});  // spare track links
  }
}

}  // namespace

void add_hull(SolidBuilder& solids) {
  solids.set_group("others");
  solids.set_material("armour");
  const double cell = solids.cell();
  // {x, floor, roof}: nose, glacis, roof, sloped rear plate
  const Section upper = between_lines(
      {{-3.42, 1.06, 1.50}, {-3.30, 1.06, 1.60}, {1.52, 1.06, 1.60}, {2.98, 1.06, 1.13}, {3.04, 1.06, 1.10}}, cell);
  solids.draw(upper, Axis::y, {-1.56, 1.56});
  const Section lower =
      between_lines({{-3.38, 0.80, 1.09}, {-3.02, 0.44, 1.09}, {2.36, 0.44, 1.09}, {2.98, 0.82, 1.09}}, cell);
  solids.draw(lower, Axis::y, {-0.96, 0.96});
  for (const double side : {-1.0, 1.0}) {  // fenders: thin plates that reach over the tracks in front and behind
    const Range y = side > 0.0 ? Range{0.99, 1.555} : Range{-1.555, -0.99};
    solids.draw(between_lines({{2.96, 1.055, 1.075}, {3.12, 0.98, 1.00}, {3.26, 0.84, 0.86}}, cell), Axis::y, y);
    solids.draw(between_lines({{-3.58, 0.93, 0.95}, {-3.41, 1.07, 1.09}, {-3.36, 1.07, 1.09}}, cell), Axis::y, y);
  }
  add_skirts(solids);
  add_stowage(solids);
  add_front(solids);
  add_rear(solids);
}

void add_engine_deck(SolidBuilder& solids) {
  solids.set_group("power_top");
  solids.set_material("armour");
  solids.box({-3.28, -1.42}, {-1.26, 1.26}, {1.595, 1.635});
  for (const double side : {-1.0, 1.0}) {
    // {x, floor, roof} of a louvred panel: slats that rise to the rear and fall off steeply
    std::vector<std::array<double, 3>> slats;
    for (int i = 0; i < 11; ++i) {
      const double front = -1.62 - 0.08 * i;
      slats.insert(slats.begin(), {front, 1.62, 1.655});
      slats.insert(slats.begin(), {front - 0.062, 1.62, 1.70});
    }
    solids.draw(between_lines(slats, solids.cell()), Axis::y, side > 0.0 ? Range{0.12, 1.16} : Range{-1.16, -0.12});
    const Point2 fan{-2.88, 0.58 * side};
    solids.draw(ring(fan, 0.25, 0.33, solids.cell()), Axis::z, {1.625, 1.70});
    solids.cylinder(Axis::z, fan, 0.245, {1.62, 1.65});
    solids.cylinder(Axis::z, fan, 0.07, {1.648, 1.69});
    for (const double y : {-0.16, 0.0, 0.16})  // bars over the fan
      solids.box({fan[0] - 0.26, fan[0] + 0.26}, {fan[1] + y - 0.012, fan[1] + y + 0.012}, {1.675, 1.695});
  }
}

}  // namespace apps::scene
