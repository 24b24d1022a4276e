// SPDX-License-Identifier: Apache-2.0

// The installed headers of radiometry are complete, and its library links by itself.

#include "radiometry/light/band_response.h"
#include "radiometry/light/spectral_signal.h"
#include "radiometry/performance/sensitivity.h"
#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/noise/noise_3d.h"
#include "radiometry/stages/noise/poisson.h"

int main() {
  const radiometry::BandResponse band({3.0, 5.0}, {});
  mtf::Image image(4, 4);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = 100.0F;
  radiometry::shot_noise(image.view(), {1, 0});
  radiometry::digitise(image.view(), radiometry::adc_for_well(1e4, 12));
  return band.radiance(radiometry::Flux::watts, 300.0) > 0.0 && image.at(0, 0) > 0.0F ? 0 : 1;
}
