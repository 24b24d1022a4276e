// SPDX-License-Identifier: Apache-2.0
#pragma once

// What radiometry refuses of a sensor file, at its place in that file: messages that begin with the key they are about
// ("detector.full_well: ...", "[blooming]: ...") get the line of that key.

#include <optional>
#include <string>

#include "mtf/error.h"
#include "mtf/io/config/config.h"

namespace apps {

/// The key of a message, its place and the rest of the text; nothing where it begins with no key of that file.
std::optional<mtf::io::Diagnostic> finding_of(const mtf::io::SensorConfig& config, const std::string& message);

/// "camera.toml:14:1: error: detector.full_well: ..."; the message as it is where it begins with no key of that file.
std::string placed(const mtf::io::SensorConfig& config, const std::string& message);

/// Runs `read`, and says which key asked for it when it fails.
template <class Read>
auto at_key(const std::string& key, const Read& read) {
  try {
    return read();
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(key + ": " + error.what());
  } catch (const mtf::RuntimeError& error) {
    throw mtf::RuntimeError(key + ": " + error.what());
  }
}

/// Runs `action`; its refusals get their place in the file.
template <class Action>
auto at_its_place(const mtf::io::SensorConfig& config, const Action& action) {
  try {
    return action();
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(placed(config, error.what()));
  }
}

}  // namespace apps
