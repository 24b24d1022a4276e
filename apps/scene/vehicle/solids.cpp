// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/vehicle/solids.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace apps::scene {
namespace {

using radiometry::scene::Point;

double between(double from, double to, double part) { return from + (to - from) * part; }

// A grid of columns x rows cells, with its outline; `place` gives the point of a corner.
template <class Place>
Section grid_section(int columns, int rows, const Place& place) {
  Section section;
  const auto number = [rows](int i, int j) { return static_cast<std::uint32_t>(i * (rows + 1) + j); };
  for (int i = 0; i <= columns; ++i)
    for (int j = 0; j <= rows; ++j) section.points.push_back(place(i, j));
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j)
      section.quads.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)});
  std::vector<std::uint32_t>& outline = section.outlines.emplace_back();
  for (int i = 0; i < columns; ++i) outline.push_back(number(i, 0));
  for (int j = 0; j < rows; ++j) outline.push_back(number(columns, j));
  for (int i = columns; i > 0; --i) outline.push_back(number(i, rows));
  for (int j = rows; j > 0; --j) outline.push_back(number(0, j));
  return section;
}

Point2 on_circle(Point2 centre, double radius, double angle) {
  return {centre[0] + radius * std::cos(angle), centre[1] + radius * std::sin(angle)};
}

// Twice the area of a quad: positive where its corners run counter-clockwise.
double signed_area(const Section& section, const std::array<std::uint32_t, 4>& quad) {
  const Point2 &a = section.points[quad[0]], &b = section.points[quad[1]], &c = section.points[quad[2]],
               &d = section.points[quad[3]];
  return (c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0]);
}

// The axes of the section, so that they and the axis of drawing are right-handed, or left-handed along y.
Point placed(Axis axis, const Point2& p, double at) {
  if (axis == Axis::x) return {at, p[0], p[1]};
  if (axis == Axis::y) return {p[0], at, p[1]};
  return {p[0], p[1], at};
}

std::uint32_t number_of(std::vector<std::string>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  const auto number = static_cast<std::uint32_t>(found - names.begin());
  if (found == names.end()) names.emplace_back(name);
  return number;
}

/// `length` in cells of about `cell`: at least one.
int cell_count(double length, double cell) { return std::max(1, static_cast<int>(std::lround(length / cell))); }

}  // namespace

double to_micrometres(double x) { return std::floor(x * 1e6 + 0.5001) / 1e6 + 0.0; }

Section between_lines(const std::vector<std::array<double, 3>>& knots, double cell) {
  std::vector<std::array<double, 3>> columns{knots.front()};
  double height = 0.0;
  for (std::size_t k = 1; k < knots.size(); ++k) {
    const auto &a = knots[k - 1], &b = knots[k];
    const double length = std::max(std::hypot(b[0] - a[0], b[1] - a[1]), std::hypot(b[0] - a[0], b[2] - a[2]));
    const int cells = cell_count(length, cell);
    for (int i = 1; i <= cells; ++i) {
      const double part = static_cast<double>(i) / cells;
      columns.push_back({between(a[0], b[0], part), between(a[1], b[1], part), between(a[2], b[2], part)});
    }
    height = std::max(height, b[2] - b[1]);
  }
  const int rows = cell_count(height, cell);
  return grid_section(static_cast<int>(columns.size()) - 1, rows, [&](int i, int j) -> Point2 {
    const auto& column = columns[static_cast<std::size_t>(i)];
    return {column[0], between(column[1], column[2], static_cast<double>(j) / rows)};
  });
}

// The square [-1, 1]^2 becomes the disc ring by ring, with equal angles on its rim (Shirley and Chiu 1997).
Section disc(Point2 centre, double radius, double cell) {
  constexpr double quarter = std::numbers::pi / 4;
  const int cells = std::max(2, cell_count(2 * quarter * radius, cell));
  return grid_section(cells, cells, [&](int i, int j) -> Point2 {
    const double u = 2.0 * i / cells - 1.0, v = 2.0 * j / cells - 1.0;
    if (u == 0.0 && v == 0.0) return centre;
    const bool steep = std::abs(v) > std::abs(u);
    const double size = steep ? v : u, angle = steep ? quarter * (2.0 - u / v) : quarter * (v / u);
    return on_circle(centre, size * radius, angle);
  });
}

Section band(const std::vector<Point2>& inner, const std::vector<Point2>& outer, int layers) {
  Section section;
  const auto count = static_cast<std::uint32_t>(inner.size());
  for (int k = 0; k <= layers; ++k)
    for (std::uint32_t i = 0; i < count; ++i) {
      const double part = static_cast<double>(k) / layers;
      section.points.push_back({between(inner[i][0], outer[i][0], part), between(inner[i][1], outer[i][1], part)});
    }
  const auto last = count * static_cast<std::uint32_t>(layers);
  for (std::uint32_t base = 0; base < last; base += count)
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t next = (i + 1) % count;
      section.quads.push_back({base + i, base + count + i, base + count + next, base + next});
    }
  section.outlines.resize(2);
  for (std::uint32_t i = 0; i < count; ++i) {
    section.outlines[0].push_back(last + i);
    section.outlines[1].push_back(count - 1 - i);
  }
  return section;
}

