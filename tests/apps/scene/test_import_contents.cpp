// SPDX-License-Identifier: Apache-2.0
// What a mesh file may hold beside triangles: each is read right, refused, noted or counted.
#include <gtest/gtest.h>

#include <cctype>
#include <span>

#include "import_checks.h"
#include "radiometry/scene/facets.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using namespace scene_test;
using apps::scene::Up;

constexpr const char* ply_head =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
constexpr const char* square = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
constexpr const char* face_list = "property list uchar int vertex_indices\n";

// A strip of n vertices makes n - 2 triangles that all look the same way; -1 begins the next one.
TEST(ImportContents, StripsOfPly) {
  const Folder folder;
  const std::string head = std::string(ply_head) + "element tristrips 1\n" + "property list int int vertex_indices\n" +
                           "end_header\n" + square;
  const Mesh one = import_mesh(folder.put("a.ply", head + "4 0 1 2 3\n"), 1.0);
  EXPECT_EQ(one.faces(), 2U);
  EXPECT_EQ(area(one), 1.0);
  EXPECT_EQ(face(one, 1), (std::vector<Point>{{0, 1, 0}, {1, 0, 0}, {1, 1, 0}}));
  const Mesh two = import_mesh(folder.put("b.ply", head + "7 0 1 2 -1 1 3 2\n"), 1.0);
  EXPECT_EQ(two.faces(), 2U);
  EXPECT_EQ(area(two), 1.0);
}

// A text of another layout than its header is not taken for what it is not.
TEST(ImportContents, PlyThatItsHeaderDoesNotDescribe) {
  const Folder folder;
  const std::string faces = std::string(ply_head) + "element face 2\n" + face_list;
  expect_refused(folder.put("more.ply", faces + "end_header\n" + square + "3 0 1 2 6 0 0 1\n3 1 3 2 6 1 0 1\n"),
                 {"line 14:", "\"face\""});
  expect_refused(folder.put("vertex.ply", faces + "end_header\n0 0 0 0\n1 0 0 0\n0 1 0 0\n1 1 0 0\n3 0 1 2\n3 1 3 2\n"),
                 {"line 10:", "\"vertex\""});
  expect_refused(folder.put("fewer.ply", std::string(ply_head) + "property float s\nelement face 1\n" + face_list +
                                             "end_header\n" + square + "3 0 1 2\n3 1 3 2\n"),
                 {"line 12:", "\"vertex\""});
  expect_refused(folder.put("longer.ply", std::string(ply_head) + "element face 1\n" + face_list + "end_header\n" +
                                              square + "3 0 1 2\n3 1 3 2\n"),
                 {"line 15:", "goes on"});
  expect_refused(folder.put("binary.ply", ply_binary(false) + "\3"), {"goes on after"});
  EXPECT_EQ(import_mesh(folder.put("blank.ply", ply_binary(true) + "\n"), 1.0).faces(), 2U);
  EXPECT_EQ(
      import_mesh(folder.put("wrapped.ply", faces + "end_header\n" + square + "3 0\n1 2\n\n3 1 3 2"), 1.0).faces(), 2U);
  const std::string edges = std::string(ply_head) + "element face 1\n" + face_list +
                            "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n" + square;
  EXPECT_TRUE(says(import_mesh(folder.put("edge.ply", edges + "3 0 1 2\n0 3\n"), 1.0).notes, "1 elements \"edge\""));
}

// They have no area; facets_of leaves them out and counts them.
TEST(ImportContents, FacesOfFewerThanThreeCornersStay) {
  const Folder folder;
  const std::string ply = std::string(ply_head) + "element face 4\n" + face_list + "end_header\n" + square;
  const Mesh mesh = import_mesh(folder.put("a.ply", ply + "3 0 1 2\n2 0 1\n1 3\n0\n"), 1.0);
  const Mesh of_obj = import_mesh(folder.put("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\nf 3\nf\n"), 1.0);
  for (const Mesh* read : {&mesh, &of_obj}) {
    ASSERT_EQ(read->faces(), 4U);
    const radiometry::scene::PlacedMesh placed{.name = "m", .mesh = read};
    const radiometry::scene::Facets facets = radiometry::scene::facets_of(std::span(&placed, 1));
    EXPECT_EQ(facets.size(), 1U);
    EXPECT_EQ(facets.report[0].faces, 4U);
    EXPECT_EQ(facets.report[0].degenerate, 3U);
  }
}

