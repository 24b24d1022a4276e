// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes as files of other programs: OBJ and PLY for MeshLab, Blender and most others, VTK for ParaView, which reads
// values of that format but not of PLY. Files appear whole or not at all.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

/// Wavefront OBJ: `g` and `usemtl` lines where group and material change, coordinates in metres that read back as the
/// same numbers. Throws UsageError when a name has a line break or a blank at its ends, which OBJ cannot hold.
void write_obj(const std::filesystem::path& file, const radiometry::scene::Mesh& mesh);

/// A named value of each vertex or of each face: "temperature".
struct MeshValues {
  std::string name;
  std::span<const float> values;
};

/// PLY, binary little endian: x, y, z as double, polygons with their group and material as numbers (the names stand in
/// comments), and the values as float properties of the same name. Throws UsageError when a name is not made of
/// letters, digits and `_`, or when there is not one value for each vertex or face.
void write_ply(const std::filesystem::path& file, const radiometry::scene::Mesh& mesh,
               const std::vector<MeshValues>& of_vertices = {}, const std::vector<MeshValues>& of_faces = {});

/// VTK's old format (DATASET POLYDATA, binary): polygons, their group and material as numbers, and the values as
/// scalars of points and cells. Throws as write_ply does.
void write_vtk(const std::filesystem::path& file, const radiometry::scene::Mesh& mesh,
               const std::vector<MeshValues>& of_vertices = {}, const std::vector<MeshValues>& of_faces = {});

}  // namespace apps::scene
