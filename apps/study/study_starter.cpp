// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "apps/study/study_shape.h"

namespace study {

std::string starter_study() {
  std::string text =
      R"toml(# Pitch and f-number of the camera in sensor.toml, traded against each other. Change the file, then run:
# mtf config check FILE. `mtf config kinds study` has every key, `mtf config kinds metrics` what a design can be asked.
schema = 1
name = "pitch against f-number"
sensor = "sensor.toml"                # beside this file; `mtf config init -o sensor.toml` writes one
constraints = ["mtf_nyquist > 0.05"]  # expressions over metrics and parameters, with units: "ifov < 150 urad"
objectives = ["maximize mtf_nyquist", "minimize ifov"]

# What varies: a parameter by the name that `mtf config explain sensor.toml` has for it.
[[axis]]
parameter = "frame.pitch"
from = "8 um"
to = "20 um"
count = 7

[[axis]]
parameter = "optics.f_number"
values = [1.4, 2.0, 2.8, 4.0]

# What follows from it: here the light-sensitive area stays as large as the pixel.
[links]
"footprint.width" = "frame.pitch"

# Columns beside those of constraints and objectives.
[metrics]
list = ["mtf50", "q"]

# What metrics take from outside of the sensor. Ranges of recognition need contrast, target_size, a magnification, and
# [detector] in the sensor file.
# [conditions]
)toml";
  for (const mtf::FieldInfo& field : condition_fields()) {
    std::string line = "# " + std::string(field.name) + " = " + std::string(field.example);
    line.resize(std::max<std::size_t>(line.size() + 2, 34), ' ');
    text += line + "# " + std::string(field.doc) + "\n";
  }
  return text;
}

}  // namespace study
