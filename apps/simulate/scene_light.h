// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene's values, whatever they stand for, as the weighted radiance that passes through a chain
// (radiometry/light/scene_radiance.h).

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/sensor/sensor_chain.h"
#include "apps/simulate/scene_source.h"
#include "mtf/engines/statistics.h"
#include "mtf/io/scene.h"

namespace apps {

// The OTF of a band where each pixel has a range of its own. A wavelength counts in the OTF by the light that gets
// through the air, so that the OTF of a band changes along the path; an image is filtered by one OTF. It is that of the
// middle range, the geometric mean of all pixels, and how much the OTFs of the nearest and the longest range differ
// from it can be said.

struct RangeWeights {
  std::shared_ptr<const mtf::ElectronRate> rate;  ///< of Band::rate, behind the path of the middle range
  std::string warning;  ///< by how much the MTF differs at the ends of the ranges; "" below 1e-4
};

/// Ranges of the pixels of an image, in m, and the paths that long.
struct PixelRanges {
  double nearest_m = 0.0, middle_m = 0.0, longest_m = 0.0;
  std::shared_ptr<const radiometry::PathTable> paths;
};

/// No rate where the band needs no weights, and none, with a warning, where no light gets through its middle range.
RangeWeights range_weights(const mtf::System<double>& system, const LoadedSensor& loaded, const PixelRanges& ranges);

struct SceneLight {
  double border_value = 0.0;            ///< what a constant border is worth
  double error = 0.0;                   ///< of a pixel, at most: what the table of the path lacks between its ranges
  std::optional<PixelRanges> ranges{};  ///< where each pixel has its own
  /// Of the band's OTF at these ranges (range_weights()); nothing where that of the sensor holds.
  std::shared_ptr<const mtf::ElectronRate> rate{};
  std::vector<std::string> warnings{};
};

/// The planes of `scene` become the one of its radiance; `rate` stays empty.
/// `source`: of the channels of emissivity and depth that [scene] names. Throws UsageError for a scene of several
/// channels that are no spectrum, and for values that cannot be (how many, and the first one).
SceneLight to_light(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, mtf::io::Scene& scene,
                    const SceneSource& source, int threads);

/// By how much the MTF over the band differs where a scene's own quantity, and not that of the sensor file, says what
/// light it is averaged for; "" below 1e-4.
std::string source_warning(const mtf::System<double>& system, const LoadedSensor& loaded, mtf::io::Quantity of_file);

/// By how much the MTFs of the first and the last channel of a spectrum differ from that of the system, which filters
/// all of them or, where a detector has `merged` them, their sum; "" below 1e-4, and of a scene without a spectrum.
std::string spectrum_warning(const mtf::System<double>& system, const std::vector<double>& wavelength_um, bool merged);

/// Turns the values of a window of a scene into light, in place. From several threads at once.
using WindowToLight = std::function<void(mtf::ImageView<float> window)>;

struct LightOfWindows {
  WindowToLight convert;
  double border_value = 0.0;  ///< what a constant border is worth
};

/// Why the windows of a scene cannot become light by themselves: it has spectra, counts, or a channel of emissivity or
/// depth; "" where they can.
std::string refusal_of_light(const mtf::io::SensorConfig& config, const LoadedSensor& loaded,
                             const mtf::io::Scene& scene);
/// Throws UsageError with refusal_of_light(), and for a scene of several channels. `file` is its name.
void require_light_of_windows(const mtf::io::SensorConfig& config, const LoadedSensor& loaded,
                              const mtf::io::Scene& scene, const std::string& file);

/// to_light() for a scene that is read in windows; `values` are the statistics of all of it. Throws UsageError where
/// there are values that cannot be.
LightOfWindows light_of_windows(const mtf::io::SensorConfig& config, const LoadedSensor& loaded,
                                const mtf::io::Scene& scene, const mtf::Statistics& values);

}  // namespace apps
