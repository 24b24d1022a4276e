// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/scene_light.h"

#include "apps/sensor/response.h"
#include "mtf/error.h"
#include "radiometry/light/path_planes.h"
#include "radiometry/light/scene_radiance.h"

namespace apps {
namespace {

using mtf::io::Quantity;

std::string attribute(const mtf::io::Scene& scene, const char* name) {
  const auto found = scene.info.attributes.find(name);
  return found == scene.info.attributes.end() ? std::string() : found->second;
}

/// Radiance that is weighted by the response of a sensor: in W for a thermal detector, in photons for others.
bool is_weighted(const mtf::io::Scene& scene) { return attribute(scene, "mtf:quantity").starts_with("weighted_"); }

/// What a picture says of itself has to suit the sensor: its air counts once, and its light is weighted once, by the
/// response that it has here.
void require_own_light(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, const mtf::io::Scene& scene,
                       const std::string& file) {
  const radiometry::SensorSettings& settings = loaded.sensor.settings;
  if (attribute(scene, "mtf:path") == "included" && (settings.path || settings.atmosphere))
    throw mtf::UsageError(file + ": the air is in it already, and would count twice with [" +
                          (settings.path ? "path" : "atmosphere") + "] of " + config.file +
                          "; remove that table, or render without air");
  if (!is_weighted(scene)) return;
  const bool watts = scene.quantity == Quantity::radiance;
  const std::string quantity = attribute(scene, "mtf:quantity");
  if (watts != (loaded.sensor.curves.flux == radiometry::Flux::watts))
    throw mtf::UsageError(file + ": holds " + quantity + ", for " + (watts ? "thermal" : "photon") + " detectors; " +
                          config.file + " has the other kind");
  const std::string given = attribute(scene, "mtf:response");
  if (given.empty())
    throw mtf::UsageError(file + ": holds " + quantity +
                          " and does not say by which response it is weighted (mtf:response); a scene of `radiance` "
                          "needs none");
  if (given != response_sha256(loaded.sensor.curves))
    throw mtf::UsageError(file + ": is weighted by another response than that of " + config.file +
                          " (band, transmission and quantum efficiency as curves); render it with this sensor");
}

class Converter {
 public:
  Converter(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, const mtf::io::Scene& scene, int threads)
      : file_(config.file),
        loaded_(loaded),
        settings_(loaded.sensor.settings),
        scene_(settings_.scene.value_or(radiometry::SceneSettings{})),
        band_(loaded.paths ? radiometry::scene_band(loaded.sensor.curves)
                           : radiometry::scene_band(loaded.sensor.curves, loaded.sensor.path)),
        quantity_(scene.quantity),
        weighted_(is_weighted(scene)),
        options_{.negative = scene_.negative, .threads = threads} {
    const Quantity quantity = quantity_;
    const bool surfaces = quantity == Quantity::temperature || quantity == Quantity::counts;
    const bool finish = scene_.surroundings_k || !scene_.emissivity.file.empty() || scene_.emissivity.number != 1.0 ||
                        !scene_.emissivity_channel.name.empty();
    if (!surfaces && finish && !weighted_)  // which a picture of surfaces has in it
      throw mtf::UsageError(file_ +
                            ": scene.emissivity, emissivity_channel and surroundings are for scenes of "
                            "temperatures or counts; this one is " +
                            std::string(mtf::io::quantity_name(quantity)) + ": remove them");
    if (quantity == Quantity::counts && scene_.emissivity.number < 1.0 && !scene_.surroundings_k)
      throw mtf::UsageError(file_ +
                            ": scene.surroundings: missing; counts of a surface with emissivity below 1 hold "
                            "what it reflects, for example \"293 K\"");
    if (quantity == Quantity::counts && (!scene_.emissivity.file.empty() || !scene_.emissivity_channel.name.empty()))
      throw mtf::UsageError(file_ +
                            ": scene.emissivity of counts is the one number that the thermometer assumes; a "
                            "curve or channel is for scenes of temperatures");
  }

