// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/mesh_readers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "apps/scene/import/helper/mesh_builder.h"

namespace apps::scene {
namespace {

using radiometry::scene::Mesh;
using radiometry::scene::Point;

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
enum class Storage { text, little, big };

struct Property {
  std::string name;
  std::optional<Type> count;  ///< of a list
  Type type;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Storage storage = Storage::text;
  std::vector<Element> elements;
  std::uint64_t lines = 0;
};

[[noreturn]] void refuse(const std::string& what) { throw std::runtime_error(what); }

Type type_of(std::string_view word) {
  constexpr std::pair<std::string_view, Type> names[] = {
      {"char", Type::int8},     {"int8", Type::int8},       {"uchar", Type::uint8},    {"uint8", Type::uint8},
      {"short", Type::int16},   {"int16", Type::int16},     {"ushort", Type::uint16},  {"uint16", Type::uint16},
      {"int", Type::int32},     {"int32", Type::int32},     {"uint", Type::uint32},    {"uint32", Type::uint32},
      {"float", Type::float32}, {"float32", Type::float32}, {"double", Type::float64}, {"float64", Type::float64}};
  for (const auto& [name, type] : names)
    if (word == name) return type;
  refuse("the header has the unknown type \"" + std::string(word) + "\"");
}

Property property_of(std::string_view rest) {
  const std::string_view word = next_word(rest);
  if (word != "list") return {std::string(next_word(rest)), {}, type_of(word)};
  const Type count = type_of(next_word(rest)), type = type_of(next_word(rest));
  return {std::string(next_word(rest)), count, type};
}

/// Takes the header off `content`.
Header take_header(std::string_view& content) {
  Header header;
  bool first = true;
  for (;;) {
    const std::size_t end = content.find('\n');
    if (end == std::string_view::npos) refuse("its header has no end_header");
    std::string_view rest = content.substr(0, end);
    content.remove_prefix(end + 1);
    ++header.lines;
    const std::string_view key = next_word(rest);
    if (std::exchange(first, false) && key != "ply") refuse("it does not begin with \"ply\"");
    if (key == "end_header") return header;
    if (key == "format") {
      const std::string_view word = next_word(rest);
      if (word != "ascii" && word != "binary_little_endian" && word != "binary_big_endian")
        refuse("its format \"" + std::string(word) + "\" is not known");
      header.storage = word == "ascii" ? Storage::text : word == "binary_big_endian" ? Storage::big : Storage::little;
    } else if (key == "element") {
      const std::string name(next_word(rest));
      std::int64_t count = 0;
      if (!parse_number(next_word(rest), count) || count < 0)
        refuse("its number of elements \"" + name + "\" is wrong");
      header.elements.push_back({name, static_cast<std::uint64_t>(count), {}});
    } else if (key == "property") {
      if (header.elements.empty()) refuse("its header has a property before the first element");
      header.elements.back().properties.push_back(property_of(rest));
    }
  }
}

/// The values after the header, one after the other.
class Values {
 public:
  Values(const Header& header, std::string_view content)
      : storage_(header.storage), lines_(header.lines), all_(content), left_(content) {}

  double next(Type type) {
    if (storage_ == Storage::text) return next_text();
    switch (type) {
      case Type::int8:
        return next_binary<std::int8_t>();
      case Type::uint8:
        return next_binary<std::uint8_t>();
      case Type::int16:
        return next_binary<std::int16_t>();
      case Type::uint16:
        return next_binary<std::uint16_t>();
      case Type::int32:
        return next_binary<std::int32_t>();
      case Type::uint32:
        return next_binary<std::uint32_t>();
      case Type::float32:
        return static_cast<double>(next_binary<float>());
      case Type::float64:
        return next_binary<double>();
    }
    return 0.0;
  }

  /// After the last value of an element. In a text its line ends there: values that the header does not announce would
  /// be taken for the next element.
  void end_element(const std::string& element) {
    if (storage_ != Storage::text) return;
    const std::string_view line = left_.substr(0, left_.find('\n'));
    if (!trimmed(line).empty())
      refuse("line " + std::to_string(line_number()) + ": after the values of an element \"" + element +
             "\" that the header announces come more (" + std::string(trimmed(line).substr(0, 40)) + ")");
    left_.remove_prefix(line.size());
  }

  /// After the last element.
  void end() const {
    if (left_.find_first_not_of(std::string(blanks) + '\0') == std::string_view::npos) return;
    refuse((storage_ == Storage::text ? "line " + std::to_string(line_number()) + ": " : "") +
           "it goes on after all that its header announces, by " + std::to_string(left_.size()) + " bytes");
  }

  /// Every value takes at least a byte, so that more cannot come.
  std::uint64_t most() const { return left_.size(); }

