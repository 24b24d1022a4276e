// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/sensor_place.h"

#include <algorithm>
#include <string_view>

#include "mtf/io/config/config_tree.h"

namespace apps {
namespace {

using mtf::io::cfg::Member;
using mtf::io::cfg::Node;

constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_";

const Member* member_of(const Node& table, std::string_view key) {
  const auto found = std::ranges::find_if(table.members, [&](const Member& m) { return m.key == key; });
  return found == table.members.end() ? nullptr : &*found;
}

bool is_key(const mtf::io::SensorConfig& config, std::string_view table, std::string_view key) {
  return std::any_of(config.schema.begin(), config.schema.end(), [&](const mtf::TableInfo& info) {
    return info.name == table && std::ranges::any_of(info.settings, [&](const auto& row) { return row.name == key; });
  });
}

}  // namespace

std::optional<mtf::io::Diagnostic> finding_of(const mtf::io::SensorConfig& config, const std::string& message) {
  const std::string file = config.file + ": ";
  const std::string text = message.starts_with(file) ? message.substr(file.size()) : message;
  const bool table_only = text.starts_with('[');
  const std::size_t start = table_only ? 1 : 0;
  const std::size_t dot = std::min(text.find_first_not_of(kLetters, start), text.size());
  const std::string table = text.substr(start, dot - start);
  const Member* found = nullptr;
  const mtf::io::cfg::Tree tree = mtf::io::cfg::read_tree(config.text);
  if (table_only && text.compare(dot, 1, "]") == 0) {
    found = member_of(tree.root, table);
  } else if (text.compare(dot, 1, ".") == 0) {
    const std::size_t end = std::min(text.find_first_not_of(kLetters, dot + 1), text.size());
    const std::string key = text.substr(dot + 1, end - dot - 1);
    found = member_of(tree.root, table);
    if (found != nullptr) {
      const Member* inner = member_of(found->value, key);
      // What is missing has the place of its table; a file beside the sensor file may be called like one.
      const bool known = is_key(config, table, key) || text.compare(end, 9, ": missing") == 0;
      found = inner != nullptr ? inner : known ? found : nullptr;
    }
  }
  if (found == nullptr) return std::nullopt;
  mtf::io::Diagnostic finding{.error = true, .position = found->position, .path = {}, .text = text};
  if (const std::size_t colon = text.find(": "); colon != std::string::npos) {
    finding.path = text.substr(0, colon);
    finding.text = text.substr(colon + 2);
  }
  return finding;
}

std::string placed(const mtf::io::SensorConfig& config, const std::string& message) {
  const auto finding = finding_of(config, message);
  return finding ? mtf::io::format_diagnostic(*finding, config.file) : message;
}

}  // namespace apps
