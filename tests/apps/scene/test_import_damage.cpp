// SPDX-License-Identifier: Apache-2.0
// Damaged and malicious files: every one is a mesh or an error that names the file, soon.
#include <gtest/gtest.h>

#include <random>

#include "apps/scene/import/import_mesh.h"
#include "apps/scene/import/mesh_stream.h"
#include "mesh_samples.h"
#include "mtf/error.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using namespace scene_test;
using apps::scene::import_mesh;
using radiometry::scene::Mesh;

/// Whether a mesh came; every index in it is valid (the receiver has checked it).
bool imported(const fs::path& file) {
  bool mesh = false;
  try {
    mesh = import_mesh(file, 1.0).faces() > 0;
    EXPECT_TRUE(mesh) << file;
  } catch (const mtf::RuntimeError& error) {
    const std::string message = error.what();
    expect_says(message, {file.filename().string(), "; "});
  }
  return mesh;
}

TEST(ImportDamage, FilesThatWereCutShort) {
  const Folder folder;
  for (const Sample& sample : samples()) {
    ASSERT_TRUE(imported(folder.put(sample.name, sample.content))) << sample.name;
    std::size_t end = sample.content.find_last_not_of("\n") + 1;
    if (sample.name == "b.ply") end = sample.content.rfind(' ') + 2;  // "7" is a number too
    if (sample.name == "d.stl") end = sample.content.rfind(" nose");  // the name is not needed
    for (std::size_t size = 0; size < end; size += 7) {
      const bool mesh = imported(folder.put(sample.name, sample.content.substr(0, size)));
      EXPECT_FALSE(sample.says_its_size && mesh) << sample.name << " of " << size << " bytes";
    }
  }
}

/// Changes up to three bytes of the samples whose names end so, `times` each.
void change_bytes(const std::string& extension, int times) {
  const Folder folder;
  std::mt19937 random(20161101);
  const auto below = [&random](std::size_t count) { return random() % count; };
  std::size_t meshes = 0, files = 0;
  for (const Sample& sample : samples()) {
    if (!sample.name.ends_with(extension)) continue;
    for (int i = 0; i < times; ++i, ++files) {
      std::string content = sample.content;
      for (std::size_t changes = 1 + below(3); changes > 0; --changes)
        content[below(content.size())] = static_cast<char>(below(256));
      meshes += imported(folder.put(sample.name, content)) ? 1U : 0U;
    }
  }
  EXPECT_GT(files, 0U);
  EXPECT_GT(meshes, 0U);     // a changed coordinate is another mesh
  EXPECT_LT(meshes, files);  // and much else is noticed
}

constexpr int kSome = 72;
TEST(ImportDamage, BytesOfObjThatWereChanged) { change_bytes(".obj", kSome); }
TEST(ImportDamage, BytesOfPlyThatWereChanged) { change_bytes(".ply", kSome); }
TEST(ImportDamage, BytesOfStlThatWereChanged) { change_bytes(".stl", kSome); }
TEST(ImportDamage, BytesOfGltfThatWereChanged) { change_bytes(".gltf", kSome); }
TEST(ImportDamage, BytesOfGlbThatWereChanged) { change_bytes(".glb", kSome); }
/// 2,002 files, a process each.
TEST(ImportDamageLong, BytesThatWereChanged) {
  for (const char* extension : {".obj", ".ply", ".stl", ".gltf", ".glb"}) change_bytes(extension, 286);
}

TEST(ImportDamage, NumbersThatTheFileCannotHold) {
  const Folder folder;
  const std::string vertices = "element vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 4000000000\nproperty list uint int vertex_indices\nend_header\n";
  EXPECT_FALSE(imported(folder.put("a.ply", "ply\nformat ascii 1.0\n" + vertices + faces + "0 0 0\n")));
  EXPECT_FALSE(imported(
      folder.put("b.ply", "ply\nformat binary_little_endian 1.0\n" + vertices + faces + std::string(96, '\0'))));
  EXPECT_FALSE(
      imported(folder.put("c.ply", "ply\nformat binary_little_endian 1.0\n" + faces + std::string(96, '\xff'))));
  EXPECT_FALSE(imported(folder.put("d.ply", "ply\nformat ascii 1.0\nelement nothing 9000000000000000000\n" + faces)));
  EXPECT_FALSE(imported(folder.put("e.stl", stl_binary(4000000000U))));
  EXPECT_FALSE(imported(folder.put("f.obj", "v 0 0 0\nf 1 1 4000000000\nf 1 1 99999999999999999999\n")));
  std::string counts = gltf("data:application/octet-stream;base64," + base64(gltf_buffer()));
  counts = replaced(counts, "\"count\":4", "\"count\":4000000000");
  EXPECT_FALSE(imported(folder.put("g.gltf", counts)));
}

// 500 nodes below one another are a mesh; 100,000 overrun the stack of Assimp, in its own process.
TEST(ImportDamage, DeepTrees) {
  const Folder folder;
  const auto chain = [](int depth) {
    std::string nodes = "[";
    for (int i = 0; i < depth; ++i) nodes += R"({"children":[)" + std::to_string(i + 1) + "]},";
    return nodes + R"({"mesh":0}])";
  };
  const std::string uri = "data:application/octet-stream;base64," + base64(gltf_buffer());
  EXPECT_TRUE(imported(folder.put("a.gltf", gltf(uri, chain(500)))));
  imported(folder.put("b.gltf", gltf(uri, chain(100000))));
  imported(folder.put("c.gltf", std::string(1000000, '[')));
  imported(folder.put("d.gltf", gltf(uri, R"([{"children":[0],"mesh":0}])")));  // a node below itself
}

// Each node has the next one twice below it: 2^40 places of the mesh in a file of 2 kB.
TEST(ImportDamage, NodesThatMultiply) {
  const Folder folder;
  std::string nodes = "[";
  for (int i = 1; i <= 40; ++i) nodes += R"({"children":[)" + std::to_string(i) + "," + std::to_string(i) + "]},";
  EXPECT_FALSE(imported(folder.put(
      "a.gltf", gltf("data:application/octet-stream;base64," + base64(gltf_buffer()), nodes + R"({"mesh":0}])"))));
}

Mesh small_mesh() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          .corners = {0, 1, 2, 0, 1, 3},
          .first = {0, 3, 6},
          .group = {0, 1},
          .material = {0, 0},
          .group_names = {"a", "b"},
          .material_names = {"m"}};
}

TEST(ImportDamage, TheReceiverTrustsNoNumber) {
  const std::string sent = apps::scene::encode_mesh(small_mesh());
  EXPECT_EQ(sent.size(), apps::scene::stream_size(small_mesh()));
  EXPECT_EQ(apps::scene::decode_import(sent).mesh.corners, small_mesh().corners);
  for (std::size_t size = 0; size < sent.size(); ++size)
    EXPECT_THROW(static_cast<void>(apps::scene::decode_import(sent.substr(0, size))), mtf::RuntimeError) << size;
  EXPECT_THROW(static_cast<void>(apps::scene::decode_import(sent + "x")), mtf::RuntimeError);
  for (std::size_t at = 0; at < sent.size(); ++at)
    for (const char value : {'\0', '\x7f', '\xff'}) {
      std::string changed = sent;
      changed[at] = value;
      try {
        const Mesh mesh = apps::scene::decode_import(changed).mesh;
        for (const std::uint32_t corner : mesh.corners) ASSERT_LT(corner, mesh.vertices.size());
        for (const std::uint32_t group : mesh.group) ASSERT_LT(group, mesh.group_names.size());
      } catch (const mtf::RuntimeError&) {
      }
    }
}

}  // namespace
