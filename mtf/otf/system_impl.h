// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bodies of System<S> and of casts between scalar types. Only the sources that instantiate a scalar type include this:
// system.cpp, calib/fit/system_jet.cpp.
//
// The average of a product of chromatic components over the band is taken at any frequencies, to kBandError. At each
// frequency the band is split at the wavelengths of the kinks (mtf/band.h). On every part the number of wavelengths is
// doubled until the integral stands still; the last change is what the average is said to err by. It is that of the
// rule with half as many wavelengths, so the error is smaller by far. The weights of metrics
// (split_mean.h) take half as long at an even rate; of a curve of a thousand samples, which they go through for each
// part, they take 8 to 12 times as long as all of this for a clear pupil.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "mtf/components/field_access.h"
#include "mtf/error.h"
#include "mtf/math/special.h"
#include "mtf/system.h"

namespace mtf {
namespace detail {

template <class To, class From>
Component<To> cast_component(const Component<From>& from) {
  Component<To> to = Component<To>::make(from.kind());
  cast_fields<To, From>(from.fields(), to.fields());
  return to;
}

/// Wavelengths times frequencies of the kinks of all components, um cycles/mm.
template <class S>
std::vector<double> chromatic_kinks(const System<S>& system, std::span<const Component<S>* const> chromatic) {
  const Context<S> middle = system.context();
  std::vector<double> kinks;
  for (const Component<S>* component : chromatic)
    for (const double f : component->kinks_cy_mm(middle)) kinks.push_back(f * value_of(middle.wavelength_um));
  return kinks;
}

/// sum[i] += weight x product at f[i], over the given wavelengths.
template <class S>
void add_nodes(const System<S>& system, std::span<const Component<S>* const> chromatic, const WavelengthNodes& nodes,
               std::span<const Freq<S>> f, std::vector<Complex<S>>& node, std::vector<Complex<S>>& sum) {
  for (std::size_t w = 0; w < nodes.weight.size(); ++w) {
    const Context<S> ctx = system.context(S(nodes.wavelength_um[w]));
    node.assign(f.size(), Complex<S>{S(nodes.weight[w]), S(0)});
    for (const Component<S>* component : chromatic) component->multiply(f, ctx, node);
    for (std::size_t i = 0; i < f.size(); ++i) sum[i] = sum[i] + node[i];
  }
}

/// Adds the integral over a part of the band at the frequencies `which` to `mean`, that of 1 to `weight`.
template <class S>
void add_part(const System<S>& system, std::span<const Component<S>* const> chromatic, double begin_um, double end_um,
              double allowed, std::vector<std::size_t> which, std::span<const Freq<S>> f, Averaged<S>& mean,
              std::vector<double>& weight) {
  constexpr int kFewest = 8, kMost = 1024;
  std::vector<Freq<S>> open;
  std::vector<Complex<S>> before, now, node;
  for (int n = kFewest; !which.empty(); n *= 2) {
    open.clear();
    for (const std::size_t i : which) open.push_back(f[i]);
    now.assign(open.size(), Complex<S>{S(0), S(0)});
    const WavelengthNodes nodes = part_nodes(*system.band, begin_um, end_um, n);
    const double share = std::accumulate(nodes.weight.begin(), nodes.weight.end(), 0.0);
    add_nodes<S>(system, chromatic, nodes, open, node, now);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < which.size(); ++i) {
      const double change = n == kFewest ? std::numeric_limits<double>::infinity()
                                         : std::hypot(value_of(now[i].re) - value_of(before[i].re),
                                                      value_of(now[i].im) - value_of(before[i].im));
      if (!(change <= allowed) && n < kMost) {
        which[kept] = which[i];
        now[kept++] = now[i];
        continue;
      }
      mean.value[which[i]] = mean.value[which[i]] + now[i];
      mean.error[which[i]] += change;
      weight[which[i]] += share;
    }
    which.resize(kept);
    before.swap(now);
  }
}

template <class S>
Averaged<S> band_average(const System<S>& system, std::span<const Component<S>* const> chromatic,
                         std::span<const Freq<S>> f) {
  Averaged<S> mean{std::vector<Complex<S>>(f.size(), {S(0), S(0)}), std::vector<double>(f.size(), 0.0)};
  if (system.band_nodes > 0) {
    std::vector<Complex<S>> node;
    add_nodes<S>(system, chromatic, wavelength_nodes(*system.band, system.band_nodes), f, node, mean.value);
    mean.error.assign(f.size(), std::numeric_limits<double>::quiet_NaN());
    return mean;
  }
  constexpr double kAllowed = std::is_same_v<S, float> ? 1e-6 : kBandError;
  const std::vector<double> kinks = chromatic_kinks(system, chromatic);
  std::vector<double> wavelengths, weight(f.size(), 0.0);
  std::vector<std::size_t> whole;  // frequencies without a kink in the band share their wavelengths
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double radius = std::hypot(value_of(f[i].x), value_of(f[i].y));
    wavelengths.clear();
    for (const double kink : kinks) wavelengths.push_back(kink / radius);
    const std::vector<double> ends = parts_of(*system.band, wavelengths);
    if (ends.size() == 2) {
      whole.push_back(i);
      continue;
    }
    const double allowed = kAllowed / static_cast<double>(ends.size() - 1);
    for (std::size_t part = 0; part + 1 < ends.size(); ++part)
      add_part<S>(system, chromatic, ends[part], ends[part + 1], allowed, {i}, f, mean, weight);
  }
  add_part<S>(system, chromatic, system.band->lo_um, system.band->hi_um, kAllowed, std::move(whole), f, mean, weight);
  // A curve as narrow as a line is known to fewer digits than 1e-12: the mean of 1 is 1 all the same.
  for (std::size_t i = 0; i < f.size(); ++i) {
    const S scale = static_cast<S>(1.0 / weight[i]);
    mean.value[i] = {mean.value[i].re * scale, mean.value[i].im * scale};
  }
  return mean;
}

}  // namespace detail

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
  const S radius = field_radius_um();
  return {frame, optics, wavelength_um, air, {point.x * radius, point.y * radius}};
}

