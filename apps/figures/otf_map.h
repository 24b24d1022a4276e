// SPDX-License-Identifier: Apache-2.0
#pragma once

// A figure of the OTF of the whole system over the image (mtf/field/image_places.h), and on the optical axis.
//
//   const apps::OtfMap map = apps::otf_map(sensor.system, "mtf@nyquist", apps::make_direction(frame, "cy/px", 0.0));
//   map.worst().value;

#include <string>
#include <vector>

#include "apps/figures/plot.h"
#include "apps/sensor/otf_curves.h"
#include "apps/text/json.h"
#include "mtf/field/image_places.h"

namespace apps {

/// The field point that --field names: "0.7,-0.7", or the pixel "320px,40px". Throws UsageError for what is neither,
/// and for a pixel outside the detector, or a place beyond its farthest corner.
mtf::FieldPoint<double> field_point_of(const mtf::System<double>& system, const std::string& text);

struct OtfMap {
  struct Place {
    double x_px = 0.0, y_px = 0.0;  ///< from the upper left corner of the detector
    mtf::FieldPoint<double> q;
    double value = 0.0;
  };
  std::string quantity, unit;  ///< "mtf@nyquist"; of the values: "" for an MTF
  Direction direction;
  double frequency = 0.0;                 ///< of an MTF
  double band_error = 0.0;                ///< that the average over the band has at most
  std::size_t along = mtf::kImagePlaces;  ///< places of a row, and rows
  bool follows_tables = true;             ///< the places are no farther apart than positions of tables
  std::vector<Place> places;              ///< row by row
  Place axis;
  double mean = 0.0, mean_error = 0.0;  ///< over the image, and its change from every other place to all
  double worst_error = 0.0;             ///< that of the worst, or of the mean where that is more

  const Place& worst() const;  ///< the lowest
  std::string error_words(double error) const;
};

/// `quantity`: mtf@nyquist, mtf@FREQ with FREQ in the unit of the direction, or mtf50. Throws UsageError for another
/// one, a system without the format of its detector, numbers that are not valid somewhere in the image, and an MTF50
/// that is not there.
OtfMap otf_map(const mtf::System<double>& system, const std::string& quantity, const Direction& direction);

std::string otf_map_table(const OtfMap& map);
std::string otf_map_csv(const OtfMap& map);
Json otf_map_json(const OtfMap& map);
Figure otf_map_figure(const OtfMap& map);

}  // namespace apps
