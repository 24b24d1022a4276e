// SPDX-License-Identifier: Apache-2.0

// `mtf budget SENSOR`: the electrons of a pixel, each noise term, and the sensitivity that follows.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/budget_table.h"
#include "apps/config_command.h"
#include "apps/figures/otf_map.h"
#include "apps/figures/plot.h"
#include "apps/options.h"
#include "apps/sensor/otf_curves.h"
#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_place.h"
#include "apps/simulate/output_files.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/words.h"
#include "radiometry/chain/chain.h"
#include "radiometry/chain/sensor_budget.h"
#include "radiometry/chain/sensor_numbers.h"
#include "radiometry/performance/condition_lines.h"
#include "radiometry/performance/target_at_range.h"

namespace apps {
namespace {

// What an observer makes of the noise of a budget: MRTD and MDTD (radiometry/performance/target_at_range.h) as two more
// rows of `mtf budget`, for photon and thermal detectors alike. The noise is the NETD and the spatial NETD of the
// budget; the observer has the defaults of a study. Studies have the same figures as the metrics `mrtd` and `mdtd`,
// with any observer and derivatives.

/// Why there is no MRTD and MDTD of a sensor with that budget, "" where there is.
std::string observer_gap(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                         const radiometry::Budget<double>& budget) {
  if (const std::string refused = refusal_of(budget, budget.netd_k); !refused.empty()) return refused;
  if (!budget.dither.dithered()) return words(budget.dither);
  constexpr double kMost_k = 1e6;  // of MrtdInput
  if (!(budget.netd_k <= kMost_k && budget.spatial_netd_k <= kMost_k))
    return "the light of this temperature hardly reaches the detector: the NETD is " +
           mtf::three_digits(budget.netd_k) + " K, the spatial one " + mtf::three_digits(budget.spatial_netd_k) + " K";
  if (!(system.frame.focal_length_mm > 0.0)) return "no [frame] focal_length";
  const auto& frame = sensor.settings.frame;
  if (sensor.settings.thermal && !(frame && frame->frame_time_s)) return "no [frame] frame_time";
  return "";
}

/// What the observer of MRTD and MDTD sees through a sensor with that budget, with the defaults of a study. `system`
/// has the electron rate of its band, and has to outlive the view.
struct BarView {
  std::shared_ptr<const mtf::Resolution<double>> resolution;
  radiometry::BarObserver<double> observer;
  radiometry::SensorAtRange<double> sensor;
  double cutoff_cy_mrad = 0.0;  ///< as far as squares are counted
};

BarView bar_view(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                 const radiometry::Budget<double>& budget) {
  mtf::ResolutionNeeds needs;
  needs.curves = true;
  needs.tolerance = 1e-6;
  const auto resolution =
      std::make_shared<const mtf::Resolution<double>>(mtf::ResolutionMeter<double>(needs).measure(system));
  return {.resolution = resolution,
          .observer = {system, {}, frame_time_s(system, sensor.settings)},
          .sensor = radiometry::sensor_at_range(budget, 1.0, radiometry::seen_otf(resolution, system.frame)),
          .cutoff_cy_mrad = radiometry::counted_cy_mrad(system, resolution->cutoff_cy_mm)};
}

/// Who the observer of MRTD and MDTD is, and what air lies before the sensor.
std::vector<std::string> observer_lines(const mtf::System<double>& system, const radiometry::Sensor& sensor) {
  const std::string air = air_words(sensor.settings);
  return radiometry::condition_lines(
      {.bars = true}, {}, {}, air.empty() ? "" : air + "; temperature differences are those of the scene behind it",
      frame_rate_words(system, sensor.settings));
}

using Rows = std::vector<radiometry::BudgetRow>;

/// Both at half of the Nyquist frequency, bars and a square of 1 / Nyquist; `system` has the electron rate of its band.
/// A row without a value says why.
std::vector<radiometry::BudgetRow> observer_rows(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                                                 const radiometry::Budget<double>& budget) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  radiometry::BudgetRow mrtd{"mrtd", "mK", none, "minimum resolvable temperature difference at half of Nyquist, 2-D"},
      mdtd{"mdtd", "mK", none, "minimum detectable temperature difference of a square of 1 / Nyquist"};
  mrtd.refused = mdtd.refused = observer_gap(system, sensor, budget);
  mrtd.saturated = mdtd.saturated = is_saturated(budget, budget.netd_k);
  if (!mrtd.refused.empty()) return {mrtd, mdtd};
  try {
    const BarView view = bar_view(system, sensor, budget);
    const double nyquist = view.observer.nyquist_cy_mrad();
    mrtd.value = 1e3 * view.observer.mrtd_k(view.sensor, 0.5 * nyquist);
    mdtd.value = 1e3 * view.observer.mdtd_k(view.sensor, 1.0 / nyquist, view.cutoff_cy_mrad);
    for (radiometry::BudgetRow* row : {&mrtd, &mdtd})
      if (!std::isfinite(row->value)) row->refused = radiometry::kNotResolved;
  } catch (const mtf::Error& error) {
    mrtd.refused = mdtd.refused = error.what();
  }
  return {mrtd, mdtd};
}

/// What the path lets through of the light of the surface, and of that of a small difference of its temperature. A
/// band average of the transmission alone would be another number.
void add_path_rows(const radiometry::Sensor& sensor, double temperature_k, Rows& rows) {
  const double reflected_k = sensor.settings.scene ? sensor.settings.scene->surroundings_k.value_or(0.0) : 0.0;
  const radiometry::Surface surface{temperature_k, sensor.emissivity, reflected_k};
  const auto add = [&](const char* name, const char* doc, const auto& light) {
    const double clear = light(sensor.curves, surface, radiometry::Path{});
    radiometry::BudgetRow row{name, "", light(sensor.curves, surface, sensor.path) / clear, doc};
    if (!(clear > 0.0)) row.refused = "no light of the scene makes electrons";
    radiometry::add_rows(rows, radiometry::BudgetGroup::signal, {std::move(row)});
  };
  add("path_share", "share of the scene's light that the path lets through", radiometry::scene_radiance);
  add("contrast_share", "the same of a small temperature difference", radiometry::scene_derivative);
}

// `mtf budget --curves`: MRTD against the frequency of bars, MDTD against the size of a square, of the observer and the
// noise of `mtf budget` (budget_table.h). A row is a frequency and the square that is as wide as one of its bars,
// W = 1/(2 f). MRTD ends at the Nyquist frequency, MDTD goes on to squares of a quarter of a pixel.

struct MinimumTemperatures {
  struct Row {
    double f_cy_mrad = 0.0, width_mrad = 0.0;
    double mrtd_x_k = 0.0, mrtd_y_k = 0.0, mrtd_k = 0.0, mdtd_k = 0.0;  ///< NaN: not resolved at any difference
    double mrtd_error = 0.0, mdtd_error = 0.0;  ///< relative, of the numbers: by what the OTF may err
  };
  std::vector<Row> rows;
  std::vector<std::string> observer;  ///< who looks, and what air lies before the sensor
};

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

/// What the rows do not say: what was assumed, what has no number, saturation where no table says it.
void note_budget(const BudgetOptions& options, const BudgetTable& budget, const Global& global) {
  constexpr double kCold_k = 100.0;
  if (!options.temperature_has_unit && options.temperature_k < kCold_k) {
    const std::string given = mtf::format_double(options.temperature_k);
    note(global, "warning: --temperature " + given + " was taken for " + given + " K; for degrees Celsius write \"" +
                     given + " degC\", or \"" + given + " K\" where kelvin is meant");
  }
  if (!options.temperature_given) note(global, "note: the pixel sees a surface of 300 K; --temperature takes another");
  if (budget.without_path) note(global, "note: the scene gives the range of each pixel; this budget is without a path");
  if (!budget.spatial_gap.empty()) note(global, "note: spatial noise has no number: " + budget.spatial_gap);
  for (const std::string& text : budget.notes) note(global, "note: " + text);
  const std::string said = words(budget.numbers.saturation);
  if (!said.empty() && (options.curves || options.format != Format::table))
    note(global, (budget.numbers.saturation.saturated() ? "warning: " : "note: ") + said);
}

/// The sensor that a budget is asked of.
mtf::io::SensorConfig read_sensor(const BudgetOptions& options, const Global& global) {
  mtf::io::SensorConfig config = read_sensor(options.sensor, global);
  if (!options.field.empty()) config.system = system_at(config.system, field_point_of(config.system, options.field));
  return options.without_path ? without_path(std::move(config)) : config;
}

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

/// Why figures have no value, but for saturation: each reason once, after the names of its rows.
std::string reasons(const Rows& rows) {
  std::vector<std::pair<std::string, std::string>> found;  // reason, names
  for (const auto& row : rows) {
    if (row.refused.empty() || row.saturated) continue;
    const auto same = std::find_if(found.begin(), found.end(), [&](const auto& f) { return f.first == row.refused; });
    if (same == found.end())
      found.emplace_back(row.refused, row.name);
    else
      same->second += ", " + row.name;
  }
  std::string text;
  for (const auto& [reason, names] : found) text += "no " + names + ": " + reason + "\n";
  return text;
}

using radiometry::BudgetGroup;

constexpr std::array kGroups{std::pair{BudgetGroup::signal, std::string_view("signal")},
                             std::pair{BudgetGroup::temporal, std::string_view("temporal noise")},
                             std::pair{BudgetGroup::spatial, std::string_view("spatial noise")},
                             std::pair{BudgetGroup::sensitivity, std::string_view("sensitivity")}};

/// 4 digits, below 10 million without an exponent.
std::string four_digits(double value) {
  const std::string text = significant(value, 4);
  const double rounded = std::stod(text), size = std::abs(rounded);
  return size >= 1e4 && size < 1e7 ? fixed(rounded, 0) : text;
}

std::string percent(double share) {
  if (share < 0.0005) return "< 0.1 %";
  return share < 0.9995 ? fixed(100.0 * share, 1) + " %" : "100 %";
}

/// Sum of the squares of the terms of a group; not above 0 where it has none or they have no numbers.
double variance_of(const Rows& rows, BudgetGroup group) {
  double sum = 0.0;
  for (const auto& row : rows)
    if (row.group == group && row.term) sum += row.value * row.value;
  return sum;
}

double share_of(const radiometry::BudgetRow& row, double variance) { return row.value * row.value / variance; }

/// Electrons or noise far below what a double resolves of the largest row of the group in that unit.
bool is_next_to_nothing(const radiometry::BudgetRow& row, const Rows& rows) {
  constexpr double kNothing = 1e-12;
  return row.group != BudgetGroup::sensitivity && std::any_of(rows.begin(), rows.end(), [&](const auto& other) {
           return other.group == row.group && other.unit == row.unit &&
                  std::abs(row.value) < kNothing * std::abs(other.value);
         });
}

/// The term that a group of noise is made of most, in words.
std::string largest_term(const Rows& rows, BudgetGroup group) {
  const double variance = variance_of(rows, group);
  if (!(variance > 0.0)) return {};
  const auto largest = std::max_element(rows.begin(), rows.end(), [&](const auto& x, const auto& y) {
    const auto size = [&](const auto& row) { return row.group == group && row.term ? row.value : -1.0; };
    return size(x) < size(y);
  });
  return "The largest " + std::string(group == BudgetGroup::temporal ? "temporal" : "spatial") + " term, " +
         percent(share_of(*largest, variance)) + " of the variance, is " + largest->name + ": " + largest->doc + ".\n";
}

std::string as_csv(const Rows& rows) {
  TextTable table({"term", "value", "unit", "doc", "reason"});
  for (const auto& row : rows) table.add({row.name, csv_number(row.value), row.unit, row.doc, row.refused});
  return table.csv();
}

Json saturation_json(const radiometry::Saturation& saturation) {
  Json json{{"saturated", saturation.saturated()}, {"end", nullptr}, {"share_held", saturation.held}};
  if (saturation.end != radiometry::RangeEnd::none) json["end"] = range_end_name(saturation.end);
  if (const std::string said = words(saturation); !said.empty())
    json[saturation.saturated() ? "reason" : "note"] = said;
  return json;
}

std::string as_json(const BudgetTable& budget, const BudgetOptions& options, const mtf::io::SensorConfig& config) {
  Json json{{"sensor", options.sensor},
            {"name", config.system.name},
            {"config_sha256", config.sha256},
            {"temperature_k", options.temperature_k},
            {"saturation", saturation_json(budget.numbers.saturation)},
            {"notes", budget.notes},
            {"conditions", {{"lines", budget.observer}}}};
  if (!options.field.empty()) json["field"] = {config.system.point.x, config.system.point.y};
  Json& terms = json["terms"] = Json::object();
  for (const auto& row : budget.rows) {
    terms[row.name] = {{"value", row.value}, {"unit", row.unit}, {"doc", row.doc}};
    if (!row.refused.empty()) terms[row.name]["reason"] = row.refused;
  }
  return json_document(json);
}

/// What a person reads beside these rows: the MTF of the system at Nyquist along x and along y, averaged over the band
/// with the electron rate of `loaded`, as `mtf curve` has it; where it changes over the image, its mean and the worst.
std::vector<radiometry::BudgetRow> nyquist_rows(const mtf::System<double>& system, const LoadedSensor& loaded) {
  const mtf::System<double> rated = with_electron_rate(system, loaded);
  std::vector<radiometry::BudgetRow> rows;
  for (const mtf::Axis axis : {mtf::Axis::x, mtf::Axis::y}) {
    const std::string name = axis == mtf::Axis::x ? "x" : "y";
    const Direction direction = make_direction(system.frame, "cy/px", axis == mtf::Axis::x ? 0.0 : 90.0);
    const OtfColumn nyquist = otf_curves(rated, {0.5}, direction).system;
    rows.push_back({"mtf_nyquist_" + name, "", std::hypot(nyquist.otf.front().re, nyquist.otf.front().im),
                    "MTF of the whole system at Nyquist along " + name + ", " +
                        mtf::significant(system.frame.nyquist_cy_mm(axis), 4) + " cy/mm"});
    if (nyquist.has_coarse_average())
      rows.back().doc += "; its average over the band errs by up to " + mtf::significant(nyquist.error.front(), 2);
    if (system.settled)
      rows.back().doc += ", at the field point (" + mtf::significant(system.point.x, 3) + ", " +
                         mtf::significant(system.point.y, 3) + ")";
    if (system.is_isoplanatic() || system.frame.columns == 0 || system.frame.rows == 0) continue;
    rows.back().doc += ", on the optical axis";
    const OtfMap map = otf_map(rated, "mtf@nyquist", direction);
    rows.push_back(
        {"mtf_nyquist_" + name + ".mean", "", map.mean, "over the image, " + map.error_words(map.mean_error)});
    rows.push_back({"mtf_nyquist_" + name + ".worst", "", map.worst().value,
                    "lowest of " + std::to_string(map.places.size()) + " places, at pixel (" +
                        mtf::significant(map.worst().x_px, 5) + ", " + mtf::significant(map.worst().y_px, 5) + "), " +
                        map.error_words(map.worst_error)});
  }
  return rows;
}

}  // namespace

