// SPDX-License-Identifier: Apache-2.0

// `mtf curve`: the OTF of each component, of each list and of the system, as table, CSV, JSON and figure.

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "apps/arguments.h"
#include "apps/figures/curve_figure.h"
#include "apps/figures/curve_values.h"
#include "apps/figures/plot.h"
#include "apps/sensor/sensor_file.h"
#include "apps/simulate/output_files.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/io/config/config.h"

namespace apps {
namespace {

using mtf::Complex;
using Json = nlohmann::ordered_json;

std::string as_table(const CurveValues& values) {
  const auto columns = columns_of(values);
  std::vector<std::string> header{values.direction.unit};
  for (const OtfColumn* column : columns) header.push_back(one_line(column->label));
  if (!values.system.real) header.emplace_back("phase [deg]");
  const std::vector<Align> align(header.size(), Align::right);
  TextTable table(std::move(header));
  for (std::size_t i = 0; i < values.frequency.size(); ++i) {
    std::vector<std::string> row{significant(values.frequency[i], 6)};
    for (const OtfColumn* column : columns) row.push_back(fixed(modulus(column->otf[i]), 5));
    const Complex<double>& h = values.system.otf[i];
    if (!values.system.real) row.push_back(fixed(std::atan2(h.im, h.re) * 180.0 / std::numbers::pi, 3));
    table.add(std::move(row));
  }
  std::string text = table.aligned(align);
  for (const OtfColumn* column : columns)
    if (has_coarse_average(*column))
      text += "the average over the band of " + one_line(column->label) + " errs by up to " +
              significant(*std::max_element(column->error.begin(), column->error.end()), 2) + "\n";
  return text;
}

std::string as_csv(const CurveValues& values) {
  const auto columns = columns_of(values);
  std::string text = "frequency";
  for (const OtfColumn* column : columns)
    text += "," +
            (column->real ? csv_field(column->label)
                          : csv_field(column->label + "_re") + "," + csv_field(column->label + "_im")) +
            (has_coarse_average(*column) ? "," + csv_field(column->label + "_error") : "");
  text += "\n";
  for (std::size_t i = 0; i < values.frequency.size(); ++i) {
    text += mtf::format_double(values.frequency[i]);
    for (const OtfColumn* column : columns) {
      text += "," + mtf::format_double(column->otf[i].re + 0.0);
      if (!column->real) text += "," + mtf::format_double(column->otf[i].im + 0.0);
      if (has_coarse_average(*column)) text += "," + mtf::format_double(column->error[i]);
    }
    text += "\n";
  }
  return text;
}

void add_parts(Json& json, const OtfColumn& column) {
  // + 0.0 makes 0 of the negative zero, which would be printed as -0.
  Json& re = json["re"] = Json::array();
  for (const auto& h : column.otf) re.push_back(h.re + 0.0);
  Json& im = json["im"] = Json::array();
  for (const auto& h : column.otf) im.push_back(h.im + 0.0);
  if (has_coarse_average(column)) json["error"] = column.error;
}

std::string as_json(const CurveValues& values, const KeyFigures& figures, const std::string& name) {
  Json json;
  json["name"] = name;
  json["unit"] = values.direction.unit;
  json["angle_deg"] = values.direction.angle_deg;
  json["nyquist"] = figures.nyquist;
  json["cutoff"] = figures.cutoff ? Json(*figures.cutoff) : Json();
  json["q"] = figures.q ? Json(*figures.q) : Json();
  json["frequency"] = values.frequency;
  json["components"] = Json::array();
  for (const OtfColumn& column : values.components) {
    Json component{{"label", column.label}, {"kind", column.kind}, {"stage", column.stage}, {"doc", column.doc}};
    add_parts(component, column);
    json["components"].push_back(std::move(component));
  }
  for (const OtfColumn& column : values.stages) add_parts(json[column.label] = Json::object(), column);
  add_parts(json["system"] = Json::object(), values.system);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

int terminal_columns() {
  winsize size{};
  int columns = 79;
  if (::isatty(STDOUT_FILENO) != 0 && ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
    columns = size.ws_col - 1;
  return std::clamp(columns, 40, 160);
}

std::string formatted(const CurveValues& values, const KeyFigures& figures, const mtf::System<double>& system,
                      Format format) {
  if (format == Format::csv) return as_csv(values);
  if (format == Format::json) return as_json(values, figures, system.name);
  return as_table(values) + "\n" + curve_footer(system, values.direction, figures);
}

/// Refuses outputs that would overwrite one another or an input, before anything is written.
void check_outputs(const CurveOptions& options, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) require_different(input, options.out);
  const bool to_stdout = options.out.empty() || options.out == "-";
  if (options.plot == "ascii") {
    if (to_stdout && options.format != Format::table)
      throw mtf::UsageError("--plot ascii and --format csv or json both write to standard output; give -o FILE");
    return;
  }
  if (options.plot.empty()) return;
  check_figure_path(options.plot);
  const std::string data = figure_data_path(options.plot);
  for (const std::string& path : {options.plot, data}) {
    for (const std::string& input : inputs) require_different(input, path);
    if (!to_stdout && is_same_file(path, options.out))
      throw mtf::UsageError(one_line(options.out) + ": -o names the " +
                            (path == data ? "data file of the figure " : "file of the figure ") +
                            one_line(options.plot) + "; choose another name for -o");
  }
}

}  // namespace

int run_curve(const CurveOptions& options, const Global& global) {
  const mtf::io::SensorConfig config = load_sensor(options.sensor, global);
  check_outputs(options, files_of(config));
  const mtf::System<double>& system = config.system;
  const Direction direction = make_direction(system.frame, options.unit, options.angle_deg);
  const KeyFigures figures = key_figures(system, direction);
  const double top = std::min(figures.cutoff.value_or(2.0 * figures.nyquist), 2.0 * figures.nyquist);
  const CurveValues values = curve_values(
      system, direction,
      options.frequencies.empty() ? evenly_spaced(0.0, top, 61) : frequency_list("--freq", options.frequencies));

  bool show_values = true;
  if (options.plot == "ascii") {
    const auto drawing = ascii_figure(curve_figure(system, values), terminal_columns(), 28);
    if (drawing) {
      show_values = !options.out.empty();
      print(*drawing + "\n" + curve_footer(system, direction, figures));
    } else {
      note(global, "mtf: note: gnuplot is not installed: no figure (Debian package gnuplot-nox)");
    }
  } else if (!options.plot.empty()) {
    const bool drawn = write_figure(options.plot, curve_figure(system, values));
    const std::string data = one_line(figure_data_path(options.plot));
    note(global,
         drawn ? "wrote " + one_line(options.plot) + " and its data " + data
               : "mtf: note: gnuplot is not installed (Debian package gnuplot-nox): wrote only the data, " + data);
  }
  if (show_values) emit(options.out, formatted(values, figures, system, options.format));
  return 0;
}

}  // namespace apps