 private:
  std::uint64_t line_number() const {
    const std::size_t at = all_.size() - left_.size() + std::min(left_.find_first_not_of(blanks), left_.size());
    return lines_ + 1 +
           static_cast<std::uint64_t>(std::count(all_.begin(), all_.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
  }

  double next_text() {
    const std::string_view word = next_word(left_);
    double value = 0.0;
    if (word.empty()) refuse("it ends before all that its header announces");
    if (!parse_number(word, value)) refuse("\"" + std::string(word) + "\" is no number");
    return value;
  }

  template <class T>
  T next_binary() {
    if (left_.size() < sizeof(T)) refuse("it ends before all that its header announces");
    std::array<char, sizeof(T)> bytes{};
    std::copy_n(left_.begin(), sizeof(T), bytes.begin());
    left_.remove_prefix(sizeof(T));
    if ((storage_ == Storage::big) != (std::endian::native == std::endian::big)) std::ranges::reverse(bytes);
    return std::bit_cast<T>(bytes);
  }

  Storage storage_;
  std::uint64_t lines_;  // of the header
  std::string_view all_, left_;
};

/// A whole number below `count` and 2^32, or an error.
std::uint32_t index_of(double value, std::uint64_t count, const char* what) {
  const double end = std::min(static_cast<double>(count), 0x1p32);
  if (!(value >= 0.0) || value >= end || value != std::floor(value)) refuse(what);
  return static_cast<std::uint32_t>(value);
}

/// Calls `take(property, values of it)` for each property of one element after the other.
template <class Take>
void read_element(const Element& element, Values& values, const Take& take) {
  if (element.properties.empty()) return;
  if (element.count > values.most()) refuse("it ends before all that its header announces");
  std::vector<double> list;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      const std::uint32_t count =
          property.count ? index_of(values.next(*property.count), values.most() + 1, "a list is longer than the file")
                         : 1;
      list.resize(count);
      for (double& value : list) value = values.next(property.type);
      take(property, list);
    }
    values.end_element(element.name);
  }
}

std::vector<Point> read_points(const Element& element, Values& values) {
  std::vector<Point> points;
  Point point{};
  const auto has = [&](std::string_view name) {
    return std::any_of(element.properties.begin(), element.properties.end(),
                       [name](const Property& property) { return property.name == name && !property.count; });
  };
  if (!has("x") || !has("y") || !has("z")) refuse("its vertices have no x, y and z");
  const Property* const last = &element.properties.back();
  read_element(element, values, [&](const Property& property, const std::vector<double>& list) {
    if (!property.count && property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z')
      point[static_cast<std::size_t>(property.name[0] - 'x')] = list[0];
    if (&property == last) points.push_back(point);
  });
  return points;
}

/// Calls `take(vertices)` for each list of vertices; of a strip -1 is among them.
template <class Take>
void read_vertex_lists(const Element& element, Values& values, const Take& take) {
  read_element(element, values, [&](const Property& property, const std::vector<double>& list) {
    if (property.name == "vertex_indices" || property.name == "vertex_index") take(list);
  });
}

std::uint32_t corner(double index, const std::vector<Point>& points, MeshBuilder& builder) {
  return builder.vertex(points[index_of(index, points.size(), "a face has a vertex that is not there")]);
}

void read_faces(const Element& element, Values& values, const std::vector<Point>& points, MeshBuilder& builder) {
  std::vector<std::uint32_t> face;
  read_vertex_lists(element, values, [&](const std::vector<double>& list) {
    face.clear();
    for (const double index : list) face.push_back(corner(index, points, builder));
    builder.add_face(face);
  });
}

/// Each vertex from the third on makes a triangle with the two before it; every other one is turned.
void read_strips(const Element& element, Values& values, const std::vector<Point>& points, MeshBuilder& builder) {
  std::vector<std::uint32_t> strip;
  read_vertex_lists(element, values, [&](const std::vector<double>& list) {
    strip.clear();
    for (const double index : list) {
      if (index == -1.0) {
        strip.clear();
        continue;
      }
      strip.push_back(corner(index, points, builder));
      const std::size_t n = strip.size();
      if (n < 3) continue;
      const std::size_t turn = n % 2 == 0 ? 1 : 0;
      builder.add_face(std::array{strip[n - 3 + turn], strip[n - 2 - turn], strip[n - 1]});
    }
  });
}

}  // namespace

Mesh read_ply(std::string_view content) {
  const Header header = take_header(content);
  Values values(header, content);
  MeshBuilder builder;
  std::vector<Point> points;
  for (const Element& element : header.elements) {
    if (element.name == "vertex")
      points = read_points(element, values);
    else if (element.name == "face")
      read_faces(element, values, points, builder);
    else if (element.name == "tristrips")
      read_strips(element, values, points, builder);
    else {
      read_element(element, values, [](const Property&, const std::vector<double>&) {});
      if (element.count > 0)
        builder.note("its " + std::to_string(element.count) + " elements \"" + element.name.substr(0, 40) +
                     "\" are not read");
    }
  }
  values.end();
  return builder.take();
}

}  // namespace apps::scene
