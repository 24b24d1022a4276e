// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/vehicle/vehicle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/scene/vehicle/solids.h"
#include "mtf/error.h"

namespace apps::scene {
namespace {

// The parts of the vehicle, each with its groups and materials. Forward is +x, left is +y, the ground is z = 0.

// others: hull and what is fixed to it: fenders, skirts, stowage, lamps, exhaust; power_top: engine deck, a plate with
// louvres and two fans.

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

// driving_part: tracks, road wheels, sprockets, idlers and return rollers.

struct Wheel {
  Point2 centre;  ///< x, z
  double radius;  ///< up to the inner side of the track
};

constexpr int road_wheels = 6;
constexpr double plate = 0.03, pad = 0.06;  // of the track between and under its pads, m
constexpr double wheel_radius = 0.32;
constexpr Wheel sprocket{{-2.86, 0.67}, 0.27}, idler{{2.72, 0.68}, 0.25};

Wheel road_wheel(int i) { return {{-2.10 + 0.80 * i, pad + wheel_radius}, wheel_radius}; }

/// A point of a line around wheels and the direction outwards.
struct TrackPoint {
  Point2 at;
  double angle;
};

/// The tight line around wheels that are given counter-clockwise in (x, z), at points `step` apart or a little less:
/// arcs and common tangents. The normal n of the tangent of two circles has n . (c2 - c1) = r1 - r2.
std::vector<TrackPoint> line_around(const std::vector<Wheel>& wheels, double step) {
  constexpr double turn = 2 * std::numbers::pi;
  const auto normal_after = [&](std::size_t i) {
    const Wheel &a = wheels[i], &b = wheels[(i + 1) % wheels.size()];
    const double dx = b.centre[0] - a.centre[0], dz = b.centre[1] - a.centre[1];
    return std::atan2(dz, dx) - std::acos((a.radius - b.radius) / std::hypot(dx, dz));
  };
  struct Piece {  // an arc about a centre, or with `length` the tangent that follows it
    Point2 centre;
    double radius, from, angle, length;
  };
  std::vector<Piece> pieces;
  double total = 0.0;
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    const Wheel &a = wheels[i], &b = wheels[(i + 1) % wheels.size()];
    const double from = normal_after((i + wheels.size() - 1) % wheels.size()), to = normal_after(i);
    const double arc = std::fmod(std::fmod(to - from, turn) + turn, turn);
    const double distance = std::hypot(b.centre[0] - a.centre[0], b.centre[1] - a.centre[1]);
    pieces.push_back({a.centre, a.radius, from, arc, 0.0});
    pieces.push_back({a.centre, a.radius, to, 0.0, std::sqrt(distance * distance - std::pow(a.radius - b.radius, 2))});
    total += a.radius * arc + pieces.back().length;
  }
  constexpr int per_link = 6;
  const int points = per_link * static_cast<int>(std::ceil(total / (step * per_link)));
  std::vector<TrackPoint> line;
  double passed = 0.0;  // length of the pieces before
  for (const Piece& piece : pieces) {
    const double length = piece.length > 0.0 ? piece.length : piece.radius * piece.angle;
    while (static_cast<int>(line.size()) < points &&
           total * static_cast<double>(line.size()) / points < passed + length) {
      const double on = total * static_cast<double>(line.size()) / points - passed;
      const double angle = piece.length > 0.0 ? piece.from : piece.from + on / piece.radius;
      const double along = piece.length > 0.0 ? on : 0.0;
      line.push_back({{piece.centre[0] + piece.radius * std::cos(angle) - along * std::sin(angle),
                       piece.centre[1] + piece.radius * std::sin(angle) + along * std::cos(angle)},
                      angle});
    }
    passed += length;
  }
  return line;
}

void add_track(SolidBuilder& solids, Range y) {
  const std::vector<TrackPoint> line =
      line_around({sprocket, road_wheel(0), road_wheel(road_wheels - 1), idler}, solids.cell() * 0.8);
  std::vector<Point2> inner, outer;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto& [at, angle] = line[i];
    const double thickness = i % 6 < 4 ? pad : plate;  // four of the six points of a link are on its pad
    inner.push_back(at);
    outer.push_back({at[0] + thickness * std::cos(angle), at[1] + thickness * std::sin(angle)});
  }
  solids.set_material("steel");
  solids.draw(band(inner, outer, 2), Axis::y, y);
}

void add_road_wheel(SolidBuilder& solids, Point2 centre, double middle, double side) {
  const double cell = solids.cell(), gap = 0.003;  // between tyre and track
  solids.set_material("rubber");
  const Section tyre = ring(centre, 0.25, wheel_radius - gap, cell);
  for (const double y : {middle - 0.16, middle + 0.03}) solids.draw(tyre, Axis::y, {y, y + 0.13});
  solids.set_material("steel");
  for (const double y : {middle - 0.125, middle + 0.065})
    solids.draw(disc(centre, 0.249, cell), Axis::y, {y, y + 0.06});
  const double from = side > 0.0 ? 0.93 : middle - 0.19, to = side > 0.0 ? middle + 0.19 : -0.93;
  solids.cylinder(Axis::y, centre, 0.075, {from, to});  // hub and axle
  const double outside = side > 0.0 ? middle + 0.12 : middle - 0.15;
  for (int i = 0; i < 6; ++i) {  // bolts of the outer disc
    const double angle = (i + 0.5) * std::numbers::pi / 3;
    solids.cylinder(Axis::y, {centre[0] + 0.17 * std::cos(angle), centre[1] + 0.17 * std::sin(angle)}, 0.02,
                    {outside, outside + 0.03});
  }
}

