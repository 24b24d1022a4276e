// SPDX-License-Identifier: Apache-2.0
#pragma once

// The numbers of EMVA Standard 1288, Release 4.0 Linear (European Machine Vision Association, 2021), by the standard's
// definitions as its reference implementation computes them (https://github.com/EMVA1288/emva1288, 2ed0b40). In counts
// (DN), with the mean y and the temporal variance s^2 of a stack, y_d and s_d^2 of the dark stack of the same exposure,
// p photons at a pixel:
//   s^2          half the mean squared difference of two frames less half the squared difference of their means; of
//                more frames the mean over pixels of the variance less the variance of the frames' means
//   mu_p.sat     the level of the largest s^2
//   K, R         slopes of s^2 - s_d^2 over y - y_d, of y - y_d over p: unweighted lines through 0 of all levels up to
//                70 % of the signal y - y_d at saturation;   eta = R / K
//   sigma_d      sqrt(sigma_y.dark^2 - 1/12) / K, where sigma_y.dark^2 is the dark variance that a line gives for no
//                exposure, with fewer than three exposures that of the shortest, and 0.24 at least
//   mu_e.min     sigma_y.dark / K + 1/2;   mu_e = eta mu_p;   DR = mu_p.sat / mu_p.min;   SNR_max = sqrt(mu_e.sat)
//   LE           least and largest relative deviation from the line y - y_d = a p + b of least relative squares, of
//                levels from 5 to 95 % of the signal at saturation
//   mu_I         slopes over the exposure of y_d, divided by K, and of s_d^2, divided by K^2
//   DSNU, PRNU   s_dark / K, sqrt(s^2 - s_dark^2) / (y - y_d), with the spatial variance of the mean of L frames of M
//                rows and N columns, s^2 = measured - S/L, of column means s_cav^2 = measured - S/(L M), of row means
//                s_rav^2 = measured - S/(L N), S the variance of a pixel from frame to frame. Its parts solve
//                s^2 = row + column + pixel,   s_cav^2 = column + pixel/M,   s_rav^2 = row + pixel/N
// Photon transfer uses the stacks of two frames where three levels or more have such, as in EMVA's own sets, else all
// stacks with all their frames. Patterns are of the stack nearest to half of saturation among those of more frames, and
// of a dark stack of its exposure.
//
// The standard deviations, which the standard does not state, are those over 1,000 repetitions of the whole computation
// with the statistics of every stack drawn anew: means normal, the light of a level too where its repeatability is
// given or its flicker is found, mean squares chi-square (mean_squares.h). So they hold the choice of saturation, which
// lies anywhere between the middles to the levels beside it. They are known to 2 %. Those of means are of this array,
// those of patterns of the process of which they are a draw. Variances below 0, for which the reference implementation
// has NaN, are not determined.
//
// Biases: the joint fit of the same stacks (characterize.h) has no straight lines and no 1/12. Where it describes the
// frames, with up to three terms of nonlinearity, the definitions above are applied to the means and variances of its
// model; what they give, over what the model has, is the bias of a formula for this camera:
//   K            a response that bends, crosstalk, whose covariances lower every variance; with K all in electrons
//   sigma_d      the floor and the 1/12, which do not hold below about 0.4 counts
//   LE           what the fitted response alone has; noise and the lamp give any camera some
//   DSNU, PRNU   the fixed part without temporal noise of rows, columns and frames, rounding, crosstalk, shading and
//                defects, which are in the standard's variances
// The notes state a bias that is larger than the standard deviation.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/characterize/characterize.h"

namespace calib {

struct EmvaNumber {
  Finding finding;
  std::optional<double> bias{};  ///< relative, of the formula for this camera; nothing where it is not known
  std::string note{};            ///< what to know about it
};

struct Emva1288 {
  std::vector<EmvaNumber> numbers;
  std::string frames, patterns;  ///< what was used for photon transfer and for patterns
  std::string biases;            ///< whence they are, or why there are none
  std::vector<std::string> warnings;

  const EmvaNumber* find(std::string_view name) const;
};

/// `counts_photons`: the light of the stacks is in photons. Throws UsageError as characterize(), and for fewer than
/// three levels with light, for one without a dark stack of its exposure, and without levels below 70 % of saturation.
Emva1288 emva1288(std::vector<Stack> stacks, const CharacterizeOptions& options, bool counts_photons);

}  // namespace calib
