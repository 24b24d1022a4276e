// SPDX-License-Identifier: Apache-2.0
// Tracks, road wheels, sprockets, idlers and return rollers.
#include <cmath>
#include <numbers>

#include "apps/scene/vehicle/vehicle_parts.h"

namespace apps::scene {
namespace {

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

}  // namespace

void add_running_gear(SolidBuilder& solids) {
  solids.set_group("driving_part");
  for (const double side : {-1.0, 1.0}) {
    const double middle = 1.28 * side;
    add_track(solids, {middle - 0.25, middle + 0.25});
    for (int i = 0; i < road_wheels; ++i) add_road_wheel(solids, road_wheel(i).centre, middle, side);
    add_end_wheels(solids, middle, side);
  }
}

}  // namespace apps::scene
