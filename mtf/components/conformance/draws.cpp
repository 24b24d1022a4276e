// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/conformance/draws.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>

#include "mtf/error.h"

namespace mtf::conformance {
namespace {

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
Taps<double> rows_of(std::string_view name, std::string_view text) {
  Taps<double> taps;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '[') taps.emplace_back();
    if (text[i - 1] == '[' || text[i - 1] == ' ')
      if (text[i] != '[' && text[i] != ' ') taps.back().push_back(number(text.substr(i)));
  }
  if (taps.empty() || taps.front().empty())
    throw UsageError("field \"" + std::string(name) + "\": the example \"" + std::string(text) +
                     "\" is no list of numbers; write one such as [0.1, 0.2], or rows of them for taps");
  return taps;
}

double draw_number(const FieldInfo& info, double example, Origin from, Random& random) {
  const double lo = info.lo_open ? std::nextafter(info.lo, info.hi) : info.lo;
  const double hi = info.hi_open ? std::nextafter(info.hi, info.lo) : info.hi;
  if (from == Origin::example) return example;
  if (from == Origin::near_example) {
    const double size = std::min(1.0, std::abs(example));
    const double near_lo = info.lo + 0.02 * size, near_hi = info.hi - 0.1 * size;
    const double value = example * random.uniform(0.35, 2.9);
    return near_lo <= near_hi ? std::clamp(value, near_lo, near_hi) : std::clamp(value, lo, hi);
  }
  if (from == Origin::lower_bound) return lo;
  if (from == Origin::upper_bound) return hi;
  const int which = random.below(6);
  if (which == 0) return lo;
  if (which == 1) return hi;
  if (which < 4) return std::clamp(random.uniform(lo, hi), lo, hi);
  return std::clamp(lo + (hi - lo) * random.decades(1e-15, 1.0), lo, hi);
}

Quantity draw_quantity(const FieldInfo& info, Origin from, Random& random, std::vector<const char*> units) {
  Quantity q = parse_quantity(unquoted(info.example), info.dimension);
  q.value = draw_number(info, q.value, from, random);
  if (from == Origin::whole_range) q.unit = find_unit(units[static_cast<std::size_t>(random.below(3))]);
  return q;
}

std::shared_ptr<const Curve> draw_curve(Origin from, Random& random) {
  const int which = from == Origin::example ? 0 : random.below(4);
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
void assign(const FieldRef<double>& field, std::string_view in_time, Origin from, Random& random) {
  const FieldInfo& info = *field.info;
  const auto plain = [&] {
    const double example = info.dimension == Dimension::none
                               ? number(info.example)
                               : convert(parse_quantity(unquoted(info.example), info.dimension), info.unit);
    return draw_number(info, example, from, random);
  };
  std::visit(
      [&](auto* value) {
        using T = std::remove_pointer_t<decltype(value)>;
        if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>) {
          *value = plain();
        } else if constexpr (std::is_same_v<T, int>) {
          *value = from == Origin::whole_range
                       ? static_cast<int>(std::min(random.uniform(info.lo, info.hi + 1.0), info.hi))
                       : static_cast<int>(std::lround(plain()));
        } else if constexpr (std::is_same_v<T, AxisPair<double>>) {
          const auto side = [&] {
            const Quantity q = draw_quantity(info, from, random, {"um", "urad", "px"});
            return Extent<double>{q.value, q.unit};
          };
          const bool split = from != Origin::example && random.below(2) == 1;
          *value = {side(), split ? side() : Extent<double>{}, split};
        } else if constexpr (std::is_same_v<T, SpatialFrequency<double>>) {
          const bool temporal = !in_time.empty() && info.dimension == Dimension::cutoff;
          FieldInfo row = info;
          if (temporal) row.example = in_time;
          const Quantity q = draw_quantity(
              row, from, random, temporal ? std::vector{"Hz", "kHz", "MHz"} : std::vector{"cy/mm", "cy/mrad", "cy/px"});
          *value = {q.value, q.unit};
        } else if constexpr (std::is_same_v<T, Choice>) {
          *value = choice_of(value->names, unquoted(info.example));
          if (from != Origin::example) value->index = random.below(static_cast<int>(value->names.size()));
        } else if constexpr (std::is_same_v<T, Coefficients<double>>) {
          *value = rows_of(info.name, "[" + std::string(info.example) + "]").front();
          if (from == Origin::whole_range) value->resize(static_cast<std::size_t>(1 + random.below(16)));
          for (double& coefficient : *value) coefficient = draw_number(info, coefficient, from, random);
        } else if constexpr (std::is_same_v<T, Taps<double>>) {
          *value = rows_of(info.name, info.example);
          if (from == Origin::whole_range) {  // odd numbers, except where the example has pairs
            const bool pairs = value->front().size() == 2;
            const auto rows = static_cast<std::size_t>(1 + 2 * random.below(3));
            value->assign(rows, std::vector<double>(pairs ? 2 : static_cast<std::size_t>(1 + 2 * random.below(3))));
          }
          for (auto& row : *value)
            for (double& tap : row)
              tap =
                  from == Origin::near_example ? tap * random.uniform(0.35, 2.9) : draw_number(info, tap, from, random);
        } else {
          *value = draw_curve(from, random);
        }
      },
      field.value);
}