  /// Values of the scene's quantity to radiance at the aperture, but for a path that differs from pixel to pixel.
  void to_radiance(mtf::Image& image, const mtf::Image& emissivity) const {
    switch (quantity_) {
      case Quantity::temperature:
        radiance_of_temperature(image.view(), band_,
                                {loaded_.sensor.emissivity, emissivity.view(), scene_.surroundings_k.value_or(0.0)},
                                options_);
        break;
      case Quantity::radiance:
      case Quantity::photon_radiance:
      case Quantity::spectral_radiance:
        radiance_of_band(image.view(), light_per_unit(), options_);
        break;
      case Quantity::counts:
        if (!settings_.counts)
          throw mtf::UsageError(file_ +
                                ": a scene of counts needs [camera_counts] with the constants of the camera that wrote "
                                "it, or [scene] quantity and gain that make a radiance or temperature of them");
        // The surface's own temperature, then what it emits and reflects in this band.
        temperature_of_counts(
            image.view(), *settings_.counts,
            {.emissivity = scene_.emissivity.number, .reflected_k = scene_.surroundings_k.value_or(0.0)},
            options_.threads);
        radiance_of_temperature(image.view(), band_,
                                {loaded_.sensor.emissivity, {}, scene_.surroundings_k.value_or(0.0)}, options_);
        break;
    }
  }

  /// to_radiance() and add_path() for windows of a scene whose values go from `least` to `largest`: what all of them
  /// share is made now. For scenes of temperature or radiance.
  WindowToLight of_windows(double least, double largest) const {
    const auto path = path_light();
    if (quantity_ == Quantity::temperature) {
      const auto light = std::make_shared<const radiometry::TemperatureRadiance>(
          band_, loaded_.sensor.emissivity, scene_.surroundings_k.value_or(0.0), std::max(least, 0.0),
          std::max(largest, 0.0));
      return [light, path](mtf::ImageView<float> window) {
        light->apply(window);
        add(path, window);
      };
    }
    return [factor = light_per_unit(), path, negative = scene_.negative](mtf::ImageView<float> window) {
      radiometry::radiance_of_band(window, factor, {.negative = negative});
      add(path, window);
    };
  }

  /// What a path that is the same for all pixels adds.
  void add_path(mtf::Image& image) const { add(path_light(), image.view()); }

  /// Returns how much a pixel errs at most: the table's error of a transmission times the light that it takes from, and
  /// of an emission times the light of a blackbody.
  double through_paths(mtf::Image& image, const mtf::Image& range_m) const {
    const mtf::Statistics ranges = mtf::statistics(range_m.view());
    const RangedPaths paths = loaded_.paths(ranges.min, ranges.max);
    const double before = mtf::statistics(image.view()).max;
    radiometry::RangeTable(band_, *paths.table, source_k()).apply(image.view(), range_m.view(), options_.threads);
    if (paths.error == 0.0) return 0.0;
    const radiometry::Surface air{.temperature_k = paths.air_k};
    return paths.error * (before + scene_radiance(loaded_.sensor.curves, air, {}));
  }

  /// What a constant border of that value is worth.
  double border(double value) const {
    mtf::Image border(1, 1);
    border.at(0, 0) = static_cast<float>(value);
    to_radiance(border, {});
    add_path(border);
    return static_cast<double>(border.at(0, 0));
  }

  const radiometry::SceneSettings& scene() const { return scene_; }
  const radiometry::SceneBand& band() const { return band_; }

 private:
  /// Of this scene's own quantity, which its file may state.
  std::optional<double> source_k() const { return source_temperature_k(settings_, quantity_); }

  /// Weighted radiance for one unit of a scene of radiance.
  double light_per_unit() const {
    if (quantity_ == Quantity::spectral_radiance) {
      const double middle_um = 0.5 * (band_.band.lo_um + band_.band.hi_um);
      return channel_weights(band_, std::array{middle_um}).weight.front();
    }
    if (weighted_) return path_share();
    const auto flux = quantity_ == Quantity::radiance ? radiometry::Flux::watts : radiometry::Flux::photons;
    return light_per_radiance(flux, band_, source_k());
  }

  /// What a path that is the same for all pixels leaves of light that is weighted already.
  double path_share() const {
    if (loaded_.paths) return 1.0;
    const radiometry::Surface surface{.temperature_k = source_k().value_or(kSurface_k)};
    return scene_radiance(loaded_.sensor.curves, surface, loaded_.sensor.path) /
           scene_radiance(loaded_.sensor.curves, surface, {});
  }

  float path_light() const {
    if (loaded_.paths) return 0.0F;
    return static_cast<float>(weighted_path_radiance(loaded_.sensor.curves, loaded_.sensor.path));
  }

  static void add(float added, mtf::ImageView<float> image) {
    if (added == 0.0F) return;
    for (std::int64_t y = 0; y < image.height; ++y)
      for (std::int64_t x = 0; x < image.width; ++x) image.at(x, y) += added;
  }

