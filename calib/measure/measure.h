// SPDX-License-Identifier: Apache-2.0
#pragma once

// The MTF from one edge, without a model of the sensor.
//
// Pixels near the edge sample the edge spread function E at their distances d from it, times the contrast, plus the
// dark value, illumination gradients and noise. E is taken as a reference step (a smooth three-parameter family with
// the 1/d tails of diffraction, fitted to the pixels together with the edge's geometry) plus a correction by penalised
// regression on every pixel, weighted by the noise variance; how much it is smoothed follows from the data. The OTF is
// the transform of the reference, known in closed form, plus that of the correction: no bins, no windows, no
// differences whose response would have to be divided out. Standard deviations are propagated from the noise of the
// pixels through plateaus, geometry, reference and correction. Frequencies are cycles per pixel along the edge's
// normal.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/edge/edge_curve.h"
#include "mtf/image.h"

namespace calib {

/// A number with its standard deviation.
struct Estimate {
  double value = 0.0;
  double sd = 0.0;
};

/// The curves' frequencies: 0, 0.005 .. 1 cycles per pixel.
inline constexpr int kCurveSamples = 201;
inline constexpr double kCurveStep_cy_px = 0.005;

/// The warning that comes with EdgeMeasurement::ends_abruptly.
inline constexpr std::string_view kEndsAbruptly =
    "many pixels have exactly the smallest or exactly the largest value, and few lie next to it: if sides are clipped "
    "the MTF is too high";

struct MeasureOptions {
  std::optional<int> order{};        ///< of the edge curve, 1 to 5; chosen by an F-test when not given
  bool circle = false;               ///< a circle instead of polynomials
  std::optional<double> noise_sd{};  ///< of a pixel, in the image's unit; estimated when not given
  double quantum = 0.0;              ///< step between neighbouring values of the image (1 for counts); 0 = none
  /// The same step at a value, on which it depends in images that were encoded; `quantum` everywhere if empty.
  std::function<double(double value)> quantum_at{};
  std::optional<double> saturation{};  ///< values at or above are clipped
  std::optional<double> floor{};       ///< values at or below are clipped
  bool sparse = false;                 ///< a Bayer plane or masked image: no warning of pixels without data
};

/// Why there is no result, or what to be careful with.
enum class Trouble {
  none,
  no_data,        ///< all pixels masked, or fewer than an edge needs
  no_edge,        ///< contrast below the noise, or no straight gradient
  several_edges,  ///< more than one edge in the region
  too_short,      ///< fewer pixels along the edge than its angle needs
  off_region,     ///< the edge leaves one side of the region without a plateau
  clipped,        ///< a side is saturated or at the floor
  contaminated,   ///< other structure near the edge
};
std::string_view trouble_name(Trouble trouble);

struct EdgeMeasurement {
  Roi roi;
  Trouble trouble = Trouble::none;    ///< none: everything below holds
  std::string reason;                 ///< what is wrong and what to change, one sentence; "" without trouble
  std::vector<std::string> warnings;  ///< what to be careful with, though there is a result

  EdgeCurve curve;
  /// Of the curve across the edge, at its origin. The curve runs where the phase of the OTF, weighted by frequency and
  /// modulus, is least: a displaced edge is displaced by just that. Absent where a method does not know it.
  std::optional<double> location_sd_px;
  Estimate angle_deg;               ///< of the normal, in (-90, 90]
  double length_px = 0.0;           ///< of the edge inside the region
  double sagitta_px = 0.0;          ///< largest distance of the curve from its chord
  double dark = 0.0, bright = 0.0;  ///< values of the plateaus at the edge, in the image's unit
  double noise_sd = 0.0;            ///< of a pixel half way up the edge
  double noise_gain = 0.0;          ///< variance = sd(0)^2 + gain x value, where the sides differ; 0 = the same
  double cnr = 0.0;                 ///< (bright - dark) / noise_sd
  double oversampling = 0.0;        ///< effective: distinct distances a pixel, at most 8 are counted
  double chi2_per_dof = 0.0;        ///< of the pixels about the model
  double clipped_share = 0.0;       ///< of the region's pixels
  bool ends_abruptly = false;       ///< the values end as those of clipped sides do, though no limit is known
  std::int64_t missing = 0;         ///< pixels of the region without data: NaN or infinite

  std::vector<double> frequency_cy_px;   ///< kCurveSamples
  std::vector<double> mtf, mtf_sd;       ///< noise bias removed
  std::vector<double> mtf_noise_sd;      ///< the part of mtf_sd that is noise, not the doubt about the edge's shape
  std::vector<double> otf_re, otf_im;    ///< about the edge's location
  std::vector<double> distance_px;       ///< of the three curves below
  std::vector<double> esf, esf_sd, lsf;  ///< E from 0 to 1; the line spread per px

  // Absent when they cannot be determined (the curve does not fall so far); `absent` then says why, in words.
  std::optional<Estimate> mtf10, mtf20, mtf30, mtf50;  ///< frequency of that contrast, cycles per pixel
  /// Frequency beyond the peak of the MTF at which half of the peak is left: of sharpened images, else as mtf50.
  std::optional<Estimate> mtf50p;
  std::optional<Estimate> nyquist;  ///< MTF at 0.5 cycles per pixel
  /// Both count from where E is 1/2, as those of a system do (mtf/metrics/resolution.h).
  std::optional<Estimate> rer;                  ///< relative edge response: the rise of E from -0.5 to 0.5 px
  std::optional<Estimate> overshoot;            ///< largest E from 1 to 3 px beyond the edge, less 1 (GIQE: H)
  std::optional<Estimate> fwhm_px;              ///< of the line spread function
  std::optional<Estimate> mtfa;                 ///< integral of the MTF from 0 to 0.5 cycles per pixel, x 2
  std::optional<Estimate> sampling_efficiency;  ///< frequency of 10 % contrast / 0.5
  std::vector<std::pair<std::string, std::string>> absent;  ///< name, reason
};

/// Measures the edge in `roi` of a linear image (radiance, counts: proportional to light). NaN pixels are no data:
/// masks and Bayer planes are images with NaN elsewhere. Data never throw: what cannot be measured is an outcome.
/// Throws UsageError for a region that is empty or outside the image and for options out of range.
EdgeMeasurement measure_edge(mtf::ImageView<const float> image, const Roi& roi, const MeasureOptions& options = {});

/// The frequency in cycles per pixel at which the MTF of a measurement first falls to `contrast`, with its standard
/// deviation; nothing where the MTF stays above or was not measured. It follows from the sampled curve: for the
/// contrasts that are members above it agrees with them to a hundredth of their standard deviation
/// (tests/calib/test_contrast.cpp). A curve without standard deviations is taken as straight lines, and the deviation
/// is NaN. Throws UsageError unless the contrast is above 0.
std::optional<Estimate> frequency_at(const EdgeMeasurement& edge, double contrast);

}  // namespace calib
