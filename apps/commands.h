// SPDX-License-Identifier: Apache-2.0
#pragma once

// The subcommands, each with its options bound to a struct of options.h.

#include "apps/command_line.h"

namespace apps {

Command curve_command();
Command info_command();
Command config_command();
Command budget_command();
Command atmosphere_command();
Command check_command();
Command demo_command();
Command simulate_command();
Command bench_command();
Command report_command();
// Where cpp-httplib and esbuild are there.
Command live_command();
// Where calib is built.
Command measure_command();
Command fit_command();
// Where apps/study is built.
Command sweep_command();
Command optimize_command();
// Where scenes are built.
Command scene_command();
Command heat_command();
Command render_command();
Command fly_command();

}  // namespace apps
