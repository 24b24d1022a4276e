// SPDX-License-Identifier: Apache-2.0
#pragma once

// Closed shells of quads: a plane section, divided into quads, is drawn along an axis. Walls have two edges along that
// axis, caps lie across it, so that every quad is plane to the last bit whatever its coordinates are rounded to. A
// tapered box keeps this too: the two edges across the taper run along an axis.
//
// Coordinates are rounded to micrometres: the same numbers on every machine, short in a file.

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

enum class Axis { x, y, z };

struct Range {
  double from = 0.0, to = 0.0;
};

using Point2 = std::array<double, 2>;

/// A plane area: quads over points, and the closed lines around it. Which two coordinates the points have is said where
/// the section is drawn along an axis.
struct Section {
  std::vector<Point2> points;
  std::vector<std::array<std::uint32_t, 4>> quads;
  std::vector<std::vector<std::uint32_t>> outlines;
};

/// The area between two lines over the first coordinate, which are straight between knots {along, low, high}. Cells are
/// about `cell` wide; knots are corners of cells.
Section between_lines(const std::vector<std::array<double, 3>>& knots, double cell);

Section disc(Point2 centre, double radius, double cell);

/// The area between two closed lines that have equally many points.
Section band(const std::vector<Point2>& inner, const std::vector<Point2>& outer, int layers);
Section ring(Point2 centre, double inner, double outer, double cell);

/// Adds shells to a mesh, with the group and the material that were set last.
class SolidBuilder {
 public:
  explicit SolidBuilder(double cell) : cell_(cell) { mesh_.first.push_back(0); }

  void set_group(std::string_view name);
  void set_material(std::string_view name);
  double cell() const { return cell_; }

  /// Draws the section along the axis. Its points are (y, z) along x, (x, z) along y, (x, y) along z.
  void draw(const Section& section, Axis axis, Range range);
  /// The same in so many cells.
  void draw(const Section& section, Axis axis, Range range, int cells);

  void box(Range x, Range y, Range z);
  /// A box that becomes narrower along y: at `y.to` it has the extents `end_x`, `end_z`.
  void tapered_box(Range x, Range z, Range y, Range end_x, Range end_z);
  /// Around an axis through `centre`, a point of the section.
  void cylinder(Axis axis, Point2 centre, double radius, Range range);

  const radiometry::scene::Mesh& mesh() const { return mesh_; }
  radiometry::scene::Mesh take() { return std::move(mesh_); }

 private:
  /// One layer of the shell: where along the axis, and what becomes of the section there.
  struct Layer {
    double at;
    Point2 scale{1.0, 1.0}, shift{};
  };
  void draw(const Section& section, Axis axis, const std::vector<Layer>& layers);
  void add_quad(std::array<std::uint32_t, 4> vertices, bool reversed);
  int cells_in(Range range) const;

  double cell_;
  radiometry::scene::Mesh mesh_;
  std::uint32_t group_ = 0, material_ = 0;
};

/// Rounded to whole micrometres. Halves, which the noise of the last bit would send up or down, go up; -0 becomes 0.
double to_micrometres(double x);

}  // namespace apps::scene