TEST(ImportContents, StatementsOfObjThatMakeNoPolygon) {
  const Folder folder;
  const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 1\ns off\nf 1 2 3\n";
  EXPECT_TRUE(import_mesh(folder.put("a.obj", start), 1.0).notes.empty());
  EXPECT_EQ(area(import_mesh(folder.put("b.obj", start + "fo 2 4 3\n"), 1.0)), 1.0);
  const Mesh lines = import_mesh(folder.put("c.obj", start + "l 1 4\nl 2 3\np 1\nF 2 4 3\n"), 1.0);
  EXPECT_TRUE(says(lines.notes, "3 lines of the") && says(lines.notes, "line 8 with \"l\""));
  EXPECT_TRUE(says(lines.notes, "1 lines of the") && says(lines.notes, "line 11 with \"F\""));
  const radiometry::scene::PlacedMesh placed{.name = "m", .mesh = &lines};
  EXPECT_EQ(radiometry::scene::facets_of(std::span(&placed, 1)).warnings.size(), 2U);
  expect_refused(folder.put("surface.obj", start + "cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nend\n"),
                 {"line 10:", "(surf)"});
  expect_refused(folder.put("call.obj", start + "call other.obj\n"), {"line 8"});
}

TEST(ImportContents, StlInOtherHands) {
  const Folder folder;
  const auto facet = [](const std::string& vertices) {
    return "facet normal 0 0 1\nouter loop\n" + vertices + "endloop\nendfacet\n";
  };
  const std::string corners = "vertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n";
  const std::string quad_text = "solid a b\n" + facet(corners + "vertex 0 1 0\n") + "endsolid a b\n";
  EXPECT_EQ(area(import_mesh(folder.put("a.stl", quad_text), 1.0)), 1.0);
  std::string upper = quad_text;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  EXPECT_EQ(area(import_mesh(folder.put("b.stl", upper), 1.0)), 1.0);
  EXPECT_EQ(import_mesh(folder.put("c.stl", "solid " + std::string(74, 'x') + stl_binary().substr(80)), 1.0).faces(),
            2U);
  EXPECT_EQ(
      import_mesh(folder.put("d.stl", "solid\n" + facet("vertex 0 0 0.1\nvertex 1 0 0\nvertex 0 1 0\n") + "endsolid"),
                  1.0)
          .vertices[0],
      (Point{0, 0, 0.1}));
  expect_refused(folder.put("count.stl", stl_binary(1)), {"1 triangles", "134 bytes", "184"});
  expect_refused(folder.put("comma.stl", "solid a\n" + facet("vertex 0,5 0 0\n" + corners) + "endsolid a\n"),
                 {"line 4:", "three numbers"});
  expect_refused(folder.put("noend.stl", "solid a\n" + facet(corners)), {"endsolid"});
  expect_refused(folder.put("noloop.stl", "solid a\nvertex 0 0 0\nendsolid a\n"), {"line 2: \"vertex\""});
}

/// The sample with another JSON, whose buffer is followed by `more`.
fs::path changed_gltf(const Folder& folder, const std::string& name,
                      const std::vector<std::pair<std::string, std::string>>& changes, const std::string& more = "") {
  std::string buffer = gltf_buffer() + more;
  buffer.resize((buffer.size() + 2) / 3 * 3);
  std::string json = gltf("data:application/octet-stream;base64," + base64(buffer), R"([{"name":"n","mesh":0}])");
  json = replaced(json, "\"byteLength\":60", "\"byteLength\":" + std::to_string(buffer.size()));
  for (const auto& [from, to] : changes) {
    json = replaced(json, from, to);
  }
  return folder.put(name, json);
}

