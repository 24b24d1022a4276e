// SPDX-License-Identifier: Apache-2.0
#pragma once

// Template bodies of Component<S> that go through the list of types: from a kind or a type to the handle, and back.
// Included by system_impl.h alone.

#include <optional>
#include <string>
#include <type_traits>

#include "mtf/components/all.h"
#include "mtf/error.h"

namespace mtf {
namespace detail {

template <class S>
auto visit(const ComponentVariant<S>& v, auto&& f) {
  return std::visit(f, v.value);
}

/// f(std::type_identity<C>{}) for every type C of the list.
template <class S>
void for_each_type(auto&& f) {
  [&]<class... C>(const std::variant<C...>*) {
    (f(std::type_identity<C>{}), ...);
  }(static_cast<decltype(ComponentVariant<S>::value)*>(nullptr));
}

}  // namespace detail

template <class S>
Component<S>::Component(ComponentVariant<S> value) : value_(std::make_shared<ComponentVariant<S>>(std::move(value))) {}

template <class S>
Component<S> Component<S>::make(std::string_view kind) {
  std::optional<ComponentVariant<S>> made;
  detail::for_each_type<S>([&]<class C>(std::type_identity<C>) {
    if (C::kind == kind) made = ComponentVariant<S>{C{}};
  });
  if (made) return Component(std::move(*made));
  const auto kinds = component_kinds();
  const auto guess = nearest(kind, kinds);
  std::string known;
  for (const std::string_view k : kinds) known += (known.empty() ? "" : ", ") + std::string(k);
  throw UsageError("unknown kind \"" + std::string(kind) + "\"" + (guess ? ", did you mean \"" + *guess + "\"?" : "") +
                   " (known: " + known + ")");
}

template <class S>
Component<S> Component<S>::copy_of(const void* component, const std::type_info& type) {
  std::optional<ComponentVariant<S>> copy;
  detail::for_each_type<S>([&]<class C>(std::type_identity<C>) {
    if (typeid(C) == type) copy = ComponentVariant<S>{*static_cast<const C*>(component)};
  });
  if (copy) return Component(std::move(*copy));
  throw UsageError(std::string("a component of the type ") + type.name() +
                   " is not in the list of mtf/components/all.h; add it there");
}

template <class S>
const void* Component<S>::address_if(const std::type_info& type) const {
  return detail::visit(*value_, [&](const auto& c) -> const void* { return typeid(c) == type ? &c : nullptr; });
}

}  // namespace mtf
