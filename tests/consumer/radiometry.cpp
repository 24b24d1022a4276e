// SPDX-License-Identifier: Apache-2.0

// The installed headers of radiometry are complete, and its library links by itself.

#include "radiometry/adc.h"
#include "radiometry/band_response.h"
#include "radiometry/fixed_pattern.h"
#include "radiometry/noise_3d.h"
#include "radiometry/poisson.h"
#include "radiometry/sensitivity.h"
#include "radiometry/spectral_signal.h"

int main() {
  const radiometry::BandResponse band({3.0, 5.0}, {});
  mtf::Image image(4, 4);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = 100.0F;
  radiometry::shot_noise(image.view(), {1, 0});
  radiometry::digitise(image.view(), radiometry::adc_for_well(1e4, 12));
  return band.radiance(radiometry::Flux::watts, 300.0) > 0.0 && image.at(0, 0) > 0.0F ? 0 : 1;
}
