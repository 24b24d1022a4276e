// SPDX-License-Identifier: Apache-2.0
#include "apps/atmosphere/atmosphere_options.h"

#include "apps/arguments.h"

namespace apps {
namespace {

using radiometry::FieldInfo;

template <class T>
void read(T& member, const FieldInfo& info, std::string_view option, const std::string& text) {
  if constexpr (radiometry::detail::is_optional<T>) {
    typename T::value_type value{};
    read(value, info, option, text);
    member = value;
  } else if constexpr (std::is_enum_v<T>) {
    const auto names = words(T{});
    std::string all;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == text) {
        member = static_cast<T>(i);
        return;
      }
      all += (i == 0 ? "" : ", ") + std::string(names[i]);
    }
    const auto meant = mtf::nearest(text, std::vector<std::string_view>(names.begin(), names.end()));
    throw mtf::UsageError(std::string(option) + ": '" + text + "' is not known" +
                          (meant ? "; did you mean " + *meant + "?" : "") + " (one of " + all + ")");
  } else if constexpr (std::is_same_v<T, std::string>) {
    member = text;
  } else if (info.dimension == mtf::Dimension::none) {
    member = number(option, text);
  } else {
    try {
      member = mtf::convert(mtf::parse_quantity(text, info.dimension), info.unit);
    } catch (const mtf::UsageError& error) {
      throw mtf::UsageError(std::string(option) + ": " + error.what());
    }
  }
}

}  // namespace

void set_key(radiometry::AtmosphereSettings& settings, std::string_view key, std::string_view option,
             const std::string& text) {
  radiometry::for_each_field(settings, [&](const FieldInfo& info, auto& member) {
    if (info.name == key) read(member, info, option, text);
  });
}

}  // namespace apps
