// SPDX-License-Identifier: Apache-2.0
#include "tests/mtf/conformance.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>

namespace mtf::test {
namespace {

enum class Draw { example, near_example, whole_box, lower_bound, upper_bound };

std::string unquoted(std::string_view text) {
  if (text.size() >= 2 && text.front() == '"') text = text.substr(1, text.size() - 2);
  return std::string(text);
}

double number(std::string_view text) {
  double value = std::numeric_limits<double>::quiet_NaN();
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// "[[0, 1], [2, 3]]"
Taps<double> rows_of(std::string_view text) {
  Taps<double> taps;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '[') taps.emplace_back();
    if (text[i - 1] == '[' || text[i - 1] == ' ')
      if (text[i] != '[' && text[i] != ' ') taps.back().push_back(number(text.substr(i)));
  }
  return taps;
}

double draw_number(const FieldInfo& info, double example, Draw draw, Random& random) {
  const double lo = info.lo_open ? std::nextafter(info.lo, info.hi) : info.lo;
  const double hi = info.hi_open ? std::nextafter(info.hi, info.lo) : info.hi;
  switch (draw) {
    case Draw::example:
      return example;
    case Draw::near_example:
      return std::clamp(example * random.uniform(0.35, 2.9), info.lo + 0.02 * std::min(1.0, example),
                        info.hi - 0.1 * std::min(1.0, example));
    case Draw::lower_bound:
      return lo;
    case Draw::upper_bound:
      return hi;
    case Draw::whole_box:
      break;
  }
  const int which = random.below(6);
  if (which == 0) return lo;
  if (which == 1) return hi;
  if (which < 4) return std::clamp(random.uniform(lo, hi), lo, hi);
  return std::clamp(lo + (hi - lo) * random.decades(1e-15, 1.0), lo, hi);
}

Quantity draw_quantity(const FieldInfo& info, Draw draw, Random& random, std::vector<const char*> units) {
  Quantity q = parse_quantity(unquoted(info.example), info.dimension);
  q.value = draw_number(info, q.value, draw, random);
  if (draw == Draw::whole_box) q.unit = find_unit(units[static_cast<std::size_t>(random.below(3))]);
  return q;
}

std::shared_ptr<const Curve> draw_curve(Draw draw, Random& random) {
  const int which = draw == Draw::example ? 0 : random.below(4);
  const auto make = [](const char* unit, std::vector<double> f, std::vector<double> v) {
    return std::make_shared<const Curve>(make_curve("lens.csv", *find_unit(unit), std::move(f), std::move(v)));
  };
  if (which == 0) return make("cy/mm", {0, 20, 40, 60}, {1, 0.7, 0.35, 0});
  if (which == 1) return make("cy/mrad", {1, 2, 4, 6}, {0.9, 0.3, -0.1, 0.02});
  if (which == 2) return make("cy/px", {0, 0.1, 0.5}, {1, 1.02, 0.4});
  return make("cy/mm", {1e-3, 70.0}, {1, 0.5});
}

// Fills one field. A double that stands for a quantity is held in the unit of the field table. A cutoff that may be
// spatial or temporal is like `in_time` when that is given.
void assign(const FieldRef<double>& field, std::string_view in_time, Draw draw, Random& random) {
  const FieldInfo& info = *field.info;
  const auto plain = [&] {
    const double example = info.dimension == Dimension::none
                               ? number(info.example)
                               : convert(parse_quantity(unquoted(info.example), info.dimension), info.unit);
    return draw_number(info, example, draw, random);
  };
  std::visit(
      [&](auto* value) {
        using T = std::remove_pointer_t<decltype(value)>;
        if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>) {
          *value = plain();
        } else if constexpr (std::is_same_v<T, int>) {
          *value = draw == Draw::whole_box ? static_cast<int>(random.uniform(info.lo, info.hi + 1.0))
                                           : static_cast<int>(std::lround(plain()));
        } else if constexpr (std::is_same_v<T, AxisPair<double>>) {
          const auto side = [&] {
            const Quantity q = draw_quantity(info, draw, random, {"um", "urad", "px"});
            return Extent<double>{q.value, q.unit};
          };
          const bool split = draw != Draw::example && random.below(2) == 1;
          *value = {side(), split ? side() : Extent<double>{}, split};
        } else if constexpr (std::is_same_v<T, SpatialFrequency<double>>) {
          const bool temporal = !in_time.empty() && info.dimension == Dimension::cutoff;
          FieldInfo row = info;
          if (temporal) row.example = in_time;
          const Quantity q = draw_quantity(
              row, draw, random, temporal ? std::vector{"Hz", "kHz", "MHz"} : std::vector{"cy/mm", "cy/mrad", "cy/px"});
          *value = {q.value, q.unit};
        } else if constexpr (std::is_same_v<T, Choice>) {
          const auto example = std::find(value->names.begin(), value->names.end(), unquoted(info.example));
          value->index = draw == Draw::example ? static_cast<int>(example - value->names.begin())
                                               : random.below(static_cast<int>(value->names.size()));
        } else if constexpr (std::is_same_v<T, Coefficients<double>>) {
          *value = rows_of("[" + std::string(info.example) + "]").front();
          if (draw == Draw::whole_box) value->resize(static_cast<std::size_t>(1 + random.below(16)));
          for (double& coefficient : *value) coefficient = draw_number(info, coefficient, draw, random);
        } else if constexpr (std::is_same_v<T, Taps<double>>) {
          *value = rows_of(info.example);
          if (draw == Draw::whole_box) {  // odd numbers, except where the example has pairs
            const bool pairs = value->front().size() == 2;
            const auto rows = static_cast<std::size_t>(1 + 2 * random.below(3));
            value->assign(rows, std::vector<double>(pairs ? 2 : static_cast<std::size_t>(1 + 2 * random.below(3))));
          }
          for (auto& row : *value)
            for (double& tap : row)
              tap = draw == Draw::near_example ? tap * random.uniform(0.35, 2.9) : draw_number(info, tap, draw, random);
        } else {
          *value = draw_curve(draw, random);
        }
      },
      field.value);
}

