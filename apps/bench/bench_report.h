// SPDX-License-Identifier: Apache-2.0
#pragma once

// The results of `mtf bench`, as a table for people, CSV and JSON for programs, and the chart of error against time.

#include <optional>
#include <string>
#include <vector>

#include "apps/bench/interleave.h"
#include "apps/bench/tolerance_runs.h"
#include "apps/figures/plot.h"

namespace apps {

struct BenchRow {
  double tolerance = 0.0;
  std::string method, detail;
  bool chosen = false;
  std::optional<double> promised, rms_error, max_error, plan_ms, memory_mib, floor_ms, floor_image_ms;
  std::optional<Timing> time;
};

/// Bare FFTW, forward and back, in place or out of place, whichever is faster.
struct Floor {
  std::array<std::int64_t, 2> size{};
  Timing time;
  bool in_place = false;
};

struct BenchReport {
  std::string command, sensor, sensor_name, config_sha256, scene_path, channel;
  const BenchJob* job = nullptr;
  int threads = 0;  ///< that plans used; FFTW and OpenCV: one
  int rounds = 0;
  std::vector<Floor> floors;  ///< the first is that of the image
  std::vector<BenchRow> rows;
  std::vector<std::string> notes;
};

std::string bench_table(const BenchReport& report);
/// The columns of the table, then detail and runs. 17 digits; an empty field where there is no number.
std::string bench_csv(const BenchReport& report);
std::string bench_json(const BenchReport& report);

/// Nothing when no row has an error and a time that a logarithmic chart can show.
std::optional<Figure> bench_figure(const BenchReport& report);

}  // namespace apps
