// SPDX-License-Identifier: Apache-2.0
// The chain of a sensor on a device against that of the processor: each operation to the bit, the counts of whole
// frames, and who does the work where the device cannot.

#include "mtf/device/device_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numeric>
#include <random>

#include "mtf/device/device_parts.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/chain/chain_impl.h"
#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/detector/nonlinearity.h"
#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/noise/noise.h"
#include "tests/mtf/device_support.h"
#include "tests/mtf/reference.h"
#include "tests/radiometry/chain_cases.h"

namespace radiometry {
namespace {

using mtf::test::open_tested_device;
using test::samples;

/// An image of the host on the tested device.
std::unique_ptr<mtf::DeviceImage> sent(const mtf::Image& image) {
  const auto device = open_tested_device();
  mtf::Device::Parts& parts = device->parts();
  std::unique_lock lock(parts.lock);
  const std::size_t bytes = static_cast<std::size_t>(image.size()) * sizeof(float);
  const mtf::DeviceMemory& memory = parts.memory(mtf::Device::Parts::Place::image, bytes);
  parts.backend->upload(parts.queue, image.data(), memory, bytes);
  parts.backend->finish(parts.queue);
  return std::make_unique<mtf::DeviceImage>(device, image.width(), image.height(), std::move(lock));
}

mtf::Image fetched(mtf::DeviceImage& image, std::int64_t width, std::int64_t height) {
  mtf::Image out(width, height);
  image.download(out.view(), 1);
  return out;
}

/// Pixels whose bits differ; NaN equals NaN.
std::int64_t unequal(const mtf::Image& a, const mtf::Image& b) {
  std::int64_t count = 0;
  for (std::int64_t i = 0; i < a.size(); ++i)
    count += a.data()[i] == b.data()[i] || (std::isnan(a.data()[i]) && std::isnan(b.data()[i])) ? 0 : 1;
  return count;
}

bool all_numbers(const mtf::Image& image) {
  return std::none_of(image.data(), image.data() + image.size(), [](float value) { return std::isnan(value); });
}

/// Means of electrons over ten decades, whole numbers among them; zero, negative and infinite ones, and NaN.
mtf::Image all_means(std::int64_t width, std::int64_t height) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> decades(-2.0, 9.0);
  mtf::Image image(width, height);
  for (std::int64_t i = 0; i < image.size(); ++i) {
    const double mean = std::pow(10.0, decades(random));
    image.data()[i] = static_cast<float>(i % 7 == 0 ? std::round(mean) : mean);
  }
  const float odd[] = {0.0F,
                       -3.0F,
                       std::numeric_limits<float>::infinity(),
                       std::numeric_limits<float>::quiet_NaN(),
                       31.999F,
                       32.0F,
                       0x1p22F,
                       1e8F,
                       1e-30F};
  for (std::size_t i = 0; i < std::size(odd); ++i) image.data()[100 + i] = odd[i];
  return image;
}

constexpr Origin kOrigins[] = {{0, 0}, {5, 3}, {(std::int64_t{1} << 31) + 1, 70000}};

mtf::DeviceRandom random_of(const NoiseKey& key, Stream stream, Origin origin) {
  return {key.seed, key.frame, static_cast<std::uint32_t>(stream), static_cast<std::uint32_t>(origin.x),
          static_cast<std::uint32_t>(origin.y)};
}

TEST(DeviceImage, ShotNoiseIsTheProcessorsToTheBit) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const mtf::Image means = all_means(301, 211);
  for (const Origin origin : kOrigins) {
    const NoiseKey key{0x123456789abcdefULL, 4};
    mtf::Image expected = mtf::copy_of(means.view());
    shot_noise(expected.view(), key, origin, 1);
    const auto image = sent(means);
    image->shot_noise(random_of(key, Stream::shot, origin));
    EXPECT_EQ(unequal(fetched(*image, 301, 211), expected), 0) << origin.x;
  }
}