template <class S>
bool System<S>::is_isoplanatic() const {
  if (!field.empty()) return false;
  // A system at a field point has its place for good.
  if (value_of(point.x) != 0.0 || value_of(point.y) != 0.0 || settled) return true;
  const auto& entries = list(Stage::presample);
  return std::none_of(entries.begin(), entries.end(),
                      [ctx = context()](const Entry<S>& entry) { return entry.component.traits(ctx).placed; });
}

template <class S>
S System<S>::field_radius_um() const {
  using std::sqrt;
  if (value_of(half_diagonal_um) > 0.0) return half_diagonal_um;
  const S x = frame.pitch_x_um * S(frame.columns), y = frame.pitch_y_um * S(frame.rows);
  const S square = x * x + y * y;
  return value_of(square) > 0.0 ? S(S(0.5) * sqrt(square)) : S(0);
}

template <class S>
FieldPoint<S> System<S>::field_point(double x_px, double y_px) const {
  if (frame.columns == 0 || frame.rows == 0)
    throw UsageError("a place in pixels needs the size of the detector; give frame.format");
  const S radius = field_radius_um();
  return {(S(x_px - 0.5 * frame.columns) - field.axis_x_px) * frame.pitch_x_um / radius,
          (S(y_px - 0.5 * frame.rows) - field.axis_y_px) * frame.pitch_y_um / radius};
}

