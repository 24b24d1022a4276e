// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sensor as the page shows it: every component and table with its rows, the values as written, and for each number
// the ends of a slider. Rows come from the field tables (apps/sensor/sensor_kinds.h), values from the text of the file.

#include "apps/sensor/sensor_kinds.h"
#include "apps/text/json.h"
#include "mtf/io/config/config.h"
#include "mtf/io/config/config_tree.h"

namespace apps::live {

/// {"name", "components": [{"label", "kind", "list", "doc", "rows": [...]}], "tables": [{"name", ...}],
/// "off": [{"number", "title"}], "kinds": what may be added}.
Json model_json(const mtf::io::SensorConfig& sensor, const SensorKinds& kinds);

/// Whether the file says what the keys of that table depend on (TableKind::condition).
bool holds(const TableKind& table, const mtf::io::cfg::Node& root);

/// The ends of a slider for a number: the range of its row where that is short, else about the value; on a logarithmic
/// scale where the row wants one and the value is above zero. In the unit of `value`.
struct SliderRange {
  double low = 0.0, high = 1.0;
  bool log = false;
};
SliderRange slider_range(const mtf::FieldInfo& parameter, double value, double lo, double hi);

/// What every row of the page has; `text`: the value as written, or the one that counts where the file has none.
Json row_head(const mtf::FieldInfo& row, const std::string& name, const std::string& key, bool given,
              const std::string& text);

/// A text as the file has it, without its quotes; any other value as TOML writes it.
std::string written(const mtf::io::cfg::Node& node);
/// Makes a row that of a number in `unit`, from `lo` to `hi` where they are finite, whose slider has that range.
void add_number(Json& row, double number, const std::string& unit, double lo, double hi, const SliderRange& range);

}  // namespace apps::live
