// SPDX-License-Identifier: Apache-2.0
// What becomes of the files of each format: vertices, polygons, groups, materials, axes, units.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>

#include "import_checks.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using namespace scene_test;
using apps::scene::Up;

const std::vector<Point> quad{{0, 0, 0}, {1, 0, 0}, {1, 2.5, 0}, {0, 2.5, 0}};

TEST(ImportMesh, ObjKeepsPolygonsGroupsAndMaterials) {
  const Folder folder;
  const Mesh mesh = import_mesh(folder.put("a.obj", obj), 1.0);
  ASSERT_EQ(mesh.faces(), 2U);
  EXPECT_EQ(mesh.vertices.size(), 5U);
  EXPECT_EQ(face(mesh, 0), quad);
  EXPECT_EQ(face(mesh, 1), (std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {0.5, 0.1, -3}}));
  EXPECT_EQ(mesh.group_names, (std::vector<std::string>{"deck plates", "nose"}));
  EXPECT_EQ(mesh.material_names, (std::vector<std::string>{"steel", "red paint"}));
  EXPECT_EQ(mesh.group, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(mesh.material, (std::vector<std::uint32_t>{0, 1}));
}

// Blanks before a word, a line that is continued, ends of lines of Windows, numbers as printf and Fortran write them.
TEST(ImportMesh, ObjInOtherHands) {
  const Folder folder;
  const Mesh mesh = import_mesh(
      folder.put(
          "a.obj",
          "v 0 0 0\r\n\tv +1 0 0 1.0\r\n v 1. 2.50E+0 0 .2 .3 .4\r\nv -0 2.5 0\r\n  f 1 2 \\\r\n3 4\r\ng\r\nf 1 2 3"),
      1.0);
  ASSERT_EQ(mesh.faces(), 2U);
  EXPECT_EQ(face(mesh, 0), quad);
  EXPECT_FALSE(std::signbit(mesh.vertices[3][0]));
  EXPECT_EQ(mesh.group_names, std::vector<std::string>{""});
}

