// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a sensor file to the chain of radiometry: the files that its tables name, read and checked.

#include <functional>
#include <string>
#include <vector>

#include "mtf/io/config/config.h"
#include "radiometry/chain/chain.h"
#include "radiometry/light/path.h"
#include "radiometry/light/spectral_signal.h"
#include "radiometry/performance/acquisition.h"

namespace apps {

/// Reads a sensor file with the tables of the chain. Its warnings and notes go to `diagnostics` where that is given.
/// Throws UsageError with every error as a "file:line:col: error: ..." line, RuntimeError when it cannot be read.
mtf::io::SensorConfig read_sensor_file(const std::string& file,
                                       std::vector<mtf::io::Diagnostic>* diagnostics = nullptr);

/// The sensor file and every file it names (curves, tables, maps): what no output may replace.
std::vector<std::string> files_of(const mtf::io::SensorConfig& config);

/// True when the file has a detector: its output is electrons, counts or display values.
bool has_chain(const mtf::io::SensorConfig& config);

/// The blackbody whose spectrum weights the band where a single one has to stand for all surfaces of a scene.
inline constexpr double kSurface_k = 300.0;

/// Of the blackbody whose spectrum light of that quantity has where nothing better is known: [scene]
/// source_temperature, else kSurface_k for temperatures and counts, else none (even in photons).
std::optional<double> source_temperature_k(const radiometry::SensorSettings& settings,
                                           std::optional<mtf::io::Quantity> quantity);

/// A table of paths and how much it errs between its ranges: in transmission, and in radiance relative to a blackbody
/// of air_k.
struct RangedPaths {
  std::shared_ptr<const radiometry::PathTable> table;
  double error = 0.0, air_k = 0.0;
};

/// A sensor and the path in front of its aperture.
struct LoadedSensor {
  radiometry::Sensor sensor;
  /// For an image whose pixels have ranges from the nearest to the longest; empty where all have one path. It may be
  /// called from several threads at once.
  std::function<RangedPaths(double nearest_m, double longest_m)> paths;
  /// What components take from [atmosphere] with other numbers; empty where none takes any, or pixels have their own
  /// range.
  std::function<mtf::PathAir<double>(const radiometry::AtmosphereSettings&)> path_air;
  /// How far [atmosphere] with other numbers goes when its range changes; empty where the file has none.
  std::function<radiometry::Reach(const radiometry::AtmosphereSettings&)> reach;
  std::shared_ptr<const radiometry::PathTable> table;  ///< of [path]; null without one
  std::optional<double> source_k;                      ///< source_temperature_k() of the quantity that [scene] states
};

/// The sensor with its curves, tables and maps. Throws UsageError with file, line and key for what does not fit,
/// RuntimeError for files that cannot be read.
LoadedSensor load_chain(const mtf::io::SensorConfig& config);

/// The curves of the camera alone, from the same tables. Throws as load_chain.
radiometry::SpectralCamera load_curves(const mtf::io::SensorConfig& config);

/// The electrons over the band that light of the sensor's source gives behind that path and through all curves;
/// nothing where they need no weights: without a curve and a source temperature, or without a component that depends on
/// the wavelength. Throws UsageError where that light gives no electrons.
std::shared_ptr<const mtf::ElectronRate> electron_rate(const mtf::System<double>& system, const LoadedSensor& loaded,
                                                       const radiometry::Path& path);

/// The system whose band has the electron_rate() of the sensor's own path.
mtf::System<double> with_electron_rate(const mtf::System<double>& system, const LoadedSensor& loaded);

/// The error for a file without [detector] that has other tables of the chain; empty when it has none.
std::string unused_table(const mtf::io::SensorConfig& config);

/// Why a file makes no chain, for `mtf config check`, with its place where it is about a key of the file; nothing where
/// it does.
std::optional<mtf::io::Diagnostic> chain_problem(const mtf::io::SensorConfig& config);

// What the weighted radiance of an image was weighted by: images that say it are taken by sensors with the same
// response and by no others.

/// SHA-256 of the band, of what the detector answers to and of all curves, 64 hex digits. Plain numbers (f-number,
/// transmission, quantum efficiency) are no part of it: the camera equation takes them after the weighted radiance.
std::string response_sha256(const radiometry::SpectralCamera& curves);

// Where two keys of a sensor file state the same thing and may not agree, and where a curve stops inside the band.

/// Warnings, as that can be meant; notes where both ways are usual.
std::vector<mtf::io::Diagnostic> chain_warnings(const mtf::io::SensorConfig& config);

}  // namespace apps