Section ring(Point2 centre, double inner, double outer, double cell) {
  const int around = std::max(12, cell_count(2 * std::numbers::pi * outer, cell));
  std::vector<Point2> inside, outside;
  for (int i = 0; i < around; ++i) {
    const double angle = 2 * std::numbers::pi * i / around;
    inside.push_back(on_circle(centre, inner, angle));
    outside.push_back(on_circle(centre, outer, angle));
  }
  return band(inside, outside, cell_count(outer - inner, cell));
}

void SolidBuilder::set_group(std::string_view name) { group_ = number_of(mesh_.group_names, name); }
void SolidBuilder::set_material(std::string_view name) { material_ = number_of(mesh_.material_names, name); }

int SolidBuilder::cells_in(Range range) const { return cell_count(range.to - range.from, cell_); }

void SolidBuilder::draw(const Section& section, Axis axis, Range range) { draw(section, axis, range, cells_in(range)); }

void SolidBuilder::draw(const Section& section, Axis axis, Range range, int cells) {
  std::vector<Layer> layers;
  for (int k = 0; k <= cells; ++k) layers.push_back({between(range.from, range.to, static_cast<double>(k) / cells)});
  draw(section, axis, layers);
}

void SolidBuilder::box(Range x, Range y, Range z) {
  draw(between_lines({{x.from, z.from, z.to}, {x.to, z.from, z.to}}, cell_), Axis::y, y);
}

void SolidBuilder::tapered_box(Range x, Range z, Range y, Range end_x, Range end_z) {
  // The section is the unit square, so that a layer scales and shifts it to its extents.
  const int columns = cells_in(x), rows = cells_in(z), cells = cell_count(std::abs(y.to - y.from), cell_);
  const Section square = grid_section(columns, rows, [&](int i, int j) -> Point2 {
    return {static_cast<double>(i) / columns, static_cast<double>(j) / rows};
  });
  std::vector<Layer> layers;
  for (int k = 0; k <= cells; ++k) {
    const double part = static_cast<double>(k) / cells;
    const double left = between(x.from, end_x.from, part), low = between(z.from, end_z.from, part);
    layers.push_back({between(y.from, y.to, part),
                      {between(x.to, end_x.to, part) - left, between(z.to, end_z.to, part) - low},
                      {left, low}});
  }
  if (y.to < y.from) std::reverse(layers.begin(), layers.end());
  draw(square, Axis::y, layers);
}

void SolidBuilder::cylinder(Axis axis, Point2 centre, double radius, Range range) {
  draw(disc(centre, radius, cell_), axis, range);
}

void SolidBuilder::draw(const Section& section, Axis axis, const std::vector<Layer>& layers) {
  // Counter-clockwise seen against the axis: (x, z) with y is left-handed.
  const bool reversed = (signed_area(section, section.quads.front()) < 0.0) != (axis == Axis::y);
  std::vector<std::vector<std::uint32_t>> numbers(layers.size());  // of the points of the section in the mesh
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const Layer& layer = layers[k];
    numbers[k].resize(section.points.size());
    const auto add = [&](std::uint32_t i) {
      const Point2& p = section.points[i];
      numbers[k][i] = static_cast<std::uint32_t>(mesh_.vertices.size());
      const Point2 scaled{layer.shift[0] + layer.scale[0] * p[0], layer.shift[1] + layer.scale[1] * p[1]};
      Point point = placed(axis, scaled, layer.at);
      for (double& x : point) x = to_micrometres(x);
      mesh_.vertices.push_back(point);
    };
    if (k == 0 || k + 1 == layers.size())
      for (std::uint32_t i = 0; i < section.points.size(); ++i) add(i);
    else
      for (const std::vector<std::uint32_t>& outline : section.outlines)
        for (const std::uint32_t i : outline) add(i);
  }
  const std::vector<std::uint32_t>&bottom = numbers.front(), &top = numbers.back();
  for (const auto& [a, b, c, d] : section.quads) {
    add_quad({bottom[d], bottom[c], bottom[b], bottom[a]}, reversed);
    add_quad({top[a], top[b], top[c], top[d]}, reversed);
  }
  for (std::size_t k = 0; k + 1 < layers.size(); ++k)
    for (const std::vector<std::uint32_t>& outline : section.outlines)
      for (std::size_t i = 0; i < outline.size(); ++i) {
        const std::uint32_t from = outline[i], to = outline[(i + 1) % outline.size()];
        add_quad({numbers[k][from], numbers[k][to], numbers[k + 1][to], numbers[k + 1][from]}, reversed);
      }
}

void SolidBuilder::add_quad(std::array<std::uint32_t, 4> vertices, bool reversed) {
  if (reversed) std::ranges::reverse(vertices);
  mesh_.add_face(vertices, group_, material_);
}

}  // namespace apps::scene
