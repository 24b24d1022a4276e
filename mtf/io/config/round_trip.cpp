// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/round_trip.h"

#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/otf/same_list.h"

namespace mtf::io {
namespace {

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
  for (std::size_t i = 0; i < from.size(); ++i)
    if (!same_value(from[i], to[i]))
      return "\"" + std::string(from[i].info->name) + "\" comes back as another value\n" + text;
  return "";
}

}  // namespace mtf::io
