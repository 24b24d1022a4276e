// SPDX-License-Identifier: Apache-2.0
#pragma once

// Point spreads in FITS, as the component `psf` takes them: rows down, odd in number, the middle sample the origin.
//   STPSF, WebbPSF   the unit OVERDIST, else DET_DIST, else the first; step PIXELSCL (arcsec). A cube is one of
//                    wavelengths (WAVELN00, or WVLN0000 of a hundred and more, in m), or of places, DET_YX0 = '(y, x)'
//                    ..., pixels counted from 0; of these the effective PSFs, which have the pixel in them as units
//                    DET_ do, have OVERSAMP samples a pixel, else DET_SAMP.
//   PSFEx            PSF_DATA: psf(X, Y) = sum of plane k x^i y^j, x = (X - POLZERO1) / POLSCAL1, y likewise, of j = 0
//   ...
//                    d and i = 0 ... d - j in this order, d = POLDEG1; step PSF_SAMP pixels, X and Y count pixels
//                    from 1. The pixel is in it.
// Images with an even number of samples have their centre between the middle ones: a row and a column of zeros make
// them odd, and the origin is half a step from the centre, which is said. PSFEx has it on the sample behind the middle,
// from the lower left, which becomes the origin.

#include <array>

#include "mtf/image.h"
#include "mtf/io/designs/design_text.h"

namespace mtf::io {

struct PsfPlane {
  std::optional<DesignField> place{};  ///< in px from the upper left corner of the detector; without one
  std::string label{};                 ///< "1.2 um"
  Image samples{};
};

struct PsfFits {
  std::string step{};  ///< "0.5 px"
  std::vector<PsfPlane> planes{};
  DesignRemarks remarks{};
};

bool is_fits(const std::string& path);

struct PsfFitsOptions {
  /// Columns and rows: places need it, but for listed ones with y down. PSFEx is evaluated from corner to corner.
  std::optional<std::array<int, 2>> detector{};
  bool y_up = true;
  std::string step{};  ///< in place of what the file says; "" = none
};

/// Throws UsageError that names the keyword or the option, RuntimeError for files that cannot be read.
PsfFits read_psf_fits(const std::string& path, const PsfFitsOptions& options);

}  // namespace mtf::io