template <class S>
S System<S>::mapped(const FieldNumber<S>& number, const FieldPoint<S>& q) const {
  const FieldMap& map = *number.map;
  using std::sqrt;
  const S radius_um = field_radius_um();
  const bool in_pixels = map.unit == FieldUnit::pixel;
  if (map.unit != FieldUnit::half_diagonal && (!(value_of(radius_um) > 0.0) || (in_pixels && frame.columns == 0)))
    throw UsageError("the positions of " + map.source + " need the size of the detector; give frame.format");
  S x = q.x, y = q.y;
  if (map.unit == FieldUnit::millimetre || map.unit == FieldUnit::slope) {
    const S scale = radius_um * S(1e-3) / (map.unit == FieldUnit::slope ? frame.focal_length_mm : S(1));
    x *= scale, y *= scale;
  } else if (in_pixels) {
    x *= radius_um / frame.pitch_x_um, y *= radius_um / frame.pitch_y_um;
  }
  if (map.radial) {
    const S square = x * x + y * y;
    x = value_of(square) > 0.0 ? S(sqrt(square)) : S(0), y = S(0);
  } else if (in_pixels) {
    x += field.axis_x_px + S(0.5 * frame.columns), y += field.axis_y_px + S(0.5 * frame.rows);
  }
  if (map.is_image()) {
    map.require_shape_of(frame.columns, frame.rows);
    x *= S(static_cast<double>(map.columns) / frame.columns), y *= S(static_cast<double>(map.rows) / frame.rows);
  }
  const FieldPoint<double> place{value_of(x), value_of(y)};
  if (!map.covers(place)) throw UsageError(map.outside_text(place));
  return S(number.factor) * (map.is_image() ? map.of_image(number.column, FieldPoint<S>{x, y}, place.x, place.y)
                                            : map.at(number.column, FieldPoint<S>{x, y}));
}

template <class S>
S System<S>::change(const FieldNumber<S>& number, const FieldPoint<S>& q) const {
  const std::array<S, 8> terms = field_terms(q);
  S sum(0);
  for (std::size_t i = 0; i < terms.size(); ++i) sum += number.coefficient[i] * terms[i];
  return number.map ? S(sum + mapped(number, q) - mapped(number, {})) : sum;
}

template <class S>
System<S> System<S>::at(const FieldPoint<S>& q) const {
  System<S> here = *this;
  here.field.numbers.clear();
  here.field.angles.clear();
  here.point = q;
  here.settled = true;
  for (const FieldNumber<S>& number : field.numbers) {
    S* value = detail::number_of(here.list(Stage::presample).at(number.entry).component.fields().at(number.field),
                                 number.element);
    if (value == nullptr) throw UsageError("a number that changes over the field is not there");
    *value += change(number, q);
  }
  using std::atan2;
  const bool on_axis = value_of(q.x) == 0.0 && value_of(q.y) == 0.0;
  for (const FieldAngle& angle : field.angles) {
    S* value = detail::number_of(here.list(Stage::presample).at(angle.entry).component.fields().at(angle.field), 0);
    if (value == nullptr) throw UsageError("an angle that turns with the field is not there");
    if (!on_axis) *value += atan2(q.y, q.x) * S(180.0 / kPi);
  }
  const auto& entries = here.list(Stage::presample);
  if (!on_axis && !(value_of(field_radius_um()) > 0.0) &&
      std::any_of(entries.begin(), entries.end(),
                  [ctx = context()](const Entry<S>& entry) { return entry.component.traits(ctx).placed; }))
    throw UsageError(
        "the size of the detector is not known, on which displacements over the field depend; give frame.format");
  return here;
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
  to.air = {detail::cast_value<To>(from.air.path_length_m), detail::cast_value<To>(from.air.scattering)};
  to.field.axis_x_px = detail::cast_value<To>(from.field.axis_x_px);
  to.field.axis_y_px = detail::cast_value<To>(from.field.axis_y_px);
  to.field.angles = from.field.angles;
  for (const FieldNumber<From>& number : from.field.numbers) {
    to.field.numbers.push_back(
        {number.entry, number.field, number.element, {}, number.map, number.column, number.factor});
    for (std::size_t i = 0; i < number.coefficient.size(); ++i)
      to.field.numbers.back().coefficient[i] = detail::cast_value<To>(number.coefficient[i]);
  }
  to.point = {detail::cast_value<To>(from.point.x), detail::cast_value<To>(from.point.y)};
  to.settled = from.settled;
  to.half_diagonal_um = detail::cast_value<To>(from.half_diagonal_um);
  for (std::size_t i = 0; i < from.stages.size(); ++i)
    for (const Entry<From>& entry : from.stages[i])
      to.stages[i].push_back({detail::cast_component<To>(entry.component), entry.label});
  return to;
}

}  // namespace mtf
