// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spectral paths with derivatives: with this included, the functions of this folder take Air<S> and Sight<S> of any
// number with derivatives, such as ceres::Jet<double, N>:
//   Air<Jet> air{.profile = surface_air(pressure, temperature, humidity)};
//   spectral_path(air, Sight<Jet>(Horizontal<Jet>{.altitude_m = 0, .range_m = range}));

#include "radiometry/atmosphere/spectral_impl.h"
