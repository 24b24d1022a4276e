// SPDX-License-Identifier: Apache-2.0
#pragma once

// Changing values in the tree of a sensor file before it is read: what schedules and trade studies do, so that units,
// bounds and defaults are those of the file. Parameters are called as messages and `mtf config explain` call them, the
// label of a component before its field: "jitter.rms", "presample[1].rms", "wavefront.zernike[3]".

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "mtf/io/config/config_tree.h"

namespace mtf::io::cfg {

/// Position of a parameter in the tree of a sensor file.
struct Target {
  std::string table;      ///< "frame", "optics", or the list of a component
  std::size_t index = 0;  ///< in that list
  bool component = false;
  std::string key{};
  std::optional<std::size_t> element{};  ///< of a list

  /// As diagnostics call it: "presample[1].rms".
  std::string path() const {
    return table + (component ? "[" + std::to_string(index) + "]" : "") + "." + key +
           (element ? "[" + std::to_string(*element) + "]" : "");
  }
};

/// By name; components also as "presample[1]".
using Targets = std::map<std::string, Target, std::less<>>;

/// Every parameter of the frame, the optics, the components and the other tables in the file, not elements of lists.
Targets targets_of(const SensorConfig& sensor);

/// The target of "owner.field" or "owner.field[3]"; null when there is none.
std::optional<Target> find_target(const Targets& targets, std::string_view name);

/// "the sensor has no parameter 'jiter.rms'; did you mean ...".
std::string unknown_parameter(const Targets& targets, const std::string& name);

/// A text as the sensor file would hold it: a number, a list, true or false, or else a string.
Node node_of(const std::string& cell, int line);

/// "rms" for "rms_x" and "rms_y", none for other keys. A pair of axes is written as one value or as two, never as both.
std::optional<std::string> pair_of_axis(std::string_view key);

/// Puts the value into the tree, and takes out what it replaces (pitch for pitch_x). What is wrong, "" when nothing is.
std::string put(Node& root, const Target& target, Node value);

}  // namespace mtf::io::cfg
