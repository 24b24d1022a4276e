// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a simulation did, how exactly and how fast; as JSON the report of `mtf simulate --report`.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mtf/io/scene.h"
#include "mtf/plan/sensor_plan.h"
#include "mtf/tiles/tiles.h"
#include "radiometry/chain/chain.h"

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
  std::shared_ptr<const mtf::SensorPlan> first_plan;  ///< RunReport::plan is that of the last frame
};

/// What was special about a run in tiles.
struct TilesReport {
  mtf::TileReport plan;
  mtf::TileTally tally;
  mtf::SampleGrid scene, out;
  std::array<std::int64_t, 2> whole_pixels{};  ///< that the scene holds
  bool for_flat_parts = false;                 ///< in memory all the same, as flat tiles take no time
};

/// What was special about a run through the chain to electrons and counts.
struct ChainReport {
  std::string stage, quantity, unit;
  std::vector<radiometry::ChainStage> stages;
  std::vector<std::pair<std::string, double>> timing_ms;  ///< of the stages that ran; of tiles the sum, though some of
                                                          ///< them ran at the same time
  radiometry::Clipped well, adc;  ///< of one image, or the sum over its tiles or a sequence, as all below
  radiometry::Spilled spilled;
  radiometry::HeldPixels held, held_defects;
  std::shared_ptr<const radiometry::TwoPoint> correction;  ///< of the last one that has it

  void add(const radiometry::ChainFrame& frame);
};

struct RunReport {
  /// Of the whole image, whatever region of it is wanted.
  const mtf::SampleGrid& whole_image() const { return tiles ? tiles->out : plan->out(); }
  /// Width and height of what was handed over.
  std::array<std::int64_t, 2> out_size() const;

  std::string sensor_file, sensor_sha256;             ///< name of the sensor file, hash of its text
  std::string scene_path, out_path;                   ///< "" for an image that was written to no file
  mtf::io::Scene scene;                               ///< as it was read, without its planes
  std::shared_ptr<const mtf::SensorPlan> plan;        ///< of the image, of one tile of it, or of the last frame
  std::optional<std::array<std::int64_t, 4>> region;  ///< x, y, width, height: cut from the whole image of `plan`
  double tolerance = 0.0;
  std::vector<std::pair<std::string, double>> timing_ms;  ///< in order
  std::vector<std::string> warnings;                      ///< reasons to doubt the result
  std::vector<std::string> notes;                         ///< about what was done; not in the JSON
  std::string bad_pixels;                                 ///< what happened to NaN and infinite pixels, "" = none
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