/// A ring with teeth of two points, with gaps of four between them.
Section toothed_ring(const Wheel& wheel) {
  constexpr int teeth = 13, steps = 6;
  std::vector<Point2> inner, outer;
  for (int i = 0; i < teeth * steps; ++i) {
    const double angle = 2 * std::numbers::pi * i / (teeth * steps);
    const double radius = wheel.radius - (i % steps < 2 ? 0.002 : 0.035);
    inner.push_back({wheel.centre[0] + 0.165 * std::cos(angle), wheel.centre[1] + 0.165 * std::sin(angle)});
    outer.push_back({wheel.centre[0] + radius * std::cos(angle), wheel.centre[1] + radius * std::sin(angle)});
  }
  return band(inner, outer, 3);
}

void add_end_wheels(SolidBuilder& solids, double middle, double side) {
  const double cell = solids.cell(), outer = side > 0.0 ? middle + 0.2 : -0.93,
               inner = side > 0.0 ? 0.93 : middle - 0.2;
  for (const double y : {middle - 0.17, middle + 0.11}) {
    solids.draw(toothed_ring(sprocket), Axis::y, {y, y + 0.06});
    solids.draw(ring(idler.centre, 0.17, idler.radius - 0.003, cell), Axis::y, {y, y + 0.06});
  }
  solids.cylinder(Axis::y, sprocket.centre, 0.17, {middle - 0.13, middle + 0.13});
  solids.cylinder(Axis::y, sprocket.centre, 0.10, {inner, outer});
  solids.cylinder(Axis::y, idler.centre, 0.171, {middle - 0.13, middle + 0.13});
  solids.cylinder(Axis::y, idler.centre, 0.08, {inner, outer});
  for (const double x : {-1.7, 0.0, 1.6}) solids.cylinder(Axis::y, {x, 0.81}, 0.09, {middle - 0.12, middle + 0.12});
}

void add_running_gear(SolidBuilder& solids) {
  solids.set_group("driving_part");
  for (const double side : {-1.0, 1.0}) {
    const double middle = 1.28 * side;
    add_track(solids, {middle - 0.25, middle + 0.25});
    for (int i = 0; i < road_wheels; ++i) add_road_wheel(solids, road_wheel(i).centre, middle, side);
    add_end_wheels(solids, middle, side);
  }
}

// firing_part: turret, gun, hatches and sights.

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

constexpr std::size_t vertices = 178190;  // as many as the object of the paper
constexpr double cell = 0.0392;           // m: the parts have a few hundred vertices less

// Two aerials, rods of square section, take the vertices that are left: four on each layer.
void add_aerials(SolidBuilder& solids) {
  solids.set_group("others");
  solids.set_material("steel");
  const std::size_t left = vertices - solids.mesh().vertices.size();
  if (solids.mesh().vertices.size() + 16 > vertices || left % 4 != 0)
    throw mtf::Error("the vehicle has no room for its aerials: " + std::to_string(solids.mesh().vertices.size()) +
                     " vertices without them; change the size of the cells");
  const int layers = static_cast<int>(left / 4), first = layers / 2;
  int more = first;
  for (const double y : {-0.72, 0.72}) {
    const Section square = between_lines({{-1.506, y - 0.006, y + 0.006}, {-1.494, y - 0.006, y + 0.006}}, 1.0);
    solids.draw(square, Axis::z, {2.21, 3.40}, more - 1);
    more = layers - first;
  }
}

constexpr int cells = 90;                            // along a side
constexpr double half_side = 40.0, height = -0.005;  // m, the latter under the vehicle

// Lines that are 0.3 m apart in the middle and farther outwards.
double line(int i) {
  constexpr double stretch = 2.9;
  const double u = 2.0 * i / cells - 1.0;
  return to_micrometres(half_side * std::sinh(stretch * u) / std::sinh(stretch));
}

// From 0 where |x| < flat to 1 at twice that, smoothly.
double away(double x, double flat) {
  const double u = std::clamp(std::abs(x) / flat - 1.0, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

double wave(double x, double length, double phase) { return std::sin(2 * std::numbers::pi * x / length + phase); }

double along_x(double x) { return away(x, 5.0) * (0.30 * wave(x, 31.0, 0.4) + 0.10 * wave(x, 11.0, 2.0)); }
double along_y(double y) { return away(y, 3.5) * (0.35 * wave(y, 37.0, 1.1) + 0.08 * wave(y, 9.0, 0.3)); }

}  // namespace

radiometry::scene::Mesh make_vehicle() {
  SolidBuilder solids(cell);
  add_hull(solids);
  add_running_gear(solids);
  add_engine_deck(solids);
  add_turret(solids);
  add_aerials(solids);
  return solids.take();
}

// z = f(x) + g(y) over a rectangular grid: opposite corners of a cell have the same sum of heights, so it is plane.
radiometry::scene::Mesh make_terrain() {
  radiometry::scene::Mesh mesh;
  mesh.group_names = mesh.material_names = {"terrain"};
  mesh.first.push_back(0);
  const auto number = [](int i, int j) { return static_cast<std::uint32_t>(i * (cells + 1) + j); };
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j)
      mesh.vertices.push_back(
          {line(i), line(j),
           to_micrometres(height + to_micrometres(along_x(line(i))) + to_micrometres(along_y(line(j))))});
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j)
      mesh.add_face(std::array{number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)});
  return mesh;
}

}  // namespace apps::scene