TEST(DeviceImage, GaussianAndLineNoiseIsTheProcessorsToTheBit) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const mtf::Image means = all_means(301, 211);
  for (const Origin origin : kOrigins) {
    const NoiseKey key{99, 12};
    mtf::Image expected = mtf::copy_of(means.view());
    add_gaussian(expected.view(), 123.4, key, Stream::read, origin, 1);
    add_row_noise(expected.view(), 7.0, key, Stream::temporal_row, origin);
    add_column_noise(expected.view(), 3.0, key, Stream::fixed_column, origin);
    const auto image = sent(means);
    image->add_gaussian(123.4F, random_of(key, Stream::read, origin));
    image->add_lines(line_numbers(7.0, key, Stream::temporal_row, origin.y, 211), true);
    image->add_lines(line_numbers(3.0, key, Stream::fixed_column, origin.x, 301), false);
    EXPECT_EQ(unequal(fetched(*image, 301, 211), expected), 0) << origin.x;
  }
}

TEST(DeviceImage, MapsWellResponseAndConverterAreTheProcessorsToTheBit) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const mtf::Image means = all_means(301, 211);
  mtf::Image map(301, 211);
  add_gaussian(map.view(), 1.0, {5, 0}, Stream::prnu);
  const auto shared = std::make_shared<const mtf::Image>(std::move(map));
  mtf::Image expected = mtf::copy_of(means.view());
  multiply_add(expected, {0.37, shared, 1.1}, {12.5, {}, -3.25}, 1);
  multiply_add(expected, {2.5}, {40.0, shared, 1e3}, 1);
  add_map(expected.view(), shared->view(), 1);
  const Clipped well = fill_well(expected.view(), 3e6);
  const Nonlinearity bent{-0.05, 0.02, -0.01};
  apply_response(expected.view(), Response(bent, 3e6));
  Adc adc{.bits = 14};
  adc.electrons_per_count = 171.3, adc.offset_counts = 64.25;
  const auto image = sent(means);
  image->multiply_add({shared, 0.37F, 1.1F}, {{}, 12.5F + -3.25F, 0.0F});
  image->multiply_add({{}, 2.5F}, {shared, 40.0F, 1e3F});
  image->add(shared);
  image->hold_well(3e6F);
  image->bend(3e6, bent.a2, bent.a3, bent.a4);
  const mtf::Image before = fetched(*image, 301, 211);
  EXPECT_EQ(unequal(before, expected), 0);
  const Clipped counts = digitise(expected.view(), adc);
  const AdcScale scale = scale_of(adc);
  image->digitise(scale.counts_per_electron, scale.offset, scale.most);
  mtf::Image out(301, 211);
  const mtf::DeviceImage::Held held = image->download(out.view(), 1);
  EXPECT_EQ(unequal(out, expected), 0);
  EXPECT_EQ(held.well, well.high);
  EXPECT_EQ(held.least, counts.low);
  EXPECT_EQ(held.most, counts.high);
  EXPECT_GT(well.high, 0);
  EXPECT_GT(counts.low, 0);
  EXPECT_GT(counts.high, 0);
}

// Counts come as 8 or 16 bits where these hold them all, as floats where they do not or where one is no number.
TEST(DeviceImage, CountsOfEveryWidthAreTheProcessorsToTheBit) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  for (const bool with_nan : {false, true})
    for (const int bits : {1, 8, 9, 16, 17, 24}) {
      SCOPED_TRACE(bits);
      mtf::Image electrons = all_means(301, 211);
      for (std::int64_t i = 0; i < electrons.size(); ++i)
        if (!with_nan && std::isnan(electrons.data()[i])) electrons.data()[i] = 5.0F;
      Adc adc{.bits = bits};
      adc.electrons_per_count = 1e9 / adc.most_counts(), adc.offset_counts = 0.25;
      const AdcScale scale = scale_of(adc);
      const auto image = sent(electrons);
      image->digitise(scale.counts_per_electron, scale.offset, scale.most);
      digitise(electrons.view(), adc);
      EXPECT_EQ(unequal(fetched(*image, 301, 211), electrons), 0);
      // What follows makes numbers of them that are not whole.
      image->multiply_add({{}, 0.375F}, {{}, 0.125F});
      for (std::int64_t i = 0; i < electrons.size(); ++i) electrons.data()[i] = 0.375F * electrons.data()[i] + 0.125F;
      EXPECT_EQ(unequal(fetched(*image, 301, 211), electrons), 0);
    }
}

