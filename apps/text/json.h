// SPDX-License-Identifier: Apache-2.0
#pragma once

// A value of JSON: what results are put into before they are written, and what files and requests are read into.
// nlohmann/json writes and reads the text, in json.cpp alone: its templates took a third of a first build when every
// report saw them. The calls are named as there.

#include <concepts>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace apps {

class Json;

template <class Element, class T>
concept different_from = !std::same_as<std::remove_cvref_t<Element>, T>;

/// A list whose elements make values, but for text.
template <class T>
concept JsonList =
    !std::convertible_to<const T&, std::string_view> && !std::same_as<T, Json> && requires(const T& list) {
  { *list.begin() } -> different_from<T>;  // a path is a list of paths
  list.end();
};

/// Null, true or false, a number, a text, a list or an object, whose members keep the order in which they came.
class Json {
 public:
  using Member = std::pair<std::string, Json>;
  using List = std::vector<Json>;
  using Members = std::vector<Member>;

  Json() noexcept;
  Json(std::nullptr_t) noexcept;
  Json(std::string text);
  Json(std::string_view text);
  Json(const char* text);
  template <std::same_as<bool> T>  // a pointer is not a truth value
  Json(T value) : Json(Value(value)) {}
  template <std::integral T>
  requires(!std::same_as<T, bool>) Json(T value) : Json(whole(value)) {}
  template <std::floating_point T>
  Json(T value) : Json(Value(static_cast<double>(value))) {}
  template <class T>  // null where there is none
  Json(const std::optional<T>& value) {
    if (value) *this = Json(*value);
  }
  template <class A, class B>
  Json(const std::pair<A, B>& both) : Json({Json(both.first), Json(both.second)}) {}
  /// A list, of a map from names an object.
  template <JsonList T>
  Json(const T& list) {
    if constexpr (requires { typename T::mapped_type; }) {
      *this = object(list);
    } else {
      *this = array();
      for (const auto& element : list) push_back(Json(element));
    }
  }
  /// {{"a", 1}, {"b", 2}} is an object, as every element is a pair that begins with a text; {1, 2} is a list.
  Json(std::initializer_list<Json> elements);

  Json(const Json&);
  Json(Json&&) noexcept;
  Json& operator=(const Json&);
  Json& operator=(Json&&) noexcept;
  ~Json();

  static Json array();
  /// Of what `of`, a function or a member, is for each element.
  template <class Elements, class Of>
  static Json array(const Elements& elements, const Of& of) {
    Json json = array();
    for (const auto& element : elements) json.push_back(Json(std::invoke(of, element)));
    return json;
  }
  static Json object();
  /// Of pairs of a name and a value.
  template <class Pairs>
  static Json object(const Pairs& members) {
    Json json = object();
    for (const auto& [name, value] : members) json[name] = Json(value);
    return json;
  }

  bool is_null() const noexcept;
  bool is_boolean() const noexcept;
  bool is_number() const noexcept;
  bool is_number_integer() const noexcept;
  bool is_string() const noexcept;
  bool is_array() const noexcept;
  bool is_object() const noexcept;

  /// The value as bool, a number or std::string. Throws mtf::UsageError where it is of another type, or not within the
  /// range of a whole number.
  template <class T>
  T get() const;

  /// Elements of a list or members of an object; 0 of null, 1 of what has none.
  std::size_t size() const noexcept;
  bool empty() const noexcept { return size() == 0; }

  /// Appends to a list, which null becomes.
  void push_back(Json element);
  Json& back();
  const List& elements() const;  ///< of a list; throws mtf::UsageError of anything else
  List& elements();
  const Json& operator[](std::size_t index) const { return elements()[index]; }
  Json& operator[](std::size_t index) { return elements()[index]; }

  /// A member; null becomes an object, and a name that is not there is added as null.
  Json& operator[](std::string_view name);
  bool contains(std::string_view name) const noexcept { return find(name) != nullptr; }
  const Json* find(std::string_view name) const noexcept;  ///< null pointer where there is none
  const Json& at(std::string_view name) const;             ///< throws mtf::UsageError where there is none
  const Json& operator[](std::string_view name) const { return at(name); }
  const Members& items() const;  ///< of an object; throws mtf::UsageError of anything else
  Members& items();
  /// Adds the members of `other`, in place of those of the same names.
  void update(const Json& other);
  /// Members in the order of their names, here and below.
  void sort();

 private:
  using Value = std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, List, Members>;

  explicit Json(Value value) noexcept;
  template <std::integral T>
  static Value whole(T value) {
    if constexpr (std::signed_integral<T>)
      return static_cast<std::int64_t>(value);
    else
      return static_cast<std::uint64_t>(value);
  }
  [[noreturn]] void fail(const char* expected) const;

  Value value_;

  friend struct JsonText;
};

template <>
bool Json::get() const;
template <>
std::string Json::get() const;
template <>
double Json::get() const;
template <>
std::int64_t Json::get() const;
template <>
std::uint64_t Json::get() const;
template <>
int Json::get() const;

/// The text with a new line at its end, indented by `indent`, on one line where that is -1. Numbers that are not finite
/// are null; the others read back as the same double. JSON is UTF-8 and names of files are any bytes: those that are no
/// UTF-8 become U+FFFD, as a name that ended the writer would take the results of hours with it.
std::string json_document(const Json& json, int indent = 2);

/// The text; null where it is empty.
inline Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

/// Reads a text. Throws mtf::UsageError with the place where it is no JSON or nested more than 64 deep.
Json parse_json(std::string_view text);
/// None where it is no JSON.
std::optional<Json> parsed_json(std::string_view text);

}  // namespace apps
