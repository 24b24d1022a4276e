// SPDX-License-Identifier: Apache-2.0
#pragma once

// The JSON report of `mtf simulate --report` (shape: DESIGN section 7).

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mtf/io/scene.h"
#include "mtf/plan/sensor_plan.h"
#include "mtf/tiles/tiles.h"
#include "radiometry/chain.h"

namespace apps {

/// What was special about a run over many frames.
struct SequenceReport {
  std::int64_t frames = 0, first = 0, last = 0;
  double seconds = 0.0, fps = 0.0;  ///< from the first file to the last
  int plans_compiled = 0;
  int plans_updated = 0;     ///< remade in part for other parameters
  int schedule_changes = 0;  ///< frames at which lines of the schedule came into force
  std::int64_t in_flight = 1;
  std::int64_t frames_with_bad_pixels = 0;
  double predicted_error = 0.0;  ///< of the worst frame
  std::string schedule, schedule_sha256;
  std::vector<std::pair<std::int64_t, radiometry::HeldPixels>> saturated;  ///< frames with pixels that light saturated
};

/// What was special about a run in tiles.
struct TilesReport {
  mtf::TileReport plan;
  mtf::TileTally tally;
  mtf::SampleGrid scene, out;
  std::array<std::int64_t, 2> whole_pixels{};  ///< that the scene holds
};

/// What was special about a run through the chain to electrons and counts.
struct ChainReport {
  std::string stage, quantity, unit;
  std::vector<radiometry::ChainStage> stages;
  std::vector<std::pair<std::string, double>> timing_ms;  ///< of the stages that ran
  radiometry::Clipped well, adc;                          ///< of one image, or the sum over a sequence, as all below
  radiometry::Spilled spilled;
  radiometry::HeldPixels held, held_defects;

  void add(const radiometry::ChainFrame& frame);
};

struct RunReport {
  const mtf::io::SensorConfig* config = nullptr;
  const mtf::io::Scene* scene = nullptr;
  const mtf::SensorPlan* plan = nullptr;
  std::string scene_path, out_path;
  double tolerance = 0.0;
  std::vector<std::pair<std::string, double>> timing_ms;  ///< in order
  std::vector<std::string> warnings;
  std::string bad_pixels;       ///< what happened to NaN and infinite pixels, "" = none
  std::string integer_scaling;  ///< "value = gain x file + offset, …" of PNG and TIFF, else ""
  mtf::io::IntegerScaling scaling;
  std::int64_t clamped = 0;
  std::optional<SequenceReport> sequence;
  std::optional<TilesReport> tiles;
  std::optional<ChainReport> chain;

  /// Quantity and unit of the output.
  std::string quantity() const;
  std::string unit() const;
};

std::string to_json(const RunReport& report);

/// Peak resident memory of this process in MiB.
double peak_rss_mib();

}  // namespace apps
