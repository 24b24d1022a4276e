// SPDX-License-Identifier: Apache-2.0
#pragma once

// The lists of checks, one file a family; all_checks() joins them.

#include "apps/check/check.h"

namespace apps::check {

std::vector<Check> special_checks();     ///< sinc, Gaussian, Bessel functions
std::vector<Check> pupil_checks();       ///< diffraction
std::vector<Check> aberration_checks();  ///< defocus, wavefront by coefficients
std::vector<Check> turbulence_checks();  ///< Kolmogorov, both exposures
std::vector<Check> motion_checks();      ///< Fresnel integrals, accelerated motion
std::vector<Check> component_checks();   ///< golden values of each kind
std::vector<Check> radiometry_checks();  ///< blackbodies, where radiometry is built
std::vector<Check> engine_checks();      ///< plans at the extremes of size, scale, contrast and OTF

}  // namespace apps::check
