// SPDX-License-Identifier: Apache-2.0
// Turret, gun, hatches and sights.
#include "apps/scene/vehicle/vehicle_parts.h"

namespace apps::scene {
namespace {

void add_gun(SolidBuilder& solids) {
  constexpr double height = 2.00;
  solids.set_material("armour");
  // {x, low, high} of the mantlet: a blunt wedge
  solids.draw(between_lines({{1.00, 1.80, 2.22}, {1.34, 1.80, 2.22}, {1.48, 1.88, 2.12}}, solids.cell()), Axis::y,
              {-0.34, 0.34});
  solids.set_material("steel");
  const Point2 bore{0.0, height};
  solids.cylinder(Axis::x, bore, 0.115, {1.46, 1.72});
  solids.cylinder(Axis::x, bore, 0.065, {1.70, 3.62});
  solids.cylinder(Axis::x, bore, 0.095, {2.45, 2.85});         // fume extractor
  solids.cylinder(Axis::x, bore, 0.088, {3.52, 3.68});         // muzzle reference
  solids.cylinder(Axis::x, {0.22, 2.02}, 0.02, {1.40, 1.62});  // coaxial gun
}

void add_roof(SolidBuilder& solids) {
  constexpr double roof = 2.30;
  solids.set_material("armour");
  const Point2 cupola{-0.30, -0.48};
  solids.draw(ring(cupola, 0.27, 0.36, solids.cell()), Axis::z, {roof - 0.01, roof + 0.16});
  solids.cylinder(Axis::z, cupola, 0.265, {roof - 0.005, roof + 0.19});
  for (int i = 0; i < 4; ++i)
    solids.box({0.04, 0.10}, {-0.84 + 0.21 * i, -0.71 + 0.21 * i}, {roof - 0.008, roof + 0.12});
  solids.cylinder(Axis::z, {-0.30, 0.48}, 0.29, {roof - 0.01, roof + 0.07});  // loader's hatch
  solids.box({0.30, 0.68}, {0.10, 0.46}, {roof - 0.01, roof + 0.26});         // gunner's sight
  solids.cylinder(Axis::z, {-0.80, 0.0}, 0.16, {roof - 0.01, roof + 0.22});   // panoramic sight
  solids.box({-0.94, -0.66}, {-0.13, 0.13}, {roof + 0.21, roof + 0.38});
  solids.set_material("steel");
  solids.box({-0.10, 0.36}, {0.67, 0.77}, {roof + 0.12, roof + 0.22});  // machine gun, its post and its barrel
  solids.cylinder(Axis::z, {0.0, 0.72}, 0.03, {roof - 0.01, roof + 0.13});
  solids.cylinder(Axis::x, {0.72, roof + 0.18}, 0.02, {0.34, 1.00});
}

void add_sides(SolidBuilder& solids) {
  solids.set_material("armour");
  for (const double side : {-1.0, 1.0}) {
    // wedges on the flanks, bins behind them
    solids.tapered_box({-0.80, 0.46}, {1.72, 2.26}, {1.13 * side, 1.34 * side}, {-0.74, 0.26}, {1.82, 2.10});
    solids.tapered_box({-1.72, -0.90}, {1.80, 2.22}, {1.02 * side, 1.24 * side}, {-1.68, -0.94}, {1.84, 2.16});
    for (int i = 0; i < 4; ++i)  // smoke dischargers
      solids.cylinder(Axis::x, {(0.98 + 0.10 * (i % 2)) * side, 2.02 + 0.11 * (i / 2)}, 0.042, {0.52, 0.86});
    solids.box({0.46, 0.56}, {side * 1.03 - 0.14, side * 1.03 + 0.14}, {1.96, 2.20});
  }
  // rack behind the turret: bars around a bin
  solids.box({-2.16, -1.76}, {-0.78, 0.78}, {1.90, 2.16});
  for (const double z : {1.86, 2.02, 2.20}) {
    solids.cylinder(Axis::y, {-2.24, z}, 0.015, {-0.90, 0.90});
    for (const double y : {-0.88, 0.88}) solids.cylinder(Axis::x, {y, z + 0.001}, 0.013, {-2.23, -1.70});
  }
}

}  // namespace

void add_turret(SolidBuilder& solids) {
  solids.set_group("firing_part");
  solids.set_material("armour");
  const double cell = solids.cell();
  solids.cylinder(Axis::z, {-0.35, 0.0}, 1.06, {1.59, 1.70});  // race ring
  // {x, right, left} of the body, seen from above: bustle, flanks, cheeks
  solids.draw(
      between_lines({{-1.74, -0.90, 0.90}, {-1.20, -1.14, 1.14}, {0.42, -1.14, 1.14}, {1.12, -0.52, 0.52}}, cell),
      Axis::z, {1.69, 2.20});
  // {x, low, high} of the roof: a plate that slopes to the front
  solids.draw(
      between_lines({{-1.66, 2.18, 2.27}, {-1.20, 2.18, 2.305}, {0.16, 2.18, 2.305}, {0.70, 2.18, 2.225}}, cell),
      Axis::y, {-0.86, 0.86});
  add_gun(solids);
  add_roof(solids);
  add_sides(solids);
}

}  // namespace apps::scene
