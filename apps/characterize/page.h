// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/characterize/pattern_planes.h"
#include "apps/characterize/stacks_file.h"
#include "apps/figures/plot.h"

namespace apps {

/// What the page of results says beside what was found.
struct PageWords {
  std::string camera;               ///< name of the nominal sensor
  std::string command;              ///< that made it
  std::vector<std::string> left{};  ///< which keys of the sensor file hold nothing measured, as not_measured() says it
  std::string edges{};              ///< what they share with the frames, a sentence; "" without edges
  int bits = 0;
  std::vector<Figure> predicted{};  ///< of the twin of a thermal camera
};

/// One page that needs nothing else: the numbers, and figures in the order of the summary sheet of EMVA 1288 (release
/// 4). The same results make the same bytes.
std::string characterize_page(const calib::Characterization& camera, const std::vector<PatternPlane>& planes,
                              const StacksFile& stacks, const PageWords& words);

}  // namespace apps
