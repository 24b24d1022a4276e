// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/repair/repaired_mesh.h"

#include <algorithm>
#include <numeric>

#include "mtf/error.h"
#include "mtf/math/word_hash.h"
#include "radiometry/scene/repair/facet_polygon.h"

namespace radiometry::scene {
namespace {

constexpr std::size_t kMostCorners = 2000;
constexpr double kLargestExtent_m = 1e9;
constexpr double kLeastArea = 1e-12;  // of the square of the diameter

void check_arrays(const PlacedMesh& placed) {
  const auto refuse = [&](const std::string& what) {
    throw mtf::UsageError("mesh `" + placed.name + "`: " + what + ": the program that fills the mesh is at fault.");
  };
  if (placed.mesh == nullptr) refuse("there is none");
  const Mesh& mesh = *placed.mesh;
  if (mesh.material.size() != mesh.faces()) refuse("there are not as many materials as faces");
  if (mesh.vertices.size() >= kNone || mesh.faces() >= kNone)
    refuse("there are more than 4294967294 vertices or faces");
  if (mesh.faces() == 0) return;
  if (mesh.first.size() != mesh.faces() + 1) refuse("the starts of faces are not one more than the faces");
  if (!std::is_sorted(mesh.first.begin(), mesh.first.end()) || mesh.first.back() > mesh.corners.size())
    refuse("the starts of faces do not rise within the list of corners");
  for (std::size_t f = 0; f < mesh.faces(); ++f)
    if (mesh.first[f + 1] - mesh.first[f] > kMostCorners)
      throw mtf::UsageError("mesh `" + placed.name + "`: face " + std::to_string(f) + " has " +
                            std::to_string(mesh.first[f + 1] - mesh.first[f]) + " corners, at most " +
                            std::to_string(kMostCorners) + " are possible: divide it in the program that made it.");
}

/// Faces whose corners are vertices with finite coordinates.
std::vector<std::uint32_t> readable_faces(const Mesh& mesh, MeshReport& report) {
  std::vector<std::uint32_t> faces;
  for (std::size_t f = 0; f < mesh.faces(); ++f) {
    const auto corners = mesh.corners_of(f);
    if (std::any_of(corners.begin(), corners.end(), [&](std::uint32_t c) { return c >= mesh.vertices.size(); }))
      ++report.bad_index;
    else if (!std::all_of(corners.begin(), corners.end(), [&](std::uint32_t c) { return finite(mesh.vertices[c]); }))
      ++report.not_finite;
    else
      faces.push_back(static_cast<std::uint32_t>(f));
  }
  return faces;
}

/// The new number of each vertex that `faces` use; vertices at equal positions get the same one, in the order of their
/// first use in the file.
std::vector<std::uint32_t> weld(const Mesh& mesh, std::span<const std::uint32_t> faces, std::vector<Point>& welded,
                                MeshReport& report) {
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNone), used;
  for (const std::uint32_t f : faces)
    for (const std::uint32_t corner : mesh.corners_of(f)) number[corner] = 0;
  for (std::uint32_t v = 0; v < number.size(); ++v)
    if (number[v] == 0) used.push_back(v);
  std::vector<std::uint32_t> sorted = used;
  std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
    return mesh.vertices[a] != mesh.vertices[b] ? mesh.vertices[a] < mesh.vertices[b] : a < b;
  });
  // The first vertex of each run stands for the run.
  std::vector<std::uint32_t> same_as(mesh.vertices.size());
  for (std::size_t i = 0; i < sorted.size(); ++i)
    same_as[sorted[i]] =
        i > 0 && mesh.vertices[sorted[i]] == mesh.vertices[sorted[i - 1]] ? same_as[sorted[i - 1]] : sorted[i];
  for (const std::uint32_t v : used) {
    if (same_as[v] == v) {
      number[v] = static_cast<std::uint32_t>(welded.size());
      welded.push_back(mesh.vertices[v]);
    } else {
      number[v] = number[same_as[v]];
      ++report.welded;
    }
  }
  return number;
}

bool has_area(std::span<const Point> vertices, std::span<const std::uint32_t> corners) {
  const PolygonPlane plane = plane_of(vertices, corners);
  double largest = 0.0;
  for (const double x : vertices[corners[0]]) largest = std::max(largest, std::abs(x));
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * largest;
  return plane.area_m2 > plane.diameter_m * std::max(kLeastArea * plane.diameter_m, rounding);
}

/// Of each face whether an earlier one has the same corners, in whatever order.
std::vector<char> repeated(const Polygons& faces) {
  Polygons sorted = faces;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    const auto begin = sorted.corners.begin() + static_cast<std::ptrdiff_t>(sorted.first[f]);
    const auto end = sorted.corners.begin() + static_cast<std::ptrdiff_t>(sorted.first[f + 1]);
    std::sort(begin, end);
    keys.emplace_back(std::accumulate(begin, end, mtf::kWordHashStart, mtf::mixed), f);
  }
  std::sort(keys.begin(), keys.end());
  const auto same = [&](std::uint32_t a, std::uint32_t b) { return std::ranges::equal(sorted[a], sorted[b]); };
  std::vector<char> copy(faces.size(), 0);
  for (std::size_t i = 1; i < keys.size(); ++i)
    copy[keys[i].second] = keys[i].first == keys[i - 1].first && same(keys[i].second, keys[i - 1].second) ? 1 : 0;
  return copy;
}

void measure_extent(std::span<const Point> vertices, const std::string& name, MeshReport& report) {
  for (std::size_t k = 0; k < 3 && !vertices.empty(); ++k) {
    const auto [low, high] = std::minmax_element(vertices.begin(), vertices.end(),
                                                 [k](const Point& a, const Point& b) { return a[k] < b[k]; });
    report.extent_m[k] = (*high)[k] - (*low)[k];
    if (!(report.extent_m[k] <= kLargestExtent_m))
      throw mtf::UsageError("mesh `" + name + "`: its coordinates spread over more than 1e9 m along " + "xyz"[k] +
                            ": mend the file, or state its `unit`.");
  }
}

}  // namespace

RepairedMesh repaired_mesh(const PlacedMesh& placed, MeshReport& report) {
  check_arrays(placed);
  const Mesh& mesh = *placed.mesh;
  report.name = placed.name;
  report.faces = mesh.faces();
  const std::vector<std::uint32_t> readable = readable_faces(mesh, report);
  RepairedMesh repaired;
  const std::vector<std::uint32_t> number = weld(mesh, readable, repaired.vertices, report);
  report.vertices = repaired.vertices.size();
  measure_extent(repaired.vertices, placed.name, report);

  Polygons faces;
  std::vector<std::uint32_t> source, corners;
  for (const std::uint32_t f : readable) {
    corners.clear();
    for (const std::uint32_t corner : mesh.corners_of(f))
      if (corners.empty() || corners.back() != number[corner]) corners.push_back(number[corner]);
    while (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
    if (corners.size() < 3 || !has_area(repaired.vertices, corners)) {
      ++report.degenerate;
      continue;
    }
    faces.corners.insert(faces.corners.end(), corners.begin(), corners.end());
    faces.first.push_back(faces.corners.size());
    source.push_back(f);
  }

  const std::vector<char> copy = repeated(faces);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (copy[f] != 0) {
      ++report.duplicate;
      continue;
    }
    repaired.faces.corners.insert(repaired.faces.corners.end(), faces[f].begin(), faces[f].end());
    repaired.faces.first.push_back(repaired.faces.corners.size());
    repaired.source.push_back(source[f]);
  }
  return repaired;
}

}  // namespace radiometry::scene
