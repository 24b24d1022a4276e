// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fitting the parameters of a sensor to what it measured, by weighted least squares over pixels.
//
// An edge: the pixel at (x, y) is  L_dark + (L_bright - L_dark) E(d) + gradients of both sides + noise, with d its
// distance from the edge (edge_curve.h) and E the step response of the whole system's OTF along the edge's normal
// (step_response.h). Plateaus, gradients and geometry are each edge's own unknowns; the sensor's parameters are shared
// by all data. Residuals are weighted by a Poisson + Gaussian noise model of the image. Curves of other instruments and
// images of point sources join as further residuals, prior knowledge as one residual each.
//
// Parameters whose effect vanishes with their square (rms of a jitter, width of a footprint) are fitted as squares: the
// likelihood is flat at zero in the parameter, not in its square. What the data do not determine is found from the
// singular values of the scaled Jacobian after the edges' own unknowns are projected out, and is reported in words.
// Where another set of values describes the data alike, as a defocus of the other sign, both are given. Every error
// holds for the model: what one more unknown of the sensor would make of the values is computed on request.

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/measure/measure.h"
#include "mtf/system.h"

namespace calib {

/// A number of the sensor that is fitted. Values are in the unit of the System.
struct FitParameter {
  std::string path;  ///< "presample[1].rms", "frame.focal_length", "optics.f_number", "presample[0].zernike[3]"
  std::string name;  ///< what reports call it: "jitter.rms"
  std::string unit;  ///< "" for plain numbers
  std::optional<double> min{}, max{};            ///< bounds in addition to those of the field
  std::optional<std::array<double, 2>> prior{};  ///< mean, sd
};

/// One edge of an image.
struct EdgeData {
  std::string name;  ///< for reports: file and region
  mtf::ImageView<const float> image;
  Roi roi;
  std::size_t condition = 0;  ///< index of the sensor it was taken with
  EdgeMeasurement start;      ///< result of measure_edge: geometry, plateaus, noise
  double quantum = 0.0;       ///< step between neighbouring values of the image (1 for counts); 0 = none
  std::optional<double> saturation{}, floor{};  ///< pixels at or beyond them are clipped and do not count
};

/// An MTF curve of another instrument, along one direction.
struct CurveData {
  std::string name;
  std::size_t condition = 0;
  double angle_deg = 0.0;           ///< direction of the frequency, from +x towards +y, in the plane of its unit
  const mtf::Unit* unit = nullptr;  ///< cy/mm, cy/mrad or cy/px; the fitted focal length and pitch convert them
  std::vector<double> frequency, mtf;
  std::vector<double> sd;  ///< one value for all frequencies, or one for each
};

/// An image of a point source on a flat background.
struct SpotData {
  std::string name;
  mtf::ImageView<const float> image;
  Roi roi;
  std::size_t condition = 0;
  std::optional<double> saturation{}, floor{};  ///< pixels at or beyond them are clipped and do not count
};

struct FitData {
  /// The sensor under each condition (exposure, band, focus ...): the same components and values of the parameters.
  std::vector<mtf::System<double>> conditions;
  std::vector<EdgeData> edges;
  std::vector<CurveData> curves;
  std::vector<SpotData> spots;
};

struct FitOptions {
  bool robust = true;    ///< Huber loss at 3 sd: outliers count less
  int starts = 1;        ///< number of runs from starting values spread over the bounds; the best one counts
  bool profile = false;  ///< computes profile-likelihood intervals of every parameter, also where they are not needed
  bool residual_otf = false;   ///< computes the shrunk OTF of the residuals, an estimate of the systematic error
  bool richer_models = false;  ///< fits also sensors with one more unknown, which the sensor lacks (FitResult)
  int threads = 0;             ///< 0 = all cores
  /// The fit calls it now and then with the share of the work done; returning false stops the fit.
  std::function<bool(double share)> progress{};
};

/// A 95 % interval by profile likelihood, or that of the square of a size that is fitted as its square. The interval of
/// a size may end at its own bound near zero; any other end at which chi-square has not risen enough is missing.
struct ProfiledInterval {
  std::optional<double> low, high;
  std::string reason;  ///< why an end is missing; "" otherwise
};

/// How well the data determine a parameter.
enum class Knowledge {
  determined,      ///< value +- stderr
  at_bound,        ///< a one-sided limit: `limit95`
  prior_only,      ///< the data add nothing to the prior
  not_determined,  ///< part of a direction that the data do not determine, or no minimum was found: no value is given
  interval,        ///< a value whose error is no standard deviation: `interval` holds, about a bound or a centre
  ambiguous        ///< one of several values that describe the data alike; `others` holds the rest
};
std::string_view knowledge_name(Knowledge knowledge);

/// Another value of an ambiguous parameter.
struct OtherValue {
  double value = 0.0;
  std::optional<double> stderr_value{};               ///< one standard deviation about it ...
  std::optional<std::array<double, 2>> interval95{};  ///< ... or where that does not describe it
  double chi2_rise = 0.0;  ///< chi-square there, above that of the best fit, in units of the noise
};

struct FittedParameter {
  FitParameter parameter;
  Knowledge knowledge = Knowledge::not_determined;
  double start = 0.0;
  double value = 0.0;                    ///< best fit; to be shown unless prior_only or not_determined
  std::optional<double> stderr_value{};  ///< one standard deviation, when determined, and of most that are ambiguous
  double linear_sd = 0.0;  ///< from the covariance; where not determined it shows only how little is known
  /// Intervals by profile likelihood, when asked for, or where a flat point is near (flat_points.h); an end may be a
  /// bound up to which chi-square does not rise enough, which `interval` states. For a size that is fitted as its
  /// square and known to a tenth or worse, also without a profile: from the standard deviation of the square.
  std::optional<std::array<double, 2>> interval68{}, interval95{};
  std::optional<ProfiledInterval> interval{};
  /// For a value at a bound: the far end of the 95 % interval that begins there, and whether that end is the upper one.
  /// With a profile it is that end of `interval95`.
  std::optional<double> limit95{};
  bool limit_is_upper = true;
  double pressed_sd = 0.0;           ///< at a bound: how many sd of the data the minimum lies beyond it
  std::vector<OtherValue> others{};  ///< when ambiguous
};

/// Parameters that have other values together at another minimum, which the data do not tell from the best fit.
struct Alternative {
  std::vector<std::size_t> parameters{};  ///< those whose values differ
  std::vector<double> values{};
  double chi2_rise = 0.0;  ///< as of OtherValue
  std::string text{};      ///< in words
};

/// The fit of a sensor that has one more unknown.
struct RicherModel {
  std::string unknown;                      ///< "defocus", "jitter", "motion along x"
  std::vector<FittedParameter> parameters;  ///< those of the fit in their order, then the unknown
  std::optional<Estimate> mtf50;
  double chi2_gain = 0.0;  ///< how much lower chi-square is, in units of the noise
  double p = 1.0;          ///< probability of so large a gain by chance, where the sensor is right without it
};

/// A combination of parameters that the data do not determine.
struct NullDirection {
  std::vector<std::size_t> parameters;  ///< indices, strongest first
  std::vector<double> weight;           ///< components of the direction in their (squared, scaled) values
  std::string text;                     ///< in words, with what would determine it
};

/// Residuals of one set of data.
struct FitResiduals {
  std::string name;
  std::size_t count = 0;
  double chi2_per_dof = 0.0;
  double outlier_share = 0.0;  ///< share of residuals beyond 4 sd
  double whiteness_p = 1.0;    ///< probability of residuals at least as structured along d, were they noise
  EdgeCurve curve;             ///< edges: geometry as fitted
  Estimate contrast;           ///< edges: bright - dark
  bool gradients = false;      ///< edges: the plateaus have gradients, which the data ask for
  mtf::Image residual;         ///< edges and spots: (pixel - model) / sd, NaN where not used; of a large spot region
                               ///< the part around the peak
};

enum class FitStatus {
  converged,
  converged_model_wrong,  ///< converged, but the residuals have structure beyond the noise, or a richer model is better
  not_converged,
  no_data,
  stopped
};
std::string_view status_name(FitStatus status);

struct FitResult {
  FitStatus status = FitStatus::not_converged;
  std::string reason;  ///< one sentence; "" when converged
  std::vector<std::string> warnings;
  std::vector<FittedParameter> parameters;
  std::vector<std::vector<double>> correlation;  ///< of the parameters in their order; NaN where the data
                                                 ///< do not depend on one at all, or one is at a flat bound
  std::vector<NullDirection> not_separable;
  std::vector<Alternative> alternatives;
  std::vector<RicherModel> richer_models;  ///< when asked for, of the unknowns that the sensor lacks
  /// Second moment of the blur along x and y in px^2, what one edge always determines: -H''(0) / (4 pi^2) beyond the
  /// linear term of diffraction (what a lens adds by it is not in here), with its standard deviation, which holds the
  /// numerical error of the extraction.
  std::optional<Estimate> equivalent_variance_px2;
  double chi2_per_dof = 0.0;  ///< NaN, as is the next, where there are no data
  double whiteness_p = 1.0;
  /// The MTF of the fitted system along the first edge's normal (or x), with the error band that the covariance gives,
  /// at the frequencies of measure.h.
  std::vector<double> frequency_cy_px, mtf, mtf_sd;
  std::optional<Estimate> mtf50;
  std::vector<double> residual_otf;  ///< |shrunk OTF of the residuals| at the same frequencies, when asked for
  std::vector<FitResiduals> data;    ///< edges, curves, spots in order
  mtf::System<double> system;        ///< system of the first condition with the fitted values
  int iterations = 0;
  int starts_agreeing = 1;  ///< runs that ended at the same minimum
  /// Values of all parameters at the minima that `alternatives` are of.
  std::vector<std::vector<double>> other_minima{};
};

/// Data never throw: the status says what went wrong. Throws UsageError for parameters that do not exist, two with the
/// same meaning, none at all, bounds that leave no value, numbers that are not finite. The result has the same bits for
/// any number of threads.
FitResult fit(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options = {});

/// The number that a path of the sensor file names, in any scalar type; nullptr when there is none. Lists by index:
/// "presample[0].zernike[3]". A field that falls back to [optics] is given a value of its own by the first call.
template <class S>
S* parameter_at(mtf::System<S>& system, std::string_view path);

/// Sets all numbers that the path stands for: "frame.pitch" is that of both axes. Returns false when there is none.
bool set_parameter(mtf::System<double>& system, std::string_view path, double value);

}  // namespace calib
