// SPDX-License-Identifier: Apache-2.0

// The module of the live view.

#include "apps/modules/modules.h"
#include "mtf/version.h"

namespace apps {

extern "C" const void* mtfkit_live_table() {
  static constexpr LiveModule table{.build = {mtf::version, mtf::git_commit}, .live = run_live};
  return &table;
}

}  // namespace apps
