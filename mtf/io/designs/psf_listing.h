// SPDX-License-Identifier: Apache-2.0
#pragma once

// Grids of a PSF that OpticStudio lists, as the component `psf` takes them: rows from the top of the image down, which
// is y down as it stands, odd in number, the middle sample at the chief ray, where the phase of the OTF is counted
// from.
//   Listing of FFT PSF Data                    Listing of Huygens PSF Data
//   Data spacing is 0.288 µm.                  Data spacing is 0.250 µm.
//   Data area is 18.455 µm wide.               Data area is 16.000 by 16.000 µm.
//   Image grid size: 64 by 64                  Image grid size: 64 by 64
//   Center point is: row 33, column 32         Center point is: 33, 33
// The grid is even and its centre no middle: it is made odd by a row and a column of zeros, which changes no sum. The
// centre of an FFT listing is counted from the top, that of a Huygens listing is column, row counted from the bottom:
// so the public pairs of both (batoid, tests/testdata) are symmetric on axis, and only so the centroid offsets that
// Huygens listings state come out, to 0.01 um. A stated offset is compared here too. The spacing has three decimals;
// the area over the number of samples has more.

#include "mtf/io/designs/design_text.h"

namespace mtf::io {

struct PsfListing {
  std::optional<DesignField> place{};  ///< y down
  double step_um = 0.0;
  std::vector<std::vector<double>> samples{};  ///< odd by odd
  DesignRemarks remarks{};
};

bool is_psf_listing(const DesignText& text);

/// Throws UsageError "file:line: ..." for what is missing, not finite, or not as large as the listing says.
PsfListing read_psf_listing(const DesignText& text, const DesignReading& reading);

}  // namespace mtf::io
