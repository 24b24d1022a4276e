// SPDX-License-Identifier: Apache-2.0

// Plans at their extremes, against slow sums in double. Errors are rms over the output pixels, relative to the standard
// deviation of the scene; the error allowed is the one that the plan itself predicted.

#include "apps/check/check_engine.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "apps/check/check.h"
#include "mtf/engines/statistics.h"
#include "mtf/plan/plan.h"

namespace apps::check {
namespace {

using mtf::Border;
using mtf::Component;
using mtf::Image;
using mtf::SampleGrid;
using mtf::System;

constexpr std::array kBorders{Border::reflect, Border::replicate, Border::constant, Border::periodic};
constexpr double kPitchXUm = 15.0, kPitchYUm = 12.0;

/// A detector with nothing in front of it.
System<double> bare() {
  System<double> system;
  system.frame = {100.0, kPitchXUm, kPitchYUm, 0.01, 0, 0};
  system.optics.f_number = 2.0;
  system.optics.wavelength_um = 4.0;
  return system;
}

/// A component whose first size or frequency is given.
Component<double> make(std::string_view kind, double value, const char* unit) {
  auto component = Component<double>::make(kind);
  for (const auto& field : component.fields()) {
    if (auto* const* size = std::get_if<mtf::AxisPair<double>*>(&field.value)) {
      **size = {{value, mtf::find_unit(unit)}, {}, false};
      return component;
    }
    if (auto* const* frequency = std::get_if<mtf::SpatialFrequency<double>*>(&field.value)) {
      **frequency = {value, mtf::find_unit(unit)};
      return component;
    }
  }
  return component;
}

System<double> with(std::initializer_list<Component<double>> components, System<double> system = bare()) {
  for (const Component<double>& component : components) system.add(mtf::Stage::presample, component);
  return system;
}

/// Noise of zero mean and unit variance, the same on every machine.
double noise(std::int64_t x, std::int64_t y) {
  std::uint64_t z = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15U + static_cast<std::uint64_t>(y) + 1U;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;  // SplitMix64 (Steele, Lea, Flood 2014)
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  z ^= z >> 31U;
  return (static_cast<double>(z >> 11U) * 0x1p-53 - 0.5) * std::sqrt(12.0);
}

SampleGrid grid_of(const Image& scene, double ratio) {
  return {scene.width(), scene.height(), kPitchXUm / std::min(ratio, static_cast<double>(scene.width())),
          kPitchYUm / std::min(ratio, static_cast<double>(scene.height()))};
}

std::string describe(const Image& scene, double ratio, Border border) {
  return std::to_string(scene.width()) + " x " + std::to_string(scene.height()) + " samples, " +
         mtf::format_double(ratio) + " a pixel, " + std::string(mtf::kBorderNames[static_cast<std::size_t>(border)]);
}

/// Compiles for this scene; a tolerance below what float32 can keep here is replaced by the one that the refusal names.
/// Nothing when the values themselves are coarse against the contrast, so that there is no tolerance to keep, and for
/// what the device that is checked cannot do.
std::optional<mtf::Plan> compile_reachable(const System<double>& system, const SampleGrid& in,
                                           mtf::PlanOptions options) {
  const SampleGrid out = mtf::detector_grid(system, in);
  try {
    return mtf::compile(system, in, out, options);
  } catch (const mtf::UnreachableTolerance& refusal) {
    if (!(refusal.reachable() < 1.0)) return std::nullopt;
    options.tolerance = refusal.reachable();
    return mtf::compile(system, in, out, options);
  } catch (const mtf::UsageError&) {
    if (!options.device.device) throw;
    return std::nullopt;
  }
}

mtf::PlanOptions options_for(const Image& scene, Border border, double level, const mtf::DeviceChoice& device = {}) {
  mtf::PlanOptions options;
  options.device = device;
  if (device.device) options.method = mtf::Method::fft_device;
  options.border = border;
  options.scene = mtf::summarise(scene.view(), border, level);
  options.threads = 1;
  return options;
}

/// rms distance, infinity when a pixel is not finite.
double rms_error(const Image& image, const std::vector<double>& exact, double offset = 0.0) {
  double squares = 0.0;
  for (std::int64_t i = 0; i < image.size(); ++i) {
    const double pixel = static_cast<double>(image.data()[i]) + offset;
    if (!std::isfinite(pixel)) return std::numeric_limits<double>::infinity();
    squares += std::pow(pixel - exact[static_cast<std::size_t>(i)], 2);
  }
  return std::sqrt(squares / static_cast<double>(image.size()));
}

void keeps_promise(Tally& tally, const System<double>& system, const Image& scene, double ratio, Border border) {
  check::keeps_promise(tally, system, scene, ratio, border, otf_of(system, mtf::Stage::presample));
}

/// A scene of one value comes out as that value, every pixel, bit by bit.
void stays_flat(Tally& tally, const System<double>& system, std::int64_t width, std::int64_t height, double ratio,
                Border border, float value) {
  Image scene(width, height);
  std::fill_n(scene.data(), scene.size(), value);
  const SampleGrid in = grid_of(scene, ratio);
  const mtf::Plan plan = mtf::compile(system, in, mtf::detector_grid(system, in), options_for(scene, border, value));
  Image image(plan.out().width, plan.out().height);
  plan.run(scene.view(), image.view(), static_cast<double>(value), 1);
  for (std::int64_t i = 0; i < image.size(); ++i)
    tally.compare(static_cast<double>(image.data()[i]), value, 0.0L, describe(scene, ratio, border));
}

using Size = std::array<std::int64_t, 2>;
constexpr std::array<Size, 17> kSizes{{{1, 1},
                                       {1, 2},
                                       {2, 1},
                                       {2, 3},
                                       {3, 3},
                                       {5, 2},
                                       {7, 7},
                                       {13, 5},
                                       {1, 31},
                                       {31, 31},
                                       {61, 13},
                                       {127, 1},
                                       {127, 3},
                                       {251, 2},
                                       {2, 251},
                                       {61, 61},
                                       {127, 31}}};

void sizes(const Tables&, Tally& tally) {
  for (const auto& [width, height] : kSizes)
    for (const Border border : kBorders)
      for (const double ratio : {1.0, 2.0, 3.7})
        if (ratio == 2.0 || width * height < 500)
          keeps_promise(tally, optics(), noisy(width, height, 1.0), ratio, border);
  keeps_promise(tally, optics(), noisy(251, 127, 1.0), 2.0, Border::periodic);
}

void flat_sizes(const Tables&, Tally& tally) {
  for (const auto& [width, height] : kSizes)
    for (const Border border : kBorders)
      for (const double ratio : {1.0, 2.0, 3.7})
        for (const float value : {0.1F, -7.3e6F}) stays_flat(tally, optics(), width, height, ratio, border, value);
}

constexpr std::array kScales{1e-30, 1e-20, 1e-10, 1.0, 1e10, 1e20, 1e30};

/// A device takes whole pixels alone.
std::int64_t columns(const Tally& tally) { return tally.device.device ? 32 : 31; }

void scales(const Tables&, Tally& tally) {
  for (const double scale : kScales)
    for (const Border border : kBorders)
      keeps_promise(tally, optics(), noisy(columns(tally), 18, 3.0 * scale, scale), 2.0, border);
}

void flat_scales(const Tables&, Tally& tally) {
  for (const double scale : kScales)
    for (const Border border : kBorders) stays_flat(tally, optics(), 31, 18, 2.0, border, static_cast<float>(scale));
}

// float32 has no room for 1e6 (1 + 1e-12): the samples are equal, and have to stay so.
void flat_contrast(const Tables&, Tally& tally) {
  for (const Border border : kBorders) {
    const Image scene = noisy(31, 18, 1e6, 1e-6);
    const SampleGrid in = grid_of(scene, 2.0);
    const mtf::Plan plan =
        mtf::compile(optics(), in, mtf::detector_grid(optics(), in), options_for(scene, border, 1e6));
    Image image(plan.out().width, plan.out().height);
    plan.run(scene.view(), image.view(), 1e6, 1);
    for (std::int64_t i = 0; i < image.size(); ++i)
      tally.compare(static_cast<double>(image.data()[i]), 1e6L, 0.0L, describe(scene, 2.0, border));
  }
}

// The same contrast in double: the mean apart, the rest through the plan, both joined in double. The sums of
// the reference round the mean itself.
void double_contrast(const Tables&, Tally& tally) {
  constexpr double mean = 1e6, contrast = 1e-6;
  const auto scene = [&](std::int64_t x, std::int64_t y) { return mean + contrast * noise(x, y); };
  for (const Border border : kBorders) {
    Image rest(columns(tally), 18);
    for (std::int64_t y = 0; y < rest.height(); ++y)
      for (std::int64_t x = 0; x < rest.width(); ++x) rest.at(x, y) = static_cast<float>(scene(x, y) - mean);
    const SampleGrid in = grid_of(rest, 2.0);
    const mtf::PlanOptions options = options_for(rest, border, 0.0, tally.device);
    const auto made = compile_reachable(optics(), in, options);
    if (!made && tally.device.device) continue;
    const mtf::Plan& plan = made.value();
    Image image(plan.out().width, plan.out().height);
    plan.run(rest.view(), image.view(), 0.0, 1);
    const mtf::System<double> system = optics();
    const auto exact = reference_image(scene, in, plan.out(), otf_of(system, mtf::Stage::presample), border, mean);
    const double std = options.scene->std;
    tally.error(rms_error(image, exact, plan.dc() * mean) / std, 1.0L,
                plan.report().predicted.total() + 64.0 * 0x1p-53 * mean / std, describe(rest, 2.0, border));
  }
}

void over_borders(Tally& tally, const System<double>& system) {
  for (const Border border : kBorders)
    for (const double ratio : {2.0, 3.7}) keeps_promise(tally, system, noisy(32, 24, 5.0), ratio, border);
}

void zero_nearly_everywhere(const Tables&, Tally& tally) {
  System<double> slow = bare();
  slow.optics.f_number = 5000.0;  // cutoff 0.05 cy/mm, far below the first frequency of the scene
  over_borders(tally, with({Component<double>::make("diffraction")}, slow));
  over_borders(tally, with({make("rc_lowpass", 1e-6, "cy/mm")}));
  over_borders(tally, with({make("gaussian", 1e6, "um")}));
}

void huge_jitter(const Tables&, Tally& tally) {
  over_borders(tally, with({make("jitter", 1000.0, "px")}));
  over_borders(tally, with({Component<double>::make("diffraction"), make("jitter", 1000.0, "px")}));
}

void wavelengths(const Tables&, Tally& tally) {
  for (const double wavelength_um : {0.2, 0.55, 4.0, 12.0, 100.0, 1000.0}) {
    System<double> system = bare();
    system.optics.wavelength_um = wavelength_um;
    over_borders(tally, with({Component<double>::make("diffraction")}, system));
    system.optics.obscuration = 0.35;
    over_borders(tally, with({Component<double>::make("diffraction")}, system));
  }
}

// On a periodic canvas sampled at its own step the mean of the output is the mean of the input. A pixel is rounded to
// float32 by half an ulp of its value.
void means(const Tables&, Tally& tally) {
  for (const double mean : {0.0, 1.0, -1e3, 1e6})
    for (const auto& [width, height] : kSizes) {
      const Image scene = noisy(width, height, mean);
      const SampleGrid in = grid_of(scene, 1.0);
      const auto options = options_for(scene, Border::periodic, 0.0, tally.device);
      if (!options.scene) continue;
      const auto plan = compile_reachable(optics(), in, options);
      if (!plan) continue;
      Image image(plan->out().width, plan->out().height);
      plan->run(scene.view(), image.view(), 0.0, 1);
      const double expected = plan->dc() * mtf::statistics(scene.view()).mean;
      tally.compare(mtf::statistics(image.view()).mean, expected, 0x1p-24 * options.scene->largest,
                    describe(scene, 1.0, Border::periodic));
    }
}

}  // namespace

System<double> optics() {
  return with(
      {Component<double>::make("diffraction"), make("footprint", 12.0, "um"), make("rc_lowpass", 40.0, "cy/mm")});
}

Image noisy(std::int64_t width, std::int64_t height, double mean, double std) {
  Image image(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) image.at(x, y) = static_cast<float>(mean + std * noise(x, y));
  return image;
}

void keeps_promise(Tally& tally, const System<double>& system, const Image& scene, double ratio, Border border,
                   const Otf& exact) {
  const SampleGrid in = grid_of(scene, ratio);
  const double level = mtf::statistics(scene.view()).mean;
  const mtf::PlanOptions options = options_for(scene, border, level, tally.device);
  if (!options.scene) return;
  const auto plan = compile_reachable(system, in, options);
  if (!plan) return;
  Image image(plan->out().width, plan->out().height);
  plan->run(scene.view(), image.view(), level, 1);
  const double rms = rms_error(image, reference_image(scene, in, plan->out(), exact, border, level));
  tally.error(rms / options.scene->std, 1.0L, plan->report().predicted.total(), describe(scene, ratio, border));
}

std::vector<Check> engine_checks(const mtf::DeviceChoice& device) {
  const std::string promise = "rms <= predicted, of the scene's std", exact = "equal bits";
  std::vector<Check> checks{
      {"engine", "sizes 1 x 1 to primes", promise, sizes},
      {"engine", "flat, sizes 1 x 1 to primes", exact, flat_sizes},
      {"engine", "radiance 1e-30 to 1e30", promise, scales},
      {"engine", "flat, radiance 1e-30 to 1e30", exact, flat_scales},
      {"engine", "contrast 1e-12 on 1e6, float32", exact, flat_contrast},
      {"engine", "contrast 1e-12 on 1e6, double", "rms <= predicted + 64 x 2^-53 mean / std", double_contrast},
      {"engine", "OTF zero nearly everywhere", promise, zero_nearly_everywhere},
      {"engine", "jitter of 1000 px", promise, huge_jitter},
      {"engine", "wavelength 0.2 um to 1 mm", promise, wavelengths},
      {"engine", "mean", "half an ulp of float32 at the largest value", means}};
  if (!device.device) return checks;
  std::erase_if(checks,
                [&](const Check& check) { return check.promise == exact; });  // flat scenes: no plan filters them
  for (Check& check : checks) {
    check.component += ", " + device.device->info().id;
    check.run = [device, run = std::move(check.run)](const Tables& tables, Tally& tally) {
      tally.device = device;
      run(tables, tally);
    };
  }
  return checks;
}

}  // namespace apps::check
