// SPDX-License-Identifier: Apache-2.0

// Components of doubles, and what is asked of them alone: the sentence for the values in use, checks, and what plans
// need to know.

#include <cmath>

#include "mtf/component_impl.h"

namespace mtf {
namespace {

bool in_range(const FieldInfo& info, double value) {
  if (!std::isfinite(value)) return false;
  return (info.lo_open ? value > info.lo : value >= info.lo) && (info.hi_open ? value < info.hi : value <= info.hi);
}

/// Text of an allowed interval: "[0, 1)".
std::string range_text(const FieldInfo& info) {
  return (info.lo_open ? "(" : "[") + format_double(info.lo) + ", " + format_double(info.hi) +
         (info.hi_open ? ")" : "]");
}

void check_field(const FieldRef<double>& field, const Context<double>& ctx, std::vector<Problem>& problems) {
  const FieldInfo& info = *field.info;
  const auto missing = [&] { problems.push_back({.field = std::string(info.name), .text = "missing"}); };
  const auto bounded = [&](std::string_view suffix, double value, std::string_view unit) {
    if (in_range(info, value)) return;
    problems.push_back({.field = std::string(info.name) + std::string(suffix),
                        .text = format_double(value) + (unit.empty() ? "" : " ") + std::string(unit) + " is outside " +
                                range_text(info)});
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

template <class S>
std::string_view Component<S>::description() const requires std::same_as<S, double> {
  return detail::visit(*value_, [](const auto& c) -> std::string_view {
    if constexpr (requires { c.variant_doc(); })
      return c.variant_doc();
    else
      return std::remove_cvref_t<decltype(c)>::doc;
  });
}

template <class S>
typename Component<S>::Rows Component<S>::rows(std::span<const S> fx,
                                               const Context<S>& ctx) const requires std::same_as<S, double> {
  Rows own = detail::visit(*value_, [&](const auto& c) -> Rows {
    if constexpr (requires { c.rows(fx, ctx); })
      return c.rows(fx, ctx);
    else
      return nullptr;
  });
  if (own) return own;
  return [value = value_, fx, ctx](const S& fy, std::span<Complex<S>> h) {
    detail::multiply(*value, ctx, h, [&](std::size_t i) { return Freq<S>{fx[i], fy}; });
  };
}

template <class S>
std::optional<Freq<double>> Component<S>::line(const Context<S>& ctx) const requires std::same_as<S, double> {
  return detail::visit(*value_, [&](const auto& c) -> std::optional<Freq<double>> {
    if constexpr (requires { c.displacement_mm(ctx); }) {
      const Freq<S> d = c.displacement_mm(ctx);
      const double length = std::hypot(value_of(d.x), value_of(d.y));
      if (length > 0.0 && length < kInfinity) return Freq<double>{value_of(d.x) / length, value_of(d.y) / length};
    }
    return std::nullopt;
  });
}

template <class S>
std::vector<Problem> Component<S>::check(const Context<S>& ctx) const requires std::same_as<S, double> {
  std::vector<Problem> problems;
  for (const FieldRef<S>& field : fields()) check_field(field, ctx, problems);
  if (!problems.empty()) return problems;  // the component's own check may rely on its bounds
  return detail::visit(*value_, [&](const auto& c) { return c.check(ctx); });
}

template class Component<double>;

std::vector<std::string_view> component_kinds() {
  std::vector<std::string_view> kinds;
  for (const auto& type : detail::kTypes<double>) kinds.push_back(type.kind);
  return kinds;
}

}  // namespace mtf
