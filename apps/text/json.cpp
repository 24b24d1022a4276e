// SPDX-License-Identifier: Apache-2.0
#include "apps/text/json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mtf/error.h"

namespace apps {
namespace {

constexpr int kDeepest = 64;  // what is nested deeper would use up the stack

/// How many lists and objects are open at once. Known before the text is parsed, as a parser that asks at each of them
/// takes quadratic time.
int deepest(std::string_view text) {
  int open = 0, most = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\')
      ++i;
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && (c == '[' || c == '{'))
      most = std::max(most, ++open);
    else if (!quoted && (c == ']' || c == '}'))
      --open;
  }
  return most;
}

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};

}  // namespace

/// Between the value and nlohmann/json.
struct JsonText {
  using Text = nlohmann::ordered_json;

  static Text text_of(const Json& json) {
    return std::visit(Overloaded{[](std::monostate) { return Text(); },
                                 [](const Json::List& list) {
                                   Text text = Text::array();
                                   for (const Json& element : list) text.push_back(text_of(element));
                                   return text;
                                 },
                                 [](const Json::Members& members) {
                                   Text text = Text::object();
                                   for (const auto& [name, value] : members) text.emplace(name, text_of(value));
                                   return text;
                                 },
                                 [](const auto& value) { return Text(value); }},
                      json.value_);
  }

  static Json value_of(Text& text) {
    using Type = Text::value_t;
    switch (text.type()) {
      case Type::boolean:
        return text.get<bool>();
      case Type::number_integer:
        return text.get<std::int64_t>();
      case Type::number_unsigned:
        return text.get<std::uint64_t>();
      case Type::number_float:
        return text.get<double>();
      case Type::string:
        return std::move(text.get_ref<std::string&>());
      case Type::array: {
        Json list = Json::array();
        for (Text& element : text) list.push_back(value_of(element));
        return list;
      }
      case Type::object: {
        Json object = Json::object();
        for (auto& [name, value] : text.items()) object[name] = value_of(value);
        return object;
      }
      default:
        return {};
    }
  }
};

Json::Json() noexcept = default;
Json::Json(std::nullptr_t) noexcept {}
Json::Json(std::string text) : value_(std::move(text)) {}
Json::Json(std::string_view text) : value_(std::string(text)) {}
Json::Json(const char* text) : value_(std::string(text)) {}
Json::Json(Value value) noexcept : value_(std::move(value)) {}
Json::Json(const Json&) = default;
Json::Json(Json&&) noexcept = default;
Json& Json::operator=(const Json&) = default;
Json& Json::operator=(Json&&) noexcept = default;
Json::~Json() = default;

Json::Json(std::initializer_list<Json> elements) {
  const bool object = std::all_of(elements.begin(), elements.end(), [](const Json& element) {
    return element.is_array() && element.size() == 2 && element[0].is_string();
  });
  if (!object) {
    value_ = List(elements);
    return;
  }
  value_ = Members();
  for (const Json& element : elements) (*this)[std::get<std::string>(element[0].value_)] = element[1];
}

Json Json::array() { return Json(Value(List())); }
Json Json::object() { return Json(Value(Members())); }

bool Json::is_null() const noexcept { return std::holds_alternative<std::monostate>(value_); }
bool Json::is_boolean() const noexcept { return std::holds_alternative<bool>(value_); }
bool Json::is_number() const noexcept { return is_number_integer() || std::holds_alternative<double>(value_); }
bool Json::is_number_integer() const noexcept {
  return std::holds_alternative<std::int64_t>(value_) || std::holds_alternative<std::uint64_t>(value_);
}
bool Json::is_string() const noexcept { return std::holds_alternative<std::string>(value_); }
bool Json::is_array() const noexcept { return std::holds_alternative<List>(value_); }
bool Json::is_object() const noexcept { return std::holds_alternative<Members>(value_); }

void Json::fail(const char* expected) const {
  std::string is = json_document(*this, -1);
  is.pop_back();
  std::size_t shown = 40;
  while (shown < is.size() && (static_cast<unsigned char>(is[shown]) & 0xC0U) == 0x80U) ++shown;  // ends a character
  throw mtf::UsageError("expected " + std::string(expected) + ", there is " +
                        (is.size() > shown ? is.substr(0, shown) + "..." : is));
}

