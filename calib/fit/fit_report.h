// SPDX-License-Identifier: Apache-2.0
#pragma once

// The results of a finished fit: errors, limits, what is not separable, in words, the fitted MTF with its band.

#include "calib/fit/confidence/adequacy.h"
#include "calib/fit/confidence/identifiability.h"
#include "calib/fit/fit_problem.h"

namespace calib {

/// Probability below which residuals, or what a richer model gains, are not taken for noise.
inline constexpr double kWrongModel_p = 1e-4;
/// Structure in the residuals that matters: rms over the region, of the contrast. Below, tables and rounding show.
inline constexpr double kStructureMatters = 1e-5;

/// For messages: of a parameter without a name its path; a number to a tenth.
std::string name_of(const FitParameter& parameter);
std::string rounded(double value);

/// Half of a 95 % interval, in standard deviations.
inline constexpr double k95_sd = 1.959963984540054;

/// The root of the rise of chi-square up to which a value belongs to the interval of +- `z` sd, for a value that lies
/// `from_bound_sd` from the bound of its range. Far from the bound it is z. Near it estimates pile up on the bound, and
/// the z of a range without an end would hold too often: a value at the bound is left out from 1.645 on at 95 %.
/// Interval and limit are one construction, as the data themselves choose between them. (Feldman and Cousins, Phys.
/// Rev. D 57, 3873 (1998).)
double allowed_rise(double z, double from_bound_sd);

/// What the residuals of each set of data tell about the noise and about the model, at the solution.
struct ResidualTests {
  std::size_t count = 0;
  Adequacy adequacy;         ///< of an edge by pixels that do not share their noise
  NoiseCorrelation noise{};  ///< of an edge: what the errors take into account
  /// What the residuals of an edge share that is not its noise: most of them are errors of rounding or of tables.
  NoiseCorrelation left_out{};
  mtf::Image image;  ///< edges and spots: as in FitResiduals
};
std::vector<NoiseCorrelation> noise_of(std::span<const ResidualTests> tests);

/// A function of the shared variables at the solution, with its derivatives by x.
struct Functional {
  double value = 0.0;
  Eigen::VectorXd gradient;
};

/// The information of x, priors included.
struct Information {
  Eigen::MatrixXd matrix{};
  Eigen::MatrixXd independent{};  ///< the same, were the noise of all pixels independent
};

struct Solved {
  const FitProblem* problem = nullptr;
  std::vector<Eigen::MatrixXd> normals{};  ///< C^T C of every block
  std::vector<double> noise_factor{};     ///< chi2 per degree of freedom of every block: its noise variances times this
  std::vector<ResidualTests> tests{};     ///< of the residuals of every block
  std::vector<Eigen::MatrixXd> scores{};  ///< covariance of the scores of every block whose pixels share their noise
  Information information{};
  std::vector<double> reference{};          ///< reference of every x, see identifiability.h
  std::vector<WeakDirection> confounded{};  ///< terms over the field that the places of the data do not tell apart
  Identified identified{};
  /// Variance of every x, in that which independent pixels would leave; 1 where they are.
  std::vector<double> variance_ratio{};
  std::size_t place = 0;              ///< Sensors::place for which MTF and variance are given
  double angle_rad = 0.0;             ///< of the normal along which they are
  std::vector<double> normals_rad{};  ///< directions of all edges
};

/// The factor on noise variances that residuals of this chi-square per degree of freedom stand for. Far below 1 they
/// are those of an image without noise, or of one that rounding has cleaned: then the noise that was given counts.
inline double trusted_noise(double chi2_per_dof) { return chi2_per_dof > 0.7 ? chi2_per_dof : 1.0; }

/// The information of x, from the normal matrices of the blocks, the covariances of their scores where pixels share
/// their noise, and the factors on the noise variances.
Information information_of(const FitProblem& problem, std::span<const Eigen::MatrixXd> normals,
                           std::span<const Eigen::MatrixXd> scores, std::span<const double> noise_factor);

/// Tests of the residuals, information and what it determines, from the problem at its solution.
void judge(Solved& solved, std::span<const FitParameter> parameters);

/// What the information determines, and the ratios of the variances.
void identify(Solved& solved);

double sd_of(const Solved& solved, const Functional& functional);

/// |H| at each frequency along the normal.
std::vector<Functional> mtf_of(const Solved& solved, std::span<const double> f_cy_px);

/// -|H|''(0) / (4 pi^2) in px^2, the linear term of diffraction apart, by a polynomial through `nodes` samples of |H|.
Functional equivalent_variance(const Solved& solved, int nodes = 7);

/// The words of a weak direction that are not its parameters.
struct WeakWords {
  std::string from;  ///< "one edge"
  std::string known = "what they do together is known";
  std::string advice = "give one of them a prior, or fix it";
  std::string single_advice = "fix it, or give it a prior";
};
std::string weak_direction_text(std::span<const std::string> names, const WeakWords& words);

/// A sentence for each weak direction, with what would determine it.
std::vector<NullDirection> null_directions(FitProblem& problem, const Solved& solved,
                                           std::span<const FitParameter> parameters);

/// Parameters with their errors, one-sided limits and what is known of them.
std::vector<FittedParameter> fitted_parameters(const Solved& solved, std::span<const FitParameter> parameters,
                                               std::span<const double> start);

/// Value, error or limit, and what is known of a parameter, from its variable x at the solution. Where that is at its
/// bound or within one sd of it, the 95 % interval begins there: the gradient of chi-square / 2 by x, the other
/// variables at their best, is the first term of the profile g t + t^2 / (2 sd^2), which is at the 95 % point
/// (allowed_rise) at the distance t from the bound.
void set_knowledge(FittedParameter& parameter, const Variable& variable, double x, double sd, bool determined,
                   const std::optional<std::array<double, 2>>& prior, double gradient);

/// Of variables; NaN where nothing depends on one.
std::vector<std::vector<double>> correlations_of(const Eigen::MatrixXd& covariance);

/// The correlation of the parameters' values; NaN where the data do not depend on one at all.
std::vector<std::vector<double>> correlations(const Solved& solved);

/// Residuals of every set of data; `block_of`: its block, or none when it was left out. Sets chi-square, whiteness,
/// warnings, and the status of a model that does not fit. Takes the images of the residuals out of `solved`.
void report_data(const FitData& data, std::span<const std::optional<std::size_t>> block_of, Solved& solved,
                 FitResult& result);

}  // namespace calib
