// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/parameter_site.h"

#include <algorithm>
#include <charconv>

#include "calib/fit/fit.h"
#include "calib/fit/system_jet.h"
#include "mtf/components/field_access.h"
#include "mtf/math/special.h"

namespace calib {
namespace {

using mtf::FieldInfo;
using mtf::FieldRef;
using mtf::Stage;
using mtf::System;

// What System::check asks of the numbers outside components.
constexpr FieldInfo kFocalLength{.name = "focal_length", .unit = "mm", .lo = 1e-6, .hi = 1e7};
constexpr FieldInfo kPitch{.name = "pitch", .unit = "um", .lo = 1e-6, .hi = 1e6};
constexpr FieldInfo kIntegrationTime{.name = "integration_time", .unit = "s", .lo = 0.0, .hi = 1e9};
constexpr FieldInfo kFNumber{.name = "f_number", .lo = 0.1, .hi = 1e4};
constexpr FieldInfo kAperture{.name = "aperture", .unit = "mm", .lo = 1e-6, .hi = 1e6};
constexpr FieldInfo kObscuration{.name = "obscuration", .lo = 0.0, .hi = 1.0, .hi_open = true};
constexpr FieldInfo kWavelength{.name = "wavelength", .unit = "um", .lo = 0.01, .hi = 1e5};
constexpr std::string_view kOnAxis = "1";  // the term that is a number's value on the optical axis
constexpr FieldInfo kAxisPlace{.name = "optical_axis", .unit = "px", .lo = -1e5, .hi = 1e5};

template <class S>
ParameterSite<S> in_frame(System<S>& system, std::string_view name) {
  mtf::Frame<S>& frame = system.frame;
  if (name == "focal_length") return {{&frame.focal_length_mm}, kFocalLength};
  if (name == "integration_time") return {{&frame.integration_time_s}, kIntegrationTime};
  if (name == "pitch") return {{&frame.pitch_x_um, &frame.pitch_y_um}, kPitch};
  if (name == "pitch_x") return {{&frame.pitch_x_um}, kPitch};
  if (name == "pitch_y") return {{&frame.pitch_y_um}, kPitch};
  return {};
}

template <class S>
ParameterSite<S> in_optics(System<S>& system, std::string_view name) {
  const auto site = [](std::optional<S>& number, const FieldInfo& info) {
    return number ? ParameterSite<S>{{&*number}, info} : ParameterSite<S>{};
  };
  if (name == "f_number") return site(system.optics.f_number, kFNumber);
  if (name == "aperture") return site(system.optics.aperture_mm, kAperture);
  if (name == "obscuration") return site(system.optics.obscuration, kObscuration);
  if (name == "wavelength") return site(system.optics.wavelength_um, kWavelength);
  return {};
}

template <class S>
ParameterSite<S> in_axis(System<S>& system, std::string_view name) {
  for (const mtf::FieldNumber<S>& number : system.field.numbers)
    if (number.map && number.map->unit == mtf::FieldUnit::pixel && !number.map->radial)
      throw mtf::UsageError(
          "optical_axis: the positions of " + number.map->source +
          " count from the corner of the detector, so that the axis is not found by them; give them in "
          "mm, or one place of the axis");
  if (name == "x") return {{&system.field.axis_x_px}, kAxisPlace};
  if (name == "y") return {{&system.field.axis_y_px}, kAxisPlace};
  return {};
}

/// What a shared field takes from [optics].
template <class S>
std::optional<S> shared_value(const System<S>& system, std::string_view name) {
  const mtf::Optics<S>& optics = system.optics;
  if (name == "obscuration") return optics.obscuration.value_or(S(0));
  if (name == "wavelength") return system.band ? std::nullopt : optics.wavelength_um;
  if (name == "aperture" && optics.f_number && !optics.aperture_mm)
    return S(system.frame.focal_length_mm / *optics.f_number);
  if (name == "aperture") return optics.aperture_mm;
  if (name == "f_number" && optics.aperture_mm && !optics.f_number)
    return S(system.frame.focal_length_mm / *optics.aperture_mm);
  return name == "f_number" ? optics.f_number : std::nullopt;
}

/// Takes "[12]" off the end of a path.
std::optional<std::size_t> take_index(std::string_view& path) {
  if (path.empty() || path.back() != ']') return std::nullopt;
  const std::size_t open = path.rfind('[');
  if (open == std::string_view::npos) return std::nullopt;
  std::size_t index = 0;
  const char* const end = path.data() + path.size() - 1;
  const auto [stop, error] = std::from_chars(path.data() + open + 1, end, index);
  if (error != std::errc{} || stop != end || open + 2 == path.size()) return std::nullopt;
  path = path.substr(0, open);
  return index;
}

/// `index`: of an element of a list, or row and column of a tap.
template <class S>
S* number_in(const System<S>& system, const FieldRef<S>& field, std::string_view name,
             std::span<const std::size_t> index) {
  const std::string_view own = field.info->name, suffix = name.substr(own.size());  // "", "_x" or "_y"
  if (auto* const* taps = std::get_if<mtf::Taps<S>*>(&field.value)) {
    const bool there =
        suffix.empty() && index.size() == 2 && index[0] < (*taps)->size() && index[1] < (**taps)[index[0]].size();
    return there ? &(**taps)[index[0]][index[1]] : nullptr;
  }
  const auto* const* pair = std::get_if<mtf::AxisPair<S>*>(&field.value);
  const bool split = pair != nullptr && (*pair)->split;
  const std::size_t indices = std::holds_alternative<mtf::Coefficients<S>*>(field.value) ? 1 : 0;
  if (split == suffix.empty() || index.size() != indices) return nullptr;
  if (auto* const* value = std::get_if<std::optional<S>*>(&field.value))
    if (!**value && field.info->presence == mtf::Presence::shared) **value = shared_value(system, own);
  return mtf::detail::number_of(field, indices == 1 ? index[0] : suffix == "_y" ? 1 : 0);
}

/// Index of an element of a list, of a row of taps; of a pair along the axes its part.
std::size_t element_of(std::string_view name, std::span<const std::size_t> index) {
  return !index.empty() ? index.front() : name.ends_with("_y") ? 1 : 0;
}

/// The coefficient of a number that changes over the field. It may have either sign, and be as large as the number's
/// range is wide; that of an angle half a turn.
template <class S>
ParameterSite<S> coefficient_of(System<S>& system, std::size_t entry, const FieldInfo& info, std::string_view name,
                                std::span<const std::size_t> index, std::string_view term) {
  const auto k = std::ranges::find(mtf::kFieldTerms, term) - mtf::kFieldTerms.begin();
  for (mtf::FieldNumber<S>& number : system.field.numbers) {
    if (k == std::ssize(mtf::kFieldTerms) || number.entry != entry || number.element != element_of(name, index))
      continue;
    const auto fields = system.list(Stage::presample)[entry].component.fields();
    if (fields[number.field].info->name != info.name) continue;
    FieldInfo range = info;
    range.hi = info.unit == "deg" ? 180.0 : info.hi - info.lo;
    range.lo = -range.hi;
    range.lo_open = range.hi_open = false;
    return {{&number.coefficient[static_cast<std::size_t>(k)]}, range};
  }
  return {};
}

}  // namespace

template <class S>
ParameterSite<S> parameter_site(System<S>& system, std::string_view path) {
  const std::size_t dot = path.find('.');
  if (dot == std::string_view::npos) return {};
  std::string_view place = path.substr(0, dot), name = path.substr(dot + 1);
  if (place == "frame") return in_frame(system, name);
  if (place == "optics") return in_optics(system, name);
  if (place == "optical_axis") return in_axis(system, name);

  std::string_view term = kOnAxis;
  if (const std::size_t end = name.rfind('.'); end != std::string_view::npos)
    term = name.substr(end + 1), name = name.substr(0, end);
  std::vector<std::size_t> index;
  while (const auto i = take_index(name)) index.insert(index.begin(), *i);
  const auto entry = take_index(place);
  for (const Stage stage : mtf::kStages) {
    if (!entry || place != mtf::stage_name(stage) || *entry >= system.list(stage).size()) continue;
    for (const FieldRef<S>& field : system.list(stage)[*entry].component.fields()) {
      const std::string own(field.info->name);
      if (name != own && name != own + "_x" && name != own + "_y") continue;
      S* const number = number_in(system, field, name, index);
      if (number == nullptr) continue;
      if (term == kOnAxis) return {{number}, *field.info};
      if (stage == Stage::presample) return coefficient_of(system, *entry, *field.info, name, index, term);
    }
  }
  return {};
}

template <class S>
S* parameter_at(System<S>& system, std::string_view path) {
  const ParameterSite<S> site = parameter_site(system, path);
  return site.numbers.empty() ? nullptr : site.numbers.front();
}

bool set_parameter(System<double>& system, std::string_view path, double value) {
  const ParameterSite<double> site = parameter_site(system, path);
  for (double* number : site.numbers) *number = value;
  return !site.numbers.empty();
}

template ParameterSite<double> parameter_site(System<double>&, std::string_view);
template ParameterSite<Jet4> parameter_site(System<Jet4>&, std::string_view);
template double* parameter_at(System<double>&, std::string_view);
template Jet4* parameter_at(System<Jet4>&, std::string_view);

}  // namespace calib
