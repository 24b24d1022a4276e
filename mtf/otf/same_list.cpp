// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf/same_list.h"

#include <algorithm>

namespace mtf {
namespace {

bool same(const Frame<double>& a, const Frame<double>& b) {
  return a.focal_length_mm == b.focal_length_mm && a.pitch_x_um == b.pitch_x_um && a.pitch_y_um == b.pitch_y_um &&
         a.integration_time_s == b.integration_time_s;
}

bool same(const Optics<double>& a, const Optics<double>& b) {
  return a.f_number == b.f_number && a.aperture_mm == b.aperture_mm && a.obscuration == b.obscuration &&
         a.wavelength_um == b.wavelength_um;
}

bool same(const ElectronRate::Block& a, const ElectronRate::Block& b) {
  return a.begin_um == b.begin_um && a.end_um == b.end_um && a.rule.wavelength_um == b.rule.wavelength_um &&
         a.rule.weight == b.rule.weight;
}

/// The rules of the blocks hold the moments of the rate. A rate without blocks has few panels; nine values of the
/// density fix a polynomial of degree 8, the highest that a panel may be.
bool same(const std::shared_ptr<const ElectronRate>& a, const std::shared_ptr<const ElectronRate>& b) {
  if (a == b || !a || !b) return a == b;
  const std::vector<double>& at = a->breaks_um();
  if (at != b->breaks_um()) return false;
  if (!a->blocks().empty())
    return std::equal(a->blocks().begin(), a->blocks().end(), b->blocks().begin(), b->blocks().end(),
                      [](const auto& x, const auto& y) { return same(x, y); });
  for (std::size_t i = 0; i + 1 < at.size(); ++i)
    for (int k = 0; k < 9; ++k) {
      const double wavelength_um = std::lerp(at[i], at[i + 1], (k + 0.5) / 9.0);
      if (a->density(wavelength_um) != b->density(wavelength_um)) return false;
    }
  return true;
}

bool same(const std::optional<Band>& a, const std::optional<Band>& b) {
  return a.has_value() == b.has_value() &&
         (!a || (a->lo_um == b->lo_um && a->hi_um == b->hi_um && same(a->rate, b->rate)));
}

}  // namespace

bool same_value(const FieldRef<double>& a, const FieldRef<double>& b) {
  return std::visit(
      [&](const auto* value) { return same_bits(*value, *std::get<std::remove_cvref_t<decltype(*value)>*>(b.value)); },
      a.value);
}

bool same_component(const Component<double>& a, const Component<double>& b) {
  if (a.kind() != b.kind()) return false;
  const auto fields = a.fields(), others = b.fields();
  return std::equal(fields.begin(), fields.end(), others.begin(), &same_value);
}

bool same_surroundings(const System<double>& a, const System<double>& b) {
  return same(a.frame, b.frame) && same(a.optics, b.optics) && a.air.path_length_m == b.air.path_length_m &&
         a.air.scattering == b.air.scattering && same(a.band, b.band) && a.band_nodes == b.band_nodes &&
         a.point == b.point && a.field_radius_um() == b.field_radius_um();
}

bool same_list(const System<double>& a, const System<double>& b, Stage stage) {
  const auto &first = a.list(stage), &second = b.list(stage);
  if (first.empty() && second.empty()) return true;
  const bool same_field = stage != Stage::presample || a.field == b.field;
  return same_field && same_surroundings(a, b) &&
         std::equal(first.begin(), first.end(), second.begin(), second.end(),
                    [](const auto& x, const auto& y) { return same_component(x.component, y.component); });
}

}  // namespace mtf
