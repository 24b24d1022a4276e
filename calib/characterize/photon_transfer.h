// SPDX-License-Identifier: Apache-2.0
#pragma once

// Photon transfer as one fit: gain, noise and response of a camera from the means and the temporal variances of stacks
// at several levels of light. Light gives e electrons in a pixel, a Poisson number, of which the camera makes counts
//   mean      m = offset + K g(e),                     g(e) = e (1 + a2 u + a3 u^2 + a4 u^3),  u = e / full well
//   variance  V = step^2 Q((g'(e)^2 K^2 e + K^2 r^2) / step^2)
// with K counts per electron, the read noise r, Q of rounding.h (of all noise of a pixel, that of rows, columns and
// frames too, which is then subtracted), and e = rate light (1 + d) + dark time. The error d of the light of a level is
// known to be normal with `light_sd`: from the repeatability of the lamp, from its flicker over the frames. The
// likelihood of independent means (normal) and variances (v dof / V is chi-square)
//   ln L = -1/2 sum (mean - m)^2 / mean_variance - sum dof/2 (v / V + ln V) - 1/2 sum (d / light_sd)^2
// is maximised by Fisher scoring; that mean and variance of a Poisson number are correlated cancels in v - K mean, so
// that they may count as independent. Where pixels have their own noise the scatter of their variances is larger than
// chi-square's: `variance_sd`. Chi-square of the fit tests the model: a lamp that is off by 0.3 %, a nonlinearity of
// 0.1 % that is left out, exchanged frames are each found.
// Against the two lines of EMVA 1288 (release 4, sections 6.4 and 6.6): those are unweighted, take the response for
// straight, and rounding for 1/12. (J. R. Janesick, Photon Transfer, SPIE 2007, ch. 5 and 6; P. Astier et al., Astron.
// Astrophys. 629, A36 (2019) for the likelihood.)

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calib/measure/measure.h"

namespace calib {

/// What one stack says, in counts.
struct TransferLevel {
  double light = 0.0;     ///< photons, or any unit that is proportional to them; 0 in the dark
  double time_s = 0.0;    ///< of the dark current
  double light_sd = 0.0;  ///< relative
  double mean = 0.0, mean_variance = 0.0;
  double variance = 0.0, dof = 1.0;
  double shared = 0.0;          ///< temporal variance of whole rows, columns and frames, which rounding sees too
  double variance_sd = 0.0;     ///< at least that much, besides chi-square's
  bool variance_counts = true;  ///< false where rounding spoils it
};

struct TransferOptions {
  int nonlinearity = 0;       ///< terms: 0, 1 (a2), 2 (a2, a3), 3 (a2, a3, a4)
  double full_well_e = 0.0;   ///< of u; needed with terms
  bool dark_current = false;  ///< the levels tell it: dark stacks of different times
  double step = 1.0;          ///< of the counts; 0: no rounding
};

struct PhotonTransfer {
  TransferOptions options;
  Estimate gain;                   ///< K, counts per electron
  Estimate read2;                  ///< r^2, electrons^2; below 0 where the data say so
  Estimate offset;                 ///< counts
  Estimate rate;                   ///< electrons per unit of light
  std::vector<Estimate> a;         ///< a2, a3, a4
  std::optional<Estimate> dark;    ///< electrons per second
  std::vector<std::string> names;  ///< of the rows of the covariance: gain, read2, offset, rate, a2, a3, a4, dark
  Eigen::MatrixXd covariance;

  struct Level {
    double electrons = 0.0, slope = 1.0;    ///< e, g'(e)
    double mean = 0.0, variance = 0.0;      ///< of the model
    double mean_z = 0.0, variance_z = 0.0;  ///< (measured - model) / standard deviation
    double light_error = 0.0;               ///< d
  };
  std::vector<Level> levels;
  double chi2 = 0.0;
  int dof = 0;
  double p = 1.0;  ///< of a larger chi2 by chance
  int iterations = 0;
  bool converged = false;
};

/// Why so many levels of light do not tell the unknowns of the fit; "" where they do.
std::string too_few_levels(std::size_t levels, int nonlinearity);

/// Throws UsageError where there are fewer levels than the unknowns need, where light or means do not rise, and where
/// the variance does not rise with the mean, as after a camera's own processing.
PhotonTransfer fit_photon_transfer(const std::vector<TransferLevel>& levels, const TransferOptions& options);

/// What the fit gives for that light, whose error is none.
PhotonTransfer::Level level_at(const PhotonTransfer& fit, double light, double time_s);

}  // namespace calib
