// SPDX-License-Identifier: Apache-2.0
// Meshes and tables that are written: read back by the importer and byte by byte.
#include <gtest/gtest.h>

#include <cstring>

#include "apps/scene/import/import_mesh.h"
#include "apps/scene/outputs/mesh_files.h"
#include "apps/scene/outputs/npy_file.h"
#include "mesh_samples.h"
#include "mtf/error.h"

namespace {

using namespace scene_test;
using apps::scene::import_mesh;
using apps::scene::write_obj;
using apps::scene::write_ply;
using apps::scene::write_vtk;
using radiometry::scene::Mesh;

Mesh small_mesh() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1.0 / 3.0, 0}, {0, 1, 1e-7}, {0.1, 0.2, -5e12}},
          .corners = {0, 1, 2, 3, 1, 2, 4, 0, 1, 4},
          .first = {0, 4, 7, 10},
          .group = {0, 1, 1},
          .material = {1, 1, 0},
          .group_names = {"hull", "gun barrel"},
          .material_names = {"rubber", "armour"}};
}

void expect_same_faces(const Mesh& a, const Mesh& b) {
  ASSERT_EQ(a.first, b.first);
  for (std::size_t i = 0; i < a.corners.size(); ++i) EXPECT_EQ(a.vertices[a.corners[i]], b.vertices[b.corners[i]]);
}

TEST(MeshFiles, ObjComesBackWithEveryDigit) {
  const Folder folder;
  write_obj(folder / "a.obj", small_mesh());
  const Mesh read = import_mesh(folder / "a.obj", 1.0);
  expect_same_faces(read, small_mesh());
  for (std::size_t face = 0; face < read.faces(); ++face) {
    EXPECT_EQ(read.group_names[read.group[face]], small_mesh().group_names[small_mesh().group[face]]);
    EXPECT_EQ(read.material_names[read.material[face]], small_mesh().material_names[small_mesh().material[face]]);
  }
}

TEST(MeshFiles, PlyComesBackWithEveryDigit) {
  const Folder folder;
  write_ply(folder / "a.ply", small_mesh());
  expect_same_faces(import_mesh(folder / "a.ply", 1.0), small_mesh());
}

TEST(MeshFiles, PlyHasValuesOfVerticesAndFaces) {
  const Folder folder;
  const Mesh mesh = small_mesh();
  const std::vector<float> vertices{280, 281, 282, 283, 284}, faces{300, 301, 302};
  write_ply(folder / "a.ply", mesh, {{"temperature", vertices}}, {{"temperature", faces}, {"flux", faces}});
  const std::string content = text_of(folder / "a.ply");
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment written by mtfkit; metres, x east, y north, z up\n"
      "comment group 0 hull\ncomment group 1 gun barrel\ncomment material 0 rubber\ncomment material 1 armour\n"
      "element vertex 5\nproperty double x\nproperty double y\nproperty double z\nproperty float temperature\n"
      "element face 3\nproperty list uchar int vertex_indices\nproperty int group\nproperty int material\n"
      "property float temperature\nproperty float flux\nend_header\n";
  ASSERT_EQ(content.substr(0, header.size()), header);
  std::string expected;
  for (std::size_t i = 0; i < 5; ++i) {
    for (const double x : mesh.vertices[i]) expected += bytes(x);
    expected += bytes(vertices[i]);
  }
  for (std::size_t face = 0; face < 3; ++face) {
    const std::uint64_t from = mesh.first[face], to = mesh.first[face + 1];
    expected += bytes(static_cast<std::uint8_t>(to - from));
    for (std::uint64_t k = from; k < to; ++k) expected += bytes(mesh.corners[k]);
    expected += bytes(mesh.group[face]) + bytes(mesh.material[face]) + bytes(faces[face]) + bytes(faces[face]);
  }
  EXPECT_EQ(content.substr(header.size()), expected);
  expect_same_faces(import_mesh(folder / "a.ply", 1.0), mesh);
}

// A face of more corners than a byte can count.
TEST(MeshFiles, PlyOfALargePolygon) {
  const Folder folder;
  Mesh mesh{.vertices = {},
            .corners = {},
            .first = {0, 300},
            .group = {0},
            .material = {0},
            .group_names = {""},
            .material_names = {""}};
  for (std::uint32_t i = 0; i < 300; ++i) {
    mesh.vertices.push_back({static_cast<double>(i), static_cast<double>(i * i), 0});
    mesh.corners.push_back(i);
  }
  write_ply(folder / "a.ply", mesh);
  expect_same_faces(import_mesh(folder / "a.ply", 1.0), mesh);
}