BudgetTable budget_table(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, double temperature_k) {
  const radiometry::Budget<double> budget =
      at_its_place(config, [&] { return budget_of(config.system, loaded.sensor, temperature_k); });
  BudgetTable table{.rows = budget_rows(config.system, loaded.sensor, budget),
                    .numbers = budget,
                    .notes = budget_notes(loaded.sensor, budget),
                    .observer = observer_lines(config.system, loaded.sensor),
                    .spatial_gap = spatial_gap(loaded.sensor.settings, budget),
                    .air = loaded.paths                        ? ""
                           : loaded.sensor.settings.path       ? "[path]"
                           : loaded.sensor.settings.atmosphere ? "[atmosphere]"
                                                               : "",
                    .without_path = static_cast<bool>(loaded.paths)};
  if (!config.system.list(mtf::Stage::readout).empty())
    table.notes.emplace_back(
        "[[readout]] filters shot noise, PRNU and DCNU with the image: the budget has their rms before it, of which "
        "simulated frames show less; MRTD, MDTD, TTP and ranges count that, and take noise behind it, with that of the "
        "flat frames of [correction], as it is");
  for (radiometry::BudgetRow& row : observer_rows(with_electron_rate(config.system, loaded), loaded.sensor, budget))
    table.rows.push_back(std::move(row));
  if (!table.air.empty()) add_path_rows(loaded.sensor, temperature_k, table.rows);
  return table;
}

