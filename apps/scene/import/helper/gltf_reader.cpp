// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/mesh_readers.h"

#include <draco/compression/decode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/scene/import/helper/buffer_file.h"
#include "apps/scene/import/helper/mesh_builder.h"

namespace apps::scene {
namespace {

using Json = nlohmann::json;
using radiometry::scene::Mesh;
using radiometry::scene::Point;

// What a glTF 2.0 file (Khronos; ISO/IEC 12113:2022) keeps its numbers in:
//   buffer       bytes: base64 in the file, a file in its folder, or the binary part of a .glb file
//   bufferView   offset and length in a buffer, and the stride of its elements
//   accessor     elements of one or more components in a bufferView, or zeros; `sparse` replaces some of them
// Offsets, lengths and indices have to be whole numbers from 0, and what they point at has to be there. All errors are
// std::runtime_error, with the object that is at fault, such as accessors[3].

/// An object of the JSON, which has to outlive it, and where it stands.
class GltfObject {
 public:
  GltfObject(const Json& json, std::string place) : json_(&json), place_(std::move(place)) {
    if (!json.is_object()) refuse("it is no object");
  }

  [[noreturn]] void refuse(const std::string& what) const { throw std::runtime_error(place_ + ": " + what); }
  bool has(const char* key) const { return json_->contains(key); }
  std::uint64_t whole(const char* key, std::optional<std::uint64_t> missing = {}) const {
    const auto found = json_->find(key);
    if (found != json_->end()) return whole_of(*found, key);
    if (!missing) refuse(std::string(key) + " is missing");
    return *missing;
  }
  /// "" when there is none.
  std::string text(const char* key) const {
    const auto found = json_->find(key);
    return found != json_->end() && found->is_string() ? found->get<std::string>() : "";
  }
  bool flag(const char* key) const { return has(key) && (*json_)[key] == true; }
  /// Nothing when there are none.
  std::optional<std::vector<double>> numbers(const char* key) const {
    if (!has(key)) return std::nullopt;
    std::vector<double> values;
    for (const Json& value : json_->at(key)) {
      if (!value.is_number()) refuse(std::string(key) + " has something that is no number");
      values.push_back(value.get<double>());
    }
    return values;
  }
  // Empty when there are none, and 0.
  std::vector<std::uint64_t> indices(const char* key) const {
    std::vector<std::uint64_t> values;
    if (has(key))
      for (const Json& value : json_->at(key)) values.push_back(whole_of(value, key));
    return values;
  }
  std::vector<std::string> words(const char* key) const {
    std::vector<std::string> values;
    if (has(key))
      for (const Json& value : json_->at(key)) values.push_back(value.is_string() ? value.get<std::string>() : "");
    return values;
  }
  std::uint64_t count(const char* list) const {
    return has(list) && json_->at(list).is_array() ? json_->at(list).size() : 0;
  }

  GltfObject object(const char* key) const {
    if (!has(key)) refuse(std::string(key) + " is missing");
    return {json_->at(key), place_ + "." + key};
  }
  GltfObject object(const char* list, std::uint64_t index) const {
    const std::string place =
        (place_ == "glTF" ? "" : place_ + ".") + list + std::string("[") + std::to_string(index) + "]";
    if (index >= count(list)) throw std::runtime_error(place + " is not there");
    return {json_->at(list)[index], place};
  }

 private:
  std::uint64_t whole_of(const Json& json, const std::string& key) const {
    if (json.is_number_unsigned()) return json.get<std::uint64_t>();
    const double value = json.is_number_float() ? json.get<double>() : -1.0;
    if (value >= 0.0 && value < 0x1p53 && value == std::floor(value)) return static_cast<std::uint64_t>(value);
    const std::string is = json.is_primitive() ? json.dump(-1, ' ', true).substr(0, 40) : "a list or an object";
    refuse(key + " is " + is + ", where a whole number from 0 belongs");
  }

  const Json* json_;
  std::string place_;
};

std::string base64_decoded(const GltfObject& buffer, std::string_view text) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  static const auto value_of = [digits] {
    std::array<int, 256> values{};
    values.fill(-1);
    for (std::size_t i = 0; i < digits.size(); ++i) values[static_cast<unsigned char>(digits[i])] = static_cast<int>(i);
    return values;
  }();
  while (text.ends_with('=')) text.remove_suffix(1);
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  unsigned bits = 0;
  int held = 0;
  for (const char c : text) {
    const int value = value_of[static_cast<unsigned char>(c)];
    if (value < 0) buffer.refuse("its base64 has a character that is none");
    bits = bits << 6U | static_cast<unsigned>(value);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> static_cast<unsigned>(held) & 0xffU);
  }
  return bytes;
}

/// The value at `from`; normalized integers divided by the largest, and no less than -1.
template <class T>
double component_at(const char* from, bool normalized) {
  T value{};
  std::memcpy(&value, from, sizeof value);  // the format is little-endian, as we are
  const auto number = static_cast<double>(value);
  return normalized ? std::max(number / static_cast<double>(std::numeric_limits<T>::max()), -1.0) : number;
}

struct Component {
  std::uint64_t type, bytes;
  double (*read)(const char*, bool);
};
constexpr std::array kComponents{
    Component{5120, 1, component_at<std::int8_t>},   Component{5121, 1, component_at<std::uint8_t>},
    Component{5122, 2, component_at<std::int16_t>},  Component{5123, 2, component_at<std::uint16_t>},
    Component{5125, 4, component_at<std::uint32_t>}, Component{5126, 4, component_at<float>}};

