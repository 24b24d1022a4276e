// SPDX-License-Identifier: Apache-2.0
#include "apps/study/dimensions.h"

#include <array>
#include <cmath>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/units.h"

namespace study {
namespace {

constexpr std::array<double Dimensions::*, 6> kBases{&Dimensions::metre,    &Dimensions::second,
                                                     &Dimensions::kelvin,   &Dimensions::electron,
                                                     &Dimensions::kilogram, &Dimensions::candela};
constexpr std::array<std::string_view, 6> kBaseNames{"m", "s", "K", "e-", "kg", "cd"};
constexpr double kMostPower = 100.0;
constexpr double kParts = 25200.0;  // of a whole power
constexpr std::size_t kMaxUnit = 80;

struct Named {
  std::string_view name;
  UnitScale scale;
};

// What metrics have beyond the units of sensor files.
constexpr std::array kMore{
    Named{"%", {{}, 0.01}},
    Named{"dB", {{}, 1.0}},
    Named{"sr", {{}, 1.0}},
    Named{"cy", {{}, 1.0}},
    Named{"ph", {{}, 1.0}},
    Named{"counts", {{}, 1.0}},
    Named{"px^2", {{}, 1.0}},
    Named{"kg", {{.kilogram = 1}, 1.0}},
    Named{"g", {{.kilogram = 1}, 1e-3}},
    Named{"cd", {{.candela = 1}, 1.0}},
    Named{"J", {{.metre = 2, .second = -2, .kilogram = 1}, 1.0}},
    Named{"cy/m", {{.metre = -1}, 1.0}},
    Named{"cy/rad", {{}, 1.0}},
    Named{"cm^2", {{.metre = 2}, 1e-4}},
};

// Capacitance and voltage count the charge in electrons of so many coulombs (exact in the SI): F = C^2 / J, V = J / C.
constexpr double kElectron = 1.602176634e-19;
/// Base units of the dimensions, in their order, in SI.
constexpr std::array<UnitScale, 23> kBaseUnits{{
    {},                                    // none
    {{.metre = 1}, 1e-6},                  // length
    {{}, 1e-6},                            // angle
    {},                                    // extent
    {},                                    // frequency
    {{.second = -1}, 1.0},                 // temporal
    {},                                    // cutoff
    {{.second = 1}, 1.0},                  // time
    {{.metre = 1, .second = -1}, 1e-6},    // velocity
    {{.second = -1}, 1e-6},                // rate
    {},                                    // pixel
    {{.metre = -2, .candela = 1}, 1.0},    // luminance
    {{.metre = 1, .second = -2}, 1e-6},    // acceleration
    {{.second = -2}, 1e-6},                // angular_acceleration
    {{.kelvin = 1}, 1.0},                  // temperature
    {},                                    // temperature_difference
    {{.electron = 1}, 1.0},                // electrons
    {{.second = -1, .electron = 1}, 1.0},  // current
    {{.metre = -2, .second = 2, .electron = 2, .kilogram = -1}, (1.0 / kElectron) * (1.0 / kElectron)},  // capacitance
    {{.metre = 2, .second = -2, .electron = -1, .kilogram = 1}, kElectron},                              // voltage
    {{.metre = 2, .second = -3, .kilogram = 1}, 1.0},                                                    // power
    {{.metre = -1, .second = -2, .kilogram = 1}, 1.0},                                                   // pressure
    {{.metre = 1, .second = -1}, 1e-3 / 3600.0},                                                         // rain_rate
}};
static_assert(kBaseUnits.size() == static_cast<std::size_t>(mtf::Dimension::rain_rate) + 1);

/// No unit has the dimensions extent and cutoff, which stand for several, nor temperature_difference, whose units are
/// those of temperature. Pixels and what is counted in them are plain numbers.
UnitScale base_of(const mtf::Unit& unit) {
  if (unit.name == "cy/mm") return {{.metre = -1}, 1e3};
  if (unit.name == "cy/mrad") return {{}, 1e3};
  return kBaseUnits[static_cast<std::size_t>(unit.dimension)];
}

/// Quotients keep powers of ten exact where products with small factors do not: 15 um = 15 / 1e6 m.
double scaled(double factor, double base) {
  return base >= 1.0 ? factor * base : factor >= 1.0 ? factor / (1.0 / base) : 1.0 / ((1.0 / factor) * (1.0 / base));
}

std::optional<UnitScale> one_unit(std::string_view name) {
  for (const Named& more : kMore)
    if (more.name == name) return more.scale;
  const mtf::Unit* unit = mtf::find_unit(name);
  if (unit == nullptr) return std::nullopt;
  UnitScale scale = base_of(*unit);
  scale.si = scaled(unit->factor, scale.si);
  return scale;
}

/// "s", "m^2", "Hz^-2" into `total`; false when it is none.
bool multiply(UnitScale& total, std::string_view factor, int sign) {
  auto scale = one_unit(factor);
  double exponent = sign;
  if (!scale) {
    const std::size_t hat = factor.rfind('^');
    if (hat == std::string_view::npos) return false;
    scale = one_unit(factor.substr(0, hat));
    const auto written = mtf::io::cell_number(factor.substr(hat + 1));
    if (!scale || !written) return false;
    exponent *= *written;
  }
  const auto raised = power(scale->dimensions, exponent);
  const auto both = raised ? product(total.dimensions, *raised) : std::nullopt;
  if (!both) return false;
  total = {*both, total.si * (exponent == 1.0 ? scale->si : std::pow(scale->si, exponent))};
  return true;
}

bool goes_on(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}

}  // namespace

UnitScale unit_scale(std::string_view unit) {
  if (unit.empty()) return {};
  if (const auto scale = one_unit(unit)) return *scale;
  UnitScale total;
  int sign = 1;
  bool good = unit.size() <= kMaxUnit;
  for (std::string_view rest = unit; good && !rest.empty();) {
    const std::size_t blank = rest.find(' ');
    const std::string_view word = rest.substr(0, blank);
    rest.remove_prefix(blank == std::string_view::npos ? rest.size() : blank + 1);
    if (word.empty()) continue;
    if (multiply(total, word, sign)) continue;
    // "W/m^2": the first factor, then those below the stroke.
    const std::size_t stroke = word.find('/');
    good = stroke != std::string_view::npos && stroke > 0 && multiply(total, word.substr(0, stroke), sign) &&
           multiply(total, word.substr(stroke + 1), -sign);
  }
  if (!good) throw mtf::UsageError("unknown unit \"" + std::string(unit.substr(0, kMaxUnit)) + "\"");
  return total;
}

std::size_t unit_length(std::string_view text) {
  text = text.substr(0, 16);
  for (std::size_t length = text.size(); length > 0; --length) {
    if (length < text.size() && text[length - 1] != '%' && goes_on(text[length])) continue;
    if (text[length - 1] != ' ' && one_unit(text.substr(0, length))) return length;
  }
  return 0;
}

std::optional<Dimensions> product(const Dimensions& a, const Dimensions& b, int power) {
  Dimensions result;
  for (const auto base : kBases) {
    result.*base = std::round((a.*base + power * b.*base) * kParts) / kParts;
    if (!(std::abs(result.*base) <= kMostPower)) return std::nullopt;
  }
  return result;
}

std::optional<Dimensions> power(const Dimensions& base, double exponent) {
  Dimensions result;
  for (const auto one : kBases) {
    if (base.*one == 0.0) continue;
    const double parts = exponent * (base.*one) * kParts, whole = std::round(parts);
    if (!(std::abs(whole) <= kMostPower * kParts) || !(std::abs(parts - whole) <= 1e-6)) return std::nullopt;
    result.*one = whole / kParts + 0.0;  // no -0
  }
  return result;
}

std::string si_unit(const Dimensions& dimensions) {
  std::string text;
  for (std::size_t i = 0; i < kBases.size(); ++i) {
    const double n = dimensions.*kBases[i];
    if (n == 0.0) continue;
    text += (text.empty() ? "" : " ") + std::string(kBaseNames[i]);
    if (n != 1.0) text += "^" + mtf::format_double(n);
  }
  return text;
}

std::string describe(const Dimensions& dimensions) {
  return dimensions.plain() ? "a plain number" : si_unit(dimensions);
}

}  // namespace study
