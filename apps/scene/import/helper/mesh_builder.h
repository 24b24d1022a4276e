// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the readers share: a mesh face by face, in which vertices with the same coordinates become one (-0 is 0), and
// the words and numbers of a text.

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "radiometry/scene/mesh.h"

namespace apps::scene {

class MeshBuilder {
 public:
  MeshBuilder() { mesh_.first.push_back(0); }

  /// Of the faces that follow; empty until then. A name that no face has is not in the mesh.
  void set_group(std::string_view name);
  void set_material(std::string_view name);

  /// The number of the vertex there. Throws std::runtime_error when there are 2^32.
  std::uint32_t vertex(radiometry::scene::Point point);
  /// Of whatever number of corners: facets_of leaves out what has fewer than three, and counts it.
  void add_face(std::span<const std::uint32_t> vertices);

  /// Of what the file holds and the mesh does not; once each.
  void note(const std::string& text);

  radiometry::scene::Mesh take() { return std::move(mesh_); }

 private:
  struct PointHash {
    std::size_t operator()(const radiometry::scene::Point& point) const;
  };

  radiometry::scene::Mesh mesh_;
  std::unordered_map<radiometry::scene::Point, std::uint32_t, PointHash> vertices_;
  std::unordered_map<std::string, std::uint32_t> groups_, materials_;
  std::string group_name_, material_name_;
  std::optional<std::uint32_t> group_, material_;  // numbers of the names, once a face has them
};

// Words and numbers of a text, whatever the locale.

constexpr std::string_view blanks = " \t\r\n\v\f";

inline std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

/// Takes the next word off `text`; empty at the end.
inline std::string_view next_word(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(blanks));
  text.remove_prefix(word.size());
  return word;
}

/// False when the word is not a number of this type, or is more than that number. Of real ones `nan` and `inf` are.
template <class T>
bool parse_number(std::string_view word, T& value) {
  if (word.starts_with('+')) word.remove_prefix(1);  // which from_chars does not know
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace apps::scene
