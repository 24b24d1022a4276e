// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/options.h"
#include "mtf/io/designs/psf_fits.h"

namespace apps {

/// `mtf config import`.
struct ImportOptions {
  std::vector<std::string> files;
  std::string kind;              ///< "zernike", "psf" or "mtf"; "" = what the files are
  std::string out;               ///< "" = stdout
  std::string columns;           ///< of listings of another layout (mtf/io/designs/design_columns.h)
  mtf::io::PsfFitsOptions fits;  ///< but for its y_up, which is that of `reading`
  int field = 0;                 ///< the one that is wanted, from 1; 0 = all
  bool force = false;
  mtf::io::DesignReading reading;
};

int run_config_import(const ImportOptions& options, const Global& global);

}  // namespace apps