TEST(MeshFiles, VtkHasValuesOfPointsAndCells) {
  const Folder folder;
  const Mesh mesh = small_mesh();
  const std::vector<float> vertices{280, 281, 282, 283, 284}, faces{300, 301, 302};
  write_vtk(folder / "a.vtk", mesh, {{"temperature", vertices}}, {{"flux", faces}});
  std::string expected =
      "# vtk DataFile Version 3.0\nwritten by mtfkit; metres, x east, y north, z up\nBINARY\nDATASET POLYDATA\nPOINTS "
      "5 double\n";
  for (const auto& p : mesh.vertices)
    for (const double x : p) expected += bytes(x, true);
  expected += "\nPOLYGONS 3 13\n";
  for (const unsigned number : {4U, 0U, 1U, 2U, 3U, 3U, 1U, 2U, 4U, 3U, 0U, 1U, 4U}) expected += bytes(number, true);
  expected += "\nCELL_DATA 3\nSCALARS group int 1\nLOOKUP_TABLE default\n";
  for (const unsigned number : {0U, 1U, 1U}) expected += bytes(number, true);
  expected += "\nSCALARS material int 1\nLOOKUP_TABLE default\n";
  for (const unsigned number : {1U, 1U, 0U}) expected += bytes(number, true);
  expected += "\nSCALARS flux float 1\nLOOKUP_TABLE default\n";
  for (const float value : faces) expected += bytes(value, true);
  expected += "\nPOINT_DATA 5\nSCALARS temperature float 1\nLOOKUP_TABLE default\n";
  for (const float value : vertices) expected += bytes(value, true);
  EXPECT_EQ(text_of(folder / "a.vtk"), expected + "\n");
}

TEST(MeshFiles, WhatAFormatCannotHoldIsRefused) {
  const Folder folder;
  for (const char* name : {"two\nlines", " blank", "blank\t", "backslash\\"}) {
    Mesh mesh = small_mesh();
    mesh.group_names[0] = name;
    EXPECT_THROW(write_obj(folder / "a.obj", mesh), mtf::UsageError) << name;
  }
  const std::vector<float> values(3);
  EXPECT_THROW(write_ply(folder / "a.ply", small_mesh(), {{"t", values}}), mtf::UsageError);
  EXPECT_THROW(write_ply(folder / "a.ply", small_mesh(), {}, {{"t in K", values}}), mtf::UsageError);
  EXPECT_THROW(write_ply(folder / "no/such/a.ply", small_mesh()), mtf::RuntimeError);
  EXPECT_FALSE(fs::exists(folder / "a.obj"));
  EXPECT_FALSE(fs::exists(folder / "a.ply"));
}

TEST(MeshFiles, NpyGrowsRowByRow) {
  const Folder folder;
  const std::vector<float> row{1.5F, -2.0F, 3.25F};
  {
    apps::scene::NpyFile file(folder / "t.npy", 3);
    for (int i = 0; i < 12; ++i) file.append(row);
    EXPECT_THROW(file.append({row.data(), 2}), mtf::UsageError);
    EXPECT_FALSE(fs::exists(folder / "t.npy"));
    file.commit();
  }
  const std::string content = text_of(folder / "t.npy");
  ASSERT_EQ(content.size(), 128U + 12 * 3 * sizeof(float));
  EXPECT_EQ(content.substr(0, 10), std::string("\x93NUMPY\x01\x00\x76\x00", 10));
  EXPECT_EQ(content.substr(10, 60), "{'descr': '<f4', 'fortran_order': False, 'shape': (12, 3), }");
  EXPECT_EQ(content[127], '\n');
  for (std::size_t i = 0; i < 36; ++i) {
    float value = 0.0F;
    std::memcpy(&value, content.data() + 128 + i * sizeof value, sizeof value);
    EXPECT_EQ(value, row[i % 3]);
  }
  { const apps::scene::NpyFile left(folder / "u.npy", 3); }
  EXPECT_FALSE(fs::exists(folder / "u.npy"));
}

}  // namespace
