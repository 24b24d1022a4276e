// SPDX-License-Identifier: Apache-2.0
#include "apps/range/budget_curves.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/budget_table.h"
#include "apps/config_command.h"
#include "apps/figures/plot.h"
#include "apps/sensor/sensor_place.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"

namespace apps {
namespace {

using Row = MinimumTemperatures::Row;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Of Nyquist: sixteenths of it, then squares down to a quarter of a pixel.
std::vector<double> shares_of_nyquist() {
  std::vector<double> shares;
  for (int k = 1; k <= 16; ++k) shares.push_back(k / 16.0);
  shares.insert(shares.end(), {1.25, 1.5, 2.0, 2.5, 3.0, 4.0});
  return shares;
}

MinimumTemperatures minimum_temperatures(const mtf::io::SensorConfig& config, const LoadedSensor& loaded,
                                         const radiometry::Budget<double>& budget) {
  if (const std::string why = observer_gap(config.system, loaded.sensor, budget); !why.empty())
    throw mtf::UsageError("no MRTD and MDTD: " + why);
  const mtf::System<double> system = with_electron_rate(config.system, loaded);
  const BarView view = bar_view(system, loaded.sensor, budget);
  const auto& [resolution, observer, sensor, cutoff] = view;
  radiometry::SensorAtRange<double> worse = sensor;
  const double error = resolution->error;
  worse.otf.mtf = [mtf = sensor.otf.mtf, error](mtf::Axis axis, double f) {
    return std::max(0.0, mtf(axis, f) - error);
  };
  worse.otf.centred = [otf = sensor.otf.centred, error](mtf::Axis axis, double f) { return otf(axis, f) - error; };

  const double nyquist = observer.nyquist_cy_mrad();
  const auto known = [](double kelvin) { return std::isfinite(kelvin) ? kelvin : kNone; };
  const auto relative = [](double value, double other) { return std::abs(other / value - 1.0); };
  MinimumTemperatures found{.rows = {}, .observer = observer_lines(config.system, loaded.sensor)};
  bool dropped = false;
  for (const double share : shares_of_nyquist()) {
    Row row{.f_cy_mrad = share * nyquist, .width_mrad = 0.5 / (share * nyquist)};
    const bool bars = share <= 1.0;
    // Each axis up to a Nyquist frequency of its own, which is not that of both where pitches differ.
    const auto along = [&](mtf::Axis axis, double pitch_um) {
      const bool within = row.f_cy_mrad <= 0.5 * system.frame.focal_length_mm / pitch_um * (1.0 + 1e-12);
      return bars && within ? known(observer.mrtd_k(sensor, axis, row.f_cy_mrad)) : kNone;
    };
    row.mrtd_x_k = along(mtf::Axis::x, system.frame.pitch_x_um);
    row.mrtd_y_k = along(mtf::Axis::y, system.frame.pitch_y_um);
    row.mrtd_k = bars ? known(observer.mrtd_k(sensor, row.f_cy_mrad)) : kNone;
    row.mdtd_k = known(observer.mdtd_k(sensor, row.width_mrad, cutoff));
    row.mrtd_error = bars ? relative(row.mrtd_k, observer.mrtd_k(worse, row.f_cy_mrad)) : kNone;
    row.mdtd_error = relative(row.mdtd_k, observer.mdtd_k(worse, row.width_mrad, cutoff));
    if (!std::isfinite(resolution->cutoff_cy_mm))  // nothing ends the MTF: what lies beyond the frequencies counted
      row.mdtd_error += relative(row.mdtd_k, observer.mdtd_k(sensor, row.width_mrad, 4.0 * cutoff));
    constexpr double kNoNumber = 0.5;  // relative
    const auto drop = [&](double Row::*of_error, std::initializer_list<double Row::*> values) {
      if (!(row.*of_error >= kNoNumber)) return;
      dropped = true;
      row.*of_error = kNone;
      for (double Row::*value : values) row.*value = kNone;
    };
    drop(&Row::mrtd_error, {&Row::mrtd_x_k, &Row::mrtd_y_k, &Row::mrtd_k});
    drop(&Row::mdtd_error, {&Row::mdtd_k});
    found.rows.push_back(row);
  }
  if (dropped)
    found.observer.push_back(
        "no number where it would err by half or more, as the MTF is known no better there; a system that ends, by "
        "diffraction and a footprint in [[presample]], has all");
  return found;
}

struct Column {
  const char *name, *head;
  double Row::*member;
  double scale;
};
constexpr std::array<Column, 8> kColumns{{{"frequency_cy_mrad", "frequency [cy/mrad]", &Row::f_cy_mrad, 1.0},
                                          {"mrtd_x_mK", "MRTD x [mK]", &Row::mrtd_x_k, 1e3},
                                          {"mrtd_y_mK", "MRTD y [mK]", &Row::mrtd_y_k, 1e3},
                                          {"mrtd_mK", "MRTD 2-D [mK]", &Row::mrtd_k, 1e3},
                                          {"size_mrad", "square [mrad]", &Row::width_mrad, 1.0},
                                          {"mdtd_mK", "MDTD [mK]", &Row::mdtd_k, 1e3},
                                          {"mrtd_error", "", &Row::mrtd_error, 1.0},
                                          {"mdtd_error", "", &Row::mdtd_error, 1.0}}};

std::string as_table(const MinimumTemperatures& found) {
  std::vector<std::string> header;
  for (const Column& column : kColumns)
    if (*column.head != '\0') header.emplace_back(column.head);
  const std::vector<Align> align(header.size(), Align::right);
  TextTable table(std::move(header));
  double mrtd_error = 0.0, mdtd_error = 0.0;
  for (const Row& row : found.rows) {
    std::vector<std::string> cells;
    for (const Column& column : kColumns)
      if (const double value = column.scale * row.*column.member; *column.head != '\0')
        cells.push_back(std::isfinite(value) ? significant(value, 4) : "-");
    table.add(std::move(cells));
    mrtd_error = std::fmax(mrtd_error, row.mrtd_error);
    mdtd_error = std::fmax(mdtd_error, row.mdtd_error);
  }
  std::string text =
      "MRTD, minimum resolvable temperature difference of four bars, 7:1, up to the Nyquist frequency\n"
      "MDTD, minimum detectable temperature difference of a square as wide as a bar\n" +
      table.aligned(align) + "numerical error: up to " + significant(mrtd_error, 2) + " of MRTD, " +
      significant(mdtd_error, 2) + " of MDTD\n";
  for (const std::string& line : found.observer) text += one_line(line) + "\n";
  return text;
}

std::string as_csv(const MinimumTemperatures& found) {
  std::vector<std::string> header;
  for (const Column& column : kColumns) header.emplace_back(column.name);
  TextTable table(std::move(header));
  for (const Row& row : found.rows) {
    std::vector<std::string> cells;
    for (const Column& column : kColumns) cells.push_back(csv_number(column.scale * row.*column.member));
    table.add(std::move(cells));
  }
  return table.csv();
}

std::string as_json(const MinimumTemperatures& found, const BudgetOptions& options,
                    const mtf::io::SensorConfig& config) {
  Json curves = Json::object();
  for (const Column& column : kColumns) {
    Json& list = curves[column.name] = Json::array();
    for (const Row& row : found.rows) list.push_back(column.scale * row.*column.member);
  }
  return json_document({{"sensor", options.sensor},
                        {"name", config.system.name},
                        {"config_sha256", config.sha256},
                        {"temperature_k", options.temperature_k},
                        {"curves", curves},
                        {"conditions", {{"lines", found.observer}}}});
}

std::vector<Figure> figures_of(const MinimumTemperatures& found) {
  const auto series = [&](const char* name, double Row::*x, double Row::*y) {
    Series line{.name = name};
    for (const Row& row : found.rows) {
      line.x.push_back(row.*x);
      line.y.push_back(1e3 * row.*y);
    }
    return line;
  };
  Figure bars, squares;
  bars.title = "MRTD";
  bars.x_label = "spatial frequency [cy/mrad]";
  bars.y_label = "MRTD [mK]";
  bars.log_y = true;
  bars.series = {series("along x", &Row::f_cy_mrad, &Row::mrtd_x_k), series("along y", &Row::f_cy_mrad, &Row::mrtd_y_k),
                 series("2-D", &Row::f_cy_mrad, &Row::mrtd_k)};
  squares.title = "MDTD";
  squares.x_label = "width of the square [mrad]";
  squares.y_label = "MDTD [mK]";
  squares.log_x = squares.log_y = true;
  squares.series = {series("MDTD", &Row::width_mrad, &Row::mdtd_k)};
  return {bars, squares};
}

}  // namespace

int run_budget_curves(const BudgetOptions& options, const Global& global) {
  const mtf::io::SensorConfig config = read_sensor(options, global);
  std::vector<std::string> files{options.out};
  for (std::string& file : figure_files(options.plot)) files.push_back(std::move(file));
  OutputSet outputs({.files = files, .inputs = files_of(config)});
  const LoadedSensor loaded = load_chain(config);
  const BudgetTable budget = budget_table(config, loaded, options.temperature_k);
  const MinimumTemperatures found =
      at_its_place(config, [&] { return minimum_temperatures(config, loaded, budget.numbers); });
  note_budget(options, budget, global);
  if (!options.plot.empty())
    note(global, figure_note(options.plot, write_figures(outputs.at(options.plot), figures_of(found), as_csv(found))));
  if (options.format == Format::csv)
    for (const std::string& line : found.observer) note(global, "note: " + line);
  outputs.commit(options.out, options.format == Format::csv    ? as_csv(found)
                              : options.format == Format::json ? as_json(found, options, config)
                                                               : as_table(found));
  return 0;
}

}  // namespace apps
