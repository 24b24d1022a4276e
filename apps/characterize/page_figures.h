// SPDX-License-Identifier: Apache-2.0
#pragma once

// The figures of the page of results, in the order of the summary sheet of EMVA 1288 (release 4).

#include <string>
#include <vector>

#include "apps/characterize/pattern_planes.h"
#include "apps/figures/plot.h"
#include "apps/page/svg.h"

namespace apps {

/// Variance against mean with the fit, and the residuals of both in standard deviations.
std::vector<Figure> transfer_figures(const calib::Characterization& camera);
/// Mean against light with the fit, and what is left of a line, with the band of the noise. `light`: label of the axis.
std::vector<Figure> response_figures(const calib::Characterization& camera, const std::string& light);
/// Counts over the radiance of blackbodies, and what is left of the line where it has more than two.
std::vector<Figure> sitf_figures(const calib::Characterization& camera, const std::string& light);
Figure snr_figure(const calib::Characterization& camera, const std::string& light, bool is_photons);
/// Root of the averaged power spectra of rows and columns.
Figure spectrum_figure(const PatternPlane& plane);
/// Mean, least and most of columns, then of rows, in counts.
std::vector<Figure> profile_figures(const calib::Stack& stack, const std::string& name);
/// Deviations of pixels from their row and column: histogram, and how many are larger, with the normal curve.
std::vector<Figure> histogram_figures(const PatternPlane& plane);
/// The seven components of three-dimensional noise of a stack in electrons; of blackbodies those that were found, in
/// mK.
std::string component_bars(const calib::Characterization& camera, const calib::Stack& stack);
/// Roots of the power in time of pixels, by octaves (calib/characterize/spectra.h), and of the means of frames, with
/// what white noise of the variances of the stack has; how many pixels have which noise, and would have, were they
/// alike.
std::vector<Figure> time_figures(const calib::Stack& stack, const NoiseUnit& unit);
/// Where defects are, at most so many of each plane: those of the largest excess.
inline constexpr std::size_t kDefectsDrawn = 2000;
Figure defect_figure(const std::vector<PatternPlane>& planes);

}  // namespace apps
