// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/gltf_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "apps/scene/import/helper/buffer_file.h"

namespace apps::scene {
namespace {

using Json = nlohmann::json;

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

std::uint64_t whole_of(const Json& json, const GltfObject& owner, const std::string& key) {
  if (json.is_number_unsigned()) return json.get<std::uint64_t>();
  const double value = json.is_number_float() ? json.get<double>() : -1.0;
  if (value >= 0.0 && value < 0x1p53 && value == std::floor(value)) return static_cast<std::uint64_t>(value);
  const std::string is = json.is_primitive() ? json.dump(-1, ' ', true).substr(0, 40) : "a list or an object";
  owner.refuse(key + " is " + is + ", where a whole number from 0 belongs");
}

}  // namespace

GltfObject::GltfObject(const Json& json, std::string place) : json_(&json), place_(std::move(place)) {
  if (!json.is_object()) refuse("it is no object");
}

void GltfObject::refuse(const std::string& what) const { throw std::runtime_error(place_ + ": " + what); }

std::uint64_t GltfObject::whole(const char* key, std::optional<std::uint64_t> missing) const {
  const auto found = json_->find(key);
  if (found != json_->end()) return whole_of(*found, *this, key);
  if (!missing) refuse(std::string(key) + " is missing");
  return *missing;
}

std::string GltfObject::text(const char* key) const {
  const auto found = json_->find(key);
  return found != json_->end() && found->is_string() ? found->get<std::string>() : "";
}

std::optional<std::vector<double>> GltfObject::numbers(const char* key) const {
  if (!has(key)) return std::nullopt;
  std::vector<double> values;
  for (const Json& value : json_->at(key)) {
    if (!value.is_number()) refuse(std::string(key) + " has something that is no number");
    values.push_back(value.get<double>());
  }
  return values;
}

std::vector<std::uint64_t> GltfObject::indices(const char* key) const {
  std::vector<std::uint64_t> values;
  if (has(key))
    for (const Json& value : json_->at(key)) values.push_back(whole_of(value, *this, key));
  return values;
}

std::vector<std::string> GltfObject::words(const char* key) const {
  std::vector<std::string> values;
  if (has(key))
    for (const Json& value : json_->at(key)) values.push_back(value.is_string() ? value.get<std::string>() : "");
  return values;
}

GltfObject GltfObject::object(const char* key) const {
  if (!has(key)) refuse(std::string(key) + " is missing");
  return {json_->at(key), place_ + "." + key};
}

GltfObject GltfObject::object(const char* list, std::uint64_t index) const {
  const std::string place =
      (place_ == "glTF" ? "" : place_ + ".") + list + std::string("[") + std::to_string(index) + "]";
  if (index >= count(list)) throw std::runtime_error(place + " is not there");
  return {json_->at(list)[index], place};
}

std::uint64_t GltfObject::count(const char* list) const {
  return has(list) && json_->at(list).is_array() ? json_->at(list).size() : 0;
}

std::string_view GltfBuffers::buffer(std::uint64_t index) {
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

std::string_view GltfBuffers::view(std::uint64_t index) {
  const GltfObject view = document_.object("bufferViews", index);
  const std::string_view bytes = buffer(view.whole("buffer"));
  const std::uint64_t offset = view.whole("byteOffset", 0), length = view.whole("byteLength");
  if (offset > bytes.size() || length > bytes.size() - offset) view.refuse("it reaches beyond the end of its buffer");
  return bytes.substr(offset, length);
}

std::vector<double> GltfBuffers::elements(const GltfObject& place, std::uint64_t count, std::uint64_t width,
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

std::vector<double> GltfBuffers::values(const GltfObject& accessor, std::string_view type) {
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

}  // namespace apps::scene
