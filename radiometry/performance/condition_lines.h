// SPDX-License-Identifier: Apache-2.0
#pragma once

// What figures of observers and ranges hold for, in words: who looks, at what, what is asked of him, through which air.
// They stand beside such figures in every output.

#include <optional>
#include <string>
#include <vector>

#include "radiometry/performance/conditions.h"

namespace radiometry {

/// Which figures an output has.
struct FiguresOfObservers {
  bool bars = false;     ///< MRTD and MDTD
  bool johnson = false;  ///< ranges by Johnson's criteria
  bool ttp = false;      ///< TTP and its ranges
};

/// `viewing`: nothing where figures of TTP have no number for want of it. `air`: "" where the output says it elsewhere.
/// `frame_rate`: of the sensor, where it is one; "" for several. Empty without such figures.
std::vector<std::string> condition_lines(const FiguresOfObservers& figures, const Conditions& conditions,
                                         const std::optional<Viewing<double>>& viewing, const std::string& air,
                                         const std::string& frame_rate);

}  // namespace radiometry
