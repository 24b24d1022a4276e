// SPDX-License-Identifier: Apache-2.0
#include "radiometry/sensor_settings.h"

namespace radiometry {
namespace {

/// Calls visit(name, doc, optional value) for every table.
template <class Settings, class Visit>
void for_each_table(Settings& s, Visit visit) {
  visit("scene", "what the values of a scene stand for", s.scene);
  visit("camera_counts", "the camera that wrote a scene of raw counts", s.counts);
  visit("path", "what lies between scene and aperture", s.path);
  visit("optics", "what the optics let through and emit", s.optics);
  visit("detector", "from photons to electrons", s.detector);
  visit("nonuniformity", "what differs from pixel to pixel", s.nonuniformity);
  visit("defects", "dead and hot pixels", s.defects);
  visit("noise", "seed, shot noise, noise of rows and columns", s.noise);
  visit("noise_3d", "the seven components of 3-D noise", s.noise_3d);
  visit("adc", "from electrons to counts", s.adc);
  visit("agc", "from counts to display levels", s.agc);
}

}  // namespace

std::vector<mtf::TableInfo> sensor_tables() {
  std::vector<mtf::TableInfo> tables;
  SensorSettings prototype;
  for_each_table(prototype, [&]<class T>(std::string_view name, std::string_view doc, const std::optional<T>&) {
    tables.push_back(table_info<T>(name, doc));
  });
  return tables;
}

SensorSettings sensor_settings(const std::vector<mtf::SettingsTable>& tables) {
  SensorSettings settings;
  for_each_table(settings, [&]<class T>(std::string_view name, std::string_view, std::optional<T>& value) {
    if (const mtf::SettingsTable* table = find_table(tables, name)) value = from_table<T>(*table);
  });
  return settings;
}

}  // namespace radiometry
