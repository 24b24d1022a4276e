// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/field_access.h"

#include <algorithm>
#include <string>

namespace mtf {

std::vector<std::string_view> words_in(std::string_view text) {
  std::vector<std::string_view> names;
  while (!text.empty()) {
    names.push_back(text.substr(0, text.find(' ')));
    text.remove_prefix(std::min(names.back().size() + 1, text.size()));
  }
  return names;
}

bool in_range(const FieldInfo& info, double value) {
  return std::isfinite(value) && (info.lo_open ? value > info.lo : value >= info.lo) &&
         (info.hi_open ? value < info.hi : value <= info.hi);
}

std::string range_text(const FieldInfo& info, std::string_view unit) {
  return with_unit(
      (info.lo_open ? "(" : "[") + format_double(info.lo) + ", " + format_double(info.hi) + (info.hi_open ? ")" : "]"),
      unit);
}

std::string outside_text(const FieldInfo& info, double value, std::string_view unit) {
  return with_unit(format_double(value), unit) + " is outside " + range_text(info, unit);
}

namespace detail {
namespace {

void check_field(const FieldRef<double>& field, const Context<double>& ctx, std::vector<Problem>& problems) {
  const FieldInfo& info = *field.info;
  const auto missing = [&] { problems.push_back({.field = std::string(info.name), .text = "missing"}); };
  const auto bounded = [&](std::string_view suffix, double value, std::string_view unit) {
    if (in_range(info, value)) return;
    problems.push_back(
        {.field = std::string(info.name) + std::string(suffix), .text = outside_text(info, value, unit)});
  };
  std::visit(
      [&](auto* value) {
        using T = std::remove_pointer_t<decltype(value)>;
        if constexpr (std::is_same_v<T, double>) {
          bounded("", *value, info.unit);
        } else if constexpr (std::is_same_v<T, std::optional<double>>) {
          if (*value)
            bounded("", **value, info.unit);
          else if (info.presence == Presence::required)
            missing();
        } else if constexpr (std::is_same_v<T, AxisPair<double>>) {
          if (value->given()) {
            bounded(value->split ? "_x" : "", value->x.value, value->x.unit->name);
            if (value->split) bounded("_y", value->y.value, value->y.unit->name);
          } else if (info.presence == Presence::required) {
            missing();
          }
        } else if constexpr (std::is_same_v<T, SpatialFrequency<double>>) {
          if (value->temporal() && info.dimension != Dimension::cutoff)
            problems.push_back({.field = std::string(info.name),
                                .text = "in " + std::string(value->unit->name) + "; it takes " +
                                        std::string(describe(info.dimension))});
          else if (value->unit != nullptr)
            bounded("", value->value, value->unit->name);
          else if (info.presence == Presence::required)
            missing();
        } else if constexpr (std::is_same_v<T, int>) {
          bounded("", *value, "");
        } else if constexpr (std::is_same_v<T, Coefficients<double>>) {
          for (std::size_t i = 0; i < value->size(); ++i)
            bounded("[" + std::to_string(i) + "]", (*value)[i], info.unit);
        } else if constexpr (std::is_same_v<T, Taps<double>>) {
          for (const auto& row : *value)
            for (const double tap : row) bounded("", tap, "");
        }
      },
      field.value);
  // Shared fields: f_number and wavelength have to come from somewhere; obscuration is 0 unless given.
  const auto* own = std::get_if<std::optional<double>*>(&field.value);
  if (info.presence != Presence::shared || own == nullptr || (*own)->has_value()) return;
  const bool found = info.name == "f_number"     ? ctx.optics.f_number || ctx.optics.aperture_mm
                     : info.name == "wavelength" ? ctx.wavelength_um > 0.0
                                                 : true;
  if (!found)
    problems.push_back({.field = std::string(info.name),
                        .text = "missing; give it here, or for all components in [optics]" +
                                std::string(info.name == "wavelength" ? " or as [band] wavelength" : "")});
}

}  // namespace

std::vector<Problem> check_fields(std::span<const FieldRef<double>> fields, const Context<double>& ctx) {
  std::vector<Problem> problems;
  for (const FieldRef<double>& field : fields) check_field(field, ctx, problems);
  return problems;
}

}  // namespace detail
}  // namespace mtf
