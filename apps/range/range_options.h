// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf range` takes: the keys of [conditions] that ranges need, as options.

#include <string>
#include <vector>

#include "apps/key_options.h"

namespace apps {

struct RangeOptions {
  std::string sensor;
  std::string target;             ///< name of a standard target; "" = the options alone
  GivenKeys given{};              ///< of [conditions]
  std::vector<double> range_m{};  ///< of the probabilities; empty = steps that show all tasks
  Format format = Format::table;
  std::string plot;  ///< .svg, .pdf or .png
  std::string out;   ///< "" = stdout
};

int run_range(const RangeOptions& options, const Global& global);

}  // namespace apps
