// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/options.h"
#include "apps/sensor/sensor_chain.h"
#include "mtf/io/config/config.h"

namespace apps {

/// Reads a sensor file for a subcommand; its warnings and notes go to standard error. Throws as load_config.
mtf::io::SensorConfig read_sensor(const std::string& file, const Global& global);

/// The same with the electron rate of its band, for commands that use the OTF alone. Throws as load_chain too.
mtf::io::SensorConfig load_sensor(const std::string& file, const Global& global);

/// What `mtf config check` found in a sensor or study file.
struct Verdict {
  std::string file;
  bool ok = false;
  std::string name{}, sha256{};
  std::string summary{};  ///< of a good one
  std::vector<mtf::io::Diagnostic> diagnostics{};
};

/// Of the text of a sensor file, without reading `file`.
Verdict sensor_verdict(const std::string& text, const std::string& file);

/// The stages of the chain in their order, and those that are off with the table that would switch them on; "" without
/// [detector]. Throws as load_chain.
std::string explain_chain(const mtf::io::SensorConfig& config);

/// True for a file whose keys are those of a study; false also for a file that is no TOML. Throws RuntimeError when the
/// file cannot be read.
bool is_study_file(const std::string& file);

/// `mtf config check` of a sensor or a study, according to the keys of the file: the verdict and notes on standard
/// output, errors on standard error. Returns the exit code, 0 or 2.
int check_config(const std::string& file, Format format);

}  // namespace apps
