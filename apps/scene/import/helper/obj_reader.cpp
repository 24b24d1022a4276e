// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/mesh_readers.h"

#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/scene/import/helper/mesh_builder.h"

namespace apps::scene {
namespace {

using radiometry::scene::Mesh;
using radiometry::scene::Point;

constexpr std::uint32_t unknown = std::numeric_limits<std::uint32_t>::max();

class ObjReader {
 public:
  explicit ObjReader(std::string_view text) : text_(text) {}

  Mesh read() {
    while (!text_.empty()) {
      const std::string_view line = next_line();
      std::string_view rest = line;
      const std::string_view key = next_word(rest);
      if (key == "v")
        add_vertex(rest);
      else if (key == "f" || key == "fo")
        add_face(rest);
      else if (key == "g" || key == "o")
        builder_.set_group(trimmed(rest));
      else if (key == "usemtl")
        builder_.set_material(trimmed(rest));
      else if (!key.empty() && !key.starts_with('#'))
        pass_over(key);
    }
    note_passed(no_face_, "make no face");
    note_passed(unknown_, "are no statements of OBJ that are known here");
    return builder_.take();
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw std::runtime_error("line " + std::to_string(line_) + ": " + what);
  }

  struct Passed {
    std::uint64_t count = 0, line = 0;
    std::string key;
  };

  // What has no part in polygons goes without a word; surfaces do, and so do other files.
  void pass_over(std::string_view key) {
    constexpr std::string_view no_part =
        " vn vt vp s mg mtllib usemap maplib lod bevel c_interp d_interp shadow_obj trace_obj ctech stech cstype deg "
        "bmat step parm trim hole scrv sp end con res ";
    constexpr std::string_view surfaces = " surf bsp bzp cdp ", files = " call csh ", lines = " l p curv curv2 cdc ";
    const std::string word = " " + std::string(key) + " ";
    if (no_part.find(word) != std::string_view::npos) return;
    if (surfaces.find(word) != std::string_view::npos)
      refuse("a free-form surface (" + std::string(key) + ") is not read: make polygons of it before exporting");
    if (files.find(word) != std::string_view::npos)
      refuse("what the file takes in from elsewhere (" + std::string(key) + ") is not read: put it into one file");
    Passed& passed = lines.find(word) != std::string_view::npos ? no_face_ : unknown_;
    if (passed.count++ == 0) passed.line = line_, passed.key = key.substr(0, 20);
  }

  void note_passed(const Passed& passed, const char* why) {
    if (passed.count > 0)
      builder_.note(std::to_string(passed.count) + " lines of the file, the first of them line " +
                    std::to_string(passed.line) + " with \"" + passed.key + "\", " + why);
  }

  // With what continues it; only then is it a copy.
  std::string_view next_line() {
    line_ += continuations_ + 1;
    continuations_ = 0;
    std::string_view line = raw_line();
    if (!line.ends_with('\\')) return line;
    joined_.clear();
    while (line.ends_with('\\')) {
      joined_ += line.substr(0, line.size() - 1);
      joined_ += ' ';
      line = raw_line();
      ++continuations_;
    }
    return joined_ += line;
  }

  std::string_view raw_line() {
    const std::size_t end = text_.find('\n');
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  void add_vertex(std::string_view rest) {
    Point point{};
    for (double& x : point)
      if (!parse_number(next_word(rest), x)) refuse("a vertex needs three numbers");
    points_.push_back(point);
    numbers_.push_back(unknown);
  }

  void add_face(std::string_view rest) {
    face_.clear();
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest))
      face_.push_back(corner(word.substr(0, word.find('/'))));
    builder_.add_face(face_);
  }

  std::uint32_t corner(std::string_view word) {
    std::int64_t index = 0;
    if (!parse_number(word, index)) refuse("\"" + std::string(word) + "\" is no vertex of a face");
    const auto count = static_cast<std::int64_t>(points_.size());
    const std::int64_t at = index < 0 ? count + index : index - 1;
    if (at < 0 || at >= count)
      refuse("a face has vertex " + std::to_string(index) + " of the " + std::to_string(count) + " before it");
    std::uint32_t& number = numbers_[static_cast<std::size_t>(at)];
    if (number == unknown) number = builder_.vertex(points_[static_cast<std::size_t>(at)]);
    return number;
  }

  std::string_view text_;
  std::string joined_;
  std::uint64_t line_ = 0, continuations_ = 0;
  std::vector<Point> points_;
  std::vector<std::uint32_t> numbers_;  // of each point in the mesh
  std::vector<std::uint32_t> face_;
  Passed no_face_, unknown_;
  MeshBuilder builder_;
};

}  // namespace

Mesh read_obj(std::string_view text) { return ObjReader(text).read(); }

}  // namespace apps::scene
