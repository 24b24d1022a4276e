// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/mesh_readers.h"

#include <draco/compression/decode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "apps/scene/import/helper/gltf_data.h"
#include "apps/scene/import/helper/mesh_builder.h"

namespace apps::scene {
namespace {

using Json = nlohmann::json;
using radiometry::scene::Mesh;
using radiometry::scene::Point;

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr std::string_view kQuantization = "KHR_mesh_quantization";
constexpr std::string_view kInstances = "EXT_mesh_gpu_instancing";

/// x -> linear x + shift.
struct Affine {
  std::array<std::array<double, 3>, 3> linear{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Point shift{};
};

Point apply(const Affine& map, const Point& p) {
  Point mapped = map.shift;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) mapped[i] += map.linear[i][j] * p[j];
  return mapped;
}

Affine product(const Affine& outer, const Affine& inner) {
  Affine result{{}, apply(outer, inner.shift)};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) result.linear[i][j] += outer.linear[i][k] * inner.linear[k][j];
  return result;
}

double determinant(const Affine& map) {
  const auto& m = map.linear;
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

std::vector<double> numbers_of(const GltfObject& node, const char* key, std::vector<double> missing) {
  std::optional<std::vector<double>> values = node.numbers(key);
  if (!values) return missing;
  if (values->size() != missing.size())
    node.refuse(std::string(key) + " has not " + std::to_string(missing.size()) + " numbers");
  return std::move(*values);
}

/// A matrix, column after column, or a scale, then a rotation (unit quaternion x, y, z, w), then a translation.
Affine affine_of(const GltfObject& node) {
  Affine map;
  if (node.has("matrix")) {
    const std::vector<double> m = numbers_of(node, "matrix", std::vector<double>(16));
    if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0)
      node.refuse("the last row of its matrix is not 0 0 0 1");
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) map.linear[i][j] = m[4 * j + i];
      map.shift[i] = m[12 + i];
    }
    return map;
  }
  const std::vector<double> scale = numbers_of(node, "scale", {1, 1, 1}),
                            t = numbers_of(node, "translation", {0, 0, 0});
  const std::vector<double> q = numbers_of(node, "rotation", {0, 0, 0, 1});
  const double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  constexpr double kRounding = 1e-3;
  if (!(std::abs(squared - 1.0) <= kRounding)) node.refuse("its rotation is no unit quaternion");
  const double s = 2.0 / squared, x = q[0], y = q[1], z = q[2], w = q[3];
  map.linear = {{{1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
                 {s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)},
                 {s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)}}};
  for (auto& row : map.linear)
    for (std::size_t j = 0; j < 3; ++j) row[j] *= scale[j];
  map.shift = {t[0], t[1], t[2]};
  return map;
}

/// The JSON of the file, and the binary part of a .glb file.
std::string_view json_of(std::string_view extension, std::string_view content, std::string_view& binary) {
  if (extension == ".gltf") return content;
  const auto number = [&content](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, content.data() + at, sizeof value);
    return value;
  };
  constexpr std::size_t head = 12, part_head = 8;
  if (content.size() < head || !content.starts_with("glTF")) throw std::runtime_error("it is no GLB file");
  if (number(4) != 2) throw std::runtime_error("its GLB version is " + std::to_string(number(4)) + ", where 2 is read");
  if (number(8) != content.size())
    throw std::runtime_error("it says that it has " + std::to_string(number(8)) + " bytes, and has " +
                             std::to_string(content.size()));
  std::string_view json;
  for (std::size_t at = head; at < content.size();) {
    const std::size_t left = content.size() - at;
    if (left < part_head || number(at) > left - part_head) throw std::runtime_error("one of its parts is cut short");
    const std::string_view part = content.substr(at + part_head, number(at));
    if (content.substr(at + 4, 4) == "JSON") json = part;
    if (content.substr(at + 4, 4) == std::string_view("BIN\0", 4)) binary = part;
    at += part_head + part.size();
  }
  return json;
}

struct Triangles {
  std::vector<double> positions;  ///< x, y, z of each vertex
  std::vector<double> indices;    ///< three a triangle
};

