// SPDX-License-Identifier: Apache-2.0
#include "radiometry/chain.h"

#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/chain_impl.h"

namespace radiometry {
namespace {

std::uint64_t seed_of(const SensorSettings& settings) {
  return settings.noise ? static_cast<std::uint64_t>(settings.noise->seed) : 0;
}

/// The part of a map of the whole detector that an image at `origin` has.
mtf::Image crop(const mtf::Image& map, const char* what, Origin origin, std::int64_t width, std::int64_t height) {
  if (map.width() < origin.x + width || map.height() < origin.y + height)
    throw mtf::UsageError(std::string(what) + ": the map has " + std::to_string(map.width()) + "x" +
                          std::to_string(map.height()) + " pixels, the image needs " +
                          std::to_string(origin.x + width) + "x" + std::to_string(origin.y + height) +
                          "; give a map of the whole detector");
  mtf::Image part(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    std::copy_n(map.data() + (origin.y + y) * map.width() + origin.x, width, part.data() + y * width);
  return part;
}

/// factor x map, as a map.
Factor scaled(double factor, const mtf::Image& map, double added) {
  Factor result{factor, mtf::Image(map.width(), map.height())};
  for (std::int64_t i = 0; i < map.size(); ++i)
    result.map.data()[i] = static_cast<float>(factor * static_cast<double>(map.data()[i]) + added);
  return result;
}

}  // namespace

Camera<double> camera_of(const mtf::System<double>& system, const Sensor& sensor) {
  const mtf::Context<double> context = system.context();
  Camera<double> camera{.f_number = mtf::f_number_of<double>({}, context),
                        .obscuration = mtf::obscuration_of<double>({}, context)};
  if (!(camera.f_number > 0.0))
    throw mtf::UsageError("optics.f_number: missing; electrons need it: write f_number or aperture in [optics]");
  if (const auto& optics = sensor.settings.optics) {
    if (optics->transmission.file.empty()) camera.transmission = optics->transmission.number;
    if (optics->cold_transmission.file.empty()) camera.cold_transmission = optics->cold_transmission.number;
    camera.optics_emissivity = optics->emissivity;
    camera.obscuration_emissivity = optics->obscuration_emissivity;
    camera.stop_emissivity = optics->stop_emissivity;
  }
  require_valid("optics", camera);
  return camera;
}

Pixel<double> pixel_of(const mtf::System<double>& system, const Sensor& sensor) {
  const auto& detector = sensor.settings.detector;
  if (!detector) throw mtf::UsageError("[detector]: missing; electrons need it");
  if (!(system.frame.integration_time_s > 0.0))
    throw mtf::UsageError("frame.integration_time: missing; [detector] needs it, for example \"10 ms\"");
  Pixel<double> pixel{.width_um = detector->width_um.value_or(system.frame.pitch_x_um),
                      .height_um = detector->height_um.value_or(system.frame.pitch_y_um),
                      .integration_s = system.frame.integration_time_s,
                      .dark_e_s = detector->dark_e_s,
                      .full_well_e = detector->full_well_e};
  if (detector->quantum_efficiency.file.empty()) pixel.quantum_efficiency = detector->quantum_efficiency.number;
  require_valid("detector", pixel);
  return pixel;
}

Adc adc_of(const Sensor& sensor) {
  const auto& adc = sensor.settings.adc;
  if (!adc) throw mtf::UsageError("[adc]: missing; counts need it");
  const double well = sensor.settings.detector ? sensor.settings.detector->full_well_e : mtf::kInfinity;
  if (!adc->electrons_per_count && !std::isfinite(well))
    throw mtf::UsageError(
        "adc.electrons_per_count: missing; give it, or detector.full_well, which then fills the range");
  Adc result = adc->electrons_per_count ? Adc{} : adc_for_well(well, adc->bits);
  if (adc->electrons_per_count) result.electrons_per_count = *adc->electrons_per_count;
  result.bits = adc->bits;
  result.offset_counts = adc->offset_counts;
  require_valid("adc", result);
  return result;
}

std::optional<double> adc_tolerance(const mtf::System<double>& system, const Sensor& sensor, double std) {
  if (!sensor.settings.adc || !(std > 0.0)) return std::nullopt;
  const double electrons = electrons_per_radiance(camera_of(system, sensor), pixel_of(system, sensor)) * std;
  const double tolerance = 0.1 * adc_of(sensor).electrons_per_count / electrons;
  return std::isfinite(tolerance) ? std::optional(std::min(tolerance, 1e-2)) : std::nullopt;
}

Chain::Chain(const mtf::SensorPlan& plan, const Sensor& sensor, Origin origin, int threads) {
  const mtf::System<double>& system = plan.system;
  const SensorSettings& settings = sensor.settings;
  const Camera<double> camera = camera_of(system, sensor);
  const Pixel<double> pixel = pixel_of(system, sensor);
  const mtf::SampleGrid& detector = plan.out();
  const int cores = mtf::threads_of(threads);
  require_on_detector(origin, detector.width, detector.height);
  const double gain = radiometry::electrons_per_radiance(camera, pixel);
  const OpticsSettings warm = settings.optics.value_or(OpticsSettings{});
  const BandRadiances<double> radiances =
      band_radiances(sensor.curves, {.temperature_k = 0.0}, {}, {warm.temperature_k, warm.stop_temperature_k});
  const Signal<double> background =
      signal(camera, pixel, {.scene = 0.0, .path = 0.0, .optics = radiances.optics, .stop = radiances.stop});

  auto impl = std::make_shared<Impl>(plan);
  impl->settings = settings;
  impl->origin = origin;
  impl->camera = camera;
  impl->pixel = pixel;
  if (settings.adc) impl->adc = adc_of(sensor);
  impl->background = background;

  const double lit = background.optics_e + background.stop_e;
  impl->light.number = gain;
  impl->glow.number = lit + background.dark_e;
  if (const auto& unequal = settings.nonuniformity) {
    mtf::Image map;
    if (sensor.responsivity) {
      map = crop(*sensor.responsivity, "nonuniformity.responsivity", origin, detector.width, detector.height);
    } else if (unequal->prnu > 0.0) {
      map = mtf::Image(detector.width, detector.height);
      responsivity_map(map.view(), unequal->prnu, seed_of(settings), origin, cores);
    }
    if (map.size() > 0) {
      impl->light = scaled(gain, map, 0.0);
      if (lit > 0.0) impl->glow = scaled(lit, map, background.dark_e);
    }
    if (sensor.offset) {
      impl->offset = crop(*sensor.offset, "nonuniformity.offset", origin, detector.width, detector.height);
    } else if (unequal->dsnu_e > 0.0) {
      impl->offset = mtf::Image(detector.width, detector.height);
      offset_map(impl->offset.view(), unequal->dsnu_e, seed_of(settings), origin, cores);
    }
  }
  if (settings.defects)
    impl->defects = find_defects(detector.width, detector.height, *settings.defects, seed_of(settings), origin);
  impl_ = std::move(impl);
}

Tap Chain::last() const {
  if (impl_->plan.post || impl_->settings.agc) return Tap::display;
  return impl_->adc ? Tap::dn : Tap::electrons;
}

std::string_view Chain::unit(Tap tap) const {
  if (tap == Tap::radiance) return "ph.s^-1.m^-2.sr^-1";
  if (tap == Tap::irradiance) return "ph.s^-1.m^-2";
  if (tap == Tap::display && impl_->settings.agc) return "levels";
  return tap == Tap::electrons || !impl_->adc ? "e-" : "counts";
}

double Chain::electrons_per_radiance() const { return impl_->light.number; }
const Signal<double>& Chain::background() const { return impl_->background; }

}  // namespace radiometry