/// Images whose curves of gain have all that is special about such: counts, any floats of both signs with some that are
/// not finite, one value alone, one but for a single pixel, two values.
std::vector<mtf::Image> images_for_gain() {
  std::vector<mtf::Image> images;
  for (int kind = 0; kind < 5; ++kind) {
    mtf::Image image = mtf::test::random_image(301, 211, 31, 0.0F);
    for (std::int64_t i = 0; i < image.size(); ++i) {
      float& value = image.data()[i];
      if (kind == 0) value = std::floor(8000.0F + 300.0F * value);
      if (kind == 1) value = i % 97 == 0 ? std::numeric_limits<float>::quiet_NaN() : i % 89 == 0 ? INFINITY : value;
      if (kind == 2 || kind == 3) value = -7.25F;
      if (kind == 4) value = value > 0.3F ? 12.0F : 0.0F;
    }
    if (kind == 3) image.data()[5000] = 1e30F;
    images.push_back(std::move(image));
  }
  return images;
}

TEST(DeviceImage, RanksAreThoseOfTheSortedPixels) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  for (const mtf::Image& image : images_for_gain()) {
    std::vector<float> sorted;
    for (std::int64_t i = 0; i < image.size(); ++i)
      if (std::isfinite(image.data()[i])) sorted.push_back(image.data()[i]);
    std::sort(sorted.begin(), sorted.end());
    const auto there = sent(image);
    const std::vector<std::uint32_t> order = there->order();
    EXPECT_EQ(std::reduce(order.begin(), order.end(), std::int64_t{0}), std::ssize(sorted));
    for (const std::size_t rank : {std::size_t{0}, sorted.size() / 200, sorted.size() / 2, sorted.size() - 1})
      EXPECT_EQ(there->value_at(static_cast<std::int64_t>(rank), order), sorted[rank]) << rank;
  }
}

/// The row of the table of stages that makes the display.
const StageRow& gain_row() {
  static const std::vector<StageRow> rows = stage_table();
  return *std::find_if(rows.begin(), rows.end(), [](const StageRow& row) { return row.name == "agc"; });
}

TEST(DeviceImage, LevelsOfTheDisplayAreTheProcessorsToTheBit) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const mtf::System<double> system = test::mwir_system();
  for (const GainMethod method : {GainMethod::linear, GainMethod::plateau})
    for (const Polarity polarity : {Polarity::white_hot, Polarity::black_hot})
      for (const auto& [clip, bins, most] : {std::tuple{0.005, 4096, 255.0}, {0.0, 2, 1000.0}, {0.2, 65536, 255.0}}) {
        Sensor sensor = test::noisy_sensor();
        sensor.settings.agc =
            AutomaticGain{.method = method, .clip = clip, .bins = bins, .most_level = most, .polarity = polarity};
        mtf::PlanOptions options;
        options.separate_readout = true;
        const CompiledChain chain(mtf::compile_sensor(system, {301, 211, 15.0, 15.0}, options), system, sensor, 301,
                                  211);
        const PixelMaps maps;
        FrameRun run{.chain = chain, .maps = maps, .threads = 1};
        for (const mtf::Image& image : images_for_gain()) {
          mtf::Image expected = image.clone();
          gain_row().step(run, expected);
          auto there = sent(image);
          run.whole_levels = false;
          gain_row().step_on_device(run, *there);
          EXPECT_EQ(unequal(fetched(*there, 301, 211), expected), 0);
          there = nullptr;
          there = sent(image);
          run.whole_levels = true;
          gain_row().step_on_device(run, *there);
          // Bytes cannot say that something is no number: such an image comes as floats.
          if (most == 255.0 && all_numbers(expected))
            for (std::int64_t i = 0; i < expected.size(); ++i) expected.data()[i] = std::round(expected.data()[i]);
          EXPECT_EQ(unequal(fetched(*there, 301, 211), expected), 0);
        }
      }
}