/// Of a primitive that is compressed by Draco. `position`: the number of that attribute.
Triangles decompressed(const GltfObject& primitive, std::string_view bytes, std::uint64_t position) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  const auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) primitive.refuse("Draco cannot decompress it: " + decoded.status().error_msg_string());
  const draco::Mesh& mesh = *decoded.value();
  const draco::PointAttribute* const points = mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(position));
  if (points == nullptr || points->num_components() != 3) primitive.refuse("what Draco decompresses has no positions");
  Triangles triangles;
  for (draco::PointIndex i(0); i < mesh.num_points(); ++i) {
    std::array<double, 3> p{};
    if (!points->ConvertValue<double, 3>(points->mapped_index(i), p.data())) primitive.refuse("a position is missing");
    triangles.positions.insert(triangles.positions.end(), p.begin(), p.end());
  }
  for (draco::FaceIndex i(0); i < mesh.num_faces(); ++i)
    for (const draco::PointIndex& corner : mesh.face(i)) triangles.indices.push_back(corner.value());
  return triangles;
}

/// Vertices of triangles, in order, of a mode: 4 triangles, 5 strip, 6 fan (3.7.2.1 of the specification).
std::vector<double> triangles_of(const GltfObject& primitive, std::uint64_t mode, std::vector<double> order) {
  const std::size_t count = order.size();
  if (mode > 6) primitive.refuse("its mode " + std::to_string(mode) + " is not known");
  if (mode == 4 ? count % 3 != 0 : count < 3)
    primitive.refuse(std::to_string(count) + " vertices make no whole triangles");
  if (mode == 4) return order;
  std::vector<double> triangles;
  for (std::size_t i = 0; i + 2 < count; ++i) {
    const std::array<std::size_t, 3> strip{i, i + 1 + i % 2, i + 2 - i % 2}, fan{i + 1, i + 2, 0};
    for (const std::size_t at : mode == 5 ? strip : fan) triangles.push_back(order[at]);
  }
  return triangles;
}

class GltfReader {
 public:
  GltfReader(const Json& json, std::string_view binary, const std::filesystem::path& folder)
      : document_(json, "glTF"), buffers_(document_, binary, folder) {}

  Mesh read() {
    check_version();
    check_extensions();
    read_nodes(shown_scene());
    if (lines_ > 0)
      builder_.note(std::to_string(lines_) + " of its primitives are points or lines, which make no face");
    if (document_.count("animations") > 0)
      builder_.note("its animations are not applied: every node stands where the file puts it at first");
    return builder_.take();
  }

 private:
  void check_version() const {
    const GltfObject asset = document_.object("asset");
    const std::string version = asset.text("version"), least = asset.text("minVersion");
    if (!version.starts_with("2.") || (!least.empty() && least != "2.0"))
      asset.refuse("glTF " + (least.empty() ? version : least) + " is not read, 2.0 is");
  }

  /// Those of colour, texture and light do not matter here.
  void check_extensions() {
    constexpr std::array kOfLooks{"KHR_materials_", "KHR_texture_", "EXT_texture_",  "KHR_lights_",
                                  "EXT_lights_",    "KHR_xmp",      "MSFT_texture_", "KHR_techniques_"};
    std::vector<std::string> required = document_.words("extensionsRequired");
    for (const std::string& name : document_.words("extensionsUsed")) {
      quantized_ = quantized_ || name == kQuantization;
      if (name == kQuantization || name == kDraco ||
          std::any_of(kOfLooks.begin(), kOfLooks.end(), [&](const char* start) { return name.starts_with(start); })) {
        std::erase(required, name);
        continue;
      }
      if (name == kInstances)
        document_.refuse("its instances (" + name + ") are not read: make them objects of their own");
      if (std::find(required.begin(), required.end(), name) == required.end())
        builder_.note("its extension " + name + " is not applied");
    }
    if (!required.empty())
      document_.refuse("it requires the extension " + required.front() + ", which is not read: leave it out");
  }

  GltfObject shown_scene() {
    const std::uint64_t scenes = document_.count("scenes"), shown = document_.whole("scene", 0);
    if (scenes > 1)
      builder_.note("it has " + std::to_string(scenes) + " scenes, of which number " + std::to_string(shown) +
                    ", counted from 0, is read");
    return document_.object("scenes", shown);
  }

