// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/round_trip.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/config_text.h"

namespace mtf::io {
namespace {

bool same(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }
bool same(const std::optional<double>& a, const std::optional<double>& b) {
  return a.has_value() == b.has_value() && (!a || same(*a, *b));
}
bool same(const Extent<double>& a, const Extent<double>& b) { return a.unit == b.unit && same(a.value, b.value); }
bool same(const AxisPair<double>& a, const AxisPair<double>& b) {
  return a.split == b.split && same(a.x, b.x) && (!a.split || same(a.y, b.y));
}
bool same(const SpatialFrequency<double>& a, const SpatialFrequency<double>& b) {
  return a.unit == b.unit && same(a.value, b.value);
}
bool same(int a, int b) { return a == b; }
bool same(const Choice& a, const Choice& b) { return a.index == b.index; }
bool same(const Coefficients<double>& a, const Coefficients<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double s, double t) { return same(s, t); });
}
bool same(const Taps<double>& a, const Taps<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) { return same(x, y); });
}
bool same(const std::shared_ptr<const Curve>& a, const std::shared_ptr<const Curve>& b) {
  return (a == nullptr) == (b == nullptr) &&
         (!a || (a->frequency == b->frequency && a->value == b->value && a->unit == b->unit));
}

std::vector<FieldRef<double>> without_files(std::span<const FieldRef<double>> fields) {
  std::vector<FieldRef<double>> rest;
  for (const FieldRef<double>& field : fields)
    if (!std::holds_alternative<std::shared_ptr<const Curve>*>(field.value)) rest.push_back(field);
  return rest;
}

}  // namespace

std::string round_trip(std::string_view kind, std::span<const FieldRef<double>> written,
                       std::span<const FieldRef<double>> read) {
  const auto from = without_files(written), to = without_files(read);
  const std::string text = "kind = " + cfg::toml_string(kind) + "\n" + cfg::write_fields(from);
  const cfg::Tree tree = cfg::read_tree(text);
  if (tree.error) return format_diagnostic(*tree.error, "") + "\n" + text;
  cfg::Reader reader;
  cfg::read_fields({reader, tree.root, "", "the component"}, to);
  for (const Diagnostic& diagnostic : reader.diagnostics)
    if (diagnostic.error) return format_diagnostic(diagnostic, "") + "\n" + text;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const bool equal = std::visit(
        [&](const auto* value) { return same(*value, *std::get<std::remove_cvref_t<decltype(*value)>*>(to[i].value)); },
        from[i].value);
    if (!equal) return "\"" + std::string(from[i].info->name) + "\" comes back as another value\n" + text;
  }
  return "";
}

}  // namespace mtf::io
