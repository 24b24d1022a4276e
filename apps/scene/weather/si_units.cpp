// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/weather/si_units.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

#include "mtf/error.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace apps::scene {
namespace {

struct Symbol {
  std::string_view name;
  SiUnit unit;
};

using Powers = std::array<int, 4>;  // of m, kg, s, K
constexpr Powers kPlain{}, kMetre{1, 0, 0, 0}, kKilogram{0, 1, 0, 0}, kSecond{0, 0, 1, 0}, kKelvin{0, 0, 0, 1};
constexpr Powers kJoule{2, 1, -2, 0}, kWatt{2, 1, -3, 0}, kPascal{-1, 1, -2, 0};

constexpr std::array kSymbols{
    Symbol{"m", {1.0, 0.0, kMetre}},
    Symbol{"km", {1e3, 0.0, kMetre}},
    Symbol{"cm", {1e-2, 0.0, kMetre}},
    Symbol{"mm", {1e-3, 0.0, kMetre}},
    Symbol{"um", {1e-6, 0.0, kMetre}},
    Symbol{"in", {0.0254, 0.0, kMetre}},
    Symbol{"ft", {0.3048, 0.0, kMetre}},
    Symbol{"kg", {1.0, 0.0, kKilogram}},
    Symbol{"g", {1e-3, 0.0, kKilogram}},
    Symbol{"t", {1e3, 0.0, kKilogram}},
    Symbol{"s", {1.0, 0.0, kSecond}},
    Symbol{"min", {60.0, 0.0, kSecond}},
    Symbol{"h", {3600.0, 0.0, kSecond}},
    Symbol{"d", {86400.0, 0.0, kSecond}},
    Symbol{"K", {1.0, 0.0, kKelvin}},
    Symbol{"mK", {1e-3, 0.0, kKelvin}},
    Symbol{"J", {1.0, 0.0, kJoule}},
    Symbol{"kJ", {1e3, 0.0, kJoule}},
    Symbol{"MJ", {1e6, 0.0, kJoule}},
    Symbol{"W", {1.0, 0.0, kWatt}},
    Symbol{"mW", {1e-3, 0.0, kWatt}},
    Symbol{"kW", {1e3, 0.0, kWatt}},
    Symbol{"MW", {1e6, 0.0, kWatt}},
    Symbol{"Pa", {1.0, 0.0, kPascal}},
    Symbol{"hPa", {1e2, 0.0, kPascal}},
    Symbol{"kPa", {1e3, 0.0, kPascal}},
    Symbol{"mbar", {1e2, 0.0, kPascal}},
    Symbol{"bar", {1e5, 0.0, kPascal}},
    Symbol{"rad", {1.0, 0.0, kPlain}},
    Symbol{"mrad", {1e-3, 0.0, kPlain}},
    Symbol{"deg", {std::numbers::pi / 180.0, 0.0, kPlain}},
    Symbol{"%", {1e-2, 0.0, kPlain}},
};

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '%'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Recursive descent over products of powers.
class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : text_(text) {}

  std::optional<SiUnit> whole() {
    const auto unit = product(0);
    return unit && at_ == text_.size() ? unit : std::nullopt;
  }

 private:
  std::optional<SiUnit> product(int depth) {
    constexpr int kDeepest = 4;
    if (depth > kDeepest) return std::nullopt;
    SiUnit result;
    bool any = false;
    for (;;) {
      int sign = 1;
      while (at_ < text_.size() && std::string_view(" *./").find(text_[at_]) != std::string_view::npos) {
        if (text_[at_] == '/' && std::exchange(sign, -1) == -1) return std::nullopt;
        ++at_;
      }
      if (at_ == text_.size() || text_[at_] == ')') return any && sign == 1 ? std::optional(result) : std::nullopt;
      const auto next = factor(depth);
      if (!next) return std::nullopt;
      result.factor *= sign > 0 ? next->factor : 1.0 / next->factor;
      for (std::size_t i = 0; i < result.powers.size(); ++i) result.powers[i] += sign * next->powers[i];
      any = true;
    }
  }

  /// A symbol or a product in brackets, with its power: "m2", "m^-2", "(m2 K)".
  std::optional<SiUnit> factor(int depth) {
    std::optional<SiUnit> base;
    if (text_[at_] == '(') {
      ++at_;
      base = product(depth + 1);
      if (!base || at_ == text_.size()) return std::nullopt;
      ++at_;
    } else {
      const std::size_t start = at_;
      while (at_ < text_.size() && is_letter(text_[at_])) ++at_;
      const std::string_view name = text_.substr(start, at_ - start);
      const auto found = std::ranges::find_if(kSymbols, [&](const Symbol& symbol) { return symbol.name == name; });
      if (found == kSymbols.end()) return std::nullopt;
      base = found->unit;
    }
    const int power = exponent();
    SiUnit result;
    result.factor = std::pow(base->factor, power);
    for (std::size_t i = 0; i < result.powers.size(); ++i) result.powers[i] = power * base->powers[i];
    return result;
  }

  int exponent() {
    std::size_t at = at_;
    if (at < text_.size() && text_[at] == '^') ++at;
    const bool negative = at < text_.size() && text_[at] == '-';
    if (negative) ++at;
    if (at == text_.size() || !is_digit(text_[at])) return 1;
    at_ = at + 1;
    return (negative ? -1 : 1) * (text_[at] - '0');
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace

std::optional<SiUnit> parse_unit(std::string_view text) {
  constexpr std::size_t kLongest = 64;
  text = mtf::trimmed(text);
  if (text == "degC" || text == "\u00b0C") return SiUnit{1.0, mtf::kZeroCelsius_k, kKelvin};
  if (text == "1") return SiUnit{};
  if (text.empty() || text.size() > kLongest) return std::nullopt;
  return UnitParser(text).whole();
}

bool same_dimension(const SiUnit& a, const SiUnit& b) { return a.powers == b.powers; }

double parse_si(std::string_view text, std::string_view in_unit, std::string_view example) {
  const auto fail = [&](const std::string& why) {
    return mtf::UsageError("\"" + mtf::printable(text, 60) + "\": " + why + "; write it like \"" +
                           std::string(example) + "\"");
  };
  std::string_view rest = mtf::trimmed(text);
  if (rest.starts_with('+')) rest.remove_prefix(1);
  double value = 0.0;
  const auto [end, status] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (status == std::errc::result_out_of_range) throw fail("the number is out of range");
  if (status != std::errc{}) throw fail("no number");
  if (!std::isfinite(value)) throw fail("the number is not finite");
  rest = mtf::trimmed(rest.substr(static_cast<std::size_t>(end - rest.data())));
  const SiUnit wanted = in_unit.empty() ? SiUnit{} : parse_unit(in_unit).value();
  if (rest.empty() && in_unit.empty()) return value;
  if (rest.empty()) throw fail("no unit");
  const auto unit = parse_unit(rest);
  if (!unit) throw fail("unknown unit \"" + mtf::printable(rest, 40) + "\"");
  if (!same_dimension(*unit, wanted)) throw fail("the unit \"" + mtf::printable(rest, 40) + "\" does not fit");
  // A quotient of equal factors is 1, so that a value in the unit that is asked for stays what it is.
  const double result = value * (unit->factor / wanted.factor) + (unit->offset - wanted.offset) / wanted.factor;
  if (!std::isfinite(result)) throw fail("the number is out of range");
  return result;
}

}  // namespace apps::scene
