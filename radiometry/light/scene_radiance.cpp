// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/scene_radiance.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <mutex>

#include "radiometry/light/constants.h"
#include "radiometry/light/pixel_rules.h"

namespace radiometry {
namespace {

using mtf::format_double;
using mtf::UsageError;
using Plane = mtf::ImageView<const float>;

/// The product of R and further curves.
BandResponse response_with(const SceneBand& scene, std::initializer_list<Spectrum> more) {
  std::vector<Spectrum> curves = scene.curves;
  curves.insert(curves.end(), more.begin(), more.end());
  return {scene.band, curves};
}

/// NaN is not below 0.
float not_negative(float value) { return value < 0.0F ? 0.0F : value; }

void check_negative(Plane plane, const std::string& what, const std::string& unit, const PlaneOptions& options) {
  if (options.negative == Negative::clamp) return;
  refuse_pixels(plane, {what, "below 0" + unit, "correct the scene, or have such pixels taken as 0"}, options.threads,
                [](float value) { return value < 0.0F; });
}

void require_surroundings(double surroundings_k) {
  if (!(surroundings_k >= 0.0) || !std::isfinite(surroundings_k))
    throw UsageError("surroundings of " + format_double(surroundings_k) + " K; a temperature is 0 or above, in kelvin");
}

/// Lowest and highest of the finite temperatures above 0; lowest above highest when there is none.
std::pair<float, float> warm_range(Plane plane, int threads) {
  std::mutex joining;
  float lowest = std::numeric_limits<float>::infinity(), highest = 0.0F;
  mtf::parallel_for(plane.height, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    float lo = std::numeric_limits<float>::infinity(), hi = 0.0F;
    for (std::int64_t y = begin; y < end; ++y) {
      const float* row = plane.row(y);
      for (std::int64_t x = 0; x < plane.width; ++x) {
        const bool warm = row[x] > 0.0F && row[x] <= std::numeric_limits<float>::max();
        lo = std::min(lo, warm ? row[x] : lo);
        hi = std::max(hi, warm ? row[x] : hi);
      }
    }
    const std::lock_guard lock(joining);
    lowest = std::min(lowest, lo);
    highest = std::max(highest, hi);
  });
  return {lowest, highest};
}

/// The hat that is 1 at channel i and 0 at its neighbours; one channel is a constant.
Spectrum hat(std::span<const double> wavelength_um, std::size_t i) {
  if (wavelength_um.size() == 1) return constant_spectrum("channel", 1.0);
  Spectrum spectrum{"channel", {}, {}};
  for (std::size_t j = i == 0 ? 0 : i - 1; j <= std::min(i + 1, wavelength_um.size() - 1); ++j) {
    spectrum.wavelength_um.push_back(wavelength_um[j]);
    spectrum.value.push_back(j == i ? 1.0 : 0.0);
  }
  return spectrum;
}

/// The samples of a curve from the last one before the interval to the first one after it.
Spectrum around(const Spectrum& spectrum, const Interval& interval) {
  const std::vector<double>& w = spectrum.wavelength_um;
  if (w.size() == 1) return spectrum;
  const auto after = std::upper_bound(w.begin(), w.end(), interval.lo_um) - w.begin();
  const auto last = std::lower_bound(w.begin(), w.end(), interval.hi_um) - w.begin();
  const auto begin = std::max<std::ptrdiff_t>(after - 1, 0);
  const auto end = std::min(last + 1, std::ssize(w));
  return {spectrum.source,
          {w.begin() + begin, w.begin() + end},
          {spectrum.value.begin() + begin, spectrum.value.begin() + end}};
}

/// integral(scene around the channel, hat) for each channel: each reads no more of the curves than it needs.
template <class Integral>
ChannelWeights weights_of(const SceneBand& scene, std::span<const double> wavelength_um, Integral integral) {
  const Spectrum all = make_spectrum("spectral channels", {wavelength_um.begin(), wavelength_um.end()},
                                     std::vector<double>(wavelength_um.size(), 1.0));
  ChannelWeights weights{{}, response_with(scene, {all}).range()};
  for (std::size_t i = 0; i < wavelength_um.size(); ++i) {
    const Spectrum own = hat(wavelength_um, i);
    const Interval range = range_of(own);
    SceneBand near{
        {std::max(range.lo_um, weights.used.lo_um), std::min(range.hi_um, weights.used.hi_um)}, {}, scene.flux};
    const bool seen = near.band.hi_um > near.band.lo_um;
    if (seen)
      for (const Spectrum& curve : scene.curves) near.curves.push_back(around(curve, near.band));
    weights.weight.push_back(seen ? integral(near, own) : 0.0);
  }
  return weights;
}

/// Mean wavelength in um of light that is even over the band: photons, of which it is the harmonic mean, or watts.
double mean_wavelength_um(Flux even, const Interval& band) {
  if (even == Flux::watts) return 0.5 * (band.lo_um + band.hi_um);
  return (band.hi_um - band.lo_um) / std::log1p((band.hi_um - band.lo_um) / band.lo_um);
}

}  // namespace

SceneBand scene_band(const SpectralCamera& camera) {
  SceneBand scene{camera.band, camera.optics, camera.flux};
  scene.curves.insert(scene.curves.end(), camera.cold_filter.begin(), camera.cold_filter.end());
  scene.curves.insert(scene.curves.end(), camera.quantum_efficiency.begin(), camera.quantum_efficiency.end());
  return scene;
}

SceneBand scene_band(const SpectralCamera& camera, const Path& path) {
  SceneBand scene = scene_band(camera);
  scene.curves.push_back(path.transmission);
  return scene;
}