class GltfBuffers {
 public:
  /// `binary`: of a .glb file; `folder`: of the buffers of a .gltf file, empty when there may be none.
  GltfBuffers(GltfObject document, std::string_view binary, std::filesystem::path folder)
      : document_(std::move(document)), binary_(binary), folder_(std::move(folder)) {}

  std::string_view view(std::uint64_t index) {
    const GltfObject view = document_.object("bufferViews", index);
    const std::string_view bytes = buffer(view.whole("buffer"));
    const std::uint64_t offset = view.whole("byteOffset", 0), length = view.whole("byteLength");
    if (offset > bytes.size() || length > bytes.size() - offset) view.refuse("it reaches beyond the end of its buffer");
    return bytes.substr(offset, length);
  }
  /// The components of all elements, one after the other: three an element for "VEC3", one for "SCALAR". Integers that
  /// are marked as normalized come as -1 to 1 or 0 to 1.
  std::vector<double> values(const GltfObject& accessor, std::string_view type) {
    if (accessor.text("type") != type)
      accessor.refuse("its type is \"" + accessor.text("type") + "\", where " + std::string(type) + " belongs");
    const std::uint64_t width = type == "VEC3" ? 3 : 1, count = accessor.whole("count");
    if (count > 0xffffffff) accessor.refuse("it announces more elements than an index can name");
    const std::uint64_t component = accessor.whole("componentType");
    const bool normalized = accessor.flag("normalized");
    std::vector<double> values;
    if (accessor.has("bufferView"))
      values = elements(accessor, count, width, component, normalized);
    else
      values.resize(count * width);
    if (!accessor.has("sparse")) return values;
    const GltfObject sparse = accessor.object("sparse"), where = sparse.object("indices");
    const std::uint64_t replaced = sparse.whole("count");
    const std::vector<double> at = elements(where, replaced, 1, where.whole("componentType"), false);
    const std::vector<double> by = elements(sparse.object("values"), replaced, width, component, normalized);
    for (std::uint64_t i = 0; i < replaced; ++i) {
      if (!(at[i] >= 0.0 && at[i] < static_cast<double>(count)) || at[i] != std::floor(at[i]))
        where.refuse("it names an element that is not there");
      std::copy_n(by.begin() + static_cast<std::ptrdiff_t>(i * width), width,
                  values.begin() + static_cast<std::ptrdiff_t>(static_cast<std::uint64_t>(at[i]) * width));
    }
    return values;
  }

 private:
  std::string_view buffer(std::uint64_t index) {
    const GltfObject buffer = document_.object("buffers", index);
    const std::uint64_t length = buffer.whole("byteLength");
    std::string_view bytes = binary_;
    if (const std::string uri = buffer.text("uri"); !uri.empty()) {
      auto found = loaded_.find(index);
      if (found == loaded_.end()) {
        constexpr std::string_view mark = ";base64,";
        const std::size_t data = uri.starts_with("data:") ? uri.find(mark) : std::string::npos;
        std::optional<std::string> content;
        if (data != std::string::npos)
          content = base64_decoded(buffer, std::string_view(uri).substr(data + mark.size()));
        else
          content = buffer_file(folder_, uri);
        if (!content) buffer.refuse("\"" + uri.substr(0, 100) + "\" is no file in the folder of the mesh");
        found = loaded_.emplace(index, std::move(*content)).first;
      }
      bytes = found->second;
    } else if (index != 0 || binary_.empty()) {
      buffer.refuse("its bytes are not there");
    }
    if (length > bytes.size())
      buffer.refuse("it has " + std::to_string(bytes.size()) + " of its " + std::to_string(length) + " bytes");
    return bytes.substr(0, length);
  }
  std::vector<double> elements(const GltfObject& place, std::uint64_t count, std::uint64_t width,
                               std::uint64_t component, bool normalized) {
    const auto* const kind = std::find_if(kComponents.begin(), kComponents.end(),
                                          [component](const Component& c) { return c.type == component; });
    if (kind == kComponents.end()) place.refuse("its componentType " + std::to_string(component) + " is not known");
    const std::uint64_t view = place.whole("bufferView"), offset = place.whole("byteOffset", 0);
    const std::string_view bytes = this->view(view);
    const std::uint64_t element = width * kind->bytes;
    const std::uint64_t stride = document_.object("bufferViews", view).whole("byteStride", element);
    if (stride < element) place.refuse("the stride of its bufferView is less than an element");
    const bool fits = offset <= bytes.size() && element <= bytes.size() - offset &&
                      count - 1 <= (bytes.size() - offset - element) / stride;
    if (count > 0 && !fits) place.refuse("it reaches beyond the end of its bufferView");
    std::vector<double> values;
    values.reserve(count * width);
    for (std::uint64_t i = 0; i < count; ++i)
      for (std::uint64_t k = 0; k < width; ++k)
        values.push_back(
            kind->read(bytes.data() + offset + i * stride + k * kind->bytes, normalized && component < 5125));
    return values;
  }

  GltfObject document_;
  std::string_view binary_;
  std::filesystem::path folder_;
  std::map<std::uint64_t, std::string> loaded_;
};

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
