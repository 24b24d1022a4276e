// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interface of every engine to a plan: planes in, filtered and sampled planes out. An engine holds one filter; it
// is immutable, and `run` is const and re-entrant.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "mtf/engines/uniform_runs.h"
#include "mtf/image.h"

namespace mtf {

class DeviceImage;
struct KeptPlane;

/// One plane to filter.
struct Channel {
  ImageView<const float> in;
  ImageView<float> out;
  double mean = 0.0;     ///< a float, which is subtracted from the samples before they are filtered
  double scale = 1.0;    ///< a power of two, by which the differences are multiplied
  bool sampled = false;  ///< mean and scale come from a few samples, and the engine checks them against all (is_near)
  double dc = 1.0;       ///< gain of the mean
  double border_value = 0.0;
  const UniformRuns* flat = nullptr;  ///< of `in`; null where they are not known
  double allowance = 0.0;     ///< rms contrast over `out`, relative to the std of `in`, that negligible lines may lose
  KeptPlane* kept = nullptr;  ///< of `in`: takes and gives what does not depend on the filter; null: nothing is kept
  /// Takes filtered samples of row y from column x on in place of `out`, from several threads at once; of the spectral
  /// engine.
  std::function<void(std::int64_t y, std::int64_t x, std::span<const float> samples)> take = {};
  /// Where the engine may leave the image on its device: then `out` is not written. Null: it may not.
  std::unique_ptr<DeviceImage>* stays = nullptr;

  /// What is added to the filtered samples.
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

/// An engine that multiplies a spectrum by an OTF.
class SpectralFilter : public Engine {
 public:
  /// Largest |H| over the frequencies in use.
  virtual double largest_gain() const = 0;
};

}  // namespace mtf
