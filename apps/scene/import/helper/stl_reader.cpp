// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/mesh_readers.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/scene/import/helper/mesh_builder.h"

namespace apps::scene {
namespace {

using radiometry::scene::Mesh;
using radiometry::scene::Point;

constexpr std::size_t kHead = 84, kTriangle = 50;

std::string lower(std::string_view word) {
  std::string text(word);
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

Mesh read_binary(std::string_view content) {
  MeshBuilder builder;
  for (std::size_t at = kHead; at < content.size(); at += kTriangle) {
    std::array<float, 12> values{};  // little-endian, as we are
    std::memcpy(values.data(), content.data() + at, sizeof values);
    std::array<std::uint32_t, 3> face{};
    for (std::size_t k = 0; k < 3; ++k)
      face[k] = builder.vertex({values[3 * k + 3], values[3 * k + 4], values[3 * k + 5]});
    builder.add_face(face);
  }
  return builder.take();
}

class TextStl {
 public:
  explicit TextStl(std::string_view text) : all_(text), left_(text) {}

  Mesh read() {
    for (std::string word; !(word = lower(next_word(left_))).empty();) {
      if (word == "solid" || word == "endsolid") {
        if (in_loop_) refuse("the loop before it has no end");
        open_ = word == "solid";
        std::string_view name = left_.substr(0, left_.find('\n'));
        left_.remove_prefix(name.size());
        if (open_) builder_.set_group(next_word(name));
      } else if (in_loop_ && (word == "facet" || word == "outer" || word == "endfacet")) {
        refuse("the loop before it has no end");
      } else if (word == "facet") {  // normal x y z
        for (int i = 0; i < 4; ++i) static_cast<void>(next_word(left_));
      } else if (word == "outer") {  // loop
        static_cast<void>(next_word(left_));
        in_loop_ = true;
      } else if (word == "vertex" && in_loop_) {
        add_vertex();
      } else if (word == "endloop" && in_loop_) {
        builder_.add_face(face_);
        face_.clear();
        in_loop_ = false;
      } else if (word != "endfacet") {
        refuse("\"" + word.substr(0, 40) + "\" does not belong there");
      }
    }
    if (open_) refuse("it ends before endsolid");
    return builder_.take();
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    const auto read = static_cast<std::ptrdiff_t>(all_.size() - left_.size());
    throw std::runtime_error("line " + std::to_string(1 + std::count(all_.begin(), all_.begin() + read, '\n')) + ": " +
                             what);
  }

  void add_vertex() {
    Point point{};
    for (double& x : point)
      if (!parse_number(next_word(left_), x)) refuse("a vertex needs three numbers");
    face_.push_back(builder_.vertex(point));
  }

  std::string_view all_, left_;
  bool open_ = false, in_loop_ = false;
  std::vector<std::uint32_t> face_;
  MeshBuilder builder_;
};

}  // namespace

Mesh read_stl(std::string_view content) {
  std::uint32_t triangles = 0;
  if (content.size() >= kHead) std::memcpy(&triangles, content.data() + kHead - sizeof triangles, sizeof triangles);
  const std::uint64_t size = kHead + kTriangle * std::uint64_t{triangles};
  if (content.size() >= kHead && content.size() == size) return read_binary(content);
  if (lower(trimmed(content).substr(0, 5)) == "solid" && content.find('\0') == std::string_view::npos)
    return TextStl(content).read();
  throw std::runtime_error("it announces " + std::to_string(triangles) + " triangles in " + std::to_string(size) +
                           " bytes and has " + std::to_string(content.size()) + ", or it is no STL file");
}

}  // namespace apps::scene