// Offsets and counts that lead out of their buffers, or to no vertex.
TEST(ImportContents, GltfNumbersAreChecked) {
  const Folder folder;
  const auto refused = [&](const std::string& from, const std::string& to,
                           std::initializer_list<std::string_view> parts) {
    expect_refused(changed_gltf(folder, "a.gltf", {{from, to}}), parts);
  };
  refused(R"("componentType":5126,)", R"("componentType":5126,"byteOffset":-12,)", {"accessors[0]: byteOffset is -12"});
  refused(R"("componentType":5123,)", R"("componentType":5123,"byteOffset":-6,)", {"accessors[1]: byteOffset is -6"});
  refused(R"("byteOffset":48)", R"("byteOffset":-12)", {"bufferViews[1]: byteOffset is -12"});
  refused(R"("byteOffset":48)", R"("byteOffset":50)", {"bufferViews[1]: it reaches beyond"});
  refused(R"("count":4)", R"("count":5)", {"accessors[0]: it reaches beyond"});
  refused(R"("count":6)", R"("count":4)", {"4 vertices"});
  refused(R"("count":6)", R"("count":5.5)", {"count is 5.5"});
  refused(R"("count":4)", R"("count":3)", {"vertex that is not"});
  refused(R"("byteLength":48)", R"("byteLength":48,"byteStride":4)", {"less than an element"});
  refused(R"("mesh":0)", R"("mesh":-1)", {"nodes[0]: mesh is -1"});
  refused(R"("scene":0)", R"("scene":1)", {"scenes[1] is not there"});
  refused(R"("type":"VEC3")", R"("type":"VEC2")", {"VEC3 belongs"});
  refused(R"("componentType":5126)", R"("componentType":5122)", {"KHR_mesh_quantization"});
  refused(R"("version":"2.0")", R"("version":"1.0")", {"glTF 1.0"});
  refused(R"({"name":"n",)", R"({"name":"n","children":[0],)", {"nodes[0]:", "more than once"});
  expect_refused(folder.put("long.glb", glb() + "xxxx"), {"has " + std::to_string(glb().size())});
}

// Each of them would be another shape.
TEST(ImportContents, GltfThatIsNotAppliedIsRefusedOrNoted) {
  const Folder folder;
  const auto with = [&](const std::string& from, const std::string& to) {
    return changed_gltf(folder, "a.gltf", {{from, to}});
  };
  const std::string node = R"({"name":"n",)", start = R"({"asset")";
  expect_refused(with(node, node + R"("skin":0,)"), {"its skin"});
  expect_refused(with(node, node + R"("weights":[0,0.5],)"), {"its morph targets"});
  expect_refused(with(node, node + R"("matrix":[1,0,0,0,0,1,0,0,0,0,1,0,3,0,0,2],)"), {"last row"});
  expect_refused(with(node, node + R"("rotation":[0,0,0,2],)"), {"no unit quaternion"});
  for (const std::string name : {"EXT_meshopt_compression", "CESIUM_RTC"})
    expect_refused(
        with(start, R"({"extensionsUsed":[")" + name + R"("],"extensionsRequired":[")" + name + R"("],"asset")"),
        {"requires the extension " + name});
  expect_refused(with(start, R"({"extensionsUsed":["EXT_mesh_gpu_instancing"],"asset")"), {"its instances"});
  const Mesh looks = import_mesh(
      with(start,
           R"({"extensionsUsed":["KHR_materials_ior","MSFT_lod"],"extensionsRequired":["KHR_materials_ior"],"asset")"),
      1.0);
  ASSERT_EQ(looks.notes.size(), 1U);
  expect_says(looks.notes[0], {"MSFT_lod"});
  EXPECT_TRUE(says(import_mesh(with(start, R"({"animations":[{}],"asset")"), 1.0).notes, "animations"));
  EXPECT_TRUE(
      says(import_mesh(with(R"([{"nodes":[0]}])", R"([{"nodes":[0]},{"nodes":[]}])"), 1.0).notes, "which number 0"));
  const Mesh lines =
      import_mesh(with(R"("primitives":[)", R"("primitives":[{"attributes":{"POSITION":0},"mode":1},)"), 1.0);
  EXPECT_EQ(lines.faces(), 2U);
  EXPECT_TRUE(says(lines.notes, "1 of its primitives"));
}

