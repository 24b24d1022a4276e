// SPDX-License-Identifier: Apache-2.0
#pragma once

// The mean over a band of OTFs that cost microseconds a sample, at many frequencies of one direction.
//   mean(t) = integral over the band of w(lambda) P(t, lambda) dlambda
// t = |f|, w the electron rate, P the product of the chromatic components. An aberrated pupil has its cutoff and its
// kinks where t lambda is a constant: at fixed t they are inside the band, over u = t lambda / hi they are at the same
// place for all wavelengths, and at one u what still changes with the wavelength (waves of aberration, r0) is smooth
// in 1 / lambda. So P becomes a table over u and 1 / lambda: Chebyshev points, in u on panels between the kinks, in the
// angle that takes away the half-integer powers at their ends (as mtf/otf/otf_tables.h). A few hundred samples of P
// serve all frequencies. The integral itself is taken between the wavelengths that have a kink at t (mtf/band.h), the
// number of nodes doubled until the mean converges.

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "mtf/band.h"
#include "mtf/math/barycentric.h"

namespace mtf {

class BandMean {
 public:
  /// values[width i + k]: number k at t[i], one wavelength. The first two are real and imaginary part of P, the others
  /// their derivatives or whatever else is averaged with them.
  using Function = std::function<void(double wavelength_um, std::span<const double> t, std::span<double> values)>;

  struct Options {
    std::size_t exact = 2;     ///< the first so many of the numbers are known to `error` (absolute),
    double error = 1e-7;       ///< the others to 1e-5 of their largest value
    std::size_t panels = 256;  ///< largest number of panels; a P that needs more is known less well
  };

  /// `breaks`: values of u between which P is smooth, in rising order; P is 0 beyond the last one when `ends` is set. A
  /// few frequencies are cheaper without the table: `most_t` <= 0 makes none, otherwise it covers all frequencies up
  /// to most_t.
  BandMean(Function p, std::size_t width, const Band& band, std::vector<double> breaks, bool ends, double most_t)
      : BandMean(std::move(p), width, band, std::move(breaks), ends, most_t, Options()) {}
  BandMean(Function p, std::size_t width, const Band& band, std::vector<double> breaks, bool ends, double most_t,
           const Options& options);

  /// The mean at t >= 0.
  void at(double t, std::span<double> mean) const;

 private:
  /// Chebyshev points of an angle between two kinks: u = begin + (end - begin) (1 - cos angle) / 2.
  struct Panel {
    double u_begin = 0.0, u_end = 0.0;          ///< ends of its piece, which lies between two kinks
    double angle_begin = 0.0, angle_end = 0.0;  ///< ends of the panel, within [0, pi]
    double from_u = 0.0;                        ///< u at which the panel begins
    std::vector<double> values;                 ///< [point][wavelength][number]
  };
  void tabulate(double most_u);
  Panel sampled(double u_begin, double u_end, double angle_begin, double angle_end) const;
  std::vector<double> choose_wavelengths(double most_u);
  bool resolved(const Panel& panel, std::span<const double> allowed) const;
  double wavelength_at(std::size_t l) const;
  void look_up(double u, double wavelength_um, double weight, std::span<double> sum) const;
  void add_rule(double t, const WavelengthNodes& rule, std::span<double> sum) const;

  Function p_;
  std::size_t width_ = 0;
  Options options_;
  Band band_;
  /// Rules of 8, 16, 32 ... nodes for the whole band, which most t share; used with a table.
  std::vector<WavelengthNodes> whole_;
  std::vector<double> breaks_;
  bool ends_ = false;
  std::size_t wavelengths_ = 0;  ///< number in the table; 0 = there is no table
  Barycentric across_panel_, across_band_;
  std::vector<Panel> panels_;  ///< in rising order
};

}  // namespace mtf
