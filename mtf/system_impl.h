// SPDX-License-Identifier: Apache-2.0
#pragma once

// Template bodies of Component<S> and System<S>. Included only where a scalar type is instantiated: system_double.cpp,
// system_float.cpp, calib/fit/system_jet.cpp.

#include <algorithm>
#include <cmath>

#include "mtf/band_average.h"
#include "mtf/components/field_access.h"
#include "mtf/error.h"
#include "mtf/system.h"
#include "mtf/system_components.h"

namespace mtf {
namespace detail {

template <class To, class From>
Component<To> cast_component(const Component<From>& from) {
  Component<To> to = Component<To>::make(from.kind());
  cast_fields<To, From>(from.fields(), to.fields());
  return to;
}

}  // namespace detail

template <class S>
std::string_view Component<S>::kind() const {
  return detail::visit(*value_, [](const auto& c) { return std::remove_cvref_t<decltype(c)>::kind; });
}
template <class S>
std::string_view Component<S>::doc() const {
  return detail::visit(*value_, [](const auto& c) { return std::remove_cvref_t<decltype(c)>::doc; });
}
template <class S>
std::string_view Component<S>::description() const {
  return detail::visit(*value_, [](const auto& c) -> std::string_view {
    if constexpr (requires { c.variant_doc(); })
      return c.variant_doc();
    else
      return std::remove_cvref_t<decltype(c)>::doc;
  });
}
template <class S>
Stages Component<S>::stages() const {
  return detail::visit(*value_, [](const auto& c) { return std::remove_cvref_t<decltype(c)>::stages; });
}
template <class S>
SensorPart Component<S>::part() const {
  return detail::visit(*value_, [](const auto& c) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(c.part)>, Choice>)
      return static_cast<SensorPart>(c.part.index);  // a field, in the order of kSensorPartNames
    else
      return c.part;
  });
}
template <class S>
bool Component<S>::is_pupil() const {
  return detail::visit(*value_, [](const auto& c) {
    return requires { std::remove_cvref_t<decltype(c)>::is_pupil; };
  });
}
template <class S>
bool Component<S>::is_footprint() const {
  return detail::visit(*value_, [](const auto& c) {
    return requires { std::remove_cvref_t<decltype(c)>::is_footprint; };
  });
}
template <class S>
bool Component<S>::is_reconstruction() const {
  return detail::visit(*value_, [](const auto& c) {
    return requires { std::remove_cvref_t<decltype(c)>::is_reconstruction; };
  });
}
template <class S>
Traits Component<S>::traits(const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) { return c.traits(ctx); });
}
template <class S>
double Component<S>::cutoff_cy_mm(const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) { return c.cutoff_cy_mm(ctx); });
}
template <class S>
double Component<S>::deviation(double fx, double fy, const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) { return c.deviation(fx, fy, ctx); });
}
template <class S>
Complex<S> Component<S>::otf(const Freq<S>& f, const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) { return c.otf(f, ctx); });
}
template <class S>
void Component<S>::multiply(std::span<const Freq<S>> f, const Context<S>& ctx, std::span<Complex<S>> h) const {
  detail::visit(*value_, [&](const auto& c) {
    if constexpr (requires { c.evaluator(ctx); }) {
      const auto otf = c.evaluator(ctx);
      for (std::size_t i = 0; i < f.size(); ++i) h[i] = h[i] * otf(f[i]);
    } else {
      for (std::size_t i = 0; i < f.size(); ++i) h[i] = h[i] * c.otf(f[i], ctx);
    }
  });
}
template <class S>
typename Component<S>::Rows Component<S>::rows(std::span<const S> fx, const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) -> Rows {
    if constexpr (requires { c.rows(fx, ctx); })
      return c.rows(fx, ctx);
    else
      return [c, fx, ctx](const S& fy, std::span<Complex<S>> h) {
        if constexpr (requires { c.evaluator(ctx); }) {
          const auto otf = c.evaluator(ctx);
          for (std::size_t i = 0; i < h.size(); ++i) h[i] = h[i] * otf({fx[i], fy});
        } else {
          for (std::size_t i = 0; i < h.size(); ++i) h[i] = h[i] * c.otf({fx[i], fy}, ctx);
        }
      };
  });
}
template <class S>
std::vector<double> Component<S>::kinks_cy_mm(const Context<S>& ctx) const {
  return detail::visit(*value_, [&](const auto& c) -> std::vector<double> {
    if constexpr (requires { c.kinks_cy_mm(ctx); }) {
      return c.kinks_cy_mm(ctx);
    } else {
      const double cutoff = c.cutoff_cy_mm(ctx);
      return cutoff < kInfinity ? std::vector{cutoff} : std::vector<double>{};
    }
  });
}
template <class S>
bool Component<S>::is_slow() const {
  return detail::visit(*value_, [](const auto& c) {
    return requires { std::remove_cvref_t<decltype(c)>::is_slow; };
  });
}
template <class S>
std::optional<Freq<double>> Component<S>::line(const Context<S>& ctx) const {
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
std::vector<FieldRef<S>> Component<S>::fields() {
  if (value_.use_count() > 1) value_ = std::make_shared<ComponentVariant<S>>(*value_);
  return std::visit([](auto& c) { return detail::field_refs<std::remove_reference_t<decltype(c)>, S>(c); },
                    value_->value);
}
template <class S>
std::vector<FieldRef<S>> Component<S>::fields() const {
  return std::visit([](auto& c) { return detail::field_refs<std::remove_reference_t<decltype(c)>, S>(c); },
                    value_->value);
}

template <class S>
std::vector<Problem> Component<S>::check(const Context<S>& ctx) const {
  std::vector<Problem> problems;
  for (const FieldRef<S>& field : fields()) detail::check_field(field, ctx, problems);
  if (!problems.empty()) return problems;  // the component's own check may rely on its bounds
  return detail::visit(*value_, [&](const auto& c) { return c.check(ctx); });
}

template <class S>
void System<S>::add(Stage stage, Component<S> component) {
  const std::string kind(component.kind());
  const auto taken = [&](const std::string& label) {
    return std::any_of(stages.begin(), stages.end(), [&](const auto& entries) {
      return std::any_of(entries.begin(), entries.end(), [&](const Entry<S>& e) { return e.label == label; });
    });
  };
  std::string label = kind;
  for (int n = 2; taken(label); ++n) label = kind + "_" + std::to_string(n);
  list(stage).push_back({std::move(component), label});
}

template <class S>
Context<S> System<S>::context() const {
  if (band) return context(S(0.5 * (band->lo_um + band->hi_um)));
  return context(optics.wavelength_um.value_or(S(0)));
}
template <class S>
Context<S> System<S>::context(const S& wavelength_um) const {
  return {frame, optics, wavelength_um};
}

template <class S>
std::vector<Complex<S>> System<S>::otf(std::span<const Entry<S>> entries, std::span<const Freq<S>> f) const {
  return otf_with_error(entries, f).value;
}

template <class S>
Averaged<S> System<S>::otf_with_error(std::span<const Entry<S>> entries, std::span<const Freq<S>> f) const {
  const Context<S> middle = context();
  Averaged<S> product{std::vector<Complex<S>>(f.size(), {S(1), S(0)}), std::vector<double>(f.size(), 0.0)};
  std::vector<const Component<S>*> chromatic;
  for (const Entry<S>& entry : entries) {
    if (band && entry.component.traits(middle).chromatic)
      chromatic.push_back(&entry.component);
    else
      entry.component.multiply(f, middle, product.value);
  }
  if (chromatic.empty()) return product;
  const Averaged<S> mean = detail::band_average<S>(*this, chromatic, f);
  for (std::size_t i = 0; i < f.size(); ++i) {
    product.error[i] = mean.error[i] * std::hypot(value_of(product.value[i].re), value_of(product.value[i].im));
    product.value[i] = product.value[i] * mean.value[i];
  }
  return product;
}

template <class S>
Complex<S> System<S>::otf(const Entry<S>& entry, const Freq<S>& f) const {
  return otf(std::span(&entry, 1), std::span(&f, 1)).front();
}

template <class S>
Complex<S> System<S>::otf(Stage stage, const Freq<S>& f) const {
  return otf(std::span(list(stage)), std::span(&f, 1)).front();
}

template <class S>
Complex<S> System<S>::otf(const Freq<S>& f) const {
  Complex<S> product{S(1), S(0)};
  for (const Stage stage : kStages) product = product * otf(stage, f);
  return product;
}

template <class To, class From>
System<To> cast(const System<From>& from) {
  System<To> to;
  to.name = from.name;
  to.band = from.band;
  to.band_nodes = from.band_nodes;
  to.frame = detail::cast_frame<To>(from.frame);
  to.optics = detail::cast_optics<To>(from.optics);
  for (std::size_t i = 0; i < from.stages.size(); ++i)
    for (const Entry<From>& entry : from.stages[i])
      to.stages[i].push_back({detail::cast_component<To>(entry.component), entry.label});
  return to;
}

}  // namespace mtf