  std::string file_;
  const LoadedSensor& loaded_;
  const radiometry::SensorSettings& settings_;
  radiometry::SceneSettings scene_;
  radiometry::SceneBand band_;
  Quantity quantity_;
  bool weighted_;
  radiometry::PlaneOptions options_;
};

/// The plane of that name beside the scene; empty for no name.
mtf::Image channel_of(const SceneSource& source, const std::string& name, const char* key) {
  if (name.empty()) return {};
  try {
    return plane_beside(source, name);
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError("scene." + std::string(key) + ": " + error.what());
  }
}

void require_one_channel(const mtf::io::Scene& scene, const std::string& file) {
  if (scene.names.size() == 1) return;
  std::string names;
  for (const std::string& name : scene.names) names += (names.empty() ? "" : ", ") + name;
  throw mtf::UsageError(file + ": the sensor makes one image of one channel, the scene has " +
                        std::to_string(scene.names.size()) + " (" + names + "); choose one with --channel");
}

/// Channels of a spectrum become their sum, weighted.
void merge_spectrum(mtf::io::Scene& scene, const Converter& convert, int threads) {
  const radiometry::ChannelWeights weights = channel_weights(convert.band(), scene.wavelength_um);
  std::vector<mtf::ImageView<const float>> channels;
  for (const mtf::Image& plane : scene.planes) channels.push_back(plane.view());
  radiometry::radiance_of_channels(channels, weights.weight, scene.planes.front().view(),
                                   {.negative = convert.scene().negative, .threads = threads});
  scene.planes.resize(1);
  scene.names = {"spectrum"};
}

}  // namespace

SceneLight to_light(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, mtf::io::Scene& scene,
                    const SceneSource& source, int threads) {
  require_own_light(config, loaded, scene, source.file);
  const Converter convert(config, loaded, scene, threads);
  const mtf::Image emissivity = channel_of(source, convert.scene().emissivity_channel.name, "emissivity_channel");
  const mtf::Image range_m = channel_of(source, convert.scene().depth_channel.name, "depth_channel");
  const bool spectrum = !scene.wavelength_um.empty();
  if (!spectrum) require_one_channel(scene, source.file);
  if (spectrum) merge_spectrum(scene, convert, threads);
  mtf::Image& plane = scene.planes.front();
  if (!spectrum) convert.to_radiance(plane, emissivity);
  convert.add_path(plane);
  SceneLight light;
  if (loaded.paths) light.error = convert.through_paths(plane, range_m);
  if (config.scene.border != mtf::Border::constant) return light;
  if (loaded.paths)
    throw mtf::UsageError(config.file +
                          ": scene.border: a constant border has no range, which scene.depth_channel gives each pixel; "
                          "use border = \"reflect\"");
  light.border_value = convert.border(config.scene.border_value);
  return light;
}

std::string refusal_of_light(const mtf::io::SensorConfig& config, const LoadedSensor& loaded,
                             const mtf::io::Scene& scene) {
  const radiometry::SceneSettings settings = loaded.sensor.settings.scene.value_or(radiometry::SceneSettings{});
  if (!scene.wavelength_um.empty()) return "a sensor with [detector] takes no scene of spectral channels";
  if (scene.quantity == Quantity::counts) return "a sensor with [detector] takes no scene of counts";
  if (!settings.emissivity_channel.name.empty()) return "scene.emissivity_channel of " + config.file + " is not read";
  if (loaded.paths) return "scene.depth_channel of " + config.file + " is not read";
  return "";
}

void require_light_of_windows(const mtf::io::SensorConfig& config, const LoadedSensor& loaded,
                              const mtf::io::Scene& scene, const std::string& file) {
  if (const std::string refusal = refusal_of_light(config, loaded, scene); !refusal.empty())
    throw mtf::UsageError(file + ": in tiles (--memory) " + refusal +
                          "; make a scene of radiance of it before, or let the whole image through at once");
  require_own_light(config, loaded, scene, file);
  require_one_channel(scene, file);
}

LightOfWindows light_of_windows(const mtf::io::SensorConfig& config, const LoadedSensor& loaded,
                                const mtf::io::Scene& scene, const mtf::Statistics& values) {
  const Converter convert(config, loaded, scene, 1);
  if (values.min < 0.0 && convert.scene().negative == radiometry::Negative::refuse)
    throw mtf::UsageError("values below 0, down to " + mtf::format_double(values.min) + " " +
                          std::string(mtf::io::quantity_unit(scene.quantity)) +
                          "; correct the scene, or have such pixels taken as 0 with scene.negative = \"clamp\"");
  LightOfWindows light{convert.of_windows(values.min, values.max), 0.0};
  if (config.scene.border == mtf::Border::constant) light.border_value = convert.border(config.scene.border_value);
  return light;
}

}  // namespace apps