/// A camera whose every stage has a step on the device.
Sensor all_stages() {
  Sensor sensor = test::noisy_sensor();
  sensor.settings.noise->fixed_row_e = 20.0;
  sensor.settings.noise->fixed_column_e = 30.0;
  sensor.settings.nonuniformity->dcnu = 0.1;
  sensor.settings.nonlinearity = Nonlinearity{-0.03, 0.01};
  sensor.settings.vignetting = Vignetting{.cos4 = true};
  sensor.settings.detector->full_well_e = 4e6;
  return sensor;
}

Chain chain_of(const mtf::System<double>& system, const Sensor& sensor, std::int64_t width, std::int64_t height,
               double step_um, std::optional<mtf::Method> method, const mtf::DeviceChoice& device) {
  mtf::PlanOptions options;
  options.tolerance = 1e-4;
  options.separate_readout = true;
  options.method = method;
  options.device = device;
  return {mtf::compile_sensor(system, {width, height, step_um, step_um}, options, samples_a_pitch(sensor)), system,
          sensor};
}

/// Radiance of 300 K with a contrast of some kelvin, a part of it beyond the full well.
mtf::Image scene(std::int64_t width, std::int64_t height) {
  const auto base = static_cast<float>(band_radiance(Flux::photons, 3.0, 5.0, 300.0));
  mtf::Image image = mtf::test::random_image(width, height, 3, 0.0F);
  for (std::int64_t i = 0; i < image.size(); ++i) {
    image.data()[i] = base * (1.0F + 0.1F * image.data()[i]);
    if (i % width < width / 8) image.data()[i] *= 3.0F;
  }
  return image;
}

TEST(DeviceChain, CountsAreTheProcessorsOfTheSameFilteredImage) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const Sensor sensor = all_stages();
  mtf::System<double> optics = test::mwir_system(), none = test::mwir_system();
  optics.add(mtf::Stage::presample, mtf::test::gaussian(9.0));
  none.list(mtf::Stage::presample).clear();
  const mtf::DeviceChoice device{open_tested_device(), true};
  const Chain on_device = chain_of(optics, sensor, 240, 180, 7.5, mtf::Method::fft_device, device);
  const Chain processor = chain_of(none, sensor, 120, 90, 15.0, {}, {});
  for (const std::uint32_t number : {0U, 7U}) {
    const ChainFrame filtered = on_device.run(scene(240, 180), number, OutputStage::radiance);
    for (const OutputStage stage : {OutputStage::electrons, OutputStage::dn}) {
      const ChainFrame made = on_device.run(scene(240, 180), number, stage);
      const ChainFrame expected = processor.run(mtf::copy_of(filtered.image.view()), number, stage);
      EXPECT_EQ(unequal(made.image, expected.image), 0);
      EXPECT_EQ(made.well.high, expected.well.high);
      EXPECT_GT(made.well.high, 100);
      EXPECT_EQ(made.held, expected.held);
      EXPECT_EQ(made.adc.high, expected.adc.high);
    }
  }
}

