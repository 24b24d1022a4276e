// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small mesh files of every kind, and a folder for them that goes away.

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace scene_test {

namespace fs = std::filesystem;

class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "mtfkit_scene_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no scratch folder");
    root_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  fs::path operator/(const std::string& name) const { return root_ / name; }

  /// Writes the file and gives its path.
  fs::path put(const std::string& name, const std::string& content) const {
    std::ofstream(root_ / name, std::ios::binary) << content;
    return root_ / name;
  }

 private:
  fs::path root_;
};

/// The bytes of a number, lowest first, or in the opposite order.
template <class T>
std::string bytes(T value, bool reversed = false) {
  std::string text(reinterpret_cast<const char*>(&value), sizeof value);
  return reversed ? std::string(text.rbegin(), text.rend()) : text;
}

inline std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// A quad and a triangle on five vertices; the triangle is of another group and material.
inline const char* const obj =
    "# two faces\nmtllib colours.mtl\nv 0 0 0\nv 1 0 0\nv 1 2.5 0\nv 0 2.5 0\nv .5 1e-1 -3\ng deck plates\nusemtl "
    "steel\n"
    "f 1/1/1 2/2/1 3/3/1 4/4/1\no nose\nusemtl red paint\nf -5 2 5\nl 1 2\np 3\n";

/// The same in PLY, without names.
inline const char* const ply_text =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 5\nproperty double x\nproperty float y\nproperty "
    "float z\n"
    "property uchar red\nelement face 2\nproperty list uchar int vertex_indices\nproperty float warmth\nend_header\n"
    "0 0 0 9\n1 0 0 9\n1 2.5 0 9\n0 2.5 0 9\n.5 0.1 -3 9\n4 0 1 2 3 7.5\n3 0 1 4 7.5\n";

inline std::string ply_binary(bool big_endian) {
  std::string file =
      std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
      "_endian 1.0\nelement vertex 5\nproperty double x\nproperty float y\nproperty float z\n"
      "property uchar red\nelement face 2\nproperty list uchar int vertex_index\nproperty float warmth\nend_header\n";
  const double x[] = {0, 1, 1, 0, 0.5};
  const float y[] = {0, 0, 2.5F, 2.5F, 0.1F}, z[] = {0, 0, 0, 0, -3};
  for (int i = 0; i < 5; ++i)
    file += bytes(x[i], big_endian) + bytes(y[i], big_endian) + bytes(z[i], big_endian) + '\x09';
  for (const std::vector<std::int32_t>& face : {std::vector<std::int32_t>{0, 1, 2, 3}, {0, 1, 4}}) {
    file += static_cast<char>(face.size());
    for (const std::int32_t corner : face) file += bytes(corner, big_endian);
    file += bytes(7.5F, big_endian);
  }
  return file;
}

/// Two solids of a triangle each, which share an edge.
inline const char* const stl_text =
    "solid deck\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 2.5 "
    "0\nendloop\nendfacet\nendsolid deck\n"
    "solid nose\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0.5 0.1 "
    "-3\nendloop\nendfacet\nendsolid nose\n";

inline std::string stl_binary(std::uint32_t announced = 2) {
  std::string file(80, ' ');
  file += bytes(announced);
  for (const float x : {1.0F, 0.5F}) {
    for (const float value : {0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, x, 2.5F, 0.F}) file += bytes(value);
    file += std::string(2, '\0');
  }
  return file;
}

/// A quad of two triangles, 1 x 2.5 in x and y of the file, in the buffer of a glTF file.
inline std::string gltf_buffer() {
  std::string buffer;
  for (const float value : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 1.F, 2.5F, 0.F, 0.F, 2.5F, 0.F}) buffer += bytes(value);
  for (const unsigned index : {0U, 1U, 2U, 0U, 2U, 3U}) buffer += bytes(static_cast<std::uint16_t>(index));
  return buffer;
}

inline const char* const gltf_nodes =
    R"([{"name":"hull","translation":[10,0,0],"children":[1,2]},{"name":"turret","mesh":0,"scale":[2,2,2]},)"
    R"({"name":"mirrored","mesh":0,"scale":[-1,1,1]}])";

/// `uri`: of the buffer, empty for the one within a .glb file.
inline std::string gltf(const std::string& uri, const std::string& nodes = gltf_nodes) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
         R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],"materials":[{"name":"paint"}],)"
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,2.5,0]},)"
         R"({"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":48},)"
         R"({"buffer":0,"byteOffset":48,"byteLength":12}],"buffers":[{"byteLength":60)" +
         (uri.empty() ? "" : R"(,"uri":")" + uri + "\"") + "}]}";
}

inline std::string glb() {
  std::string json = gltf("");
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string buffer = gltf_buffer();
  const auto part = [](const std::string& kind, const std::string& content) {
    return bytes(static_cast<std::uint32_t>(content.size())) + kind + content;
  };
  const std::string parts = part("JSON", json) + part(std::string("BIN\0", 4), buffer);
  return "glTF" + bytes(std::uint32_t{2}) + bytes(static_cast<std::uint32_t>(12 + parts.size())) + parts;
}

inline std::string base64(const std::string& content) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i + 2 < content.size(); i += 3) {  // the buffer has a multiple of three bytes
    const unsigned group = (static_cast<unsigned char>(content[i]) << 16U) |
                           (static_cast<unsigned char>(content[i + 1]) << 8U) |
                           static_cast<unsigned char>(content[i + 2]);
    for (const unsigned shift : {18U, 12U, 6U, 0U}) text += digits[(group >> shift) & 63U];
  }
  return text;
}

struct Sample {
  std::string name, content;
  bool says_its_size;  ///< so that what was cut short is found out
};

inline std::vector<Sample> samples() {
  return {{"a.obj", obj, false},
          {"b.ply", ply_text, true},
          {"c.ply", ply_binary(false), true},
          {"d.stl", std::string(stl_text).substr(std::string(stl_text).find("solid nose")), true},
          {"e.stl", stl_binary(), true},
          {"f.gltf", gltf("data:application/octet-stream;base64," + base64(gltf_buffer())), true},
          {"g.glb", glb(), true}};
}

}  // namespace scene_test
