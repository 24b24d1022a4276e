// SPDX-License-Identifier: Apache-2.0

// Programs that must not compile, each by its name, and the same program that does without one (tests/CMakeLists.txt).

#include "mtf/components/jitter.h"
#include "mtf/components/lowpass.h"
#include "mtf/components/vibration.h"
#include "mtf/from_quantities.h"
#include "mtf/literals.h"
#include "mtf/system.h"

using namespace mtf;
using namespace mtf::literals;

void accepted() {
  System<double> system;
  system.frame = make_frame({.focal_length = 100_mm, .pitch = 15_um});
  system.add(Stage::presample, Jitter<double>{.rms = 20_urad});
  system.add(Stage::presample, Vibration<double>{.amplitude = 2_px, .direction_deg = 45_deg});
  system.add(Stage::presample, RcLowpass<double>{{.cutoff = 40_cy_mm}});
#if defined(NUMBER_AS_LENGTH)
  make_frame({.focal_length = 100.0, .pitch = 15_um});
#elif defined(ANGLE_AS_LENGTH)
  make_frame({.focal_length = 100_mm, .pitch = 15_urad});
#elif defined(LENGTH_LEFT_OUT)
  make_frame({.focal_length = 100_mm});
#elif defined(NUMBER_AS_EXTENT)
  system.add(Stage::presample, Jitter<double>{.rms = 20.0});
#elif defined(NUMBER_IN_BRACES_AS_EXTENT)
  system.add(Stage::presample, Jitter<double>{.rms = {20.0}});
#elif defined(DURATION_AS_EXTENT)
  system.add(Stage::presample, Jitter<double>{.rms = 20_ms});
#elif defined(NUMBER_AS_ANGLE)
  system.add(Stage::presample, Vibration<double>{.amplitude = 2_px, .direction_deg = 45.0});
#elif defined(LENGTH_AS_ANGLE)
  system.add(Stage::presample, Vibration<double>{.amplitude = 2_px, .direction_deg = 45_um});
#elif defined(NUMBER_AS_FREQUENCY)
  system.add(Stage::presample, RcLowpass<double>{{.cutoff = 40.0}});
#elif defined(LENGTH_AS_FREQUENCY)
  system.add(Stage::presample, RcLowpass<double>{{.cutoff = 40_um}});
#elif defined(LENGTH_AGAINST_ANGLE)
  static_cast<void>(15_um == 15_urad);
#elif defined(QUOTIENT_OF_FREQUENCIES)
  static_cast<void>(15_cy_mm / 1_cy_px);
#elif defined(COMPONENT_OF_ANOTHER_SCALAR)
  system.add(Stage::presample, Jitter<float>{.rms = 20_urad});
#endif
}
