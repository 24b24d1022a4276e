// SPDX-License-Identifier: Apache-2.0

// From charge to counts, and what a camera does to its counts.

#include <algorithm>
#include <numeric>

#include "radiometry/chain/steps/stage_rows.h"

namespace radiometry {
namespace {

/// Where no flat frames can be made, a tenth of the scene or more may be saturated as well; the message names both.
std::shared_ptr<const TwoPoint> correction_of(const FrameRun& run) {
  try {
    return run.chain.correction(run.threads);
  } catch (const mtf::UsageError& refused) {
    const HeldPixels& held = run.frame.held;
    if (held.share() < 0.1) throw;
    throw mtf::UsageError(std::string(refused.what()) + ". The scene is saturated too: " + where_held(held));
  }
}

}  // namespace

std::span<const StageRow> count_rows() {
  using enum StageRow::Part;
  static constexpr StageRow kRows[] = {
      {.name = "adc",
       .part = conversion,
       .require = [](const System&, const Sensor& sensor) -> void {
         if (sensor.settings.adc) adc_of(sensor);
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         if (!sensor.settings.adc) return {false, "no [adc]"};
         const Adc adc = adc_of(sensor);
         return {true, std::to_string(adc.bits) + " bits, " + rounded(adc.electrons_per_count) + " " +
                           std::string(signal_unit(sensor)) + " a count"};
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         const Adc& adc = *run.chain.adc;
         const HeldCounter::Counts held = run.counter.run(
             electrons, [&](mtf::ImageView<float> values) { return digitise(values, adc, run.threads); });
         run.frame.adc.low += held.all.low;
         run.frame.adc.high += held.all.high;
         const auto add = [](HeldPixels& sum, const Clipped& clipped) {
           sum.least_count += clipped.low;
           sum.most_count += clipped.high;
         };
         add(run.frame.held, held.light());
         add(run.frame.held_defects, held.stuck);
       },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& electrons) -> void {
         const AdcScale scale = scale_of(*run.chain.adc);
         electrons.digitise(scale.counts_per_electron, scale.offset, scale.most);
       },
       .border = [](FrameRun& run) -> void {
         const Adc& adc = *run.chain.adc;
         run.border = std::clamp(run.border / adc.electrons_per_count + adc.offset_counts, 0.0, adc.most_counts());
       }},
      {.name = "correction",
       .part = correction,
       .whole_image = "refers to the mean of all pixels in flat frames",
       .require = [](const System&, const Sensor& sensor) -> void {
         const SensorSettings& s = sensor.settings;
         const auto& flats = s.correction;
         if (!flats) return;
         if (s.thermal && !(flats->cold_k && flats->hot_k && *flats->cold_k < *flats->hot_k))
           refuse("[correction]",
                  "its flat frames are those of two blackbodies, the second warmer than the first; give cold = \"10 "
                  "degC\" and hot = \"40 degC\", or remove it and give in [nonuniformity] what the camera's own "
                  "correction leaves");
         if (!s.thermal && !std::isfinite(s.detector->full_well_e))
           refuse("[correction]", "needs detector.full_well, of which low and high are parts");
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& flats = sensor.settings.correction;
         if (!flats) return {false, "no [correction]"};
         const std::string mean = ", mean of " + std::to_string(flats->frames);
         if (flats->cold_k && flats->hot_k)
           return {true, "two points, blackbodies at " + rounded(*flats->cold_k) + " K and " + rounded(*flats->hot_k) +
                             " K" + mean};
         return {true, "two points, flats at " + rounded(flats->low) + " and " + rounded(flats->high) +
                           " of full well" + mean};
       },
       .step = [](FrameRun& run, mtf::Image& counts) -> void {
         const auto maps = correction_of(run);
         run.lap("flat frames");
         correct(counts.view(), *maps, run.threads);
         run.frame.correction = maps;
         if (run.chain.settings.correction->replace_bad && !maps->bad.empty()) replace_bad(counts.view(), maps->bad);
       },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& counts) -> void {
         const auto maps = run.chain.correction(run.threads);
         counts.multiply_add({{maps, &maps->gain}}, {{maps, &maps->offset}});
         run.frame.correction = maps;
       },
       // Flat frames take the filters of the chain, which wait for the device that this frame holds.
       .stays = [](const FrameRun& run) -> bool {
         const auto maps = run.chain.known_correction();
         return maps && (maps->bad.empty() || !run.chain.settings.correction->replace_bad);
       }},
      {.name = "postsample",
       .part = display,
       .whole_image = "filters pixels together with their neighbours",
       .words = filters<mtf::Stage::postsample>,
       .step = [](FrameRun& run, mtf::Image& image) { filter(*run.chain.plan.post, run, image); }},
      {.name = "agc",
       .part = display,
       .whole_image = "takes its curve from the histogram of all pixels",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& agc = sensor.settings.agc;
         return said(agc ? "to " + rounded(agc->most_level) + " levels" : "", "no [agc]");
       },
       .step = [](FrameRun& run, mtf::Image& image) -> void {
         const AutomaticGain& agc = *run.chain.settings.agc;
         apply(image.view(), tone_curve(image.view(), agc, run.threads), run.threads);
         if (agc.polarity == Polarity::black_hot) invert_polarity(image.view(), agc.most_level);
       },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& image) -> void {
         const AutomaticGain& agc = *run.chain.settings.agc;
         for (std::int64_t frame = 0; frame < image.frames(); ++frame) {
           image.choose(frame);
           const std::vector<std::uint32_t> order = image.order();
           const auto value_at = [&](std::int64_t rank) { return static_cast<double>(image.value_at(rank, order)); };
           const ToneCurve curve =
               tone_curve({.finite = std::reduce(order.begin(), order.end(), std::int64_t{0}),
                           .values_at = [&](const auto& ranks) -> std::array<double, 2> {
                             return {value_at(ranks[0]), value_at(ranks[1])};
                           },
                           .histogram = [&](double low, double scale, std::int64_t bins) -> std::vector<std::int64_t> {
                             const std::vector<std::uint32_t> counts = image.histogram(low, scale, bins);
                             return {counts.begin(), counts.end()};
                           }},
                          agc);
           image.tone(curve.level, curve.low, curve.scale());
         }
         const auto most = static_cast<float>(agc.most_level);
         if (agc.polarity == Polarity::black_hot) image.multiply_add({{}, -1.0F}, {{}, most});
         if (run.whole_levels && most == 255.0F) image.round_to_bytes();
       }}};
  return kRows;
}

}  // namespace radiometry