// Strips, fans, positions that are replaced, stored as integers or compressed: all the same square of 2.5.
TEST(ImportContents, GltfStoredInOtherWays) {
  const Folder folder;
  const auto area_of = [&](const std::vector<std::pair<std::string, std::string>>& changes,
                           const std::string& more = "") {
    return area(import_mesh(changed_gltf(folder, "a.gltf", changes, more), 1.0, Up::z));
  };
  const auto shorts = [](std::initializer_list<int> values) {
    std::string text;
    for (const int value : values) text += bytes(static_cast<std::int16_t>(value));
    return text;
  };
  const std::string primitive = R"("indices":1)", view = R"("byteLength":12})";
  const auto extra_view = [&](int size) {
    return view + R"(,{"buffer":0,"byteOffset":60,"byteLength":)" + std::to_string(size) + "}";
  };
  EXPECT_EQ(area_of({}), 2.5);
  const std::pair<std::string, std::string> four{R"("bufferView":1,"componentType":5123,"count":6)",
                                                 R"("bufferView":2,"componentType":5123,"count":4)"};
  EXPECT_EQ(area_of({{primitive, R"("indices":1,"mode":5)"}, four, {view, extra_view(8)}}, shorts({0, 1, 3, 2})), 2.5);
  EXPECT_EQ(area_of({{primitive, R"("indices":1,"mode":6)"}, four, {view, extra_view(8)}}, shorts({0, 1, 2, 3})), 2.5);
  // The two upper vertices move from y = 2.5 to y = 5.
  std::string moved = shorts({2, 3});
  for (const float value : {1.F, 5.F, 0.F, 0.F, 5.F, 0.F}) moved += bytes(value);
  EXPECT_EQ(
      area_of(
          {{R"("count":4,)",
            R"("count":4,"sparse":{"count":2,"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":3}},)"},
           {view, extra_view(4) + R"(,{"buffer":0,"byteOffset":64,"byteLength":24})"}},
          moved),
      5.0);
  // In steps of 1/32767 along x, which a scale of 2 makes 0 to 2.
  const std::pair<std::string, std::string> quantized{R"({"asset")",
                                                      R"({"extensionsUsed":["KHR_mesh_quantization"],"asset")"};
  EXPECT_EQ(
      area_of({quantized,
               {R"({"name":"n",)", R"({"name":"n","scale":[2,2.5,1],)"},
               {R"("bufferView":0,"componentType":5126)", R"("bufferView":2,"componentType":5122,"normalized":true)"},
               {view, R"("byteLength":12},{"buffer":0,"byteOffset":60,"byteLength":32,"byteStride":8})"}},
              shorts({0, 0, 0, 0, 32767, 0, 0, 0, 32767, 32767, 0, 0, 0, 32767, 0, 0})),
      5.0);
}

// What draco_encoder (1.5.5, -cl 0 -qp 0) makes of the two triangles: 28 bytes, then the positions as they are.
TEST(ImportContents, GltfCompressedByDraco) {
  const Folder folder;
  const std::string head("DRACO\x02\x02\x01\0\0\0\x02\x04\x01\0\x01\x02\0\x02\x03\x01\x01\0\x09\x03\0\0\0", 28);
  const std::string primitive = R"("indices":1)", view = R"("byteLength":12})";
  const std::vector<std::pair<std::string, std::string>> changes{
      {primitive,
       primitive + R"(,"extensions":{"KHR_draco_mesh_compression":{"bufferView":2,"attributes":{"POSITION":0}}})"},
      {view, view + R"(,{"buffer":0,"byteOffset":60,"byteLength":76})"}};
  const std::string compressed = head + gltf_buffer().substr(0, 48);
  const Mesh mesh = import_mesh(changed_gltf(folder, "a.gltf", changes, compressed), 1.0, Up::z);
  EXPECT_EQ(mesh.faces(), 2U);
  EXPECT_EQ(area(mesh), 2.5);
  expect_refused(changed_gltf(folder, "b.gltf", changes, "x" + compressed.substr(1)), {"Draco cannot decompress it"});
}

}  // namespace
