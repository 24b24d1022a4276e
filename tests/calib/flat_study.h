// SPDX-License-Identifier: Apache-2.0
#pragma once

// Monte-Carlo study of fits in which the effect of a parameter vanishes at a bound, or at a centre about which it is
// mirrored: how often the statements of it and of its partners hold the truth. Images come from the sensor's own OTF by
// the quadrature of made_edges.h, those of a motion as means over the places. The statement of a parameter is its 95 %
// interval, else value +- 1.96 standard errors, else its limit; of an ambiguous one that of each of its values.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calib/fit/fit.h"

namespace flat_study {

/// A number of the sensor: its true value and where the fit starts.
struct Truth {
  std::string path;
  double value = 0.0, start = 0.0;
  std::optional<double> min{}, max{};  ///< bounds given by the user
};

/// A camera with diffraction, and one edge.
struct Case {
  std::string name;
  mtf::System<double> sensor;
  std::vector<Truth> fitted;
  double angle_deg = 5.0;
  double cnr = 60.0;
  mtf::System<double> at_rest{};    ///< where there are places: the sensor but for the motion
  std::vector<double> places_px{};  ///< along the normal, where the image has been
};

/// Visible light, f/8, pitch 4.73 um: a jitter of 2.5 um and a diffusion of charge (absorption in 10 um, a depletion
/// layer of 3 um) of which the length is given.
Case diffusion(double diffusion_um);
/// The f-number and a jitter.
Case lens_and_jitter(double rms_um);
/// A defocus of so many waves at the pupil's edge, and the f-number.
Case lens_out_of_focus(double waves);
/// A jitter of 2.5 um beside a second footprint of that width, whose effect differs from that of the jitter in fourth
/// order only.
Case two_footprints(double width_um);

/// An image that moves along x at 200 um/s for 10 ms, with this acceleration, the only unknown.
Case accelerated(double um_s2);
/// A defocus as the only unknown.
Case out_of_focus(double waves);
/// The same beside a spherical aberration of 0.3 waves that is known: mirrored about another centre, nearly.
Case out_of_focus_aberrated(double waves);
/// Defocus and spherical aberration, both unknown: mirrored together.
Case two_aberrations(double w020, double w040);

struct Held {
  int inside = 0;      ///< the statement holds the truth
  int zero = 0;        ///< it holds 0
  int determined = 0;  ///< it is one value with a standard error
  int silent = 0;      ///< nothing is stated
  int unbounded = 0;   ///< an interval without an end on one side
  double width = 0.0;  ///< mean; of an open interval up to the bound
};
struct Outcome {
  int draws = 0, failed = 0;
  int at_bound = 0;              ///< draws in which some parameter ended at its bound
  std::vector<Held> parameters;  ///< in the order of Case::fitted
  int inside_mtf50 = 0;
  double ms = 0.0;                        ///< median processor time of a fit
  std::vector<calib::FitResult> results;  ///< of every draw
};
Outcome run(const Case& one, int draws, std::uint64_t seed, const calib::FitOptions& options = {});

}  // namespace flat_study
