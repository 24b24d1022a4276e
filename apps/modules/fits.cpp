// SPDX-License-Identifier: Apache-2.0

// The module of fits and optima.

#include "apps/characterize/characterize_options.h"
#include "apps/modules/modules.h"
#include "mtf/version.h"

namespace apps {

extern "C" const void* mtfkit_fits_table() {
  static constexpr FitsModule table{.build = {mtf::version, mtf::git_commit},
                                    .fit = run_fit,
                                    .optimize = run_optimize,
                                    .characterize = run_characterize};
  return &table;
}

}  // namespace apps