std::vector<Figure> minimum_temperature_figures(const mtf::io::SensorConfig& config, double temperature_k) {
  const LoadedSensor loaded = load_chain(config);
  const BudgetTable budget = budget_table(config, loaded, temperature_k);
  return figures_of(at_its_place(config, [&] { return minimum_temperatures(config, loaded, budget.numbers); }));
}

std::string budget_text(const BudgetTable& budget, const Rows& rows) {
  TextTable table({"term", "value", "unit", "of variance", "what it is"});
  std::vector<std::string> zeros;
  for (const auto& [group, title] : kGroups) {
    const double variance = variance_of(rows, group);
    bool titled = false;
    for (const auto& row : rows) {
      // The largest term is said of every detector, in words.
      if (row.group != group || row.name == "largest") continue;
      if (row.value == 0.0 || is_next_to_nothing(row, rows)) {
        zeros.push_back(row.name +
                        (row.value == 0.0 ? "" : " (" + mtf::with_unit(significant(row.value, 2), row.unit) + ")"));
        continue;
      }
      if (!std::exchange(titled, true)) {
        const bool behind_air = group == BudgetGroup::sensitivity && !budget.air.empty();
        table.add({std::string(title), "", "", "",
                   behind_air
                       ? "behind the air of " + budget.air + "; --without-path gives that of the sensor by itself"
                       : ""});
      }
      table.add({"  " + row.name,
                 row.saturated              ? "saturated"
                 : std::isfinite(row.value) ? four_digits(row.value)
                                            : "-",
                 row.unit, row.term && variance > 0.0 ? percent(share_of(row, variance)) : "", row.doc});
    }
  }
  std::string lines;
  if (!zeros.empty()) lines += "Zero: " + joined(zeros) + ".\n";
  lines += largest_term(rows, BudgetGroup::temporal) + largest_term(rows, BudgetGroup::spatial);
  lines += reasons(rows);
  if (const std::string said = words(budget.numbers.saturation); !said.empty()) lines += said + "\n";
  for (const std::string& line : budget.observer) lines += one_line(line) + "\n";
  return table.aligned({Align::left, Align::right, Align::left, Align::right}) + lines;
}

int run_budget(const BudgetOptions& options, const Global& global) {
  if (options.curves) return run_budget_curves(options, global);
  if (!options.plot.empty()) throw mtf::UsageError("--plot: draws the curves of --curves; give both");
  const mtf::io::SensorConfig config = read_sensor(options, global);
  if (!options.out.empty())
    for (const std::string& input : files_of(config)) require_different(input, options.out);
  const LoadedSensor loaded = load_chain(config);
  const BudgetTable budget = budget_table(config, loaded, options.temperature_k);
  note_budget(options, budget, global);
  const Rows& rows = budget.rows;
  switch (options.format) {
    case Format::table: {
      Rows shown = rows;
      for (auto& row : nyquist_rows(config.system, loaded)) shown.push_back(std::move(row));
      emit(options.out, budget_text(budget, shown));
      break;
    }
    case Format::csv:
      for (const std::string& line : budget.observer) note(global, "note: " + line);
      emit(options.out, as_csv(rows));
      break;
    case Format::json:
      emit(options.out, as_json(budget, options, config));
      break;
  }
  return 0;
}

}  // namespace apps
