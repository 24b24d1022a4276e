// SPDX-License-Identifier: Apache-2.0

// Pixels that are not like the others: cameras of known defects, drawn with random numbers of the standard library, and
// how often the intervals of what is found of them hold.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "calib/characterize/characterize.h"
#include "radiometry/stages/noise/blinking.h"
#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/noise/frame_flicker.h"
#include "radiometry/stages/noise/noise.h"

namespace calib {
namespace {

constexpr std::int64_t kPixelSide = 48;
constexpr std::size_t kPixels = kPixelSide * kPixelSide;
using Random = std::mt19937_64;

struct PixelCamera {
  double gain = 0.5, read_e = 3.0, offset = 100.2, rate = 3000.0, prnu = 0.01, dsnu_e = 3.0, side = 0.0;
  double hot_share = 0.0, hot_e = 0.0, dead_share = 0.0;
  bool equally_hot = false;                    ///< all have hot_e, where it is their mean
  double octave_e = 0.0, lowest = 0.1 / 64.0;  ///< 1/f noise from frame to frame
  double blinking_share = 0.0, blinking_e = 0.0, dwell = 6.0;
  bool equally_blinking = false, seldom_high = false;  ///< all have blinking_e; they are high for a tenth of the time
  double lasting = 0.0;                                ///< correlation of successive frames' read noise
  double shading = 0.0;                                ///< part of the light that is missing in the corners
};

/// 1/f noise of a pixel: two lines in each octave, whose frequency is somewhere in its half, with normal amplitudes.
/// The spectrum of all pixels is 1/f from the lowest to half a cycle.
std::vector<double> slow_series(const PixelCamera& camera, int frames, Random& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<double> series(static_cast<std::size_t>(frames), 0.0);
  if (!(camera.octave_e > 0.0)) return series;
  const double octaves = std::log2(0.5 / camera.lowest), lines = std::ceil(2.0 * octaves);
  for (double line = 0.0; line < lines; ++line) {
    const double turn = 2.0 * std::numbers::pi * camera.lowest * std::exp2(octaves * (line + uniform(random)) / lines);
    const double rms = camera.octave_e * std::sqrt(octaves / lines), c = std::cos(turn), s = std::sin(turn);
    double a = rms * normal(random), b = rms * normal(random);
    for (double& value : series) {
      value += a;
      const double next = c * a - s * b;
      b = s * a + c * b;
      a = next;
    }
  }
  return series;
}

struct PixelArray {
  std::vector<double> response, offset_e, hot_e, blinking_e;
  std::map<std::size_t, float> stuck{};             ///< counts of pixels that have the same in all frames
  double mean_response = 0.0, mean_offset_e = 0.0;  ///< of those that are not dead, of all
};

PixelArray array_of(const PixelCamera& camera, Random& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  PixelArray a;
  double alive = 0.0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    const double u = uniform(random), response = 1.0 + camera.prnu * normal(random);
    const bool dead = u < camera.dead_share, hot = !dead && u < camera.dead_share + camera.hot_share;
    const auto from_middle = [](std::size_t k) {
      const double x = (static_cast<double>(k) + 0.5) / (0.5 * kPixelSide) - 1.0;
      return 0.5 * x * x;
    };
    const double light = 1.0 - camera.shading * (from_middle(i % kPixelSide) + from_middle(i / kPixelSide));
    a.response.push_back(dead ? 0.0 : light * response);
    a.offset_e.push_back(camera.dsnu_e * normal(random));
    a.hot_e.push_back(!hot                 ? 0.0
                      : camera.equally_hot ? camera.hot_e
                                           : std::exponential_distribution<double>(1.0 / camera.hot_e)(random));
    const bool blinks = !dead && !hot && u > 1.0 - camera.blinking_share;
    a.blinking_e.push_back(!blinks ? 0.0
                           : camera.equally_blinking
                               ? camera.blinking_e
                               : std::exponential_distribution<double>(1.0 / camera.blinking_e)(random));
    alive += dead ? 0.0 : 1.0;
    a.mean_response += a.response.back();
    a.mean_offset_e += a.offset_e.back() / kPixels;
  }
  a.mean_response /= alive;
  return a;
}

Stack frames_of(const PixelCamera& camera, const PixelArray& array, double light, int frames, Random& random) {
  std::normal_distribution<double> normal;
  StackStatistics sums(kPixelSide, kPixelSide, {.low = 0.0, .high = 16383.0});
  std::vector<double> e(kPixels), noise(kPixels, 0.0);
  std::vector<std::vector<double>> slow;
  for (std::size_t i = 0; i < kPixels; ++i) slow.push_back(slow_series(camera, frames, random));
  mtf::Image frame(kPixelSide, kPixelSide);
  std::vector<mtf::Image> kept;  // which a second reading takes
  std::vector<char> high(kPixels);
  std::uniform_real_distribution<double> uniform;
  const double change = -0.5 * std::expm1(-2.0 / camera.dwell), part = camera.seldom_high ? 0.1 : 0.5;
  for (int t = 0; t < frames; ++t) {
    for (std::size_t i = 0; i < kPixels; ++i) {
      if (t == 0 ? array.blinking_e[i] > 0.0 : array.blinking_e[i] > 0.0 && uniform(random) < 2.0 * change)
        high[i] = uniform(random) < part ? 1 : 0;  // a coin at each of twice as many times
      const double mean =
          camera.rate * light * array.response[i] + array.hot_e[i] + (high[i] != 0 ? array.blinking_e[i] : 0.0);
      e[i] = mean > 0.0 ? std::poisson_distribution<int>(mean)(random) : 0.0;
    }
    for (std::int64_t y = 0, i = 0; y < kPixelSide; ++y)
      for (std::int64_t x = 0; x < kPixelSide; ++x, ++i) {
        const auto at = [&](std::int64_t dx, std::int64_t dy) {
          return e[static_cast<std::size_t>((y + dy + kPixelSide) % kPixelSide * kPixelSide +
                                            (x + dx + kPixelSide) % kPixelSide)];
        };
        const double s = camera.side, r = t > 0 ? camera.lasting : 0.0;
        double& lasts = noise[static_cast<std::size_t>(i)];
        lasts = r * lasts + std::sqrt(1.0 - r * r) * camera.read_e * normal(random);
        const double out = (1.0 - 4.0 * s) * at(0, 0) + s * (at(1, 0) + at(-1, 0) + at(0, 1) + at(0, -1)) +
                           array.offset_e[static_cast<std::size_t>(i)] + lasts +
                           slow[static_cast<std::size_t>(i)][static_cast<std::size_t>(t)];
        const auto stuck = array.stuck.find(static_cast<std::size_t>(i));
        frame.data()[i] = stuck != array.stuck.end()
                              ? stuck->second
                              : static_cast<float>(std::floor(camera.gain * out + camera.offset + 0.5));
      }
    sums.add(frame.view());
    if (light == 0.0) kept.push_back(frame.clone());
  }
  Stack stack{.name = light > 0.0 ? "light" : "dark", .light = light, .sums = summary_of(sums)};
  stack.sums.series = empty_series(stack.sums);
  for (const mtf::Image& one : kept) stack.sums.series.add(one.view());
  return stack;
}

Characterization found_of(const PixelCamera& camera, const PixelArray& array, Random& random, int dark_frames = 8) {
  std::vector<Stack> stacks;
  for (const double light : {0.0, 0.25, 0.5, 1.0, 2.0, 4.0})
    stacks.push_back(frames_of(camera, array, light, light > 0.0 ? 8 : dark_frames, random));
  return characterize(std::move(stacks), {});
}

bool warned_of(const Characterization& camera, const std::string& words) {
  return std::ranges::any_of(camera.warnings, [&](const std::string& w) { return w.find(words) != std::string::npos; });
}

struct PixelCondition {
  std::string name;
  PixelCamera camera;
  int dark_frames = 8;
  std::map<std::string, double> more{};  ///< what is true beside what all have
  bool is_slow = false;                  ///< blinking that is refused, or else warned of
  double others_hold = 0.95;             ///< a known shortfall: what too few changes tell is in no error
};
void PrintTo(const PixelCondition& condition, std::ostream* out) { *out << condition.name; }

/// Of how many draws, each a new array, the 95 % intervals hold the truth; and that the mean error is small beside the
/// standard deviation of a draw, as far as the draws tell.
void expect_held(const PixelCondition& condition, int draws, double least_sd) {
  const PixelCamera& camera = condition.camera;
  struct Tally {
    int held = 0, stated = 0;
    double error = 0.0, squares = 0.0;
  };
  std::map<std::string, Tally> tallies;
  int misfits = 0, warned = 0;
  for (int draw = 0; draw < draws; ++draw) {
    Random random(static_cast<std::uint64_t>(1000 + draw));
    const PixelArray array = array_of(camera, random);
    Characterization found;
    try {
      found = found_of(camera, array, random, condition.dark_frames);
    } catch (const mtf::UsageError& error) {  // pixels that blink slowly look as a drift does
      ASSERT_TRUE(condition.is_slow) << error.what();
      continue;
    }
    misfits += found.misfit ? 1 : 0;
    const Finding* const blinking = found.find("blinking_fraction");
    warned += warned_of(found, "kept their level") || blinking->verdict == Verdict::not_determined ? 1 : 0;
    std::map<std::string, double> truth = condition.more;
    truth.insert({{"electrons_per_count", 1.0 / camera.gain},
                  {"read_noise", camera.read_e},
                  {"offset", camera.offset + camera.gain * array.mean_offset_e},
                  {"rate", camera.rate * array.mean_response},
                  {"dsnu", camera.dsnu_e},
                  {"prnu", camera.prnu}});
    for (const auto& [name, value] : truth) {
      const Finding* f = found.find(name);
      const bool stated = f != nullptr && f->verdict != Verdict::not_determined;
      ASSERT_TRUE(stated || (condition.is_slow && condition.more.contains(name))) << name;
      if (!stated) continue;
      Tally& tally = tallies[name];
      ++tally.stated;
      tally.held += f->low95 <= value && value <= f->high95 ? 1 : 0;
      tally.error += f->value - value;
      tally.squares += (f->value - value) * (f->value - value);
    }
  }
  if (condition.is_slow)
    EXPECT_GE(warned, 0.9 * draws);
  else
    EXPECT_LE(misfits, 2 + draws / 250);  // p is below 0.001 once in a thousand
  for (const auto& [name, tally] : tallies) {
    const double n = tally.stated, mean = tally.error / n, sd = std::sqrt(tally.squares / n - mean * mean);
    testing::Test::RecordProperty(name, std::to_string(tally.held) + " of " + std::to_string(tally.stated) + ", " +
                                            std::to_string(mean / sd) + " sd");
    const double part = condition.more.contains(name) ? 0.95 : condition.others_hold;
    EXPECT_GE(tally.held, n * part - least_sd * std::sqrt(n * 0.95 * 0.05)) << name;
    // Of 97 % and 2.5 sd of chance. What blinking pixels add to others is a bound, which holds more.
    const bool is_bound = camera.blinking_share > 0.0 && !condition.more.contains(name);
    EXPECT_LE(tally.held, is_bound ? n : n * 0.97 + 2.5 * std::sqrt(n * 0.97 * 0.03)) << name;
    // Those that are stated only where chance made them clear are not without bias.
    EXPECT_LT(std::abs(mean), ((condition.is_slow ? 1.0 : 0.25) + 3.0 / std::sqrt(n)) * sd) << name;
  }
}

// The number of hot and dead ones of a fraction is binomial, so the interval of the fraction is that of the process;
// the offset, the read noise and the responsivity are those of the other pixels. The excess of blinking ones is no part
// of offset, read noise, gain and patterns either: alone, with hot ones and crosstalk, and where they change about once
// in the dark stack. Read noise and DSNU are those without 1/f noise: a corner at 0.3, one at 0.01 cycles per frame.
const std::vector<PixelCondition> kPixelConditions = [] {
  const auto corner = [](double octave_e) {
    return std::map<std::string, double>{
        {"flicker_octave", octave_e},
        {"flicker_corner", 0.5 * octave_e * octave_e / std::numbers::ln2 / (9.0 + 1.0 / 12.0 / 0.25)}};
  };
  std::vector<PixelCondition> all{
      {"HotAndDead", {.hot_share = 0.01, .hot_e = 200.0, .dead_share = 0.004}},
      {"HotAndDeadCrosstalk", {.side = 0.02, .hot_share = 0.01, .hot_e = 200.0, .dead_share = 0.004}},
      {"Blinking", {.blinking_share = 0.02, .blinking_e = 200.0}, 64},
      {"BlinkingFewFrames", {.blinking_share = 0.02, .blinking_e = 400.0, .dwell = 4.0}, 24},
      {"BlinkingHotCrosstalk",
       {.side = 0.01, .hot_share = 0.01, .hot_e = 300.0, .blinking_share = 0.02, .blinking_e = 300.0, .dwell = 2.0},
       32},
      {"BlinkingOnce", {.blinking_share = 0.02, .blinking_e = 300.0, .dwell = 32.0}, 32, {}, true},
      {"BlinkingSeldom", {.blinking_share = 0.02, .blinking_e = 300.0, .dwell = 100.0}, 32, {}, true, 0.88},
      {"OneOverF", {.octave_e = 2.0}, 64, corner(2.0)},
      {"OneOverFBelowWhite", {.octave_e = 0.35}, 64, corner(0.35)}};
  for (PixelCondition& one : all) {
    const PixelCamera& camera = one.camera;
    if (camera.hot_share > 0.0) one.more.insert({{"hot_fraction", camera.hot_share}, {"hot_excess", camera.hot_e}});
    if (camera.dead_share > 0.0) one.more.insert({"dead_fraction", camera.dead_share});
    if (camera.blinking_share > 0.0)
      one.more.insert({{"blinking_fraction", camera.blinking_share},
                       {"blinking_excess", camera.blinking_e},
                       {"blinking_dwell", camera.dwell}});
  }
  return all;
}();

class CharacterizePixelsHeld : public testing::TestWithParam<PixelCondition> {};
class CharacterizePixelsHeldLong : public testing::TestWithParam<PixelCondition> {};
TEST_P(CharacterizePixelsHeld, AsStated) { expect_held(GetParam(), 60, 4.2); }
// With the per cent that the estimators are off by in single conditions.
TEST_P(CharacterizePixelsHeldLong, AsStated) { expect_held(GetParam(), 1000, 5.0); }
const auto name_of_condition = [](const auto& condition) { return condition.param.name; };
INSTANTIATE_TEST_SUITE_P(Cameras, CharacterizePixelsHeld, testing::ValuesIn(kPixelConditions), name_of_condition);
INSTANTIATE_TEST_SUITE_P(Cameras, CharacterizePixelsHeldLong, testing::ValuesIn(kPixelConditions), name_of_condition);

// A pixel that stands at an end of the scale in the dark and in the light is a defect, and no stack is clipped by it:
// the numbers are those that the same frames have without, but for its own part of them. One that is there in the light
// alone is clipped.
TEST(CharacterizePixels, StuckOnes) {
  Random random(31), same(31);
  PixelArray array = array_of({}, random);
  const Characterization without = found_of({}, array_of({}, same), same);
  array.stuck = {{777, 0.0F}, {1010, 16383.0F}, {2000, 16383.0F}};
  const Characterization found = found_of({}, array, random);
  EXPECT_EQ(std::ranges::count(found.level_of, -1), 0);
  EXPECT_DOUBLE_EQ(found.find("dead_fraction")->value, 3.0 / kPixels);
  for (const char* const name : {"electrons_per_count", "offset", "read_noise", "dsnu", "prnu"})
    EXPECT_NEAR(found.find(name)->value, without.find(name)->value, 0.5 * without.find(name)->sd) << name;
  std::vector<Stack> full;
  for (const double light : {0.0, 0.25, 0.5, 1.0, 2.0, 4.0}) {
    array.stuck.clear();
    if (light == 4.0) array.stuck[777] = 16383.0F;
    full.push_back(frames_of({}, array, light, 8, random));
  }
  EXPECT_EQ(characterize(std::move(full), {}).level_of.back(), -1);
}

TEST(CharacterizePixels, WhatTheTwinHasNot) {
  Random random(5);
  const auto found = [&](const PixelCamera& camera) { return found_of(camera, array_of(camera, random), random); };
  const Characterization good = found({});
  EXPECT_EQ(good.find("hot_fraction")->verdict, Verdict::upper_limit);
  EXPECT_EQ(good.find("hot_excess")->verdict, Verdict::not_determined);
  EXPECT_NEAR(good.find("dead_fraction")->high95, 3.689 / kPixels, 1e-6);  // no event: -ln 0.025
  EXPECT_TRUE(good.warnings.empty()) << good.warnings.front();
  EXPECT_FALSE(warned_of(found({.hot_share = 0.03, .hot_e = 300.0}), "not exponentially"));
  EXPECT_TRUE(warned_of(found({.hot_share = 0.03, .hot_e = 300.0, .equally_hot = true}), "not exponentially"));
  // A pixel that answers by nine tenths, beyond 4.5 sd of 1 %, and one that is cold.
  PixelArray odd = array_of({}, random);
  for (const std::size_t i : {100U, 700U, 1300U}) odd.response[i] = 0.9;
  odd.offset_e[1900] = -60.0;
  EXPECT_TRUE(warned_of(found_of({}, odd, random), "4 pixels are beyond 4.5 sd"));
}

// A pixel that is high in every other frame, with seven changes of seven: the chance of a change that makes so many in
// one of forty draws is 0.025^(1/7) by the binomial distribution.
TEST(CharacterizePixels, ALevelThatChangesInEveryFrame) {
  PixelSeries series{.places = {3}, .values = {}, .frames = 8};
  for (int t = 0; t < 8; ++t) series.values.push_back(t % 2 == 0 ? 0.0F : 1000.0F);
  const BlinkingNoise found = estimate_blinking(series, 9.0, 0.5);
  ASSERT_EQ(found.pixels.size(), 1U);
  EXPECT_NEAR(found.change95[0], std::pow(0.025, 1.0 / 7.0), 0.05);
}

// Light that falls to 44 % in the corners makes more noise in the middle, which is no sign of blinking. Of a thousand
// frames the gain was 0.44 % off, as the noisiest were left out; its error is 0.07 %.
TEST(CharacterizePixels, ShadingIsNoBlinking) {
  Random random(12);
  const PixelCamera camera{.blinking_share = 0.02, .blinking_e = 200.0, .shading = 0.56};
  const PixelArray array = array_of(camera, random);
  std::vector<Stack> stacks;
  for (const double light : {0.0, 2.0, 4.0})
    stacks.push_back(frames_of(camera, array, light, light > 0.0 ? 1000 : 64, random));
  const Characterization found = characterize(std::move(stacks), {});
  const Finding &gain = *found.find("electrons_per_count"), &prnu = *found.find("prnu");
  EXPECT_LT(gain.sd, 0.002);
  EXPECT_NEAR(gain.value, 2.0, 4.0 * gain.sd);
  EXPECT_NEAR(prnu.value, 0.01, 4.0 * prnu.sd);
}

// Pixels that blink otherwise than the chain's are said, others are not taken for blinking ones.
TEST(CharacterizePixels, OtherBlinkingOnes) {
  Random random(9);
  const auto found = [&](const PixelCamera& camera, int frames = 64) {
    return found_of(camera, array_of(camera, random), random, frames);
  };
  for (int draw = 0; draw < 10; ++draw) {
    const Characterization good = found({.hot_share = draw % 2 * 0.01, .hot_e = 500.0});
    EXPECT_EQ(good.find("blinking_fraction")->verdict, Verdict::upper_limit);
    EXPECT_EQ(good.find("blinking_fraction")->low95, 0.0);
    EXPECT_NEAR(good.find("blinking_fraction")->high95, 3.689 / kPixels, 1e-6);  // no event: -ln 0.025
    EXPECT_TRUE(good.warnings.empty()) << good.warnings.front();
  }
  const PixelCamera blinks{.blinking_share = 0.03, .blinking_e = 300.0};
  EXPECT_TRUE(found(blinks).warnings.empty());
  PixelCamera other = blinks;
  other.equally_blinking = true;
  EXPECT_TRUE(warned_of(found(other), "not exponentially"));
  other = blinks;
  other.seldom_high = true;
  EXPECT_TRUE(warned_of(found(other), "% of the time"));
  // A time in a state beyond the stack: hardly any changes, and hot ones otherwise.
  other = blinks;
  other.dwell = 1e5;
  EXPECT_NE(found(other).find("blinking_fraction")->verdict, Verdict::determined);
  EXPECT_NE(found(blinks, 4).find("blinking_fraction")->why.find("8 frames"), std::string::npos);
}

TEST(CharacterizePixels, NoiseOneOverF) {
  Random random(6);
  const auto found = [&](const PixelCamera& camera, int frames) {
    return found_of(camera, array_of(camera, random), random, frames);
  };
  const Characterization none = found({}, 64);
  EXPECT_EQ(none.find("flicker_octave")->verdict, Verdict::upper_limit);
  EXPECT_EQ(none.find("flicker_octave")->value, 0.0);
  EXPECT_LT(none.find("flicker_octave")->high95, 0.35);
  EXPECT_NE(found({}, 8).find("flicker_octave")->why.find("16 frames"), std::string::npos);
  const Characterization lag = found({.lasting = 0.4}, 64);
  EXPECT_NE(lag.find("flicker_octave")->why.find("not as 1/f noise"), std::string::npos);
  EXPECT_TRUE(warned_of(lag, "correlated from frame to frame"));
  EXPECT_FALSE(warned_of(found({.octave_e = 2.0}, 64), "correlated from frame to frame"));
}

// The chain's own noise and pixels, made by its stages: what is found are the numbers of its sensor file.
void expect_stages_held(int draws) {
  const radiometry::Defects defects{.dead_fraction = 0.01, .hot_fraction = 0.02, .hot_e = 300.0};
  const radiometry::FlickerOctaves flicker{.octave_e = 1.5, .lowest_cy_frame = 0.1 / 64.0};
  const radiometry::Blinking blinking{.fraction = 0.02, .excess_e = 250.0, .dwell_frames = 5.0};
  std::map<std::string, int> held;
  const std::set<std::string> with_flicker{"flicker_octave", "read_noise", "dsnu"};  // where that is refused
  int refused = 0;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(draws); ++seed) {
    const auto found_defects = radiometry::find_defects(kPixelSide, kPixelSide, defects, seed);
    const auto found_blinking = radiometry::find_blinking(kPixelSide, kPixelSide, blinking, seed);
    mtf::Image offset(kPixelSide, kPixelSide);
    radiometry::offset_map(offset.view(), 3.0, seed);
    std::vector<Stack> stacks;
    std::uint32_t number = 0;
    for (const double light : {0.0, 1.0, 2.0, 4.0}) {
      StackStatistics sums(kPixelSide, kPixelSide, {.low = 0.0, .high = 16383.0});
      std::vector<mtf::Image> frames;
      for (int t = 0; t < (light > 0.0 ? 8 : 64); ++t, ++number) {
        mtf::Image frame(kPixelSide, kPixelSide);
        std::fill_n(frame.data(), frame.size(), static_cast<float>(3000.0 * light));
        radiometry::apply_defects(frame.view(), found_defects);
        radiometry::apply_blinking(frame.view(), found_blinking, blinking, {seed, number});
        radiometry::shot_noise(frame.view(), {seed, number});
        radiometry::add_map(frame.view(), offset.view());
        radiometry::add_gaussian(frame.view(), 3.0, {seed, number}, radiometry::Stream::read);
        radiometry::add_frame_flicker(frame.view(), flicker.noise(), {seed, number});
        for (std::int64_t i = 0; i < frame.size(); ++i) frame.data()[i] = std::floor(0.5F * frame.data()[i] + 100.7F);
        sums.add(frame.view());
        frames.push_back(std::move(frame));
      }
      stacks.push_back({.name = "stack", .light = light, .sums = summary_of(sums)});
      stacks.back().sums.series = empty_series(stacks.back().sums);
      for (const mtf::Image& frame : frames) stacks.back().sums.series.add(frame.view());
    }
    const Characterization found = characterize(std::move(stacks), {});
    const bool is_refused = found.find("flicker_octave")->verdict == Verdict::not_determined;
    refused += is_refused ? 1 : 0;
    for (const auto& [name, truth] :
         {std::pair{"hot_fraction", 0.02}, std::pair{"hot_excess", 300.0}, std::pair{"dead_fraction", 0.01},
          std::pair{"flicker_octave", 1.5}, std::pair{"read_noise", 3.0}, std::pair{"rate", 3000.0},
          std::pair{"dsnu", 3.0}, std::pair{"blinking_fraction", 0.02}, std::pair{"blinking_excess", 250.0},
          std::pair{"blinking_dwell", 5.0}}) {
      if (is_refused && with_flicker.contains(name)) continue;
      const Finding* f = found.find(name);
      ASSERT_TRUE(f != nullptr && f->verdict == Verdict::determined) << name;
      EXPECT_LT(std::abs(f->value - truth), 4.5 * f->sd) << name;
      held[name] += f->low95 <= truth && truth <= f->high95 ? 1 : 0;
    }
  }
  EXPECT_LE(refused, 1 + draws / 40);  // 1/f noise whose scales chance makes others
  for (const auto& [name, count] : held) {
    testing::Test::RecordProperty(name, count);
    EXPECT_GE(count,
              (draws - (with_flicker.contains(name) ? refused : 0)) * 0.95 - 4.2 * std::sqrt(draws * 0.95 * 0.05))
        << name;
  }
}

TEST(CharacterizePixels, StagesOfTheChain) { expect_stages_held(20); }
TEST(CharacterizePixelsLong, StagesOfTheChain) { expect_stages_held(120); }

}  // namespace
}  // namespace calib
