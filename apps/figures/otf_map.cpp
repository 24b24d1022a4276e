// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/otf_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "apps/arguments.h"
#include "apps/figures/curve_figure.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/field/image_places.h"
#include "mtf/words.h"

namespace apps {
namespace {

constexpr int kMostAlong = 129;

/// Of the places those that people are shown: 9 x 9.
std::vector<const OtfMap::Place*> shown_places(const OtfMap& map) {
  const std::size_t step = (map.along - 1) / (mtf::kImagePlaces - 1);
  std::vector<const OtfMap::Place*> shown;
  for (std::size_t j = 0; j < map.along; j += step)
    for (std::size_t i = 0; i < map.along; i += step) shown.push_back(&map.places[j * map.along + i]);
  return shown;
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

}  // namespace

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
  const mtf::Frame<double>& frame = system.frame;
  if (!x_px) {
    const double axis_um =
                     std::hypot(system.field.axis_x_px * frame.pitch_x_um, system.field.axis_y_px * frame.pitch_y_um),
                 most = 1.0 + (axis_um > 0.0 ? axis_um / system.field_radius_um() : 0.0);
    if (!(std::hypot(x, y) <= most + 1e-9))
      throw mtf::UsageError("--field: " + text + " is " + significant(std::hypot(x, y), 3) +
                            " half diagonals from the optical axis; the detector ends within " + significant(most, 3));
    return {x, y};
  }
  const mtf::FieldPoint<double> q = system.field_point(x, y);
  if (!(x >= 0.0 && x <= frame.columns && y >= 0.0 && y <= frame.rows))
    throw mtf::UsageError("--field: " + text + " is outside the detector of " + std::to_string(frame.columns) + " x " +
                          std::to_string(frame.rows) + " pixels");
  return q;
}

const OtfMap::Place& OtfMap::worst() const {
  return *std::min_element(places.begin(), places.end(),
                           [](const Place& a, const Place& b) { return a.value < b.value; });
}

std::string OtfMap::error_words(double error) const {
  return "to about " + significant(error, 1) +
         (follows_tables ? "" : " by every other of these places, than which positions of tables are closer");
}

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
  double every_other = 0.0, worst = std::numeric_limits<double>::infinity();
  const int along = mtf::image_places_along(system, kMostAlong);
  map.along = static_cast<std::size_t>(along);
  map.follows_tables = mtf::follows_tables(system, along);
  for (const mtf::ImagePlace& from : mtf::image_places(frame.columns, frame.rows, along)) {
    OtfMap::Place& place = map.places.emplace_back();
    place = {.x_px = from.x_px, .y_px = from.y_px, .q = system.field_point(from.x_px, from.y_px)};
    value_at(place);
    map.mean += from.weight * place.value;
    every_other += from.every_other * place.value;
    if (from.every_other > 0.0) worst = std::min(worst, place.value);
  }
  map.mean_error = std::abs(map.mean - every_other);
  map.worst_error = std::max(worst - map.worst().value, map.mean_error);
  map.axis.x_px = 0.5 * frame.columns + system.field.axis_x_px;
  map.axis.y_px = 0.5 * frame.rows + system.field.axis_y_px;
  value_at(map.axis);
  return map;
}

std::string otf_map_table(const OtfMap& map) {
  std::vector<std::string> header{"y \\ x [px]"};
  const std::vector<const OtfMap::Place*> places = shown_places(map);
  constexpr std::size_t kSide = mtf::kImagePlaces;
  for (std::size_t i = 0; i < kSide; ++i) header.push_back(significant(places[i]->x_px, 5));
  const std::vector<Align> align(header.size(), Align::right);
  TextTable table(std::move(header));
  for (std::size_t j = 0; j < kSide; ++j) {
    std::vector<std::string> row{significant(places[j * kSide]->y_px, 5)};
    for (std::size_t i = 0; i < kSide; ++i) row.push_back(fixed(places[j * kSide + i]->value, 4));
    table.add(std::move(row));
  }
  const auto shown = [&](double value) { return mtf::with_unit(significant(value, 4), map.unit); };
  std::string text = map.quantity;
  if (map.unit.empty()) text += ", at " + significant(map.frequency, 6) + " " + map.direction.unit;
  text += ", direction " + significant(map.direction.angle_deg, 4) + " deg\n" + table.aligned(align);
  text += "axis   " + shown(map.axis.value) + "\n";
  text += "mean   " + shown(map.mean) + " over the image, " + map.error_words(map.mean_error) + "\n";
  text += "worst  " + shown(map.worst().value) + " of " + std::to_string(map.places.size()) + " places, at " +
          place_text(map.worst()) + ", " + map.error_words(map.worst_error) + "\n";
  if (!(map.band_error <= mtf::kBandError))
    text += "the average over the band errs by up to " + significant(map.band_error, 2) + "\n";
  return text;
}

std::string otf_map_csv(const OtfMap& map) {
  std::string text = "x_px,y_px,field_x,field_y,value\n";
  for (const OtfMap::Place& place : map.places)
    text += mtf::format_double(place.x_px) + "," + mtf::format_double(place.y_px) + "," +
            mtf::format_double(place.q.x) + "," + mtf::format_double(place.q.y) + "," +
            mtf::format_double(place.value) + "\n";
  return text;
}

Json otf_map_json(const OtfMap& map) {
  Json json{{"quantity", map.quantity}, {"unit", map.direction.unit}, {"angle_deg", map.direction.angle_deg}};
  if (map.unit.empty()) json["frequency"] = map.frequency;
  json["axis"] = place_json(map.axis);
  json["mean"] = map.mean;
  json["mean_error"] = map.mean_error;
  json["worst"] = place_json(map.worst());
  json["follows_tables"] = map.follows_tables;
  json["worst_error"] = map.worst_error;
  json["places"] = Json::array(map.places, place_json);
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
  for (const OtfMap::Place* place : shown_places(map)) {
    series.x.push_back(place->x_px);
    series.y.push_back(place->y_px);
    series.value.push_back(place->value);
    series.words.push_back(significant(place->value, 2));
  }
  const auto [low, high] = std::minmax_element(series.value.begin(), series.value.end());
  figure.colour_range = {*low, *high > *low ? *high : *low + 0.01};
  figure.series.push_back(std::move(series));
  return figure;
}

}  // namespace apps
