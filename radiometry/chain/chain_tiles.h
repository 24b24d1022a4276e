// SPDX-License-Identifier: Apache-2.0
#pragma once

// The chain (chain.h) for an image whose pixels come in tiles, because all of them do not fit memory. After the
// sampling most stages act on each pixel for itself: light to electrons, defects, shot noise, full well, nonlinearity,
// fixed patterns, read noise and the converter. Their random numbers are those of the pixel's place on the detector, of
// the frame and of the stage (stages/noise/random.h), as are the numbers of noise that whole rows and columns share. So
// a tile has the pixels that the whole image has there. Stages that need more of the image are those that
// whole_image_stages() names.

#include <memory>

#include "radiometry/chain/chain.h"

namespace radiometry {

class TiledChain {
 public:
  /// `tile` is the plan of a tile, presample OTF and sampling, of `system`; `columns` and `rows` are those of the whole
  /// image, which starts at the first pixel of the detector. Throws UsageError as Chain and require_maps(), and for a
  /// stage of whole_image_stages().
  TiledChain(const mtf::SensorPlan& tile, const mtf::System<double>& system, const Sensor& sensor, std::int64_t columns,
             std::int64_t rows, OutputStage stage);

  /// The pixels from `origin` on, of the weighted radiance that the sampling has left; its memory is used. May be
  /// called from several threads at once. Pixels that are held at an end of the range are counted for these pixels
  /// alone. Throws UsageError for pixels beyond the detector.
  ChainFrame run(mtf::Image radiance, Origin origin, std::uint32_t frame, int threads = 1) const;

 private:
  std::shared_ptr<const CompiledChain> compiled_;
  Sensor sensor_;
  OutputStage stage_;
};

/// Throws UsageError for a map of the sensor that does not have the size of its detector, or has a number that is not
/// finite or a factor below 0; it says the pixel. For use before anything that takes long.
void require_maps(const Sensor& sensor, std::int64_t columns, std::int64_t rows);

/// The most memory that TiledChain::run takes for a pixel of a tile, its image included, in bytes.
double tile_bytes_a_pixel(const mtf::System<double>& system, const Sensor& sensor);
/// Memory of the maps of the whole detector that the sensor holds, in bytes.
std::int64_t map_bytes(const Sensor& sensor);

}  // namespace radiometry
