// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/scene_light.h"

#include <algorithm>
#include <cmath>

#include "apps/sensor/otf_curves.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/simulate/stated_camera.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "radiometry/light/path_planes.h"
#include "radiometry/light/pixel_rules.h"
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
                          "; leave it out with --without-path, or render with --no-air");
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

double geometric_mean(const mtf::Image& plane) {
  double sum = 0.0;
  for (std::int64_t i = 0; i < plane.size(); ++i) sum += std::log(static_cast<double>(plane.data()[i]));
  return std::exp(sum / static_cast<double>(plane.size()));
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
        counts_(settings_.counts),
        emissivity_(loaded.sensor.emissivity),
        weighted_(is_weighted(scene)),
        options_{.negative = scene_.negative, .threads = threads} {
    if (quantity_ == Quantity::counts) take_stated(config, scene);
    const Quantity quantity = quantity_;
    const bool surfaces = is_of_surfaces();
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
                                {emissivity_, emissivity.view(), scene_.surroundings_k.value_or(0.0)}, options_);
        break;
      case Quantity::radiance:
      case Quantity::photon_radiance:
      case Quantity::spectral_radiance:
        radiance_of_band(image.view(), light_per_unit(), options_);
        break;
      case Quantity::counts:
        to_temperature(image);
        radiance_of_temperature(image.view(), band_, {emissivity_, {}, scene_.surroundings_k.value_or(0.0)}, options_);
        break;
    }
  }

  /// to_radiance() and add_path() for windows of a scene whose values go from `least` to `largest`: what all of them
  /// share is made now. For scenes of temperature or radiance.
  WindowToLight of_windows(double least, double largest) const {
    const auto path = path_light();
    if (quantity_ == Quantity::temperature) {
      const auto light = std::make_shared<const radiometry::TemperatureRadiance>(
          band_, emissivity_, scene_.surroundings_k.value_or(0.0), std::max(least, 0.0), std::max(largest, 0.0));
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

  /// Values of the scene's quantity to radiance at the aperture, through a path of each pixel's range. Surfaces whose
  /// temperatures are known have the spectrum of their own; `to_radiance` has been called for other quantities.
  SceneLight through_paths(mtf::Image& image, const mtf::Image& emissivity, const mtf::Image& range_m) const {
    radiometry::refuse_pixels(std::as_const(range_m).view(),
                              {"scene.depth_channel", "without a finite range above 0 m",
                               "give every pixel its distance along the line of sight, in m"},
                              options_.threads, [](float r) { return !(r > 0.0F && std::isfinite(r)); });
    const mtf::Statistics ranges = mtf::statistics(range_m.view());
    const RangedPaths paths = loaded_.paths(ranges.min, ranges.max);
    double interpolation = 0.0, before = 0.0;
    if (is_of_surfaces()) {
      if (quantity_ == Quantity::counts) to_temperature(image);
      const mtf::Statistics warm = mtf::statistics(image.view());
      interpolation = radiometry::radiance_at_ranges(
          image.view(), range_m.view(), band_, {emissivity_, emissivity.view(), scene_.surroundings_k.value_or(0.0)},
          *paths.table, options_);
      before = black(std::max({warm.max, scene_.surroundings_k.value_or(0.0), 0.0}));
    } else {
      before = mtf::statistics(image.view()).max;
      radiometry::RangeTable(band_, *paths.table, source_k()).apply(image.view(), range_m.view(), options_.threads);
    }
    // The table's error of a transmission errs the light that it takes from, that of an emission the air's own.
    return {.error = (paths.error + interpolation) * before + paths.error * black(paths.air_k),
            .ranges = PixelRanges{ranges.min, geometric_mean(range_m), ranges.max, paths.table}};
  }

  /// What a constant border of that value is worth.
  double border(double value) const {
    mtf::Image border(1, 1);
    border.at(0, 0) = static_cast<float>(value);
    to_radiance(border, {});
    add_path(border);
    return static_cast<double>(border.at(0, 0));
  }

  /// True for scenes that say how warm things are.
  bool is_of_surfaces() const { return quantity_ == Quantity::temperature || quantity_ == Quantity::counts; }

  const radiometry::SceneSettings& scene() const { return scene_; }
  const radiometry::SceneBand& band() const { return band_; }
  /// What a file says of its counts and is used; "" for nothing.
  const std::string& note() const { return note_; }

 private:
  /// The file of a camera says what its counts are; each key of the sensor file comes first.
  void take_stated(const mtf::io::SensorConfig& config, const mtf::io::Scene& scene) {
    std::string left_out;
    const auto stated = stated_camera(scene.info.attributes);
    if (stated) {
      assumed_ = stated->assumed();
      left_out = stated->left_out;
      if (!counts_) counts_ = stated->camera;
      const mtf::SettingsTable* table = find_table(config.tables, "scene");
      const bool own_emissivity = table != nullptr && table->find("emissivity") != nullptr;
      if (!scene_.surroundings_k && (!own_emissivity || stated->told.surroundings_k > 0.0))
        scene_.surroundings_k = stated->told.surroundings_k;
      if (!own_emissivity) {
        left_out += stated->no_emissivity;
        scene_.emissivity.number = stated->told.emissivity;
        emissivity_ = radiometry::constant_spectrum("the file's", stated->told.emissivity);
      }
    }
    assumed_.emissivity = scene_.emissivity.number;
    assumed_.reflected_k = scene_.surroundings_k.value_or(0.0);
    if (stated)
      note_ = "counts are temperatures by " +
              std::string(settings_.counts ? "[camera_counts]" : "the constants of the camera in the file") + " with " +
              thermometry_words(assumed_) +
              "; [camera_counts], and emissivity and surroundings of [scene], each override the file" + left_out;
  }

  /// Counts become the temperatures of the surfaces themselves.
  void to_temperature(mtf::Image& image) const {
    if (!counts_)
      throw mtf::UsageError(file_ +
                            ": a scene of counts needs [camera_counts] with the constants of the camera that wrote "
                            "it, or [scene] quantity and gain that make a radiance or temperature of them");
    require_camera(file_, *counts_);
    temperature_of_counts(image.view(), *counts_, assumed_, options_.threads);
  }

  /// Weighted radiance of a blackbody.
  double black(double temperature_k) const {
    return temperature_k > 0.0 ? scene_radiance(loaded_.sensor.curves, {.temperature_k = temperature_k}, {}) : 0.0;
  }

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
  std::optional<radiometry::CountCamera> counts_;
  radiometry::Thermometry assumed_;  ///< of counts
  radiometry::Spectrum emissivity_;
  std::string note_;
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
  throw mtf::UsageError(file + ": the sensor makes one image of one channel, the scene has " +
                        std::to_string(scene.names.size()) + " (" + joined(scene.names) +
                        "); choose one with --channel");
}

/// Channels of a spectrum become their sum, weighted. Returns what of the band they leave open, in words, or "".
std::string merge_spectrum(mtf::io::Scene& scene, const Converter& convert, int threads) {
  const radiometry::ChannelWeights weights = channel_weights(convert.band(), scene.wavelength_um);
  std::vector<mtf::ImageView<const float>> channels;
  for (const mtf::Image& plane : scene.planes) channels.push_back(plane.view());
  radiometry::radiance_of_channels(channels, weights.weight, scene.planes.front().view(),
                                   {.negative = convert.scene().negative, .threads = threads});
  scene.planes.resize(1);
  scene.names = {"spectrum"};
  const radiometry::Interval all = radiometry::BandResponse(convert.band().band, convert.band().curves).range();
  if (weights.used.lo_um <= all.lo_um * (1.0 + 1e-9) && weights.used.hi_um >= all.hi_um * (1.0 - 1e-9)) return "";
  return "the channels of the spectrum hold light of " + describe(weights.used) + ", and all other light of " +
         describe(all) + ", which the sensor would see, counts as 0; give channels up to these ends, or narrow [band]";
}

constexpr double kSeen = 1e-4;  // of an MTF: below that nobody sees the difference

using Values = std::vector<mtf::Complex<double>>;

/// Along both axes, at the Nyquist frequency and its half, quarter and eighth.
Values otf_values(mtf::System<double> system, std::shared_ptr<const mtf::ElectronRate> rate) {
  if (system.band) system.band->rate = std::move(rate);
  Values all;
  for (const double angle_deg : {0.0, 90.0}) {
    const Values along =
        otf_curves(system, {0.0625, 0.125, 0.25, 0.5}, make_direction(system.frame, "cy/px", angle_deg)).system.otf;
    all.insert(all.end(), along.begin(), along.end());
  }
  return all;
}

double largest_difference(const Values& a, const Values& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::abs(std::hypot(a[i].re, a[i].im) - std::hypot(b[i].re, b[i].im)));
  return most;
}

