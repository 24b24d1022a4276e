// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/facets.h"

#include <algorithm>
#include <sstream>

#include "mtf/error.h"
#include "radiometry/scene/repair/facet_polygon.h"
#include "radiometry/scene/repair/repaired_mesh.h"
#include "radiometry/scene/repair/shells.h"

namespace radiometry::scene {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr double kFlat = 1e-6, kLeastFlat = 1e-4;  // of the diameter
constexpr double kSingleRounding = 0x1p-23;        // of a coordinate
constexpr double kLargestExtent_m = 1e9, kOddlyLarge_m = 1e3, kOddlySmall_m = 1e-2;

bool is_flat(const PolygonPlane& plane, std::span<const Point> vertices, std::span<const std::uint32_t> corners) {
  double largest = 0.0;
  for (const std::uint32_t corner : corners)
    for (const double x : vertices[corner]) largest = std::max(largest, std::abs(x));
  return plane.deviation_m <=
         std::clamp(kSingleRounding * largest, kFlat * plane.diameter_m, kLeastFlat * plane.diameter_m);
}

/// Twice the area, along the normal.
Vector twice_area(std::span<const Point> vertices, const Triangle& t) {
  return cross(vertices[t[1]] - vertices[t[0]], vertices[t[2]] - vertices[t[0]]);
}

/// Adds `facet` with its triangles; area and centre are theirs. Nothing is added where these have no area.
void append_facet(Facets& facets, Facet facet, std::span<const Triangle> triangles) {
  const Point& base = facets.vertices[triangles[0][0]];
  Vector moment{};
  double twice = 0.0;
  for (const Triangle& t : triangles) {
    // Along the normal of the whole: a triangle that an outline which crosses itself turns over counts as negative.
    const double part = dot(facet.normal, twice_area(facets.vertices, t));
    twice += part;
    for (const std::uint32_t corner : t) moment = moment + (part / 3.0) * (facets.vertices[corner] - base);
  }
  if (!(twice > 0.0)) return;
  facet.area_m2 = 0.5 * twice;
  facet.centre = base + (1.0 / twice) * moment;
  facets.triangles.insert(facets.triangles.end(), triangles.begin(), triangles.end());
  facets.facet_of.resize(facets.triangles.size(), static_cast<std::uint32_t>(facets.facet.size()));
  facets.first.push_back(facets.triangles.size());
  facets.facet.push_back(facet);
  ++facets.shells[facet.shell].facets;
}

void append_mesh(Facets& facets, const PlacedMesh& placed, std::uint32_t mesh, MeshReport& report) {
  const RepairedMesh repaired = repaired_mesh(placed, report);
  const FaceShells shells = shells_of(repaired.faces, repaired.vertices, placed.winding);
  const auto first_vertex = static_cast<std::uint32_t>(facets.vertices.size());
  const auto first_shell = static_cast<std::uint32_t>(facets.shells.size());
  const std::size_t first_facet = facets.size();
  for (const std::string& note : placed.mesh->notes)
    facets.warnings.push_back("mesh `" + placed.name + "`: " + note + ".");
  facets.vertices.insert(facets.vertices.end(), repaired.vertices.begin(), repaired.vertices.end());
  for (std::size_t i = 0; i < shells.closed.size(); ++i)
    facets.shells.push_back({mesh, 0, shells.closed[i] != 0, shells.outward[i] != 0});

  std::vector<std::uint32_t> corners;
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < repaired.faces.size(); ++f) {
    corners.assign(repaired.faces[f].begin(), repaired.faces[f].end());
    if (shells.turn[f] != 0) std::reverse(corners.begin(), corners.end());
    for (std::uint32_t& corner : corners) corner += first_vertex;
    const PolygonPlane plane = plane_of(facets.vertices, corners);
    triangles.clear();
    append_triangles(facets.vertices, corners, plane.normal, triangles);
    Facet facet{.normal = plane.normal,
                .area_m2 = 0.0,
                .mesh = mesh,
                .face = repaired.source[f],
                .group = placed.mesh->group[repaired.source[f]],
                .material = placed.mesh->material[repaired.source[f]],
                .shell = first_shell + shells.shell_of[f]};
    report.turned += shells.turn[f] != 0 ? 1 : 0;
    if (is_flat(plane, facets.vertices, corners)) {
      append_facet(facets, facet, triangles);
      continue;
    }
    ++report.not_flat;
    for (const Triangle& triangle : triangles) {
      const Vector area = twice_area(facets.vertices, triangle);
      if (length(area) == 0.0) continue;
      facet.normal = (1.0 / length(area)) * area;
      append_facet(facets, facet, std::span(&triangle, 1));
    }
  }
  report.facets = facets.size() - first_facet;
  report.shells = shells.closed.size();
  report.open_shells = static_cast<std::uint64_t>(std::count(shells.closed.begin(), shells.closed.end(), 0));
  report.one_sided = shells.one_sided;

