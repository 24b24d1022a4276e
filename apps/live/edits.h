// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a user of the page has changed, as a list of edits of the sensor file that the command was started with. The
// page keeps the list: undo takes its last entry off, a link carries it, and every answer follows from it alone. Edits
// are the only thing that changes a sensor here, and none of them can name a file.

#include <memory>
#include <span>
#include <string>
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

}  // namespace apps::live
