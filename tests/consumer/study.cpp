// SPDX-License-Identifier: Apache-2.0

// A study file is read through the installed library of trade studies.

#include <fstream>

#include "apps/study/study.h"
#include "mtf/io/config/config.h"

int main() {
  std::ofstream("consumer_base.toml") << mtf::io::starter_config();
  std::ofstream("consumer_study.toml") << R"(schema = 1
name = "pitch"
sensor = "consumer_base.toml"
objectives = ["maximize mtf_nyquist"]
[[axis]]
parameter = "frame.pitch"
from = "10 um"
to = "20 um"
count = 6
)";
  return study::load_study("consumer_study.toml")->designs == 6 ? 0 : 1;
}