std::string kilometres(double m) { return significant(1e-3 * m, 3) + " km"; }

}  // namespace

SceneLight to_light(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, mtf::io::Scene& scene,
                    const SceneSource& source, int threads) {
  require_own_light(config, loaded, scene, source.file);
  const Converter convert(config, loaded, scene, threads);
  const mtf::Image emissivity = channel_of(source, convert.scene().emissivity_channel.name, "emissivity_channel");
  const mtf::Image range_m = channel_of(source, convert.scene().depth_channel.name, "depth_channel");
  const bool spectrum = !scene.wavelength_um.empty();
  if (!spectrum) require_one_channel(scene, source.file);
  const std::string open = spectrum ? merge_spectrum(scene, convert, threads) : "";
  mtf::Image& plane = scene.planes.front();
  const std::string clipped =
      scene.quantity == Quantity::counts
          ? clipped_counts(scene.info, scene.names.front(), std::as_const(plane).view(), scene.scaling)
          : "";
  const bool ranged = static_cast<bool>(loaded.paths);
  if (!spectrum && !(ranged && convert.is_of_surfaces())) convert.to_radiance(plane, emissivity);
  SceneLight light;
  if (ranged) {
    light = convert.through_paths(plane, emissivity, range_m);
    if (spectrum)
      light.warnings.emplace_back(
          "scene.depth_channel: the air takes from the sum of the spectral channels what it takes from light that is "
          "even over the band, not from each channel its own; this is not in the promised error");
  } else {
    convert.add_path(plane);
  }
  for (const std::string& text : {open, clipped})
    if (!text.empty()) light.warnings.push_back(source.file + ": " + text);
  if (!convert.note().empty()) light.warnings.push_back(source.file + ": " + convert.note());
  if (config.scene.border != mtf::Border::constant) return light;
  if (ranged)
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

std::string spectrum_warning(const mtf::System<double>& system, const std::vector<double>& wavelength_um, bool merged) {
  if (wavelength_um.empty()) return "";
  std::array ends{wavelength_um.front(), wavelength_um.back()};
  const Values used = otf_values(system, system.band ? system.band->rate : nullptr);
  double most = 0.0;
  for (double& end_um : ends) {
    if (merged) end_um = std::clamp(end_um, system.band->lo_um, system.band->hi_um);
    mtf::System<double> alone = system;
    alone.band = mtf::Band{end_um * (1.0 - 1e-6), end_um * (1.0 + 1e-6)};
    most = std::max(most, largest_difference(otf_values(std::move(alone), nullptr), used));
  }
  if (most <= kSeen) return "";
  return "all channels of the spectrum are filtered by one OTF, that of " +
         std::string(system.band ? "[band]" : "optics.wavelength") + "; at " + significant(ends[0], 6) + " um and " +
         significant(ends[1], 6) + " um alone the MTF differs from it by up to " + significant(most, 2) +
         ", which is not in the promised error";
}

std::string source_warning(const mtf::System<double>& system, const LoadedSensor& loaded, Quantity of_file) {
  LoadedSensor own = loaded;
  own.source_k = source_temperature_k(loaded.sensor.settings, of_file);
  if (!system.band || own.source_k == loaded.source_k) return "";
  const double most = largest_difference(otf_values(system, system.band->rate),
                                         otf_values(system, electron_rate(system, own, loaded.sensor.path)));
  if (most <= kSeen) return "";
  const auto light = [](const std::optional<double>& source_k) {
    return source_k ? "of a blackbody of " + significant(*source_k, 6) + " K" : std::string("of an even spectrum");
  };
  return "the OTF is the mean over [band] for light " + light(loaded.source_k) +
         ", as [scene] quantity of the sensor file has it; for light " + light(own.source_k) +
         ", as the scene's own quantity has it, the MTF differs from it by up to " + significant(most, 2) +
         "; write quantity = \"" + std::string(mtf::io::quantity_name(of_file)) + "\" there";
}

RangeWeights range_weights(const mtf::System<double>& system, const LoadedSensor& loaded, const PixelRanges& ranges) {
  // Pixels are float32, and the last may be rounded beyond the table.
  const auto rate_at = [&](double range_m) {
    return electron_rate(system, loaded, ranges.paths->at(std::min(range_m, ranges.paths->range_m().back())));
  };
  RangeWeights weights;
  try {
    weights.rate = rate_at(ranges.middle_m);
  } catch (const mtf::UsageError&) {
    weights.warning = "scene.depth_channel: no light gets through " + kilometres(ranges.middle_m) +
                      " of air, the middle of the ranges: the OTF of the band is that without air";
    return weights;
  }
  if (!weights.rate || ranges.nearest_m == ranges.longest_m) return weights;
  const Values middle = otf_values(system, weights.rate);
  double most = 0.0;
  for (const double end_m : {ranges.nearest_m, ranges.longest_m}) try {
      most = std::max(most, largest_difference(otf_values(system, rate_at(end_m)), middle));
    } catch (const mtf::UsageError&) {  // opaque: there is no image at that range
    }
  if (most > kSeen)
    weights.warning = "scene.depth_channel: all pixels are filtered by the OTF of the band behind " +
                      kilometres(ranges.middle_m) + " of air, the middle of the ranges; at " +
                      kilometres(ranges.nearest_m) + " and " + kilometres(ranges.longest_m) +
                      " the MTF differs from it by up to " + significant(most, 2) +
                      ", which is not in the promised error";
  return weights;
}

}  // namespace apps