System<double> empty_system(Draw draw, Random& random) {
  System<double> s;
  s.frame = {100.0, 15.0, 15.0, 0.01, 0, 0};
  if (draw == Draw::near_example) s.frame = {37.5, 12.0, 17.0, 0.02, 0, 0};
  if (draw == Draw::whole_box && random.below(2) == 1)
    s.frame = {random.decades(1e-6, 1e7), random.decades(1e-6, 1e6), random.decades(1e-6, 1e6), 0.01, 0, 0};
  s.optics.f_number = 2.5;
  s.optics.obscuration = draw == Draw::example ? 0.0 : 0.25;
  s.optics.wavelength_um = 4.5;
  return s;
}

bool has_error(const System<double>& system) {
  const auto findings = system.check();
  return std::any_of(findings.begin(), findings.end(), [](const auto& f) { return f.problem.error; });
}

// A typical frequency in time beside a field that says how time becomes place; empty for other fields.
std::string_view frequency_in_time(const FieldInfo& info) {
  if (info.dimension == Dimension::velocity || info.dimension == Dimension::rate) return "400 kHz";
  return info.dimension == Dimension::temporal ? "4 MHz" : "";
}

/// The component with the fields of that bit set filled; the others are left as they are.
Component<double> filled(const Component<double>& blank, std::uint64_t chosen, Draw draw, Random& random) {
  Component<double> component = blank;
  const auto refs = component.fields();
  const auto in_use = [&](std::size_t i) { return (chosen >> i & 1) != 0; };
  std::string_view in_time;
  for (std::size_t i = 0; i < refs.size(); ++i)
    if (in_use(i) && in_time.empty()) in_time = frequency_in_time(*refs[i].info);
  for (std::size_t i = 0; i < refs.size(); ++i)
    if (in_use(i)) assign(refs[i], in_time, draw, random);
  return component;
}

Stage first_stage(const Component<double>& component) {
  return *std::find_if(kStages.begin(), kStages.end(), [&](Stage stage) { return component.stages().allows(stage); });
}

