// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "radiometry/chain/sensor_budget.h"
#include "tests/radiometry/chain_cases.h"

namespace radiometry::test {

/// Flat scenes of a sensor with [adc] over its frames, in electrons.
struct FlatScenes {
  double pattern_e = 0.0;   ///< rms over the pixels of a mean of frames, less what of their own noise is left in it
  double temporal_e = 0.0;  ///< rms of a pixel over the frames, over all pixels
};

/// At the last stage of the sensor, 128 x 128 pixels.
inline FlatScenes flat_scenes(const Sensor& sensor, double temperature_k,
                              const mtf::System<double>& system = mwir_system()) {
  constexpr int kFrames = 40;
  const SpectralNumbers<double> spectral = spectral_numbers(sensor, sensor.path, temperature_k);
  const Chain chain = make_chain(system, sensor, 128, 128, 15.0);
  const auto light = static_cast<float>(spectral.radiances.scene + spectral.radiances.path);
  const OutputStage stage = last_output_stage(system, sensor);
  std::vector<double> sum(128 * 128, 0.0), squares(128 * 128, 0.0);
  for (std::uint32_t n = 0; n < kFrames; ++n) {
    const mtf::Image frame = chain.run(flat(128, 128, light), n, stage).image;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double value = static_cast<double>(frame.data()[i]);
      sum[i] += value;
      squares[i] += value * value;
    }
  }
  double mean = 0.0, mean2 = 0.0, temporal = 0.0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const double pixel = sum[i] / kFrames;
    mean += pixel / static_cast<double>(sum.size());
    mean2 += pixel * pixel / static_cast<double>(sum.size());
    temporal += (squares[i] / kFrames - pixel * pixel) / (kFrames - 1) / static_cast<double>(sum.size());
  }
  const double count_e = adc_of(sensor).electrons_per_count;
  return {std::sqrt(mean2 - mean * mean - temporal) * count_e, std::sqrt(temporal * kFrames) * count_e};
}

}  // namespace radiometry::test