// From the device's own filtered image: counts differ where the rounding of the filter crosses a step of the converter.
// Their share is at most twice the rms difference in counts, and below 1e-3.
TEST(DeviceChain, CountsDifferWhereRoundingCrossesAStepAlone) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const Sensor sensor = all_stages();
  mtf::System<double> optics = test::mwir_system();
  optics.add(mtf::Stage::presample, mtf::test::gaussian(9.0));
  const Chain on_device =
      chain_of(optics, sensor, 480, 360, 7.5, mtf::Method::fft_device, {open_tested_device(), true});
  const Chain processor = chain_of(optics, sensor, 480, 360, 7.5, mtf::Method::fft_float, {});
  const ChainFrame a = on_device.run(scene(480, 360), 3, OutputStage::dn);
  const ChainFrame b = processor.run(scene(480, 360), 3, OutputStage::dn);
  const ChainFrame c = on_device.run(scene(480, 360), 3, OutputStage::dn);
  EXPECT_EQ(unequal(a.image, c.image), 0) << "the same device gives the same bits";
  // Of light alone: shot noise makes whole electrons of it, in which roundings are not seen.
  Sensor still = sensor;
  still.settings.noise.reset();
  const mtf::DeviceChoice device{open_tested_device(), true};
  const mtf::Image x = chain_of(optics, still, 480, 360, 7.5, mtf::Method::fft_device, device)
                           .run(scene(480, 360), 3, OutputStage::electrons)
                           .image,
                   y = chain_of(optics, still, 480, 360, 7.5, mtf::Method::fft_float, {})
                           .run(scene(480, 360), 3, OutputStage::electrons)
                           .image;
  double squares = 0.0;
  for (std::int64_t i = 0; i < x.size(); ++i)
    squares += std::pow((static_cast<double>(x.data()[i]) - static_cast<double>(y.data()[i])) / 450.0, 2);
  const double rms = std::sqrt(squares / static_cast<double>(x.size()));
  const double share = static_cast<double>(unequal(a.image, b.image)) / static_cast<double>(a.image.size());
  EXPECT_GT(share, 0.0);
  EXPECT_LE(share, 2.0 * rms);
  EXPECT_LT(share, 1e-3);
  for (std::int64_t i = 0; i < a.image.size(); ++i)
    ASSERT_LE(std::abs(a.image.data()[i] - b.image.data()[i]), 1.0F) << "more than a step";
}

// Correction and gain, too: the first frame measures the correction on the processor, the others are made on the
// device.
TEST(DeviceChain, DisplayIsTheProcessorsOfTheSameFilteredImage) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  mtf::System<double> optics = test::mwir_system(), none = test::mwir_system();
  optics.add(mtf::Stage::presample, mtf::test::gaussian(9.0));
  none.list(mtf::Stage::presample).clear();
  Sensor sensor = all_stages();
  sensor.settings.agc = AutomaticGain{.method = GainMethod::plateau, .polarity = Polarity::black_hot};
  const mtf::DeviceChoice device{open_tested_device(), true};
  // A limit of the response that some pixels are beyond has them replaced, by the processor.
  for (const auto& correction : {std::optional<CorrectionSettings>{}, std::optional(CorrectionSettings{.frames = 2}),
                                 std::optional(CorrectionSettings{.frames = 2, .limit = 4e-3}),
                                 std::optional(CorrectionSettings{.frames = 2, .limit = 4e-3, .replace_bad = false})}) {
    sensor.settings.correction = correction;
    const Chain on_device = chain_of(optics, sensor, 240, 180, 7.5, mtf::Method::fft_device, device);
    const Chain processor = chain_of(none, sensor, 120, 90, 15.0, {}, {});
    for (const std::uint32_t number : {0U, 7U}) {
      const ChainFrame filtered = on_device.run(scene(240, 180), number, OutputStage::radiance);
      const ChainFrame made = on_device.run(scene(240, 180), number, OutputStage::display);
      const ChainFrame whole = on_device.run(scene(240, 180), number, OutputStage::display, 0.0, 0, nullptr, true);
      ChainFrame expected = processor.run(mtf::copy_of(filtered.image.view()), number, OutputStage::display);
      EXPECT_EQ(unequal(made.image, expected.image), 0);
      EXPECT_EQ(made.held, expected.held);
      EXPECT_GT(made.held.full_well, 100);
      const auto on_processor = [&](std::string_view stage) {
        return std::ranges::any_of(made.timing_ms, [&](const auto& time) { return time.first == stage; });
      };
      const bool replaces = correction && correction->limit < 0.1 && correction->replace_bad;
      EXPECT_EQ(on_processor("agc"), replaces || (correction && number == 0));
      EXPECT_EQ(on_processor("correction"), replaces || (correction && number == 0));
      if (replaces) continue;
      for (std::int64_t i = 0; i < expected.image.size(); ++i)
        expected.image.data()[i] = std::round(expected.image.data()[i]);
      EXPECT_EQ(unequal(whole.image, expected.image), 0);
    }
  }
}

