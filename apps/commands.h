// SPDX-License-Identifier: Apache-2.0
#pragma once

// The subcommands, each with its options bound to a struct of options.h.

#include "apps/command_line.h"

namespace apps {

Command curve_command();
Command devices_command();
Command info_command();
Command config_command();
Command budget_command();
Command atmosphere_command();
Command check_command();
Command demo_command();
Command simulate_command();
Command bench_command();
Command report_command();
Command live_command();
Command scene_command();
Command heat_command();
Command render_command();
Command fly_command();
// Where calib is built.
Command measure_command();
Command fit_command();
Command characterize_command();
// Where apps/study is built.
Command sweep_command();
Command optimize_command();
Command range_command();

/// The command `mtf` with these words: what it is called by comes first. Returns the exit code; never throws.
int run_command(int argc, char** argv);

}  // namespace apps