template <>
bool Json::get() const {
  if (!is_boolean()) fail("true or false");
  return std::get<bool>(value_);
}

template <>
std::string Json::get() const {
  if (!is_string()) fail("a text");
  return std::get<std::string>(value_);
}

template <>
double Json::get() const {
  if (const auto* value = std::get_if<double>(&value_)) return *value;
  if (const auto* value = std::get_if<std::int64_t>(&value_)) return static_cast<double>(*value);
  if (const auto* value = std::get_if<std::uint64_t>(&value_)) return static_cast<double>(*value);
  fail("a number");
}

template <>
std::int64_t Json::get() const {
  if (const auto* value = std::get_if<std::int64_t>(&value_)) return *value;
  if (const auto* value = std::get_if<std::uint64_t>(&value_); value && std::in_range<std::int64_t>(*value))
    return static_cast<std::int64_t>(*value);
  fail("a whole number");
}

template <>
std::uint64_t Json::get() const {
  if (const auto* value = std::get_if<std::uint64_t>(&value_)) return *value;
  if (const auto* value = std::get_if<std::int64_t>(&value_); value && *value >= 0)
    return static_cast<std::uint64_t>(*value);
  fail("a whole number that is not negative");
}

template <>
int Json::get() const {
  const auto value = get<std::int64_t>();
  if (!std::in_range<int>(value)) fail("a whole number of 32 bits");
  return static_cast<int>(value);
}

std::size_t Json::size() const noexcept {
  if (const auto* list = std::get_if<List>(&value_)) return list->size();
  if (const auto* members = std::get_if<Members>(&value_)) return members->size();
  return is_null() ? 0 : 1;
}

void Json::push_back(Json element) {
  if (is_null()) value_ = List();
  elements().push_back(std::move(element));
}

const Json::List& Json::elements() const {
  if (!is_array()) fail("a list");
  return std::get<List>(value_);
}

Json::List& Json::elements() { return const_cast<List&>(std::as_const(*this).elements()); }

Json& Json::back() { return elements().back(); }

const Json::Members& Json::items() const {
  if (!is_object()) fail("an object");
  return std::get<Members>(value_);
}

Json::Members& Json::items() { return const_cast<Members&>(std::as_const(*this).items()); }

const Json* Json::find(std::string_view name) const noexcept {
  const auto* members = std::get_if<Members>(&value_);
  if (!members) return nullptr;
  const auto found = std::find_if(members->begin(), members->end(), [&](const Member& m) { return m.first == name; });
  return found == members->end() ? nullptr : &found->second;
}

const Json& Json::at(std::string_view name) const {
  if (const Json* member = find(name)) return *member;
  fail(("an object with \"" + std::string(name) + "\"").c_str());
}

Json& Json::operator[](std::string_view name) {
  if (is_null()) value_ = Members();
  if (const Json* member = find(name)) return const_cast<Json&>(*member);
  return items().emplace_back(name, Json()).second;
}

void Json::update(const Json& other) {
  for (const auto& [name, value] : other.items()) (*this)[name] = value;
}

void Json::sort() {
  if (auto* list = std::get_if<List>(&value_))
    for (Json& element : *list) element.sort();
  if (auto* members = std::get_if<Members>(&value_)) {
    std::sort(members->begin(), members->end(), [](const Member& a, const Member& b) { return a.first < b.first; });
    for (Member& member : *members) member.second.sort();
  }
}

std::string json_document(const Json& json, int indent) {
  return JsonText::text_of(json).dump(indent, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

Json parse_json(std::string_view text) {
  if (deepest(text) > kDeepest) throw mtf::UsageError("nested too deeply");
  try {
    JsonText::Text parsed = JsonText::Text::parse(text);
    return JsonText::value_of(parsed);
  } catch (const nlohmann::json::exception& error) {
    throw mtf::UsageError(error.what());
  }
}

std::optional<Json> parsed_json(std::string_view text) {
  try {
    return parse_json(text);
  } catch (const mtf::UsageError&) {
    return std::nullopt;
  }
}

}  // namespace apps
