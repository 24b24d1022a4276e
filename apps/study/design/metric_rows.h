// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rows of the catalogue of metric_list.h, for the code that computes the metrics.

#include <optional>
#include <span>
#include <string_view>

#include "mtf/frame.h"

namespace study {

enum class Metric {
  cutoff,
  nyquist,
  q,
  ifov,
  gsd,
  fov,
  optics_mtf_nyquist,
  detector_mtf_nyquist,
  presample_mtf_nyquist,
  mtf_nyquist,
  folded_mtf_nyquist,
  mtf_at,
  mtf50,
  mtfa,
  rer,
  edge_overshoot,
  edge_height,
  fwhm,
  aliasing_ratio,
  spurious_in_band,
  spurious_out_of_band,
  spurious_response,
  strehl,
  ensquared_energy,
  signal,
  background,
  well_fill,
  scene_shot_noise,
  background_shot_noise,
  dark_shot_noise,
  read_noise,
  reset_noise,
  other_noise,
  quantisation_noise,
  temporal_noise,
  prnu_noise,
  dsnu_noise,
  correction_noise,
  spatial_noise,
  snr,
  netd,
  shot_netd,
  spatial_netd,
  nei,
  nep,
  dynamic_range,
  target_snr,
  niirs_giqe3,
  niirs_giqe4,
  niirs_giqe5,
  grd,
  mrtd,
  mdtd,
  johnson_detect,
  johnson_recognise,
  johnson_identify,
  ttp,
  ttp_detect,
  ttp_recognise,
  ttp_identify
};

/// The quantities that have to be computed for a metric.
enum class Effort {
  geometry,
  points,
  edge,
  overshoot,
  fwhm,
  mtf50,
  area,
  aliasing,
  spurious,
  light,
  budget,
  giqe,
  grd,
  bars,  ///< of an observer of bars or squares, behind the sensor's own air
  air    ///< of an observer of a target, at any range
};

struct MetricRow {
  Metric metric;
  std::string_view name;
  bool directional;  ///< also NAME_x and NAME_y; NAME is their geometric mean
  std::string_view unit, definition, source, needs;
  Effort effort;
  bool less_is_better = false;
};

std::span<const MetricRow> metric_rows();
const MetricRow& row_of(Metric metric);

/// Where in the image a metric of the OTF is taken: on the optical axis, or at the places of mtf/field/image_places.h.
enum class Over { axis, mean, worst };

/// A metric as asked for: which, along which axis (none: the geometric mean), for mtf_at the frequency, and where in
/// the image.
struct MetricChoice {
  const MetricRow* row = nullptr;
  std::optional<mtf::Axis> axis{};
  mtf::SpatialFrequency<double> at{};
  Over over = Over::axis;
};

/// Null for a name that no metric has.
std::optional<MetricChoice> choose_metric(std::string_view name);

}  // namespace study