// Coordinates far from the origin, as of a map, keep their digits.
TEST(ImportMesh, ObjAndPlyAreReadInDouble) {
  const Folder folder;
  const Mesh mesh = import_mesh(folder.put("a.obj", "v 691234.5671 5334567.8912 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), 1.0);
  EXPECT_EQ(mesh.vertices[0], (Point{691234.5671, 5334567.8912, 0}));
  const Mesh ply = import_mesh(folder.put("b.ply", ply_text), 1.0);
  EXPECT_EQ(ply.vertices[4], (Point{0.5, 0.1, -3}));
}

TEST(ImportMesh, Ply) {
  const Folder folder;
  for (const std::string& content : {std::string(ply_text), ply_binary(false), ply_binary(true)}) {
    const Mesh mesh = import_mesh(folder.put("a.ply", content), 1.0);
    ASSERT_EQ(mesh.faces(), 2U);
    EXPECT_EQ(face(mesh, 0), quad);
    EXPECT_EQ(face(mesh, 1).size(), 3U);
    EXPECT_EQ(mesh.group_names, std::vector<std::string>{""});
    EXPECT_EQ(mesh.material_names, std::vector<std::string>{""});
  }
}

TEST(ImportMesh, StlWeldsTheCornersOfItsTriangles) {
  const Folder folder;
  const Mesh text = import_mesh(folder.put("a.stl", stl_text), 1.0);
  ASSERT_EQ(text.faces(), 2U);
  EXPECT_EQ(text.vertices.size(), 4U);
  EXPECT_EQ(text.group_names, (std::vector<std::string>{"deck", "nose"}));
  const Mesh binary = import_mesh(folder.put("b.STL", stl_binary()), 1.0);
  ASSERT_EQ(binary.faces(), 2U);
  EXPECT_EQ(face(binary, 1), (std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {0.5, 2.5, 0}}));
}

TEST(ImportMesh, VerticesApartByOneBitStayApart) {
  const Folder folder;
  const Mesh mesh = import_mesh(
      folder.put("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1.0000000000000002 0 0\nv 1 0 0\nf 1 2 3\nf 1 4 3\nf 1 5 3\n"),
      1.0);
  EXPECT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(mesh.faces(), 3U);
}

// y of the file is up: (x, y, z) becomes (x, -z, y). Transforms of nodes apply, a mirrored face keeps its outer side.
TEST(ImportMesh, GltfNodesAndAxes) {
  const Folder folder;
  folder.put("my buffer.bin", gltf_buffer());
  for (const fs::path& file :
       {folder.put("a.gltf", gltf("my%20buffer.bin")), folder.put("b.glb", glb()),
        folder.put("c.gltf", gltf("data:application/octet-stream;base64," + base64(gltf_buffer())))}) {
    const Mesh mesh = import_mesh(file, 1.0);
    ASSERT_EQ(mesh.faces(), 4U) << file;
    EXPECT_EQ(mesh.group_names, (std::vector<std::string>{"turret", "mirrored"}));
    EXPECT_EQ(mesh.material_names, std::vector<std::string>{"paint"});
    EXPECT_EQ(face(mesh, 0), (std::vector<Point>{{10, 0, 0}, {12, 0, 0}, {12, 0, 5}}));
    for (const std::size_t i : {0U, 2U}) {  // the normal of both is -y, where +z of the file points
      const std::vector<Point> p = face(mesh, i);
      EXPECT_LT((p[1][2] - p[0][2]) * (p[2][0] - p[0][0]) - (p[1][0] - p[0][0]) * (p[2][2] - p[0][2]), 0.0) << i;
    }
    EXPECT_EQ(face(import_mesh(file, 1.0, Up::z), 0), (std::vector<Point>{{10, 0, 0}, {12, 0, 0}, {12, 5, 0}}));
  }
}

TEST(ImportMesh, UnitAndUp) {
  const Folder folder;
  const fs::path file = folder.put("a.obj", obj);
  EXPECT_EQ(import_mesh(file, 0.001).vertices[2], (Point{0.001, 0.0025, 0}));
  EXPECT_EQ(import_mesh(file, 1.0, Up::y).vertices[4], (Point{0.5, 3, 0.1}));
  for (const double unit : {0.0, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_THROW(static_cast<void>(import_mesh(file, unit)), mtf::UsageError);
}

TEST(ImportMesh, NamesOfFiles) {
  const Folder folder;
  for (const char* name :
       {"a b.obj", "Fahrzeug-\xc3\xa4\xe2\x98\x83.obj", "-o.obj", "$(touch x);.obj", "quote\".obj", "x\ny.obj"})
    EXPECT_EQ(import_mesh(folder.put(name, obj), 1.0).faces(), 2U) << name;
}

// The faces of such vertices are left out later, with a count.
TEST(ImportMesh, CoordinatesThatAreNotFiniteStay) {
  const Folder folder;
  const Mesh mesh = import_mesh(folder.put("a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nv inf 0 0\nf 1 2 3\nf 4 2 3\n"), 1.0);
  EXPECT_TRUE(std::isnan(mesh.vertices[0][0]));
  EXPECT_TRUE(std::isinf(mesh.vertices[3][0]));
}

TEST(ImportMesh, RefusalsNameFileAndReason) {
  const Folder folder;
  expect_refused(folder / "missing.obj", {"No such file"});
  expect_refused(folder.put("a.fbx", "x"), {"\".fbx\""});
  expect_refused(folder.put("noext", "x"), {"is not known"});
  expect_refused(folder.put("empty.obj", ""), {"the file is empty"});
  expect_refused(folder.put("nofaces.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), {"it has no faces"});
  expect_refused(folder.put("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n"), {"line 5:", "vertex 4 of the"});
  expect_refused(folder.put("zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"), {"line 4"});
  expect_refused(folder.put("back.obj", "v 0 0 0\nf -1 -2 -1\n"), {"line 2"});
  expect_refused(folder.put("word.obj", "v 0 zero 0\n"), {"line 1:", "three numbers"});
  expect_refused(folder.put("cut.obj", "v 0 0 0\n# a \\\nb\nv 1 0\n"), {"line 4"});
  expect_refused(folder.put("index.ply",
                            [] {
                              std::string text = ply_text;
                              return replaced(text, "3 0 1 4", "3 0 1 5");
                            }()),
                 {"vertex that is not"});
  expect_refused(folder.put("type.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n1\n"),
                 {"half"});
  expect_refused(folder.put("other.ply", "plyx\n"), {"ply"});
  expect_refused(folder.put("text.gltf", "no JSON"), {"its JSON is damaged"});
  expect_refused(folder.put("nobuffer.gltf", gltf("nowhere.bin")), {"buffers[0]: \"nowhere.bin\" is no file"});
  fs::create_directory(folder / "folder.obj");
  expect_refused(folder / "folder.obj", {"it is a folder"});
}

// None of them is read: reading would wait or never end.
TEST(ImportMesh, OnlyOrdinaryFilesAreRead) {
  const Folder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe.obj").c_str(), 0600), 0);
  expect_refused(folder / "pipe.obj", {"ordinary file"});
  fs::create_symlink("/dev/zero", folder / "zero.stl");
  expect_refused(folder / "zero.stl", {"ordinary file"});
  ASSERT_EQ(::mkfifo((folder / "pipe.bin").c_str(), 0600), 0);
  expect_refused(folder.put("a.gltf", gltf("pipe.bin")), {"export it again"});
}

TEST(ImportMesh, BuffersOfOtherFoldersAreNotRead) {
  const Folder folder;
  fs::create_directory(folder / "inner");
  folder.put("buffer.bin", gltf_buffer());
  expect_refused(folder.put("inner/a.gltf", gltf("../buffer.bin")), {"export it again"});
  expect_refused(folder.put("inner/b.gltf", gltf((folder / "buffer.bin").string())), {"export it again"});
  folder.put("inner/buffer.bin", gltf_buffer());
  EXPECT_EQ(import_mesh(folder.put("c.gltf", gltf("inner/buffer.bin")), 1.0).faces(), 4U);
}

}  // namespace
