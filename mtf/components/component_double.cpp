// SPDX-License-Identifier: Apache-2.0

// Components of doubles, and what is asked of them alone: the sentence for the values in use, checks, what plans need.

#include "mtf/components/component_impl.h"

namespace mtf {

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
    if constexpr (requires { c.displacement_mm(ctx); })
      return detail::direction_of(c.displacement_mm(ctx));
    else
      return std::nullopt;
  });
}

template <class S>
std::vector<Problem> Component<S>::check(const Context<S>& ctx) const requires std::same_as<S, double> {
  if (std::vector<Problem> problems = detail::check_fields(fields(), ctx); !problems.empty()) return problems;
  return detail::visit(*value_, [&](const auto& c) { return detail::own_check(c, ctx); });
}

template class Component<double>;

std::vector<std::string_view> component_kinds() {
  std::vector<std::string_view> kinds;
  for (const auto& type : detail::kTypes<double>) kinds.push_back(type.facts.kind);
  return kinds;
}

}  // namespace mtf