// A stage without a step on the device takes the frame back; the stages after it are the processor's.
TEST(DeviceChain, AStageOfTheProcessorTakesTheFrameBack) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  Sensor sensor = all_stages();
  sensor.settings.defects = Defects{.dead_fraction = 0.01, .hot_fraction = 0.01, .hot_e = 1e5};
  mtf::System<double> optics = test::mwir_system(), none = test::mwir_system();
  optics.add(mtf::Stage::presample, mtf::test::gaussian(9.0));
  none.list(mtf::Stage::presample).clear();
  const Chain on_device =
      chain_of(optics, sensor, 240, 180, 7.5, mtf::Method::fft_device, {open_tested_device(), true});
  const Chain processor = chain_of(none, sensor, 120, 90, 15.0, {}, {});
  const ChainFrame filtered = on_device.run(scene(240, 180), 1, OutputStage::radiance);
  const ChainFrame made = on_device.run(scene(240, 180), 1, OutputStage::dn);
  const ChainFrame expected = processor.run(mtf::copy_of(filtered.image.view()), 1, OutputStage::dn);
  EXPECT_EQ(unequal(made.image, expected.image), 0);
  EXPECT_EQ(made.held_defects, expected.held_defects);
}

// A scene that comes again is sent once, and its frames are those of a scene that is sent each time.
TEST(DeviceChain, AKeptSceneGivesTheSameFrames) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  mtf::System<double> optics = test::mwir_system();
  optics.add(mtf::Stage::presample, mtf::test::gaussian(9.0));
  const Chain chain =
      chain_of(optics, all_stages(), 240, 180, 7.5, mtf::Method::fft_device, {open_tested_device(), true});
  std::vector<mtf::Image> planes;
  planes.push_back(scene(240, 180));
  mtf::KeptScene kept(std::make_shared<const std::vector<mtf::Image>>(std::move(planes)));
  for (const std::uint32_t number : {0U, 1U, 2U})
    EXPECT_EQ(unequal(chain.run(kept, number, OutputStage::dn).image,
                      chain.run(scene(240, 180), number, OutputStage::dn).image),
              0);
}

// A batch is bit for bit its frames one by one, whatever they are numbered, at every stage.
TEST(DeviceChain, ABatchIsItsFramesOneByOne) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  mtf::System<double> optics = test::mwir_system();
  optics.add(mtf::Stage::presample, mtf::test::gaussian(9.0));
  Sensor sensor = all_stages();
  sensor.settings.correction = CorrectionSettings{.frames = 2};
  sensor.settings.agc = AutomaticGain{.method = GainMethod::plateau, .polarity = Polarity::black_hot};
  const Chain chain = chain_of(optics, sensor, 240, 180, 7.5, mtf::Method::fft_device, {open_tested_device(), true});
  std::vector<mtf::Image> planes;
  planes.push_back(scene(240, 180));
  mtf::KeptScene kept(std::make_shared<const std::vector<mtf::Image>>(std::move(planes)));
  EXPECT_EQ(chain.batch_size(OutputStage::radiance), 1);
  EXPECT_EQ(chain.batch_size(OutputStage::display), 1) << "before the correction is measured";
  chain.prepare(OutputStage::display);
  for (const OutputStage stage : {OutputStage::electrons, OutputStage::dn, OutputStage::display})
    for (const auto& [first, step, count] :
         {std::tuple{0U, 1U, 5}, {7U, 3U, 2}, {0xfffffffeU, 1U, 3}, {9U, 1U, 1}, {0U, 1U, 40}})
      for (const bool whole : {false, true}) {
        EXPECT_GT(chain.batch_size(stage), 1);
        const std::vector<ChainFrame> frames = chain.run_batch(kept, {first, step, count}, stage, 0.0, 2, whole);
        ASSERT_EQ(std::ssize(frames), count);
        for (int i = 0; i<count; i += count> 10 ? 13 : 1) {
          const ChainFrame& made = frames[static_cast<std::size_t>(i)];
          const ChainFrame alone =
              chain.run(kept, first + static_cast<std::uint32_t>(i) * step, stage, 0.0, 1, nullptr, 1, whole);
          EXPECT_EQ(unequal(made.image, alone.image), 0) << i;
          EXPECT_EQ(made.held, alone.held);
          EXPECT_EQ(made.held_defects, alone.held_defects);
          EXPECT_EQ(made.well.high, alone.well.high);
          EXPECT_EQ(made.adc.low, alone.adc.low);
          EXPECT_EQ(made.adc.high, alone.adc.high);
          EXPECT_EQ(made.noise_rows, alone.noise_rows);
          EXPECT_EQ(made.timing_ms.size(), alone.timing_ms.size());
        }
        if (count > 1) {
          EXPECT_GT(unequal(frames[0].image, frames[1].image), 1000) << "the noise is not that of one frame";
        }
      }
}

