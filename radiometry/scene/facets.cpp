// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/facets.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <sstream>
#include <vector>

#include "mtf/error.h"
#include "mtf/math/word_hash.h"
#include "radiometry/scene/vectors.h"

namespace radiometry::scene {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// One polygon of a mesh: its mean plane, its diameter, and triangles that cover it.

struct PolygonPlane {
  Vector normal{};  ///< of length 1; 0 where there is no area
  double area_m2 = 0.0;
  double diameter_m = 0.0;   ///< diagonal of the box around it
  double deviation_m = 0.0;  ///< largest distance of a corner from the plane through the mean of the corners
};

/// Twice the signed area of the triangle, seen against the normal.
double turn(const Point& a, const Point& b, const Point& c, const Vector& normal) {
  return dot(normal, cross(b - a, c - a));
}

bool inside(const Point& p, const Point& a, const Point& b, const Point& c, const Vector& normal) {
  return turn(a, b, p, normal) >= 0.0 && turn(b, c, p, normal) >= 0.0 && turn(c, a, p, normal) >= 0.0;
}

/// Newell's plane. `corners` index `vertices`.
PolygonPlane plane_of(std::span<const Point> vertices, std::span<const std::uint32_t> corners) {
  // Differences from the first corner keep the digits of a small face that is far from the origin.
  const Point& base = vertices[corners[0]];
  Vector twice_area{}, low{}, high{}, mean{};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector a = vertices[corners[i]] - base;
    const Vector b = vertices[corners[(i + 1) % corners.size()]] - base;
    twice_area = twice_area + cross(a, b);
    mean = mean + (1.0 / static_cast<double>(corners.size())) * a;
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], a[k]), high[k] = std::max(high[k], a[k]);
  }
  PolygonPlane plane{.area_m2 = 0.5 * length(twice_area), .diameter_m = length(high - low)};
  if (plane.area_m2 == 0.0) return plane;
  plane.normal = (0.5 / plane.area_m2) * twice_area;
  for (const std::uint32_t corner : corners)
    plane.deviation_m = std::max(plane.deviation_m, std::abs(dot(plane.normal, vertices[corner] - base - mean)));
  return plane;
}

/// Appends triangles that cover the polygon, by cutting ears (Meisters, "Polygons have ears", Am. Math. Mon. 82, 1975);
/// concave polygons too. Of one that crosses itself the triangles still use all corners, in the order of the polygon.
void append_triangles(std::span<const Point> vertices, std::span<const std::uint32_t> corners, const Vector& normal,
                      std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> rest(corners.begin(), corners.end());
  while (rest.size() > 3) {
    const std::size_t n = rest.size();
    // The ear with the largest area, relative to its longest side, gives the best triangles; where rounding or a
    // polygon that crosses itself leaves no ear, the corner that is nearest to one is cut.
    std::size_t best = 0;
    double best_quality = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t before = (i + n - 1) % n, after = (i + 1) % n;
      const Point &a = vertices[rest[before]], &b = vertices[rest[i]], &c = vertices[rest[after]];
      const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
      double quality = turn(a, b, c, normal) / longest;
      if (quality <= best_quality) continue;
      const bool ear = quality > 0.0 && std::none_of(rest.begin(), rest.end(), [&](std::uint32_t other) {
                         return other != rest[before] && other != rest[i] && other != rest[after] &&
                                inside(vertices[other], a, b, c, normal);
                       });
      if (!ear) quality -= 4.0;  // below any ear's
      if (quality > best_quality) best = i, best_quality = quality;
    }
    triangles.push_back({rest[(best + n - 1) % n], rest[best], rest[(best + 1) % n]});
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(best));
  }
  triangles.push_back({rest[0], rest[1], rest[2]});
}

// Faces of a mesh joined into shells, with one winding in each.

/// Polygons over shared vertices; face i has the corners [first[i], first[i + 1]).
struct Polygons {
  std::vector<std::uint32_t> corners;
  std::vector<std::uint64_t> first{0};

  void add(std::span<const std::uint32_t> face) {
    corners.insert(corners.end(), face.begin(), face.end());
    first.push_back(corners.size());
  }
  std::size_t size() const { return first.size() - 1; }
  std::span<const std::uint32_t> operator[](std::size_t i) const {
    return std::span(corners).subspan(first[i], first[i + 1] - first[i]);
  }
};

struct FaceShells {
  std::vector<std::uint32_t> shell_of;  ///< of each face
  std::vector<char> turn;               ///< of each face: its corners have to be reversed
  std::vector<char> closed{};           ///< of each shell
  std::vector<char> outward{};          ///< of each shell: closed, and its normals point out
  std::uint64_t one_sided = 0;          ///< shells that no winding suits
};

/// An edge as one face runs through it.
struct EdgeUse {
  std::uint64_t edge;  ///< smaller vertex in the upper half, larger one in the lower
  std::uint32_t face;
  bool forward;  ///< from the smaller vertex to the larger one
};

std::vector<EdgeUse> edge_uses(const Polygons& faces) {
  std::vector<EdgeUse> uses;
  uses.reserve(faces.corners.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::uint64_t a = face[i], b = face[(i + 1) % face.size()];
      uses.push_back({std::min(a, b) << 32 | std::max(a, b), static_cast<std::uint32_t>(f), a < b});
    }
  }
  std::sort(uses.begin(), uses.end(),
            [](const EdgeUse& a, const EdgeUse& b) { return a.edge != b.edge ? a.edge < b.edge : a.face < b.face; });
  return uses;
}