  std::vector<Vector> vector_area(shells.closed.size());
  std::vector<double> area(shells.closed.size(), 0.0);
  for (std::size_t i = first_facet; i < facets.size(); ++i) {
    const Facet& facet = facets.facet[i];
    const std::size_t shell = facet.shell - first_shell;
    vector_area[shell] = vector_area[shell] + facet.area_m2 * facet.normal;
    area[shell] += facet.area_m2;
  }
  for (std::size_t shell = 0; shell < area.size(); ++shell)
    if (shells.closed[shell] == 0 && length(vector_area[shell]) < 0.5 * area[shell]) ++report.with_hole;
}

void add_warnings(const MeshReport& report, std::vector<std::string>& warnings) {
  const auto warn = [&](const std::string& text) { warnings.push_back("mesh `" + report.name + "`: " + text); };
  const std::uint64_t left_out = report.bad_index + report.not_finite + report.degenerate + report.duplicate;
  if (left_out > 0) {
    std::ostringstream text;
    text << left_out << " of " << report.faces << " faces were left out (a corner names no vertex: " << report.bad_index
         << ", a coordinate is not finite: " << report.not_finite
         << ", no area or fewer than three corners: " << report.degenerate
         << ", second copy of a face: " << report.duplicate << ").";
    warn(text.str());
  }
  if (report.facets == 0) warn("no face is left of it.");
  if (report.with_hole + report.one_sided > 0) {
    std::ostringstream text;
    text << report.with_hole << " of " << report.shells << " shells have a hole, " << report.one_sided
         << " no consistent winding; which side of such a shell is its front is said by the winding of most of its "
            "faces.";
    warn(text.str());
  }
  const double extent = *std::max_element(report.extent_m.begin(), report.extent_m.end());
  if (extent > kOddlyLarge_m || (extent < kOddlySmall_m && report.facets > 0)) {
    std::ostringstream text;
    text << "it is " << extent << " m long. If that is wrong, state the `unit` of its coordinates.";
    warn(text.str());
  }
}

/// The middle and half the extent of the box around all vertices.
void measure_box(Facets& facets) {
  Point low = facets.vertices[0], high = low;
  for (const Point& p : facets.vertices)
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
  const Vector extent = high - low;
  facets.half_extent_m = 0.5 * *std::max_element(extent.begin(), extent.end());
  facets.middle = low + 0.5 * extent;
  facets.lowest_m = low[2];
  if (!(facets.half_extent_m <= kLargestExtent_m))
    throw mtf::UsageError("the meshes of the scene are more than 1e9 m apart: place them closer to each other.");
}

}  // namespace

Facets facets_of(std::span<const PlacedMesh> meshes) {
  Facets facets;
  facets.first.push_back(0);
  for (std::uint32_t i = 0; i < meshes.size(); ++i) {
    append_mesh(facets, meshes[i], i, facets.report.emplace_back());
    add_warnings(facets.report.back(), facets.warnings);
  }
  if (facets.size() == 0) {
    std::string message = "the meshes of the scene have no face that can be used";
    for (const std::string& warning : facets.warnings) message += "; " + warning;
    throw mtf::UsageError(message);
  }
  measure_box(facets);
  return facets;
}

Receivers single_sides(std::vector<Side> sides) {
  Receivers receivers{.sides = std::move(sides)};
  for (std::size_t i = 1; i <= receivers.sides.size(); ++i) receivers.first.push_back(i);
  return receivers;
}

Receivers single_sides(const Facets& facets) {
  std::vector<Side> sides(facets.size());
  for (std::uint32_t f = 0; f < sides.size(); ++f) sides[f].facet = f;
  return single_sides(std::move(sides));
}

Receivers sets_of_sides(std::span<const Side> sides, std::span<const std::uint32_t> set_of, std::size_t sets) {
  if (set_of.size() != sides.size())
    throw mtf::UsageError("sets_of_sides: there are " + std::to_string(sides.size()) + " sides and the sets of " +
                          std::to_string(set_of.size()));
  Receivers receivers{.sides = std::vector<Side>(sides.size()), .first = std::vector<std::uint64_t>(sets + 1, 0)};
  for (const std::uint32_t set : set_of) {
    if (set >= sets)
      throw mtf::UsageError("sets_of_sides: a side belongs to set " + std::to_string(set) + " of " +
                            std::to_string(sets));
    ++receivers.first[set + 1];
  }
  for (std::size_t i = 0; i < sets; ++i) receivers.first[i + 1] += receivers.first[i];
  std::vector<std::uint64_t> next(receivers.first.begin(), receivers.first.end() - 1);
  for (std::size_t s = 0; s < sides.size(); ++s) receivers.sides[next[set_of[s]]++] = sides[s];
  return receivers;
}

std::vector<double> areas_m2(const Facets& facets, const Receivers& receivers) {
  std::vector<double> areas(receivers.size(), 0.0);
  for (std::size_t i = 0; i < areas.size(); ++i)
    for (const Side& side : receivers[i]) areas[i] += facets.facet[side.facet].area_m2;
  return areas;
}

}  // namespace radiometry::scene