// What cannot be done together is done one by one: stages of the processor, memory that is missing, a device that is
// lost; whoever insists on it hears of that.
TEST(DeviceChain, ABatchThatTheDeviceCannotDoIsDoneAllTheSame) {
  const auto info = mtf::test::tested_device();
  if (!info) GTEST_SKIP() << "no device";
  mtf::System<double> optics = test::mwir_system();
  optics.add(mtf::Stage::presample, mtf::test::gaussian(9.0));
  std::vector<mtf::Image> planes;
  planes.push_back(scene(240, 180));
  const auto shared = std::make_shared<const std::vector<mtf::Image>>(std::move(planes));
  Sensor with_defects = all_stages();
  with_defects.settings.defects = Defects{.dead_fraction = 0.01, .hot_fraction = 0.01, .hot_e = 1e5};
  const Chain chain =
      chain_of(optics, with_defects, 240, 180, 7.5, mtf::Method::fft_device, {open_tested_device(), true});
  const Chain processor = chain_of(optics, all_stages(), 240, 180, 7.5, mtf::Method::fft_float, {});
  EXPECT_EQ(chain.batch_size(OutputStage::dn), 1);
  EXPECT_EQ(processor.batch_size(OutputStage::dn), 1);
  for (const Chain* one : {&chain, &processor}) {
    mtf::KeptScene kept(shared);
    const std::vector<ChainFrame> frames = one->run_batch(kept, {3, 1, 2}, OutputStage::dn);
    for (const std::uint32_t i : {0U, 1U})
      EXPECT_EQ(unequal(frames[i].image, one->run(kept, 3 + i, OutputStage::dn).image), 0);
  }
  for (const bool insisted : {true, false}) {
    const auto device = mtf::open_device(*info, mtf::DeviceFault::chain);
    const Chain lost = chain_of(optics, all_stages(), 240, 180, 7.5, mtf::Method::fft_device, {device, insisted});
    mtf::KeptScene kept(shared), again(shared);
    if (insisted) {
      EXPECT_THROW(lost.run_batch(kept, {0, 1, 3}, OutputStage::dn), mtf::DeviceError);
      continue;
    }
    const std::vector<ChainFrame> frames = lost.run_batch(kept, {0, 1, 3}, OutputStage::dn);
    ASSERT_EQ(frames.size(), 3U);
    for (std::uint32_t i = 0; i < 3; ++i)
      EXPECT_LT(unequal(frames[i].image, processor.run(again, i, OutputStage::dn).image),
                frames[i].image.size() / 1000);
    EXPECT_TRUE(device->failure());
  }
}

TEST(DeviceImage, BatchesHaveTheRoomThatTheDeviceHas) {
  mtf::DeviceInfo info;
  info.bytes = info.largest_bytes = std::int64_t{1} << 30;
  EXPECT_TRUE(mtf::DeviceImage::has_room(info, 640, 512, 16));
  EXPECT_FALSE(mtf::DeviceImage::has_room(info, 8192, 8192, 2));
  info.largest_bytes = 1 << 20;
  EXPECT_FALSE(mtf::DeviceImage::has_room(info, 640, 512, 1));
  EXPECT_FALSE(mtf::DeviceImage::has_room(info, std::int64_t{1} << 29, 4, 16));
}

