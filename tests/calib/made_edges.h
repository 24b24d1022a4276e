// SPDX-License-Identifier: Apache-2.0
#pragma once

// Images of edges whose MTF is known, for tests and Monte-Carlo studies.
// A pixel is dark + (bright - dark) E(d) + gradients + noise, d the distance of its centre (i + 0.5, j + 0.5) from the
// edge. E comes from an MTF slice by a quadrature independent of calib's: one rule of many nodes over [0, top], rotated
// from one point of a uniform table to the next; a Gaussian's E is erfc.

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "mtf/image.h"

namespace made {

/// A real OTF slice along the normal, cycles per pixel, and the edge spread function that belongs to it.
class Step {
 public:
  using Mtf = std::function<double(double f_cy_px)>;

  /// `top_cy_px`: H is 0 beyond; E is tabulated for |d| <= range_px.
  Step(Mtf mtf, double top_cy_px, double range_px);
  /// exp(-2 pi^2 sigma^2 f^2), in closed form.
  static Step gaussian(double mtf50_cy_px);
  /// Both in closed form; E is about the edge's location, and `mtf` falls to 0.1 below 4 cycles per pixel.
  static Step closed(std::function<double(double d_px)> esf, Mtf mtf);

  /// The same seen by a sensor that moves along the normal: the mean over the places where it has been, px.
  Step moved(std::vector<double> places_px) const;

  double mtf(double f_cy_px) const { return mtf_(f_cy_px); }
  double at(double d_px) const;
  /// Frequency at which the MTF first falls to `contrast`.
  double crossing(double contrast) const;

 private:
  Step() = default;
  double at_rest(double d_px) const;
  Mtf mtf_;
  std::function<double(double)> esf_;
  double sigma_px_ = 0.0;
  double range_px_ = 0.0;
  double top_cy_px_ = 0.0;
  std::vector<double> value_, slope_;  // at i / kTableSteps, E - 1/2 and the line spread
  std::vector<double> places_px_{0.0};
};

/// A camera: circular pupil, square pixel, four-dot low-pass filter, Gaussian. Lengths in pixels.
struct Camera {
  double s = 0.0;                 ///< wavelength x f-number / pitch; 0 = no diffraction
  double pixel = 1.0;             ///< width of the footprint; 0 = none
  double olpf = 0.0;              ///< half separation of the dots along x and y
  double variance = 0.0;          ///< of a Gaussian, px^2
  double w020 = 0.0, w040 = 0.0;  ///< waves: w020 r^2 + w040 r^4
};
/// Wavelength 0.55 um and pitch 4.73 um, as the public set of edges.
Camera camera_of(double f_number);
/// The OTF of the camera at frequency f along the direction (cos a, sin a).
double camera_otf(const Camera& camera, double angle_rad, double f_cy_px);
Step camera_step(const Camera& camera, double angle_deg, double range_px = 120.0);

/// The image of an edge. The normal (cos angle, sin angle) points to the bright side (x right, y down).
struct Scene {
  std::int64_t width = 128, height = 100;
  double angle_deg = 5.0;
  std::optional<double> x{}, y{};  ///< a point of the edge; the middle of the image when not given
  double sagitta_px = 0.0;         ///< parabola, at half_length_px from its vertex
  double half_length_px = 50.0;
  double dark = 0.2, bright = 0.8;
  double gradient_dark = 0.0, gradient_bright = 0.0;  ///< added to the value of a side, per px away from the edge
  double noise_sd = 0.0;
  double noise_gain = 0.0;  ///< variance = noise_sd^2 + noise_gain x value
  double quantum = 0.0;     ///< values are rounded to multiples
  std::uint64_t seed = 1;
};

/// Distance of a point from the edge, positive on the bright side.
double distance(const Scene& scene, double x, double y);
mtf::Image make(const Step& step, const Scene& scene);

}  // namespace made
