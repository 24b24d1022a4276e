// SPDX-License-Identifier: Apache-2.0
#pragma once

// A study of the starter sensor (`mtf config init`) for tests of the command.

#include <gtest/gtest.h>

#include <string>

#include "tests/apps/command.h"

namespace study_test {

inline constexpr const char* kSmallStudy = R"toml(schema = 1
name = "pitch against jitter"
sensor = "sensor.toml"
seed = 7
constraints = ["mtf_nyquist > 0.1", "frame.pitch <= 18 um"]
objectives = ["maximize mtf_nyquist", "minimize frame.pitch"]
[[axis]]
parameter = "frame.pitch"
from = "8 um"
to = "20 um"
count = 13
[[axis]]
parameter = "jitter.rms"
from = "0.1 um"
to = "4 um"
count = 9
[metrics]
list = ["mtf_nyquist", "mtf_nyquist_x"]
)toml";

/// The same with what is built about each design, on a sample of `points` designs.
inline std::string sampled_study(int points, int draws) {
  std::string text = kSmallStudy;
  for (const char* count : {"count = 13\n", "count = 9\n"}) text.erase(text.find(count), std::string(count).size());
  return text + "[[as_built]]\nparameter = \"jitter.rms\"\nsd = \"10 %\"\n[sampling]\nmethod = \"sobol\"\npoints = " +
         std::to_string(points) + "\n[yield]\ndraws = " + std::to_string(draws) + "\n";
}

/// sensor.toml and study.toml.
inline void add_study(const apps_test::Scratch& scratch, const std::string& text = kSmallStudy) {
  if (!std::filesystem::exists(scratch / "sensor.toml")) scratch.add_sensor();
  apps_test::write_file(scratch / "study.toml", text);
}

/// The bytes of the tables of a sweep.
inline std::string tables(const apps_test::Scratch& scratch, const std::string& folder) {
  return apps_test::read_file(scratch / (folder + "/designs.csv")) +
         apps_test::read_file(scratch / (folder + "/designs.npy"));
}

}  // namespace study_test
