// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the emissivity of a smooth surface changes with the angle to its normal: a factor g on that along the normal, the
// same at all wavelengths,
//   eps(lambda, theta) = eps(lambda, 0) g(cos theta).
// Schlick (Computer Graphics Forum 13, 1994) has reflectance R0 + (1 - R0) (1 - cos theta)^p, p = 5, which is
//   g = 1 - (1 - cos theta)^p;
// a dielectric of refractive index n has Fresnel's reflectance of unpolarised light R, and g = (1 - R) / (1 - R(0)).
// The mean over the hemisphere, 2 integral of g cos theta dcos theta, is what a surface gives off to all sides: with
// Schlick's law 1 - 2 / ((p + 1) (p + 2)).

#include <span>
#include <vector>

namespace radiometry {

/// Values at equally spaced cosines from 0 to 1, straight lines between them; empty: 1 at all angles.
struct AngularEmissivity {
  std::vector<float> relative{};
  bool empty() const { return relative.empty(); }
};

/// Throw mtf::UsageError for exponents outside 1 ... 100, indices outside 1 ... 10 (1 itself reflects nothing), and
/// tables that do not rise from 0 to at most 90 degrees or have values outside 0 ... 100; a table is held beyond its
/// last angle, and begins with 1.
AngularEmissivity schlick(double exponent);
AngularEmissivity dielectric(double index);
AngularEmissivity angle_table(std::span<const double> angle_deg, std::span<const double> relative);

double relative_emissivity(const AngularEmissivity& curve, double cosine);
double hemispherical_mean(const AngularEmissivity& curve);
double largest(const AngularEmissivity& curve);

}  // namespace radiometry
