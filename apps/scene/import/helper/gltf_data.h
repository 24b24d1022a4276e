// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a glTF 2.0 file (Khronos; ISO/IEC 12113:2022) keeps its numbers in:
//   buffer       bytes: base64 in the file, a file in its folder, or the binary part of a .glb file
//   bufferView   offset and length in a buffer, and the stride of its elements
//   accessor     elements of one or more components in a bufferView, or zeros; `sparse` replaces some of them
// Offsets, lengths and indices have to be whole numbers from 0, and what they point at has to be there. All errors are
// std::runtime_error, with the object that is at fault, such as accessors[3].

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace apps::scene {

/// An object of the JSON, which has to outlive it, and where it stands.
class GltfObject {
 public:
  GltfObject(const nlohmann::json& json, std::string place);

  [[noreturn]] void refuse(const std::string& what) const;
  bool has(const char* key) const { return json_->contains(key); }
  std::uint64_t whole(const char* key, std::optional<std::uint64_t> missing = {}) const;
  std::string text(const char* key) const;  ///< "" when there is none
  bool flag(const char* key) const { return has(key) && (*json_)[key] == true; }
  std::optional<std::vector<double>> numbers(const char* key) const;  ///< nothing when there are none
  std::vector<std::uint64_t> indices(const char* key) const;          ///< empty when there are none
  std::vector<std::string> words(const char* key) const;              ///< empty when there are none
  GltfObject object(const char* key) const;
  GltfObject object(const char* list, std::uint64_t index) const;
  std::uint64_t count(const char* list) const;  ///< 0 when there is none

 private:
  const nlohmann::json* json_;
  std::string place_;
};

class GltfBuffers {
 public:
  /// `binary`: of a .glb file; `folder`: of the buffers of a .gltf file, empty when there may be none.
  GltfBuffers(GltfObject document, std::string_view binary, std::filesystem::path folder)
      : document_(std::move(document)), binary_(binary), folder_(std::move(folder)) {}

  std::string_view view(std::uint64_t index);
  /// The components of all elements, one after the other: three an element for "VEC3", one for "SCALAR". Integers that
  /// are marked as normalized come as -1 to 1 or 0 to 1.
  std::vector<double> values(const GltfObject& accessor, std::string_view type);

 private:
  std::string_view buffer(std::uint64_t index);
  std::vector<double> elements(const GltfObject& place, std::uint64_t count, std::uint64_t width,
                               std::uint64_t component, bool normalized);

  GltfObject document_;
  std::string_view binary_;
  std::filesystem::path folder_;
  std::map<std::uint64_t, std::string> loaded_;
};

}  // namespace apps::scene
