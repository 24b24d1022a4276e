// SPDX-License-Identifier: Apache-2.0
#pragma once

// Zernike coefficients that lens programs list, as the component `wavefront` takes them.
//
// OpticStudio, "Listing of Zernike Standard (or Fringe) Coefficient Data", a field a file:
//   Field : 0.0000, 7.0000 (deg)     Wavelength : 0.5500 µm     Z   4  0.10000000  :  3^(1/2) (2p^2 - 1)
// Standard terms are those of Noll, of unit rms over the full disc; Fringe terms have unit peak. Angles are counted
// from +x towards +y, which points up: of the public listing and wavefront map of one field (batoid, tests/testdata:
// HSC) the difference less piston and tilt has an rms of 0.00858620 waves, which the listing states as its fit error.
// Sign: in public pairs of map and PSF (LSST, HSC) psf = |sum over the pupil of exp(2 pi i [W(p) + a p.x])|^2, a > 0,
// correlates with 0.98 to 0.996, with -W with 0.44 to 0.87. That is the sign of mtf: W(x, y) = W_listed(x, -y), which
// turns the sine terms and nothing else.
//
// A table, a field a row, whose order of terms has to be said; columns of other names are left out:
//   x (deg), y (deg), wavelength (um), Z4 (waves), Z5 (waves), ...
//
// A listing states the rms of its coefficients over the full disc, which is computed anew and compared, and the rms of
// its rays. Where the two differ the pupil is not the full disc. Then W is the sum of the terms within that pupil only.

#include "mtf/components/pupil/wavefront_pupil.h"
#include "mtf/io/designs/design_text.h"

namespace mtf::io {

/// A wavefront as mtf has it: x right, y down, in waves.
struct ZernikeField {
  std::optional<DesignField> place{};  ///< y down
  double wavelength_um = 0.0;
  std::vector<double> waves{};  ///< Z1, Z2, ...; piston and tilt are 0
};

struct ZernikeListing {
  ZernikeNumbering numbering = ZernikeNumbering::noll;
  std::vector<ZernikeField> fields{};
  DesignRemarks remarks{};
};

bool is_zernike_listing(const DesignText& text);

/// Throws UsageError "file:line: ..." for what is missing, not finite, or beyond what `wavefront` holds.
ZernikeListing read_zernike_listing(const DesignText& text, const DesignReading& reading);

/// The sum of terms, waves[i] of Z(i + 1).
PupilPolynomial zernike_sum(ZernikeNumbering numbering, const std::vector<double>& waves);

/// The coefficients of a wavefront: its projections on all terms over the disc.
std::vector<double> zernike_terms(ZernikeNumbering numbering, const PupilPolynomial& wavefront);

/// Root of the mean of W^2 over the full disc.
double disc_rms(const PupilPolynomial& wavefront);

}  // namespace mtf::io
