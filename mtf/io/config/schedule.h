// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parameters that change over the frames of a sequence, from a CSV file:
//   # focus drifts, the mount shakes from frame 20 on
//   frame,parameter,value
//   1,defocus.waves,0.1
//   20,jitter.rms,8 urad
//   20,frame.integration_time,5 ms
//   30,wavefront.zernike[3],0.05
// A line sets a parameter from its frame on, until the next line for that parameter. Parameters are called as the
// messages of a sensor file and `mtf config explain` call them, the label of a component before its field; elements of
// a list count from 0. Values are what the sensor file would hold, strings without their quotes; they are read by the
// same code, so that units, bounds and defaults are those of the file.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/config/config.h"

namespace mtf::io {

/// Largest number of a frame.
inline constexpr std::int64_t kLastFrame = 999'999'999;

/// One line of a schedule.
struct Setting {
  std::int64_t frame = 0;
  std::string parameter{};  ///< as written: "jitter.rms"
  std::string value{};      ///< as written: "8 urad"
  int line = 0;             ///< of the file, from 1
};

struct Schedule {
  std::string file;
  std::string sha256;                ///< of the text
  std::vector<Setting> settings{};   ///< by frame
  std::vector<std::string> files{};  ///< that its values name, and the sensor
};

/// A file of at most 64 MiB and a million lines. Every sensor that it makes of `sensor` is checked. Throws RuntimeError
/// when it cannot be read, UsageError with "file:line: error: ..." lines for what is wrong in it.
Schedule read_schedule(const std::string& path, const SensorConfig& sensor);

/// The same from text; `file` is what messages call it.
Schedule parse_schedule(std::string_view text, const std::string& file, const SensorConfig& sensor);

/// The sensor as it is at one frame after the other.
class ScheduledSensor {
 public:
  ScheduledSensor(const SensorConfig& sensor, Schedule schedule);
  ~ScheduledSensor();
  ScheduledSensor(ScheduledSensor&&) noexcept;
  ScheduledSensor& operator=(ScheduledSensor&&) noexcept;

  /// Goes on to `frame`, which is not before the last one. True when lines of the schedule came into force. Throws
  /// UsageError for values that the sensor file could not hold; there is no going on from there.
  bool advance(std::int64_t frame);
  const SensorConfig& sensor() const;
  /// Parameters set so far and their values as written: "jitter.rms = 8 urad; optics.f_number = 4".
  std::string in_force() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mtf::io
