// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor_chain.h"

#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "radiometry/band_response.h"

namespace apps {
namespace {

using radiometry::NumberOrFile;
using radiometry::Spectrum;

/// Runs `read`, and says which key asked for it when it fails.
template <class Read>
auto at_key(const std::string& file, const char* key, const Read& read) {
  try {
    return read();
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(file + ": " + key + ": " + error.what());
  }
}

Spectrum curve_of(const NumberOrFile& value, const char* key, double most) {
  if (value.file.empty()) return radiometry::constant_spectrum(key, value.number, most);
  throw mtf::UsageError("curves are not read yet");
}

void add_curve(std::vector<Spectrum>& curves, const NumberOrFile& value, const char* key) {
  if (!value.file.empty()) curves.push_back(curve_of(value, key, 1.0));
}

radiometry::Path path_of(const radiometry::PathSettings& settings) {
  radiometry::Path path;
  path.transmission = curve_of(settings.transmission, "path.transmission", 1.0);
  path.radiance = curve_of(settings.radiance, "path.radiance", std::numeric_limits<double>::max());
  if (settings.air_temperature_k) {
    path.emissivity = complement(path.transmission);
    path.air_temperature_k = *settings.air_temperature_k;
  }
  return path;
}

}  // namespace

bool has_chain(const mtf::io::SensorConfig& config) { return find_table(config.tables, "detector") != nullptr; }

radiometry::Sensor load_chain(const mtf::io::SensorConfig& config) {
  radiometry::Sensor sensor;
  sensor.settings = radiometry::sensor_settings(config.tables);
  const radiometry::SensorSettings& settings = sensor.settings;
  if (!config.system.band)
    throw mtf::UsageError(config.file +
                          ": band: missing; electrons need it: write [band] wavelength = [\"3.4 um\", \"4.8 um\"]");
  sensor.curves.band = {config.system.band->lo_um, config.system.band->hi_um};
  if (settings.optics) {
    add_curve(sensor.curves.optics, settings.optics->transmission, "optics.transmission");
    add_curve(sensor.curves.cold_filter, settings.optics->cold_transmission, "optics.cold_transmission");
  }
  if (settings.detector)
    add_curve(sensor.curves.quantum_efficiency, settings.detector->quantum_efficiency, "detector.quantum_efficiency");
  if (settings.scene) sensor.emissivity = curve_of(settings.scene->emissivity, "scene.emissivity", 1.0);
  if (settings.path) sensor.path = path_of(*settings.path);
  return sensor;
}

}  // namespace apps
