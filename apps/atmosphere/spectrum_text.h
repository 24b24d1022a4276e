// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spectra of the air as files: CSV of `mtf atmosphere`, the table over ranges that path.table reads, and
// columns as in MODTRAN's tape7 (mtf/io/csv/tape7.h says which), for programs that read those.

#include <string>

#include "radiometry/atmosphere/spectral_path.h"
#include "radiometry/light/path.h"

namespace apps {

/// wavenumber_cm-1,wavelength_um,transmittance,path_radiance_W_m-2_sr-1_per_cm-1, then one column a component. Without
/// emission (above 3500 cm^-1) the radiance is an empty field.
std::string spectrum_csv(const radiometry::atmosphere::SpectralPath<double>& path);

/// range_m,wavelength_um,transmission,radiance_w_m2_sr_um
std::string path_table_csv(const radiometry::PathTable& table, const std::string& what);

/// One run with FREQ, TOT TRANS and PTH THRML; SOL SCAT is blank. Throws UsageError where the model has no emission.
std::string tape7_text(const radiometry::atmosphere::SpectralPath<double>& path, const std::string& what);

}  // namespace apps