// Also of a sequence that remembers, and of a scene that comes again.
TEST(DeviceChain, IsDoneByTheProcessorWhereTheDeviceFails) {
  const auto info = mtf::test::tested_device();
  if (!info) GTEST_SKIP() << "no device";
  Sensor sensor = all_stages();
  sensor.settings.lag = Lag{.time_constant_s = 0.02};
  mtf::System<double> optics = test::mwir_system();
  optics.add(mtf::Stage::presample, mtf::test::gaussian(9.0));
  std::vector<mtf::Image> planes;
  planes.push_back(scene(240, 180));
  const auto shared = std::make_shared<const std::vector<mtf::Image>>(std::move(planes));
  const Chain processor = chain_of(optics, sensor, 240, 180, 7.5, mtf::Method::fft_float, {});
  for (const bool insisted : {true, false}) {
    const auto device = mtf::open_device(*info, mtf::DeviceFault::chain);
    const Chain chain = chain_of(optics, sensor, 240, 180, 7.5, mtf::Method::fft_device, {device, insisted});
    mtf::KeptScene kept(shared), again(shared);
    ChainState state, expected_state;
    if (insisted) {
      EXPECT_THROW(chain.run(kept, 0, OutputStage::dn, 0.0, 1, &state), mtf::DeviceError);
      continue;
    }
    for (const std::uint32_t number : {0U, 1U, 3U}) {
      const ChainFrame made = chain.run(kept, number, OutputStage::dn, 0.0, 1, &state);
      const ChainFrame expected = processor.run(again, number, OutputStage::dn, 0.0, 1, &expected_state);
      EXPECT_LT(unequal(made.image, expected.image), made.image.size() / 1000) << number;
      const ChainFrame alone = chain.run(mtf::copy_of(shared->front().view()), number, OutputStage::dn);
      EXPECT_LT(unequal(alone.image, processor.run(scene(240, 180), number, OutputStage::dn).image),
                made.image.size() / 1000);
    }
    EXPECT_TRUE(device->failure());
  }
}

// Times of frames from a scene that is kept to counts on the host. Printed for reports.
TEST(DeviceTimesLong, of_chains) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  mtf::System<double> optics = test::mwir_system();
  optics.add(mtf::Stage::presample, mtf::test::gaussian(9.0));
  struct Case {
    std::int64_t width, height;
    double step_um;
  };
  for (const auto& [width, height, step_um] : {Case{2560, 2048, 7.5}, Case{640, 512, 15.0}}) {
    std::vector<mtf::Image> planes;
    planes.push_back(scene(width, height));
    const auto shared = std::make_shared<const std::vector<mtf::Image>>(std::move(planes));
    for (const bool on_device : {true, false}) {
      const Chain chain = on_device
                              ? chain_of(optics, all_stages(), width, height, step_um, mtf::Method::fft_device,
                                         {open_tested_device(), true})
                              : chain_of(optics, all_stages(), width, height, step_um, mtf::Method::fft_float, {});
      mtf::KeptScene kept(shared);
      std::vector<double> ms;
      std::map<std::string_view, double> stages;
      for (std::uint32_t number = 0; number < 12; ++number) {
        const mtf::Stopwatch watch;
        const ChainFrame frame = chain.run(kept, number, OutputStage::dn);
        ms.push_back(watch.ms());
        stages.clear();
        for (const auto& [name, stage_ms] : frame.timing_ms) stages[name] += stage_ms;
      }
      std::sort(ms.begin() + 2, ms.end());
      std::printf("%lld x %lld samples to counts, %s: first %.2f, least %.3f, median %.3f ms; of the last",
                  static_cast<long long>(width), static_cast<long long>(height), on_device ? "device" : "processor",
                  ms[0], ms[2], ms[7]);
      for (const auto& [name, stage_ms] : stages) std::printf(" %s %.2f", std::string(name).c_str(), stage_ms);
      std::printf("\n");
    }
  }
}

}  // namespace
}  // namespace radiometry