double weighted_path_radiance(const SpectralCamera& camera, const Path& path) {
  return band_radiances(camera, {.temperature_k = 0.0}, path, {}).path;
}

TemperatureRadiance::TemperatureRadiance(const SceneBand& scene, const Spectrum& emissivity, double surroundings_k,
                                         double lo_k, double hi_k)
    : table_(response_with(scene, {emissivity}), lo_k, hi_k, scene.flux) {
  require_surroundings(surroundings_k);
  reflected_ = response_with(scene, {complement(emissivity)}).radiance(scene.flux, surroundings_k);
}

void TemperatureRadiance::apply(mtf::ImageView<float> plane, int threads) const {
  for_each_pixel(plane, threads, [&](float t) { return static_cast<float>(table_(t) + reflected_); });
}

void radiance_of_temperature(mtf::ImageView<float> plane, const SceneBand& scene, const SurfaceFinish& finish,
                             const PlaneOptions& options) {
  require_surroundings(finish.surroundings_k);
  check_negative(plane, "temperature", " K", options);
  const auto [lowest, highest] = warm_range(plane, options.threads);
  const double lo = lowest <= highest ? static_cast<double>(lowest) : 0.0, hi = static_cast<double>(highest);

  if (finish.plane.data == nullptr) {
    TemperatureRadiance(scene, finish.emissivity, finish.surroundings_k, lo, hi).apply(plane, options.threads);
    return;
  }
  require_size_of(plane, finish.plane, "emissivity");
  refuse_pixels(finish.plane, {"emissivity", "outside 0 to 1", "correct the plane; is it in percent?"}, options.threads,
                [](float value) { return !(value >= 0.0F && value <= 1.0F); });
  const BandResponse response = response_with(scene, {});
  const RadianceTable table(response, lo, hi, scene.flux);
  const double surroundings = response.radiance(scene.flux, finish.surroundings_k);
  for_each_pixel(plane, finish.plane, options.threads, [&](float t, float emissivity) {
    const auto e = static_cast<double>(emissivity);
    return static_cast<float>(e * table(t) + (1.0 - e) * surroundings);
  });
}

double light_per_radiance(Flux given, const SceneBand& scene, std::optional<double> source_k) {
  const BandResponse response = response_with(scene, {});
  const Interval& band = scene.band;
  if (!source_k) {
    const double of_same = response.integral() / (band.hi_um - band.lo_um);
    if (given == scene.flux) return of_same;
    const double mean_um = mean_wavelength_um(scene.flux, band);
    return given == Flux::watts ? of_same * mean_um / kPhotonEnergy_j_um : of_same * kPhotonEnergy_j_um / mean_um;
  }
  const double whole = band_radiance(given, band.lo_um, band.hi_um, *source_k);
  const double seen = response.radiance(scene.flux, *source_k);
  if (!(whole >= std::numeric_limits<double>::min()) || !std::isfinite(whole) || !std::isfinite(seen))
    throw UsageError("source_temperature of " + format_double(*source_k) + " K: its radiance in the band " +
                     describe(band) + " is " + format_double(whole) +
                     ", no shape of a spectrum; give the temperature of what is in the scene, or none");
  return seen / whole;
}

ChannelWeights channel_weights(const SceneBand& scene, std::span<const double> wavelength_um) {
  const bool photons = scene.flux == Flux::photons;
  const Spectrum per_joule =
      photons ? photons_per_joule(response_with(scene, {}).range()) : constant_spectrum("watts", 1.0);
  return weights_of(scene, wavelength_um, [&](const SceneBand& near, const Spectrum& own) {
    return response_with(near, {own, per_joule}).integral();
  });
}

ChannelWeights shape_weights(const SceneBand& scene, std::span<const double> wavelength_um,
                             std::optional<double> source_k) {
  return weights_of(scene, wavelength_um, [&](const SceneBand& near, const Spectrum& own) {
    const BandResponse response = response_with(near, {own});
    return source_k ? response.radiance(scene.flux, *source_k) : response.integral();
  });
}

void radiance_of_band(mtf::ImageView<float> plane, double factor, const PlaneOptions& options) {
  check_negative(plane, "radiance", "", options);
  for_each_pixel(plane, options.threads,
                 [&](float value) { return static_cast<float>(factor * static_cast<double>(not_negative(value))); });
}

void radiance_of_channels(std::span<const Plane> channels, std::span<const double> weight, mtf::ImageView<float> out,
                          const PlaneOptions& options) {
  if (channels.size() != weight.size())
    throw UsageError(std::to_string(channels.size()) + " spectral planes and " + std::to_string(weight.size()) +
                     " weights; give one for each");
  for (const Plane& channel : channels) {
    require_size_of(out, channel, "spectral plane");
    check_negative(channel, "spectral radiance", "", options);
  }
  mtf::parallel_for(out.height, kRowsAtOnce, options.threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<double> sum(static_cast<std::size_t>(out.width));
    for (std::int64_t y = begin; y < end; ++y) {
      std::fill(sum.begin(), sum.end(), 0.0);
      for (std::size_t i = 0; i < channels.size(); ++i) {
        if (weight[i] == 0.0) continue;
        const float* row = channels[i].row(y);
        for (std::size_t x = 0; x < sum.size(); ++x) sum[x] += weight[i] * static_cast<double>(not_negative(row[x]));
      }
      std::transform(sum.begin(), sum.end(), out.row(y), [](double value) { return static_cast<float>(value); });
    }
  });
}

}  // namespace radiometry
