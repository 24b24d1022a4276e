// SPDX-License-Identifier: Apache-2.0
#pragma once

// Facets: the planar surfaces that have one temperature each.
//
// A face of a mesh that is flat stays one facet, whatever its number of corners; another one is divided into triangles,
// each of them a facet. A face is flat when no corner is farther from its mean plane than 1e-6 of the face's diameter,
// or than the rounding of coordinates in single precision (2^-23 of the largest coordinate; most files hold such) where
// that is more, yet at most 1e-4 of the diameter. The normal is Newell's: half the sum of the cross products of
// successive corners, whose length is the area.
//
// Meshes are repaired first, and every repair is counted under the name of the mesh:
//   faces with an index out of range, a coordinate that is not finite, or no area, and second copies of a face, are
//   left out vertices at equal positions become one faces joined by edges that exactly two faces share form a shell;
//   within a shell the winding is made the same, that of
//     most of its faces
//   a shell is closed when each of its edges is run through as often forwards as backwards. Normals of closed shells
//   point
//     out of the volume, or stay as given (Winding)
//
// Coordinates are those of the scene, in double precision, so that area and normal are as exact far from the origin as
// the coordinates allow. Rays are traced in single precision about `middle`.

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "radiometry/scene/mesh.h"
#include "radiometry/scene/vectors.h"

namespace radiometry::scene {

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

enum class Winding {
  outward,  ///< normals of closed shells point out of the volume
  as_given  ///< the winding of most faces of a shell is kept: for rooms, whose facets face inwards
};

/// A mesh as it enters a scene: in metres, in place. The mesh is only read while facets are made.
struct PlacedMesh {
  std::string name;  ///< as messages say it
  const Mesh* mesh = nullptr;
  Winding winding = Winding::outward;
};

struct Facet {
  Point centre{};  ///< of area
  Vector normal;
  double area_m2 = 0.0;
  std::uint32_t mesh = 0;      ///< index of the PlacedMesh
  std::uint32_t face = 0;      ///< of that mesh; facets of a face that is not flat share it
  std::uint32_t group = 0;     ///< an index into the mesh's group_names
  std::uint32_t material = 0;  ///< an index into the mesh's material_names
  std::uint32_t shell = 0;     ///< an index into Facets::shells
};

struct Shell {
  std::uint32_t mesh = 0;
  std::uint64_t facets = 0;
  bool closed = false;
  bool outward = false;  ///< closed, and its normals point out: a ray that meets the back of a facet is inside
};

/// What was found and done in a mesh; numbers of faces unless said otherwise.
struct MeshReport {
  std::string name;
  std::uint64_t faces = 0;           ///< of the file
  std::uint64_t facets = 0;          ///< made of them
  std::uint64_t vertices = 0;        ///< in use, after welding
  std::uint64_t welded = 0;          ///< vertices in use that were at the position of another one
  std::uint64_t bad_index = 0;       ///< left out: a corner names no vertex
  std::uint64_t not_finite = 0;      ///< left out: a coordinate is NaN or infinite
  std::uint64_t degenerate = 0;      ///< left out: fewer than three different corners, or no area
  std::uint64_t duplicate = 0;       ///< left out: the same corners as another face
  std::uint64_t not_flat = 0;        ///< divided into triangles
  std::uint64_t turned = 0;          ///< winding reversed
  std::uint64_t shells = 0;          ///< shells
  std::uint64_t open_shells = 0;     ///< shells with a rim
  std::uint64_t with_hole = 0;       ///< open shells whose area vectors add up to less than half their area
  std::uint64_t one_sided = 0;       ///< open shells with no consistent winding, as a Moebius strip
  std::array<double, 3> extent_m{};  ///< along x, y and z
};

struct Facets {
  std::vector<Facet> facet;
  std::vector<Point> vertices;                          ///< welded; of one mesh after the other
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from the front
  std::vector<std::uint64_t> first;                     ///< facet i has the triangles [first[i], first[i + 1])
  std::vector<std::uint32_t> facet_of;                  ///< of each triangle
  std::vector<Shell> shells;
  Point middle{};                     ///< of the box around everything
  double half_extent_m = 0.0;         ///< largest distance from `middle` along an axis
  double lowest_m = 0.0;              ///< height of the lowest vertex
  std::vector<MeshReport> report;     ///< one for each mesh
  std::vector<std::string> warnings;  ///< whole sentences with the name of the mesh

  std::size_t size() const { return facet.size(); }
};

/// Throws mtf::UsageError that names the mesh when nothing is left of all meshes, when arrays of a mesh do not fit each
/// other, when a face has more than 2000 corners, or when coordinates spread over more than 1e9 m. Warns of
/// left-out faces, of shells with a hole, and of extents above 1 km or below 1 cm, which a wrong unit makes.
Facets facets_of(std::span<const PlacedMesh> meshes);

/// A side of a facet that takes in and gives off radiation: the front, where the normal points, or the back of a sheet.
struct Side {
  std::uint32_t facet = 0;
  bool back = false;
};
constexpr bool operator==(Side a, Side b) { return a.facet == b.facet && a.back == b.back; }

/// Sides of all facets in one row: front of facet 0, its back, front of facet 1, ...
constexpr std::size_t index(Side side) { return 2 * std::size_t{side.facet} + (side.back ? 1 : 0); }

/// Sets of sides that share one answer: single sides, or the classes of classes.h. Set i has the sides
/// [first[i], first[i + 1]).
struct Receivers {
  std::vector<Side> sides;
  std::vector<std::uint64_t> first{0};

  std::size_t size() const { return first.size() - 1; }
  std::span<const Side> operator[](std::size_t i) const {
    return std::span(sides).subspan(first[i], first[i + 1] - first[i]);
  }
};

/// Each side by itself; without `sides`, the front of every facet.
Receivers single_sides(const Facets& facets);
Receivers single_sides(std::vector<Side> sides);
/// Side i belongs to set `set_of[i]` of `sets`.
Receivers sets_of_sides(std::span<const Side> sides, std::span<const std::uint32_t> set_of, std::size_t sets);

/// The area of each receiver, m^2.
std::vector<double> areas_m2(const Facets& facets, const Receivers& receivers);

}  // namespace radiometry::scene
