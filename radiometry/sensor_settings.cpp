// SPDX-License-Identifier: Apache-2.0
#include "radiometry/sensor_settings.h"

namespace radiometry {
namespace {

/// Calls visit(name, doc, optional value) for every table.
template <class Settings, class Visit>
void for_each_table(Settings& s, Visit visit) {
  visit("frame", "time from frame to frame", s.frame);
  visit("scene", "what the values of a scene stand for", s.scene);
  visit("camera_counts", "the camera that wrote a scene of raw counts", s.counts);
  visit("path", "what lies between scene and aperture", s.path);
  visit("optics", "what the optics let through and emit", s.optics);
  visit("optical_axis", "where the optical axis meets the detector", s.axis);
  visit("distortion", "radial distortion of the scene", s.distortion);
  visit("veiling_glare", "light scattered over the whole image", s.glare);
  visit("ghost", "the image mirrored through the axis", s.ghost);
  visit("vignetting", "fall of the light towards the corners", s.vignetting);
  visit("narcissus", "the detector's own cold in the background", s.narcissus);
  visit("detector", "from photons to electrons", s.detector);
  visit("microscan", "frames between the pixels, put together", s.microscan);
  visit("shutter", "when the rows of a frame are exposed", s.shutter);
  visit("lag", "time constant of a bolometer over a sequence", s.lag);
  visit("nonuniformity", "what differs from pixel to pixel", s.nonuniformity);
  visit("defects", "dead and hot pixels", s.defects);
  visit("blinking", "pixels that come and go", s.blinking);
  visit("blooming", "where charge above the full well goes", s.blooming);
  visit("noise", "seed, shot noise, noise of rows and columns", s.noise);
  visit("flicker", "1/f noise of the readout", s.flicker);
  visit("noise_3d", "the seven components of 3-D noise", s.noise_3d);
  visit("nonlinearity", "response that is not proportional to the charge", s.nonlinearity);
  visit("adc", "from electrons to counts", s.adc);
  visit("correction", "two-point correction and replacement of bad pixels", s.correction);
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
