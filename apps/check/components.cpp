// SPDX-License-Identifier: Apache-2.0

// Components as a sensor file makes them: one case of each with its OTF to 25 digits (golden_components.py).

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

#include "apps/check/check.h"
#include "mtf/components/motion_means.h"
#include "mtf/components/turbulence.h"
#include "mtf/error.h"
#include "mtf/math/fresnel.h"
#include "mtf/system.h"

namespace apps::check {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

/// "0|1/2|3": rows of numbers.
mtf::Taps<double> taps(const std::string& text) {
  mtf::Taps<double> rows;
  for (const std::string& row : split(text, '/')) {
    rows.emplace_back();
    for (const std::string& tap : split(row, '|')) rows.back().push_back(std::strtod(tap.c_str(), nullptr));
  }
  return rows;
}

/// "0:1|20:0.5 cy/mm": frequencies and values in place of a file.
std::shared_ptr<const mtf::Curve> curve(const std::string& text) {
  const std::size_t space = text.find(' ');
  std::vector<double> frequencies, values;
  for (const std::string& sample : split(text.substr(0, space), '|')) {
    frequencies.push_back(std::strtod(sample.c_str(), nullptr));
    values.push_back(std::strtod(sample.substr(sample.find(':') + 1).c_str(), nullptr));
  }
  return std::make_shared<const mtf::Curve>(
      mtf::make_curve("table", *mtf::find_unit(text.substr(space + 1)), frequencies, values));
}

/// One field from its text: "15 um", "3", "short", rows of taps, samples of a curve.
void assign(const mtf::FieldRef<double>& field, const std::string& text, const std::string& where) {
  const mtf::FieldInfo& info = *field.info;
  const auto plain = [&] {
    return info.dimension == mtf::Dimension::none ? std::strtod(text.c_str(), nullptr)
                                                  : mtf::convert(mtf::parse_quantity(text, info.dimension), info.unit);
  };
  std::visit(
      [&](auto* value) {
        using T = std::remove_pointer_t<decltype(value)>;
        if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>) {
          *value = plain();
        } else if constexpr (std::is_same_v<T, int>) {
          *value = static_cast<int>(plain());
        } else if constexpr (std::is_same_v<T, mtf::AxisPair<double>>) {
          const mtf::Quantity size = mtf::parse_quantity(text, info.dimension);
          *value = {{size.value, size.unit}, {}, false};
        } else if constexpr (std::is_same_v<T, mtf::SpatialFrequency<double>>) {
          const mtf::Quantity frequency = mtf::parse_quantity(text, info.dimension);
          *value = {frequency.value, frequency.unit};
        } else if constexpr (std::is_same_v<T, mtf::Choice>) {
          const auto word = std::find(value->names.begin(), value->names.end(), text);
          if (word == value->names.end()) throw mtf::UsageError(where + ": " + text + " is no word of this field");
          value->index = static_cast<int>(word - value->names.begin());
        } else if constexpr (std::is_same_v<T, mtf::CurveSum<double>>) {
          *value = curve(text);
        } else if constexpr (std::is_same_v<T, mtf::Taps<double>>) {
          *value = taps(text);
        } else {
          throw mtf::UsageError(where + ": fields of this type cannot stand in a table");
        }
      },
      field.value);
}

/// "width = 15 um; fill_factor = 0.8" into the fields of a component.
void assign_all(mtf::Component<double>& component, const std::string& settings, const std::string& where) {
  const auto fields = component.fields();
  for (std::size_t at = 0; at < settings.size();) {
    const std::size_t end = std::min(settings.find("; ", at), settings.size()), equals = settings.find(" = ", at);
    if (equals >= end) throw mtf::UsageError(where + ": settings are \"field = value; field = value\"");
    const std::string name = settings.substr(at, equals - at);
    const auto field = std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return f.info->name == name; });
    if (field == fields.end())
      throw mtf::UsageError(where + ": " + std::string(component.kind()) + " has no field " + name);
    assign(*field, settings.substr(equals + 3, end - equals - 3), where);
    at = end + 2;
  }
}