  void read_nodes(const GltfObject& scene) {
    struct Place {
      std::uint64_t node;
      Affine map;
    };
    std::vector<char> seen(document_.count("nodes"), 0);
    std::vector<Place> open;  // a stack of our own: the depth of the tree is the file's choice
    const auto push = [&open](const std::vector<std::uint64_t>& nodes, const Affine& map) {
      for (std::size_t i = nodes.size(); i-- > 0;) open.push_back({nodes[i], map});  // the first is taken first
    };
    push(scene.indices("nodes"), {});
    while (!open.empty()) {
      const auto [index, outer] = open.back();
      open.pop_back();
      const GltfObject node = document_.object("nodes", index);
      if (std::exchange(seen[index], 1) != 0) node.refuse("it is in the scene more than once");
      const Affine map = product(outer, affine_of(node));
      if (node.has("mesh")) add_mesh(node, map);
      push(node.indices("children"), map);
    }
  }

  void add_mesh(const GltfObject& node, const Affine& map) {
    const GltfObject mesh = document_.object("meshes", node.whole("mesh"));
    if (node.has("skin")) node.refuse("its skin is not applied: apply the pose of its bones before exporting");
    const std::optional<std::vector<double>> own = node.numbers("weights"),
                                             weights = own ? own : mesh.numbers("weights");
    if (weights && std::any_of(weights->begin(), weights->end(), [](double w) { return w != 0.0; }))
      node.refuse("its morph targets are not applied: apply its shape keys before exporting");
    builder_.set_group(node.text("name"));
    for (std::uint64_t i = 0; i < mesh.count("primitives"); ++i) add_primitive(mesh.object("primitives", i), map);
  }

  void add_primitive(const GltfObject& primitive, const Affine& map) {
    const std::uint64_t mode = primitive.whole("mode", 4);
    if (mode < 4) {
      ++lines_;
      return;
    }
    builder_.set_material(
        primitive.has("material") ? document_.object("materials", primitive.whole("material")).text("name") : "");
    const Triangles part = triangles(primitive, mode);
    constexpr std::uint32_t unknown = std::numeric_limits<std::uint32_t>::max();
    const std::size_t count = part.positions.size() / 3;
    std::vector<std::uint32_t> numbers(count, unknown);  // of the vertices in the mesh
    const bool mirrored = determinant(map) < 0.0;        // seen from the other side: the corners run backwards
    std::array<std::uint32_t, 3> face{};
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double index = part.indices[i + k];
        if (!(index >= 0.0 && index < static_cast<double>(count)) || index != std::floor(index))
          primitive.refuse("a triangle has a vertex that is not there");
        const auto at = static_cast<std::size_t>(index);
        const double* const p = part.positions.data() + 3 * at;
        if (numbers[at] == unknown) numbers[at] = builder_.vertex(apply(map, {p[0], p[1], p[2]}));
        face[k] = numbers[at];
      }
      if (mirrored) std::reverse(face.begin(), face.end());
      builder_.add_face(face);
    }
  }

  Triangles triangles(const GltfObject& primitive, std::uint64_t mode) {
    const GltfObject accessor = document_.object("accessors", primitive.object("attributes").whole("POSITION"));
    if (primitive.has("extensions") && primitive.object("extensions").has(kDraco)) {
      const GltfObject draco = primitive.object("extensions").object(kDraco);
      Triangles part = decompressed(primitive, buffers_.view(draco.whole("bufferView")),
                                    draco.object("attributes").whole("POSITION"));
      if (mode != 4) primitive.refuse("a strip or a fan that Draco compressed is not read");
      return part;
    }
    constexpr std::uint64_t kFloat = 5126;
    if (accessor.whole("componentType") != kFloat && !quantized_)
      accessor.refuse("its positions are no floating-point numbers, which " + std::string(kQuantization) +
                      " would have to be named for");
    Triangles part{buffers_.values(accessor, "VEC3"), {}};
    std::vector<double> order(part.positions.size() / 3);
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<double>(i);
    if (primitive.has("indices"))
      order = buffers_.values(document_.object("accessors", primitive.whole("indices")), "SCALAR");
    part.indices = triangles_of(primitive, mode, std::move(order));
    return part;
  }

  GltfObject document_;
  GltfBuffers buffers_;
  MeshBuilder builder_;
  bool quantized_ = false;
  std::uint64_t lines_ = 0;  // primitives of points or lines
};

}  // namespace

Mesh read_gltf(std::string_view extension, std::string_view content, const std::filesystem::path& folder) {
  std::string_view binary;
  const std::string_view text = json_of(extension, content, binary);
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::exception& error) {
    throw std::runtime_error(std::string("its JSON is damaged: ") + error.what());
  }
  return GltfReader(json, binary, folder).read();
}

}  // namespace apps::scene
