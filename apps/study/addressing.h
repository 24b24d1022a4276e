// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which value of a sensor file a name in a study denotes: where it is, whether it is a number that can be set without
// reading the file again, in which unit it is held, and its range.

#include <string>
#include <string_view>

#include "mtf/io/config/config_edit.h"

namespace study {

namespace cfg = mtf::io::cfg;
using cfg::Node;

/// A sensor file in which names are searched.
struct SensorView {
  mtf::io::SensorConfig sensor;
  Node tree;
  cfg::Targets targets;
};

/// The places of a sensor that was read without errors.
SensorView view_of(mtf::io::SensorConfig sensor);

struct Place {
  enum class Kind {
    number,  ///< calib::parameter_site has it, or it is a number of another table of the file
    level    ///< anything else: a value that has to be written into the file
  };
  cfg::Target target;
  Kind kind = Kind::level;
  std::string what{};     ///< what a level is, with its article: "a whole number"
  bool file = false;      ///< true: a text in its place names a file
  mtf::FieldInfo info{};  ///< of numbers: unit as held ("" for plain ones; of an Extent as written), range, example
  double value = 0.0;     ///< value of a number
};

/// A place, or why there is none: a sentence that says what to write.
struct Found {
  std::optional<Place> place;
  std::string problem{};
  bool unknown = false;  ///< true: no sensor file has a value of that name
};

/// "owner.key", "owner.key[3]", or the key alone where one owner has it. A number that the sensor file does not give is
/// not found: its problem says what to write there. Nor is one that a map of the sensor file replaces.
Found find_place(const SensorView& view, std::string_view name);

/// True when setting one changes the other, or what it does: "frame.pitch" and "frame.pitch_x", a list and its element,
/// a map of [nonuniformity] and the number that it replaces.
bool overlap(std::string_view path, std::string_view other);

}  // namespace study
