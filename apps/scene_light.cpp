// SPDX-License-Identifier: Apache-2.0
#include "apps/scene_light.h"

#include "mtf/error.h"
#include "radiometry/path_planes.h"
#include "radiometry/scene_radiance.h"

namespace apps {
namespace {

using mtf::io::Quantity;

class Converter {
 public:
  Converter(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, Quantity quantity, int threads)
      : file_(config.file),
        loaded_(loaded),
        settings_(loaded.sensor.settings),
        scene_(settings_.scene.value_or(radiometry::SceneSettings{})),
        band_(loaded.paths ? radiometry::scene_band(loaded.sensor.curves)
                           : radiometry::scene_band(loaded.sensor.curves, loaded.sensor.path)),
        quantity_(quantity),
        options_{.negative = scene_.negative, .threads = threads} {}

  /// Values of the scene's quantity to radiance at the aperture, but for a path that differs from pixel to pixel.
  void to_radiance(mtf::Image& image, const mtf::Image& emissivity) const {
    switch (quantity_) {
      case Quantity::temperature:
        radiance_of_temperature(image.view(), band_,
                                {loaded_.sensor.emissivity, emissivity.view(), scene_.surroundings_k.value_or(0.0)},
                                options_);
        break;
      case Quantity::radiance:
      case Quantity::photon_radiance: {
        const auto flux = quantity_ == Quantity::radiance ? radiometry::Flux::watts : radiometry::Flux::photons;
        radiance_of_band(image.view(), photons_per_radiance(flux, band_, scene_.source_temperature_k), options_);
        break;
      }
      case Quantity::spectral_radiance: {
        const double middle_um = 0.5 * (band_.band.lo_um + band_.band.hi_um);
        radiance_of_band(image.view(), channel_weights(band_, std::array{middle_um}).weight.front(), options_);
        break;
      }
      case Quantity::counts:
        if (!settings_.counts)
          throw mtf::UsageError(file_ +
                                ": a scene of counts needs [camera_counts] with the constants of the camera that wrote "
                                "it, or [scene] quantity and gain that make a radiance or temperature of them");
        temperature_of_counts(image.view(), *settings_.counts, {}, options_.threads);
        radiance_of_temperature(image.view(), band_, {}, options_);
        break;
    }
    if (loaded_.paths) return;
    const auto added = static_cast<float>(path_photon_radiance(loaded_.sensor.curves, loaded_.sensor.path));
    if (added == 0.0F) return;
    for (float& v : std::span(image.data(), static_cast<std::size_t>(image.size()))) v += added;
  }

  void through_paths(mtf::Image& image, const mtf::Image& range_m) const {
    radiometry::RangeTable(band_, *loaded_.paths, scene_.source_temperature_k)
        .apply(image.view(), range_m.view(), options_.threads);
  }

  const radiometry::SceneSettings& scene() const { return scene_; }

 private:
  std::string file_;
  const LoadedSensor& loaded_;
  const radiometry::SensorSettings& settings_;
  radiometry::SceneSettings scene_;
  radiometry::SceneBand band_;
  Quantity quantity_;
  radiometry::PlaneOptions options_;
};

/// Takes the plane of that name out of the scene, or reads it from the file; empty for no name.
mtf::Image take_channel(mtf::io::Scene& scene, const std::string& path, const std::string& name, const char* key) {
  if (name.empty()) return {};
  for (std::size_t c = 0; c < scene.names.size(); ++c)
    if (scene.names[c] == name) {
      mtf::Image plane = std::move(scene.planes[c]);
      scene.names.erase(scene.names.begin() + static_cast<std::ptrdiff_t>(c));
      scene.planes.erase(scene.planes.begin() + static_cast<std::ptrdiff_t>(c));
      return plane;
    }
  try {
    mtf::io::ReadOptions options;
    options.channel = name;
    return std::move(mtf::io::read_image(path, options).planes.front());
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError("scene." + std::string(key) + ": " + error.what());
  }
}

}  // namespace

double to_light(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, mtf::io::Scene& scene,
                const std::string& path, int threads) {
  const Converter convert(config, loaded, scene.quantity, threads);
  const mtf::Image emissivity =
      take_channel(scene, path, convert.scene().emissivity_channel.name, "emissivity_channel");
  const mtf::Image range_m = take_channel(scene, path, convert.scene().depth_channel.name, "depth_channel");
  if (scene.planes.size() != 1) {
    std::string names;
    for (const std::string& name : scene.names) names += (names.empty() ? "" : ", ") + name;
    throw mtf::UsageError(path + ": the sensor makes one image of one channel, the scene has " +
                          std::to_string(scene.planes.size()) + " (" + names + "); choose one with --channel");
  }
  mtf::Image& plane = scene.planes.front();
  convert.to_radiance(plane, emissivity);
  if (loaded.paths) convert.through_paths(plane, range_m);
  if (config.scene.border != mtf::Border::constant) return 0.0;
  if (loaded.paths)
    throw mtf::UsageError(config.file +
                          ": scene.border: a constant border has no range, which scene.depth_channel gives each pixel; "
                          "use border = \"reflect\"");
  mtf::Image border(1, 1);
  border.at(0, 0) = static_cast<float>(config.scene.border_value);
  convert.to_radiance(border, {});
  return static_cast<double>(border.at(0, 0));
}

}  // namespace apps
