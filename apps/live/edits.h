// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a user of the page has changed, as a list of edits of the sensor file that the command was started with. The
// page keeps the list: undo takes its last entry off, a link carries it, and every answer follows from it alone. Edits
// are the only thing that changes a sensor here, and none of them can name a file.

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/sensor/sensor_kinds.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/config/config.h"

namespace apps::live {

struct Edit {
  enum class Kind {
    set,     ///< parameter `name`, "jitter.rms", takes `value`, as a schedule has it
    unset,   ///< the file states parameter `name` no longer
    remove,  ///< the component labelled `name`, or the table "[noise]"
    off,     ///< the same stays as a comment
    on,      ///< the comment number `name` becomes a table again
    add      ///< the component of kind `value` to the list `name`, or the table `value` where `name` is "table"
  };
  Kind kind{};
  std::string name{}, value{};

  bool operator==(const Edit&) const = default;
};

/// An edit that cannot be made: the place in its list, which a request calls `list`.
class RefusedEdit : public mtf::UsageError {
 public:
  RefusedEdit(const std::string& text, std::size_t index, std::string list)
      : UsageError(text), index_(index), list_(std::move(list)) {}
  std::size_t index() const { return index_; }
  const std::string& list() const { return list_; }

 private:
  std::size_t index_;
  std::string list_;
};

/// From JSON: [["set", "jitter.rms", "20 urad"], ...]. Throws UsageError.
std::vector<Edit> read_edits(const Json& list);

/// The sensor with these edits. Throws RefusedEdit of the list "edits" for one that cannot be made, with the message of
/// the reader, whose file name is that of the start.
class EditedSensor {
 public:
  using Sensor = std::shared_ptr<const mtf::io::SensorConfig>;

  explicit EditedSensor(Sensor start) : start_(std::move(start)), kinds_(sensor_kinds()) {}

  /// Edits that the last call had too, from the first one on, are not made again.
  Sensor with(std::span<const Edit> edits);
  const Sensor& start() const { return start_; }
  const SensorKinds& kinds() const { return kinds_; }

 private:
  Sensor start_;
  SensorKinds kinds_;
  std::vector<Edit> edits_;
  std::vector<Sensor> after_;  ///< after each of them
};

// Whole tables of a sensor file as pieces of its text: taken out, added at the end, switched off and on again. A table
// that is off stays in the file as a comment whose lines begin with "#- ", so that a saved file keeps it.

/// The lines of one table: its header, its keys and the comments among them. Comments and blank lines above the next
/// header belong to that one.
struct TomlBlock {
  std::string header;              ///< "presample", "noise"
  bool list = false;               ///< [[presample]]
  bool off = false;                ///< a comment of "#- " lines
  std::size_t index = 0;           ///< among blocks of the same header that are as much on or off
  std::size_t begin = 0, end = 0;  ///< bytes of the text
};

/// In the order of the file. Headers within multi-line strings are none.
std::vector<TomlBlock> toml_blocks(std::string_view text);

/// Texts of the same file without the block, with it as a comment, and with the comment as a table again.
std::string without_block(std::string_view text, const TomlBlock& block);
std::string switched_off(std::string_view text, const TomlBlock& block);
std::string switched_on(std::string_view text, const TomlBlock& block);
/// The lines of a block that is off, as TOML.
std::string text_of_off(std::string_view text, const TomlBlock& block);
/// The text with a table at its end.
std::string with_block(std::string_view text, std::string_view block);

}  // namespace apps::live
