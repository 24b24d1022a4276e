// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/options.h"
#include "mtf/io/designs/design_text.h"

namespace apps {

/// `mtf config import`.
struct ImportOptions {
  std::vector<std::string> files;
  std::string kind;  ///< "zernike", "psf" or "mtf"; "" = what the files are
  std::string out;   ///< "" = stdout
  int field = 0;     ///< the one that is wanted, from 1; 0 = all
  bool force = false;
  mtf::io::DesignReading reading;
};

int run_config_import(const ImportOptions& options, const Global& global);

}  // namespace apps