// Rounding of the lengths to double and of their products with f comes before the formula: a few ulp of 1 in all.
void golden(const Tables& tables, Tally& tally, std::string_view kind) {
  constexpr long double allowed = 4.0L * std::numeric_limits<double>::epsilon();
  for (const Row& row : tables.rows("golden_components.csv")) {
    if (row.at("kind") != kind) continue;
    mtf::System<double> system;
    system.frame = {100.0, 17.0, 17.0, 0.01, 0, 0};
    system.optics.f_number = 1.0;
    system.optics.wavelength_um = 4.0;
    auto component = mtf::Component<double>::make(kind);
    assign_all(component, row.at("settings"), row.where);
    const mtf::Complex<double> h = component.otf({number(row, "f_cy_mm"), 0.0}, system.context());
    const long double re = precise(row, "re"), im = precise(row, "im");
    tally.error(std::hypot(h.re - re, h.im - im), std::hypot(re, im), allowed, row.where);
  }
}

// Fresnel integrals, and the OTF of accelerated motion that they give.

void fresnel(const Tables& tables, Tally& tally) {
  constexpr long double allowed = 5e-16L;
  for (const Row& row : tables.rows("fresnel_integrals.csv"))
    for (const double sign : {1.0, -1.0}) {
      const mtf::FresnelIntegrals f = mtf::fresnel(sign * number(row, "u_hex"));
      tally.compare(sign * f.c.value, precise(row, "c"), allowed, row.where);
      tally.compare(sign * f.s.value, precise(row, "s"), allowed, row.where);
    }
}

void chirp(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("accelerated_motion.csv")) {
    const mtf::ChirpMean h = mtf::chirp_mean(number(row, "d_hex"), number(row, "b_hex"));
    const auto compare = [&](const mtf::Complex<double>& value, const std::string& by, long double allowed) {
      const long double re = precise(row, "re" + by), im = precise(row, "im" + by);
      tally.error(std::hypot(value.re - re, value.im - im), std::hypot(re, im), allowed, row.where);
    };
    compare(h.value, "", 5e-16L);
    compare(h.by_d, "_by_d", 1e-15L);
    compare(h.by_b, "_by_b", 1e-15L);
  }
}

// v, w rounded to double, the power and the bracket: a few units in the last place of the exponent.
void compare(const Row& row, double v, double w, double alpha, Tally& tally) {
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  const mtf::KolmogorovExponent e = mtf::kolmogorov_exponent(v, w, alpha);
  for (const auto& [column, c] :
       {std::pair{"otf_coeff_exact", mtf::Turbulence<double>::kExact}, {"otf_coeff_3_44", 3.44}}) {
    const auto exact = static_cast<double>(precise(row, column));
    const double full = c * std::pow(v, 5.0 / 3.0);
    tally.compare(std::exp(-c * e.value), exact, 4.0 * kRounding * exact * (1.0 + 2.0 * full) + 5e-324, row.where);
  }
}

void long_exposure(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("kolmogorov_long_exposure.csv")) compare(row, number(row, "u"), 0.0, 0.0, tally);
}

void short_exposure(const Tables& tables, Tally& tally) {
  for (const Row& row : tables.rows("kolmogorov_short_exposure.csv")) {
    const double nu = number(row, "nu");
    compare(row, nu * number(row, "D_over_r0"), nu, number(row, "alpha"), tally);
  }
}

}  // namespace

std::vector<Check> component_checks() {
  std::vector<std::string> kinds;  // in the order of the table
  for (const Row& row : Tables().rows("golden_components.csv"))
    if (std::find(kinds.begin(), kinds.end(), row.at("kind")) == kinds.end()) kinds.push_back(row.at("kind"));
  std::vector<Check> checks;
  for (const std::string& kind : kinds)
    checks.push_back({kind, "golden values", "4 ulp of 1",
                      [kind](const Tables& tables, Tally& tally) { golden(tables, tally, kind); }});
  return checks;
}

std::vector<Check> motion_checks() {
  return {{"accelerated_motion", "Fresnel integrals", "5e-16", fresnel},
          {"accelerated_motion", "mean phase and slopes", "5e-16, slopes 1e-15", chirp}};
}

std::vector<Check> turbulence_checks() {
  const std::string promise = "4 ulp x (1 + 2 |exponent|)";
  return {{"turbulence", "long exposure", promise, long_exposure},
          {"turbulence", "short exposure", promise, short_exposure}};
}

}  // namespace apps::check
