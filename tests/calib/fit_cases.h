// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sensors and edges for the tests of the fit: the measurement that a fit starts from is the truth with small errors.

#include <string>

#include "calib/fit/fit.h"
#include "tests/calib/made_edges.h"
#include "tests/mtf/builders.h"

namespace fit_cases {

inline constexpr double kPitch_um = 4.73;
inline constexpr double kWavelength_um = 0.55;

/// A sensor without components.
mtf::System<double> bare();
/// One Gaussian, sigma in pixels.
mtf::System<double> gaussian(double sigma_px);
/// Diffraction and a square pixel; the f-number is the shared one.
mtf::System<double> camera(double f_number, double pixel_px = 1.0);
/// The sensor of the identifiability table: S = 0.93, pixel 1, then rms_wavefront, jitter and motion along x.
mtf::System<double> table_sensor(double wfe, double jitter_px, double smear_px);

double sigma_of(double mtf50_cy_px);

/// The edge of a scene with a start off the truth by a fraction of a pixel and of a degree.
calib::EdgeData edge_of(const mtf::Image& image, const made::Scene& scene, const std::string& name = "edge");

/// All of the image fitted with one edge.
calib::FitData data_of(mtf::System<double> sensor, calib::EdgeData edge);

calib::FitParameter parameter(const std::string& path, const std::string& name = "");

/// |H| of a sensor along an angle.
double mtf_along(const mtf::System<double>& system, double angle_deg, double f_cy_px);
/// Frequency at which it first falls to one half.
double mtf50_along(const mtf::System<double>& system, double angle_deg);

}  // namespace fit_cases