/// Calls `work` with the uses of one edge after the other.
template <class Work>
void for_each_edge(std::span<const EdgeUse> uses, const Work& work) {
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin + 1;
    while (end < uses.size() && uses[end].edge == uses[begin].edge) ++end;
    work(uses.subspan(begin, end - begin));
    begin = end;
  }
}

/// Two faces that share an edge, and whether one of them has to be turned to suit the other.
struct Joint {
  std::uint32_t face, other;
  bool turned;
};

/// Joints of each face: face i has [first[i], first[i + 1]).
struct Joints {
  std::vector<Joint> list;
  std::vector<std::size_t> first;
};

Joints joints_of(std::span<const EdgeUse> uses, std::size_t faces) {
  Joints joints;
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 2 || edge[0].face == edge[1].face) return;
    const bool turned = edge[0].forward == edge[1].forward;
    joints.list.push_back({edge[0].face, edge[1].face, turned});
    joints.list.push_back({edge[1].face, edge[0].face, turned});
  });
  std::sort(joints.list.begin(), joints.list.end(),
            [](const Joint& a, const Joint& b) { return a.face != b.face ? a.face < b.face : a.other < b.other; });
  joints.first.assign(faces + 1, 0);
  for (const Joint& joint : joints.list) ++joints.first[joint.face + 1];
  for (std::size_t f = 0; f < faces; ++f) joints.first[f + 1] += joints.first[f];
  return joints;
}

/// Six times the volume between the face and `middle`, positive where the face is seen from outside.
double six_volumes(std::span<const std::uint32_t> face, std::span<const Point> vertices, const Point& middle) {
  double sum = 0.0;
  const Vector a = vertices[face[0]] - middle;
  for (std::size_t i = 1; i + 1 < face.size(); ++i)
    sum += dot(a, cross(vertices[face[i]] - middle, vertices[face[i + 1]] - middle));
  return sum;
}

FaceShells shells_of(const Polygons& faces, std::span<const Point> vertices, Winding winding) {
  const std::vector<EdgeUse> uses = edge_uses(faces);
  const Joints joints = joints_of(uses, faces.size());
  FaceShells shells{.shell_of = std::vector<std::uint32_t>(faces.size(), kNone),
                    .turn = std::vector<char>(faces.size(), 0)};
  std::vector<std::vector<std::uint32_t>> members;
  for (std::uint32_t seed = 0; seed < faces.size(); ++seed) {
    if (shells.shell_of[seed] != kNone) continue;
    const auto shell = static_cast<std::uint32_t>(members.size());
    std::vector<std::uint32_t> queue{seed};
    shells.shell_of[seed] = shell;
    bool consistent = true;
    for (std::size_t at = 0; at < queue.size(); ++at) {
      const std::uint32_t face = queue[at];
      for (std::size_t j = joints.first[face]; j < joints.first[face + 1]; ++j) {
        const std::uint32_t other = joints.list[j].other;
        const auto turn = static_cast<char>(shells.turn[face] ^ static_cast<char>(joints.list[j].turned));
        if (shells.shell_of[other] == kNone) {
          shells.shell_of[other] = shell;
          shells.turn[other] = turn;
          queue.push_back(other);
        } else if (shells.turn[other] != turn) {
          consistent = false;
        }
      }
    }
    const auto turned = std::count_if(queue.begin(), queue.end(), [&](std::uint32_t f) { return shells.turn[f] != 0; });
    if (2 * static_cast<std::size_t>(turned) > queue.size())
      for (const std::uint32_t f : queue) shells.turn[f] ^= 1;
    shells.closed.push_back(static_cast<char>(consistent));
    shells.one_sided += consistent ? 0 : 1;
    members.push_back(std::move(queue));
  }

  // Of one edge: times that each shell runs through it forwards, less backwards.
  std::vector<int> net(members.size(), 0);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    for (const EdgeUse& use : edge)
      net[shells.shell_of[use.face]] += use.forward != (shells.turn[use.face] != 0) ? 1 : -1;
    for (const EdgeUse& use : edge) {
      int& sum = net[shells.shell_of[use.face]];
      if (sum != 0) shells.closed[shells.shell_of[use.face]] = 0;
      sum = 0;
    }
  });

  for (std::size_t shell = 0; shell < members.size(); ++shell) {
    double volumes = 0.0;
    if (shells.closed[shell] != 0) {
      const Point& middle = vertices[faces[members[shell].front()].front()];
      for (const std::uint32_t f : members[shell])
        volumes += (shells.turn[f] != 0 ? -1.0 : 1.0) * six_volumes(faces[f], vertices, middle);
      if (volumes < 0.0 && winding == Winding::outward) {
        volumes = -volumes;
        for (const std::uint32_t f : members[shell]) shells.turn[f] ^= 1;
      }
    }
    shells.outward.push_back(volumes > 0.0 ? 1 : 0);
  }
  return shells;
}

// A mesh without the faces that cannot be used, over vertices at different positions.

struct RepairedMesh {
  std::vector<Point> vertices;
  Polygons faces;
  std::vector<std::uint32_t> source;  ///< of each face: its number in the mesh
};

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

/// Fills the counts of the report that are of faces left out and of vertices, and the extent.
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
    faces.add(corners);
    source.push_back(f);
  }

  const std::vector<char> copy = repeated(faces);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (copy[f] != 0) {
      ++report.duplicate;
      continue;
    }
    repaired.faces.add(faces[f]);
    repaired.source.push_back(source[f]);
  }
  return repaired;
}

constexpr double kFlat = 1e-6, kLeastFlat = 1e-4;  // of the diameter
constexpr double kSingleRounding = 0x1p-23;        // of a coordinate
constexpr double kOddlyLarge_m = 1e3, kOddlySmall_m = 1e-2;

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
