// SPDX-License-Identifier: Apache-2.0

// `mtf curve`: the OTF of each component, of each list and of the system, as table, CSV, JSON and figure.

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "apps/arguments.h"
#include "apps/config_command.h"
#include "apps/figures/curve_figure.h"
#include "apps/figures/curve_json.h"
#include "apps/figures/plot.h"
#include "apps/sensor/otf_curves.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/config/config.h"
#include "mtf/words.h"

namespace apps {
namespace {

// A figure of the OTF of the whole system over the image: at 9 x 9 places, from the centre of one corner pixel to that
// of the opposite one, and on the optical axis.

struct OtfMap {
  static constexpr std::size_t kSide = 9;
  struct Place {
    double x_px = 0.0, y_px = 0.0;  ///< from the upper left corner of the detector
    mtf::FieldPoint<double> q;
    double value = 0.0;
  };
  std::string quantity, unit;  ///< "mtf@nyquist"; of the values: "" for an MTF
  Direction direction;
  double frequency = 0.0;                   ///< of an MTF
  double band_error = 0.0;                  ///< that the average over the band has at most
  std::array<Place, kSide * kSide> places;  ///< row by row
  Place axis;
  double mean = 0.0, mean_error = 0.0;  ///< over the image, and its change from every other place to all

  /// The lowest.
  const Place& worst() const {
    return *std::min_element(places.begin(), places.end(),
                             [](const Place& a, const Place& b) { return a.value < b.value; });
  }
};

constexpr std::size_t kSide = OtfMap::kSide;

/// Simpson's rule over every `stride`-th of kSide places along an axis, weights that add up to 1.
double simpson_weight(std::size_t i, std::size_t stride) {
  const std::size_t last = (kSide - 1) / stride, k = i / stride;
  return (k == 0 || k == last ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) / (3.0 * static_cast<double>(last));
}

double mean_of(const OtfMap& map, std::size_t stride) {
  double sum = 0.0;
  for (std::size_t j = 0; j < kSide; j += stride)
    for (std::size_t i = 0; i < kSide; i += stride)
      sum += simpson_weight(i, stride) * simpson_weight(j, stride) * map.places[j * kSide + i].value;
  return sum;
}

std::string place_text(const OtfMap::Place& place) {
  return "pixel (" + significant(place.x_px, 5) + ", " + significant(place.y_px, 5) + "), field point (" +
         significant(place.q.x, 3) + ", " + significant(place.q.y, 3) + ")";
}

Json place_json(const OtfMap::Place& place) {
  Json json{{"x_px", place.x_px}, {"y_px", place.y_px}};
  json["field"] = {place.q.x, place.q.y};
  json["value"] = place.value;
  return json;
}

/// `quantity`: mtf@nyquist, mtf@FREQ with FREQ in the unit of the direction, or mtf50. Throws UsageError for another
/// one, a system without the format of its detector, numbers that are not valid somewhere in the image, and an MTF50
/// that is not there.
OtfMap otf_map(const mtf::System<double>& system, const std::string& quantity, const Direction& direction) {
  const mtf::Frame<double>& frame = system.frame;
  if (frame.columns == 0 || frame.rows == 0)
    throw mtf::UsageError("--map: the size of the detector is not known; give [frame] format");
  OtfMap map;
  map.quantity = quantity;
  map.direction = direction;
  const bool mtf50_wanted = quantity == "mtf50";
  if (mtf50_wanted) {
    map.unit = direction.unit;
  } else if (quantity == "mtf@nyquist") {
    map.frequency = key_figures(system, direction).nyquist;
  } else if (quantity.starts_with("mtf@")) {
    map.frequency = number("--map", quantity.substr(4));
  } else {
    throw mtf::UsageError("--map: '" + quantity + "' is not known; write mtf@nyquist, mtf@0.25 or mtf50");
  }
  const auto value_at = [&](OtfMap::Place& place) {
    const mtf::System<double> here = system_at(system, place.q);
    const OtfCurves curves =
        otf_curves(here, mtf50_wanted ? std::vector<double>() : std::vector<double>{map.frequency}, direction);
    for (const double error : curves.system.error)
      if (!(error <= map.band_error)) map.band_error = error;
    if (!mtf50_wanted) {
      place.value = modulus(curves.system.otf.front());
    } else if (const std::optional<double> found = mtf50(here, curves)) {
      place.value = *found;
    } else {
      throw mtf::UsageError("--map mtf50: at " + place_text(place) + " the MTF does not cross 1/2 from 0 to " +
                            significant(curves.frequency.back(), 4) + " " + direction.unit + "; use mtf@FREQ");
    }
  };
  for (std::size_t j = 0; j < kSide; ++j)
    for (std::size_t i = 0; i < kSide; ++i) {
      OtfMap::Place& place = map.places[j * kSide + i];
      const auto at = [](std::size_t k, int count) {
        return 0.5 + static_cast<double>(k) * static_cast<double>(count - 1) / static_cast<double>(kSide - 1);
      };
      place.x_px = at(i, frame.columns);
      place.y_px = at(j, frame.rows);
      place.q = system.field_point(place.x_px, place.y_px);
      value_at(place);
    }
  map.axis.x_px = 0.5 * frame.columns + system.field.axis_x_px;
  map.axis.y_px = 0.5 * frame.rows + system.field.axis_y_px;
  value_at(map.axis);
  map.mean = mean_of(map, 1);
  map.mean_error = std::abs(map.mean - mean_of(map, 2));
  return map;
}

std::string otf_map_table(const OtfMap& map) {
  std::vector<std::string> header{"y \\ x [px]"};
  for (std::size_t i = 0; i < kSide; ++i) header.push_back(significant(map.places[i].x_px, 5));
  const std::vector<Align> align(header.size(), Align::right);
  TextTable table(std::move(header));
  for (std::size_t j = 0; j < kSide; ++j) {
    std::vector<std::string> row{significant(map.places[j * kSide].y_px, 5)};
    for (std::size_t i = 0; i < kSide; ++i) row.push_back(fixed(map.places[j * kSide + i].value, 4));
    table.add(std::move(row));
  }
  const auto shown = [&](double value) { return mtf::with_unit(significant(value, 4), map.unit); };
  std::string text = map.quantity;
  if (map.unit.empty()) text += ", at " + significant(map.frequency, 6) + " " + map.direction.unit;
  text += ", direction " + significant(map.direction.angle_deg, 4) + " deg\n" + table.aligned(align);
  text += "axis   " + shown(map.axis.value) + "\n";
  text += "mean   " + shown(map.mean) + " over the image, to about " + significant(map.mean_error, 1) + "\n";
  text += "worst  " + shown(map.worst().value) + " of these places, at " + place_text(map.worst()) + "\n";
  if (!(map.band_error <= mtf::kBandError))
    text += "the average over the band errs by up to " + significant(map.band_error, 2) + "\n";
  return text;
}

std::string otf_map_csv(const OtfMap& map) {
  std::string text = "x_px,y_px,field_x,field_y,value\n";
  const auto add = [&](const OtfMap::Place& place) {
    text += mtf::format_double(place.x_px) + "," + mtf::format_double(place.y_px) + "," +
            mtf::format_double(place.q.x) + "," + mtf::format_double(place.q.y) + "," +
            mtf::format_double(place.value) + "\n";
  };
  for (const OtfMap::Place& place : map.places) add(place);
  return text;
}

Json otf_map_json(const OtfMap& map) {
  Json json{{"quantity", map.quantity}, {"unit", map.direction.unit}, {"angle_deg", map.direction.angle_deg}};
  if (map.unit.empty()) json["frequency"] = map.frequency;
  json["axis"] = place_json(map.axis);
  json["mean"] = map.mean;
  json["mean_error"] = map.mean_error;
  json["worst"] = place_json(map.worst());
  json["places"] = json_list(map.places, place_json);
  if (!(map.band_error <= mtf::kBandError)) json["error"] = map.band_error;
  return json;
}

Figure otf_map_figure(const OtfMap& map) {
  Figure figure;
  figure.title = map.quantity + " of the system over the image";
  figure.x_label = "x [pixels]";
  figure.y_label = "y, downwards [pixels]";
  figure.equal_axes = true;
  const OtfMap::Place& last = map.places.back();
  const double width = last.x_px + 0.5, height = last.y_px + 0.5, margin = 0.08;  // room for words at the edges
  figure.x_range = {-margin * width, (1.0 + margin) * width};
  figure.y_low = (1.0 + margin) * height;
  figure.y_high = -margin * height;
  figure.colour_label = map.unit.empty() ? "MTF" : "MTF50 [" + map.unit + "]";
  Series series{"places", {}, {}};
  series.mark = Mark::large_points;
  for (const OtfMap::Place& place : map.places) {
    series.x.push_back(place.x_px);
    series.y.push_back(place.y_px);
    series.value.push_back(place.value);
    series.words.push_back(significant(place.value, 2));
  }
  const auto [low, high] = std::minmax_element(series.value.begin(), series.value.end());
  figure.colour_range = {*low, *high > *low ? *high : *low + 0.01};
  figure.series.push_back(std::move(series));
  return figure;
}

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

/// The field point of "0.7,-0.7", or of the pixel "320px,40px".
mtf::FieldPoint<double> field_point_of(const mtf::System<double>& system, const std::string& text) {
  const std::size_t comma = text.find(',');
  const auto part = [&](std::string one, bool& pixels) {
    pixels = one.ends_with("px");
    if (pixels) one.resize(one.size() - 2);
    return number("--field", one);
  };
  if (comma == std::string::npos)
    throw mtf::UsageError("--field: '" + text + "' is not a place; write X,Y such as 0.7,-0.7 or 320px,40px");
  bool x_px = false, y_px = false;
  const double x = part(text.substr(0, comma), x_px), y = part(text.substr(comma + 1), y_px);
  if (x_px != y_px) throw mtf::UsageError("--field: " + text + ": give both in px, or neither");
  if (!x_px) return {x, y};
  const mtf::Frame<double>& frame = system.frame;
  const mtf::FieldPoint<double> q = system.field_point(x, y);
  if (!(x >= 0.0 && x <= frame.columns && y >= 0.0 && y <= frame.rows))
    throw mtf::UsageError("--field: " + text + " is outside the detector of " + std::to_string(frame.columns) + " x " +
                          std::to_string(frame.rows) + " pixels");
  return q;
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
