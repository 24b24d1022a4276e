// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/shutter_closings.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "mtf/error.h"

namespace apps {
namespace {

constexpr std::array<std::string_view, 3> kDrifting{"detector.shutter_temperature", "optics.stop_temperature",
                                                    "optics.temperature"};

void refuse_drift_of_scheduled_temperatures(const mtf::io::SensorConfig& sensor, const mtf::io::Schedule& schedule) {
  const auto settings = radiometry::sensor_settings(sensor.tables);
  if (!settings.thermal) return;
  const auto& lines = schedule.settings;
  const bool drifts = settings.thermal->drift_k_s != 0.0 ||
                      std::any_of(lines.begin(), lines.end(),
                                  [](const auto& line) { return line.parameter == "detector.shutter_drift"; });
  if (!drifts) return;
  for (const mtf::io::Setting& line : lines)
    if (line.frame > 0 && std::find(kDrifting.begin(), kDrifting.end(), line.parameter) != kDrifting.end())
      throw mtf::UsageError(schedule.file + ":" + std::to_string(line.line) + ": error: " + line.parameter +
                            ": the temperature at frame " + std::to_string(line.frame) +
                            ", which detector.shutter_drift states too: it warms shutter, housing and optics from "
                            "frame 0 on; remove shutter_drift, or the lines of temperatures after frame 0");
}

}  // namespace

ShutterClosings::ShutterClosings(const mtf::io::SensorConfig& sensor, mtf::io::Schedule schedule)
    : sensor_(sensor), schedule_(std::move(schedule)) {
  refuse_drift_of_scheduled_temperatures(sensor_, schedule_);
}

std::optional<radiometry::ShutterClosing> ShutterClosings::before(std::uint32_t frame,
                                                                  const radiometry::SensorSettings& settings) {
  if (!settings.thermal || !settings.thermal->closes()) return std::nullopt;
  const radiometry::ShutterEvents events = shutter_events(settings);
  const std::uint32_t closed = events.closing_before(frame);
  if (last_ && last_->frame == closed) return last_;
  radiometry::CameraEmission camera = emission_of(settings);
  if (closed < frame && !schedule_.settings.empty()) {
    mtf::io::ScheduledSensor then(sensor_, schedule_);
    then.advance(closed);
    camera = emission_of(radiometry::sensor_settings(then.sensor().tables));
  }
  last_ = {closed, warmed(camera, events.warming_k(closed))};
  return last_;
}

}  // namespace apps
