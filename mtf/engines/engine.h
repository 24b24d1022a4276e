// SPDX-License-Identifier: Apache-2.0
#pragma once

// What every way of doing the work looks like to a plan: planes in, filtered and sampled planes out. Engines hold one
// filter; they are immutable, and `run` is const and re-entrant.

#include <cstdint>
#include <vector>

#include "mtf/image.h"
#include "mtf/survey/uniform_runs.h"

namespace mtf {

/// One plane to filter.
struct Channel {
  ImageView<const float> in;
  ImageView<float> out;
  double mean = 0.0;     ///< a float, taken off before
  double scale = 1.0;    ///< and this applied (a power of two)
  bool sampled = false;  ///< both are of a few samples only: an engine that is told so checks them by all
  double dc = 1.0;       ///< gain of the mean
  double border_value = 0.0;
  const UniformRuns* flat = nullptr;  ///< of `in`; null: nothing is known
  double allowance = 0.0;  ///< rms contrast over `out`, relative to the std of `in`, that may be left out of lines

  /// Added back at the end.
  double out_mean() const { return dc * mean; }
};

class Engine {
 public:
  Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  virtual ~Engine() = default;

  /// Filters all channels. The result does not depend on `threads` (0 = all cores).
  virtual void run(const std::vector<Channel>& channels, int threads) const = 0;
  /// Bytes that one run of `channels` planes allocates.
  virtual std::int64_t run_bytes(std::int64_t channels, int threads) const = 0;
  /// Bytes that the filter itself holds.
  virtual std::int64_t filter_bytes() const = 0;
};

}  // namespace mtf
