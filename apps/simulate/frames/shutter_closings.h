// SPDX-License-Identifier: Apache-2.0
#pragma once

// When the shutter of a thermal camera closed last, for the frames of a sequence, and what it and the camera were like
// then: as the schedule has them at that frame, whether or not that frame is one of those that are run. So a frame does
// not depend on where --frames begins and on what it leaves out.

#include <cstdint>
#include <optional>

#include "mtf/io/config/schedule.h"
#include "radiometry/chain/sensor_settings.h"

namespace apps {

class ShutterClosings {
 public:
  /// Throws UsageError for a schedule of temperatures that [detector] shutter_drift changes too.
  ShutterClosings(const mtf::io::SensorConfig& sensor, mtf::io::Schedule schedule);

  /// The last closing of the camera with these settings, which are those of `frame`; nothing where it does not close.
  std::optional<radiometry::ShutterClosing> before(std::uint32_t frame, const radiometry::SensorSettings& settings);

 private:
  mtf::io::SensorConfig sensor_;  ///< of the file
  mtf::io::Schedule schedule_;
  std::optional<radiometry::ShutterClosing> last_;
};

}  // namespace apps
