// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/otf_map.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "apps/arguments.h"
#include "apps/figures/curve_figure.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/words.h"

namespace apps {
namespace {

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

}  // namespace

const OtfMap::Place& OtfMap::worst() const {
  return *std::min_element(places.begin(), places.end(),
                           [](const Place& a, const Place& b) { return a.value < b.value; });
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

}  // namespace apps
