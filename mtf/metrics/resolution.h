// SPDX-License-Identifier: Apache-2.0
#pragma once

// Figures of merit of a system, from its OTF along the axes of the focal plane. Everything is an integral over the OTF
// or the OTF at a frequency; no image, no grid. With u = f x pitch in cycles per pixel, H the system OTF along the axis
// and P that of the presample list:
//   lsf(x)  = 2 int [Re H cos(2 pi u x) - Im H sin(2 pi u x)] du
//   esf(x)  = 1/2 + int [Re H sin(2 pi u x) + Im H cos(2 pi u x)] / (pi u) du
//   rer     = esf(e + 1/2) - esf(e - 1/2), e the place of esf = 1/2 (0 for a real OTF); Gaussian: erf(1/(sqrt 8 sigma))
//   overshoot   = largest esf(e + x) - 1 for 1 <= x <= 3
//   edge_height = esf at 1.25 px where it rises from 1 to 3 px, else its largest value there (GIQE's H)
//   fwhm    = full width of the lsf at half of its peak
//   mtf50   = first frequency where |H| falls to 1/2
//   mtfa    = 2 int from 0 to 1/2 of |H| du
//   folded_nyquist = 2 sum over m >= 0 of |P(m + 1/2)|: with replicas in phase, before sampling
//   aliasing       = int beyond 1/2 of |P| du / int to 1/2 of |P| du
//   spurious_in    = int over g > 1/2 of |P(g)| |Q(g folded)| dg / int from 0 of |P Q|, Q what follows sampling
//   spurious_out   = int over |f| > 1/2 of sum over k = +-1, +-2 of |P(f - k)| |Q(f)| / int over all f of |P Q|
//   strehl    = int int optics OTF / int int of the same pupil without aberration, at the image of the axis
//   ensquared = int int optics OTF(fx, fy) sinc(fx px) sinc(fy py) px py: light in one pitch about its centre
// (Fiete, Modeling the Imaging Chain of Digital Cameras, SPIE 2010, for RER and H; Leachtenauer et al., Appl. Opt. 36,
// 8322 (1997); Driggers et al., Introduction to Infrared and Electro-Optical Systems, 2nd ed. 2012, for the spurious
// response.)
//
// The OTF is evaluated for its Chebyshev series (otf_series.h), on panels that end at the cutoff and where a pupil has
// kinks, and integrated from them. The series are as long as the tolerance asks for; the error that remains is
// reported, amplified as kernels, slopes and small bases do: absolute for what is at most about 1, relative for
// the others. A template over S, so that studies differentiate through every parameter.

#include <vector>

#include "mtf/otf/otf_series.h"
#include "mtf/system.h"

namespace mtf {

struct AxisNeeds {
  bool edge = false;        ///< rer
  bool unfiltered = false;  ///< rer_unfiltered
  bool overshoot = false;   ///< and edge_height
  bool fwhm = false;
  bool mtf50 = false;
  bool area = false;      ///< mtfa
  bool aliasing = false;  ///< aliasing and spurious_in
  bool spurious = false;  ///< spurious_out
};

struct ResolutionNeeds {
  AxisNeeds axis;
  bool strehl = false;
  bool ensquared = false;
  bool curves = false;                         ///< Resolution::curve_x and curve_y
  bool y = true;                               ///< the y axis, too
  std::vector<SpatialFrequency<double>> at{};  ///< frequencies of mtf_at
  double tolerance = 1e-4;                     ///< 1e-12 to 0.1
};

/// Figures along one axis; NaN for what was not asked for, and where the doc says so.
template <class S>
struct AxisFigures {
  S nyquist{}, optics_nyquist{}, detector_nyquist{},
      presample_nyquist{};  ///< MTF at Nyquist, 1 without such components
  S folded_nyquist{};
  S mtf50_cy_px{};  ///< NaN where the MTF never falls that far, or is below 1/2 next to f = 0 already
  S mtfa{};
  /// Of the edge: NaN where a phase moves it, or a tail goes on, for more pixels than the quadrature follows, some
  /// hundred.
  S rer{}, overshoot{}, edge_height{}, fwhm_px{};
  S rer_unfiltered{};  ///< the same of the image before digital filters ([[postsample]])
  S aliasing{}, spurious_in{};
  S spurious_out{};         ///< NaN where nothing ends what follows sampling (no display)
  std::vector<S> mtf_at{};  ///< of the system, in the order of ResolutionNeeds::at
};

template <class S>
struct Resolution {
  AxisFigures<S> x, y;
  S strehl{}, ensquared{};           ///< NaN without a pupil (diffraction, defocus, wavefront)
  OtfCurve<S> curve_x{}, curve_y{};  ///< of the system, for models that use many frequencies
  double cutoff_cy_mm = 0.0;         ///< from where on the presample OTF is 0; infinite without a pupil
  double error = 0.0;                ///< estimated, of the worst integral
  bool edge_lost = false;            ///< figures of an edge are NaN because it is moved, or goes on, too far
  bool veiled = false;               ///< mtf50 is NaN because contrast is lost at all frequencies, not by blur
  int evaluations = 0;               ///< of OTFs; those of the optics for strehl and ensquared at each wavelength
  int wavelengths = 1;               ///< of the OTF along the axes, at one frequency
};

/// A meter keeps its buffers and the nodes of a band from one system to the next. One a thread.
template <class S>
class ResolutionMeter {
 public:
  explicit ResolutionMeter(ResolutionNeeds needs);
  ~ResolutionMeter();
  ResolutionMeter(ResolutionMeter&&) noexcept;

  /// The system has to be valid (System::check). An OTF that 256 panels do not resolve has the error reached.
  Resolution<S> measure(const System<S>& system);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

extern template class ResolutionMeter<double>;

}  // namespace mtf