System<double> system_of(const Component<double>& component, Draw draw, Random& random) {
  System<double> system = empty_system(draw, random);
  system.add(first_stage(component), component);
  return system;
}

// Which fields are given, as bit sets: the required ones with every combination of the others. Where there are more
// than five others: every smallest set that check() accepts, alone and with each one and each pair of the rest.
std::vector<std::uint64_t> field_subsets(const Component<double>& component) {
  std::uint64_t required = 0;
  std::vector<std::uint64_t> others;
  std::uint64_t bit = 1;
  for (const auto& field : component.fields()) {
    if (field.info->presence == Presence::required)
      required |= bit;
    else
      others.push_back(bit);
    bit <<= 1;
  }
  std::vector<std::uint64_t> subsets;
  if (others.size() <= 5) {
    for (std::size_t chosen = 0; chosen < std::size_t{1} << others.size(); ++chosen) {
      std::uint64_t subset = required;
      for (std::size_t i = 0; i < others.size(); ++i) subset |= chosen >> i & 1 ? others[i] : 0;
      subsets.push_back(subset);
    }
    return subsets;
  }
  others.insert(others.begin(), 0);  // "no field": triples with repetition are all sets of up to three
  std::vector<std::uint64_t> smallest;
  for (int size = 0; size <= 3; ++size)
    for (std::size_t i = 0; i < others.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        for (std::size_t k = 0; k <= j; ++k) {
          const std::uint64_t set = required | others[i] | others[j] | others[k];
          if (std::popcount(set ^ required) != size) continue;
          const auto inside = [&](std::uint64_t known) { return (known & set) == known; };
          Random random(1);
          if (std::none_of(smallest.begin(), smallest.end(), inside) &&
              !has_error(system_of(filled(component, set, Draw::example, random), Draw::example, random)))
            smallest.push_back(set);
        }
  for (const std::uint64_t set : smallest)
    for (std::size_t i = 0; i < others.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j) subsets.push_back(set | others[i] | others[j]);
  std::sort(subsets.begin(), subsets.end());
  subsets.erase(std::unique(subsets.begin(), subsets.end()), subsets.end());
  return subsets;
}

std::vector<Case> make_cases() {
  std::vector<Case> cases;
  for (const std::string_view kind : component_kinds()) {
    const Component<double> blank = Component<double>::make(kind);
    for (const std::uint64_t chosen : field_subsets(blank)) {
      std::string name(kind);
      std::vector<std::string> given;
      const auto infos = blank.fields();
      for (std::size_t i = 0; i < infos.size(); ++i) {
        if ((chosen >> i & 1) == 0) continue;
        name += " " + std::string(infos[i].info->name);
        if (infos[i].info->presence != Presence::required) given.emplace_back(infos[i].info->name);
      }
      for (int repeat = 0; repeat < 11; ++repeat) {
        const Draw draw = repeat == 0   ? Draw::example
                          : repeat < 4  ? Draw::near_example
                          : repeat < 9  ? Draw::whole_box
                          : repeat == 9 ? Draw::lower_bound
                                        : Draw::upper_bound;
        const std::string case_name = name + " #" + std::to_string(repeat);
        Random random(case_name);
        const Component<double> component = filled(blank, chosen, draw, random);
        const Stage stage = first_stage(component);
        Case c{case_name, system_of(component, draw, random), stage, given, repeat < 4};
        if (!has_error(c.system))
          cases.push_back(std::move(c));
        else if (repeat == 0)
          break;  // these fields exclude each other
      }
    }
  }
  return cases;
}

}  // namespace

Random::Random(std::string_view name, std::uint64_t stream) : state_(0xCBF29CE484222325u) {  // FNV-1a
  for (const char c : name) state_ = (state_ ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  state_ += stream * 0xBF58476D1CE4E5B9u;
}

std::uint64_t Random::bits() {  // SplitMix64 (Steele, Lea, Flood 2014)
  std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

const std::vector<Case>& conformance_cases() {
  static const std::vector<Case> cases = make_cases();
  return cases;
}

}  // namespace mtf::test
