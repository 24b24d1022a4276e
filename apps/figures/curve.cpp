// SPDX-License-Identifier: Apache-2.0

// `mtf curve`: the OTF of each component, of each list and of the system, as table, CSV, JSON and figure.

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/arguments.h"
#include "apps/config_command.h"
#include "apps/figures/curve_figure.h"
#include "apps/figures/otf_map.h"
#include "apps/figures/plot.h"
#include "apps/sensor/otf_curves.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/io/config/config.h"

namespace apps {
namespace {

using mtf::Complex;

std::string as_table(const OtfCurves& curves) {
  const auto columns = curves.columns();
  std::vector<std::string> header{curves.direction.unit};
  for (const OtfColumn* column : columns) header.push_back(one_line(column->label));
  if (!curves.system.real) header.emplace_back("phase [deg]");
  const std::vector<Align> align(header.size(), Align::right);
  TextTable table(std::move(header));
  for (std::size_t i = 0; i < curves.frequency.size(); ++i) {
    std::vector<std::string> row{significant(curves.frequency[i], 6)};
    for (const OtfColumn* column : columns) row.push_back(fixed(modulus(column->otf[i]), 5));
    const Complex<double>& h = curves.system.otf[i];
    if (!curves.system.real) row.push_back(fixed(std::atan2(h.im, h.re) * 180.0 / std::numbers::pi, 3));
    table.add(std::move(row));
  }
  std::string text = table.aligned(align);
  for (const OtfColumn* column : columns)
    if (column->has_coarse_average())
      text += "the average over the band of " + one_line(column->label) + " errs by up to " +
              significant(*std::max_element(column->error.begin(), column->error.end()), 2) + "\n";
  return text;
}

std::string as_csv(const OtfCurves& curves) {
  const std::vector<TableColumn> table = table_of(curves);
  std::string text = joined(
                         table, [](const TableColumn& column) { return csv_field(column.name); }, ",") +
                     "\n";
  for (std::size_t i = 0; i < curves.frequency.size(); ++i)
    for (const TableColumn& column : table)
      text += mtf::format_double(column.values[i]) + (&column == &table.back() ? "\n" : ",");
  return text;
}

int terminal_columns() {
  winsize size{};
  int columns = 79;
  if (::isatty(STDOUT_FILENO) != 0 && ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
    columns = size.ws_col - 1;
  return std::clamp(columns, 40, 160);
}

std::string formatted(const OtfCurves& curves, const mtf::System<double>& system, Format format) {
  if (format == Format::csv) return as_csv(curves);
  if (format == Format::json) return json_document(curves_json(curves), -1);
  return as_table(curves) + "\n" + curve_footer(system, curves);
}

std::vector<std::string> outputs_of(const CurveOptions& options) {
  const bool to_stdout = options.out.empty() || options.out == "-", ascii = options.plot == "ascii";
  if (ascii && to_stdout && options.format != Format::table)
    throw mtf::UsageError("--plot ascii and --format csv or json both write to standard output; give -o FILE");
  std::vector<std::string> outputs{options.out};
  for (std::string& file : figure_files(ascii ? "" : options.plot)) outputs.push_back(std::move(file));
  return outputs;
}

int show_map(const mtf::System<double>& system, const CurveOptions& options, OutputSet& outputs, const Global& global) {
  if (!options.field.empty() || !options.frequencies.empty())
    throw mtf::UsageError("--map is over the whole image; leave --field and --freq out");
  if (options.plot == "ascii") throw mtf::UsageError("--map has no figure in characters; give --plot map.svg");
  const OtfMap map = otf_map(system, options.map, make_direction(system.frame, options.unit, options.angle_deg));
  if (!options.plot.empty()) {
    const bool drawn = write_figure(outputs.at(options.plot), otf_map_figure(map));
    note(global, figure_note(options.plot, drawn));
  }
  outputs.commit(options.out, options.format == Format::csv    ? otf_map_csv(map)
                              : options.format == Format::json ? json_document(otf_map_json(map), -1)
                                                               : otf_map_table(map));
  return 0;
}

}  // namespace

int run_curve(const CurveOptions& options, const Global& global) {
  const mtf::io::SensorConfig config = load_sensor(options.sensor, global);
  OutputSet outputs({.files = outputs_of(options), .inputs = files_of(config)});
  if (!options.map.empty()) return show_map(config.system, options, outputs, global);
  std::optional<mtf::FieldPoint<double>> q;
  if (!options.field.empty()) q = field_point_of(config.system, options.field);
  const mtf::System<double> system = system_at(config.system, q.value_or(mtf::FieldPoint<double>{}));
  const Direction direction = make_direction(system.frame, options.unit, options.angle_deg);
  OtfCurves curves = otf_curves(
      system, options.frequencies.empty() ? std::vector<double>() : frequency_list("--freq", options.frequencies),
      direction);
  if (q) curves.field = *q;

  bool show_values = true;
  if (options.plot == "ascii") {
    const auto drawing = ascii_figure(curve_figure(curves), terminal_columns(), 28);
    if (drawing) {
      show_values = !options.out.empty();
      print(*drawing + "\n" + curve_footer(system, curves));
    } else {
      note(global, "mtf: note: gnuplot is not installed: no figure (Debian package gnuplot-nox)");
    }
  } else if (!options.plot.empty()) {
    const bool drawn = write_figure(outputs.at(options.plot), curve_figure(curves));
    note(global, figure_note(options.plot, drawn));
  }
  if (show_values)
    outputs.commit(options.out, formatted(curves, system, options.format));
  else
    outputs.commit();
  return 0;
}

}  // namespace apps