// A typical frequency in time for a cutoff beside a field that says how time becomes place; empty for other fields.
std::string_view frequency_in_time(const FieldInfo& info) {
  if (info.dimension == Dimension::velocity || info.dimension == Dimension::rate) return "400 kHz";
  return info.dimension == Dimension::temporal ? "4 MHz" : "";
}

Context<double> surroundings(Origin from, Random& random) {
  Context<double> ctx;
  ctx.frame = {100.0, 15.0, 15.0, 0.01, 0, 0};
  if (from == Origin::near_example) ctx.frame = {37.5, 12.0, 17.0, 0.02, 0, 0};
  if (from == Origin::whole_range && random.below(2) == 1)
    ctx.frame = {random.decades(1e-6, 1e7), random.decades(1e-6, 1e6), random.decades(1e-6, 1e6), 0.01, 0, 0};
  ctx.optics.f_number = 2.5;
  ctx.optics.obscuration = from == Origin::example ? 0.0 : 0.25;
  ctx.optics.wavelength_um = 4.5;
  ctx.wavelength_um = 4.5;
  return ctx;
}

// Which fields are given, as bit sets: the required ones with every combination of the others. Where there are more
// than five others: every smallest set that is accepted, alone and with each one and each pair of the rest.
std::vector<std::uint64_t> field_subsets(std::span<const FieldRef<double>> fields,
                                         const std::function<bool(const Draw&)>& accepted) {
  std::uint64_t required = 0;
  std::vector<std::uint64_t> others;
  std::uint64_t bit = 1;
  for (const FieldRef<double>& field : fields) {
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
          if (std::ranges::none_of(smallest, inside) && accepted({"", set, Origin::example})) smallest.push_back(set);
        }
  for (const std::uint64_t set : smallest)
    for (std::size_t i = 0; i < others.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j) subsets.push_back(set | others[i] | others[j]);
  std::ranges::sort(subsets);
  subsets.erase(std::unique(subsets.begin(), subsets.end()), subsets.end());
  return subsets;
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

Context<double> give_values(const Draw& draw, std::span<const FieldRef<double>> fields) {
  Random random(draw.name);
  const auto is_given = [&](std::size_t i) { return (draw.given >> i & 1) != 0; };
  std::string_view in_time;
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (is_given(i) && in_time.empty()) in_time = frequency_in_time(*fields[i].info);
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (is_given(i)) assign(fields[i], in_time, draw.origin, random);
  return surroundings(draw.origin, random);
}

std::vector<Draw> draws_of(std::string_view kind, std::span<const FieldRef<double>> fields,
                           const std::function<bool(const Draw&)>& accepted) {
  std::vector<Draw> draws;
  for (const std::uint64_t given : field_subsets(fields, accepted)) {
    std::string name(kind);
    for (std::size_t i = 0; i < fields.size(); ++i)
      if ((given >> i & 1) != 0) name += " " + std::string(fields[i].info->name);
    for (int repeat = 0; repeat < 11; ++repeat) {
      const Origin origin = repeat == 0   ? Origin::example
                            : repeat < 4  ? Origin::near_example
                            : repeat < 9  ? Origin::whole_range
                            : repeat == 9 ? Origin::lower_bound
                                          : Origin::upper_bound;
      Draw draw{name + " #" + std::to_string(repeat), given, origin};
      if (accepted(draw))
        draws.push_back(std::move(draw));
      else if (repeat == 0)
        break;  // these fields exclude each other
    }
  }
  return draws;
}

}  // namespace mtf::conformance
