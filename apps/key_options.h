// SPDX-License-Identifier: Apache-2.0
#pragma once

// Options with the names of the keys of a table ("relative_humidity" -> "--relative-humidity"), from its rows: what a
// file says under a key a command line says after the option.

#include <algorithm>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "apps/command_line.h"
#include "radiometry/fields.h"

namespace apps {

/// Keys that were given as options, and their texts.
using GivenKeys = std::vector<std::pair<std::string, std::string>>;

inline std::string option_of(std::string_view key) {
  std::string option = "--" + std::string(key);
  std::replace(option.begin(), option.end(), '_', '-');
  return option;
}

namespace detail {

template <class T>
std::vector<std::string> words_of(const T&) {
  std::vector<std::string> found;
  if constexpr (radiometry::detail::is_optional<T>)
    found = words_of(typename T::value_type{});
  else if constexpr (std::is_enum_v<T>)
    found.assign(words(T{}).begin(), words(T{}).end());
  return found;
}

template <class T>
void read_key(T& member, const radiometry::FieldInfo& info, const std::string& option, const std::string& text) {
  if constexpr (radiometry::detail::is_optional<T>) {
    typename T::value_type value{};
    read_key(value, info, option, text);
    member = value;
  } else if constexpr (std::is_enum_v<T>) {
    member = static_cast<T>(place_of(option, text, words(T{})));
  } else if constexpr (std::is_same_v<T, std::string>) {
    member = text;
  } else if (info.dimension == mtf::Dimension::none) {
    member = number(option, text);
  } else {
    try {
      member = mtf::convert(mtf::parse_quantity(text, info.dimension), info.unit);
    } catch (const mtf::UsageError& error) {
      throw mtf::UsageError(option + ": " + error.what());
    }
  }
}

}  // namespace detail

/// An option for each key of `prototype` for which `wanted(key)` holds.
template <class T, class Wanted>
void add_keys(Command& app, const T& prototype, GivenKeys& given, const Wanted& wanted) {
  radiometry::for_each_field(prototype, [&](const radiometry::FieldInfo& info, const auto& member) {
    if (!wanted(info.name)) return;
    const std::string key(info.name);
    std::string example(info.example);
    std::erase(example, '"');
    std::string doc(info.doc);
    const std::vector<std::string> words = detail::words_of(member);
    for (const std::string& word : words) doc += (&word == &words.front() ? ": " : ", ") + word;
    add_text(app, option_of(key), example.find(' ') == std::string::npos ? example : "'" + example + "'", doc,
             [&given, key](const std::string& text) { given.emplace_back(key, text); })
        .candidates = one_of(words);
  });
}

/// Sets the keys to what options say: a quantity with its unit, a plain number, a word or a file. Throws UsageError
/// that names the option.
template <class T>
void set_keys(T& table, const GivenKeys& given) {
  for (const auto& [key, text] : given)
    radiometry::for_each_field(table, [&](const radiometry::FieldInfo& info, auto& member) {
      if (info.name == key) detail::read_key(member, info, option_of(key), text);
    });
}

}  // namespace apps
