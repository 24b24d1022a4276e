// SPDX-License-Identifier: Apache-2.0

// The lag of cameras of known lag, from frames that are drawn with random numbers of the standard library, and from the
// stage of the chain.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "calib/characterize/lag_step.h"
#include "radiometry/stages/detector/lag.h"
#include "tests/expect_error.h"

namespace calib {
namespace {

using Engine = std::mt19937_64;

/// Means of frames before and after a step from 4000 to 100 counts, each with noise of 0.3, of which successive ones
/// share `memory` as blinking pixels make them, and with that of the light, `light` counts before the step.
std::vector<double> means_of(double kept, Engine& engine, int before = 12, int after = 40, double other = 0.0,
                             double within = 0.0, double memory = 0.0, double light = 0.0) {
  std::normal_distribution<double> noise(0.0, 0.3);
  double lasts = noise(engine);
  std::vector<double> means;
  double part = 1.0, slow = 1.0;  // of the step that is left
  for (int t = 0; t < before + after; ++t) {
    if (t >= before) {
      part = part * kept + (t == before ? within * (1.0 - kept) : 0.0);
      slow *= 0.95;
    }
    means.push_back(100.0 + 3900.0 * (t < before ? 1.0 : (1.0 - other) * part + other * slow) + lasts +
                    light * std::sqrt(t < before ? 1.0 : part) * noise(engine));
    lasts = memory * lasts + std::sqrt(1.0 - memory * memory) * noise(engine);
  }
  return means;
}

Characterization found_of(const std::vector<double>& means, double frame_time_s = 0.02) {
  Characterization camera;
  add_lag(fit_lag_step(means), frame_time_s, "step", camera);
  return camera;
}

// Of 1,000 intervals from 930 to 970 should hold; 910 and 983 are 2.5 standard deviations beyond. Those of a lag that
// is not there hold all, as they begin at 0.
TEST(LagStep, IntervalsHoldAsStated) {
  for (const auto& [kept, memory] :
       {std::pair{0.0, 0.0}, {0.01, 0.0}, {0.3, 0.0}, {0.8, 0.0}, {0.25, 0.7}, {0.6, 0.7}, {0.8, 0.7}}) {
    std::map<std::string, int> held;
    int as_it_is = 0;
    for (std::uint64_t draw = 0; draw < 1000; ++draw) {
      Engine engine(100 + draw);
      const Characterization camera =
          found_of(means_of(kept, engine, 12, 40, 0.0, 0.0, memory, memory > 0.0 ? 4.0 : 0.0));
      const Finding& share = *camera.find("lag_share");
      as_it_is += share.verdict == (kept == 0.0 ? Verdict::upper_limit : Verdict::determined) ? 1 : 0;
      held["share"] += share.low95 <= kept && kept <= share.high95 ? 1 : 0;
      const Finding* const time = camera.find("lag_time_constant");
      if (time == nullptr || kept == 0.0) continue;
      const double truth = -0.02 / std::log(kept);
      held["time"] += time->low95 <= truth && truth <= time->high95 ? 1 : 0;
      EXPECT_LT(std::abs(time->value - truth), 6.0 * time->sd);
    }
    EXPECT_GE(as_it_is, 990) << kept;  // one in a thousand is beyond 3 sd, or refused
    for (const auto& [name, count] : held) {
      testing::Test::RecordProperty(name + std::to_string(kept) + " " + std::to_string(memory), count);
      EXPECT_GE(count, 910) << name << " of " << kept;
      EXPECT_LE(count, kept > 0.0 ? 983 : 1000) << name << " of " << kept;
    }
  }
}

// The stage itself, up and down, without noise: the time constant to rounding.
TEST(LagStep, IsThatOfTheStage) {
  for (const auto& [from, to] : {std::pair{2000.0F, 50.0F}, std::pair{50.0F, 2000.0F}}) {
    radiometry::LagState state;
    std::vector<double> means;
    for (int t = 0; t < 60; ++t) {
      mtf::Image frame(2, 2);
      std::fill_n(frame.data(), frame.size(), t < 10 ? from : to);
      radiometry::apply_lag(frame.view(), {.time_constant_s = 0.013}, 0.02, state);
      means.push_back(static_cast<double>(frame.data()[0]));
    }
    // Floats round by 6e-8 of a value.
    EXPECT_NEAR(found_of(means).find("lag_time_constant")->value, 0.013, 1e-7);
  }
}

TEST(LagStep, OtherCoursesAreSaid) {
  Engine engine(7);
  for (const auto& means : {means_of(0.2, engine, 12, 40, 0.0, 0.4),  // light for a part of the first exposure
                            means_of(0.2, engine, 12, 40, 0.1)}) {    // a tenth of the lag is slower
    const Characterization camera = found_of(means);
    EXPECT_EQ(camera.find("lag_share")->verdict, Verdict::not_determined);
    expect_says(camera.find("lag_share")->why, {"one exponential", "between two exposures"});
    EXPECT_EQ(camera.find("lag_time_constant"), nullptr);
  }
  // A tenth of the step is left at the end: the interval of what is kept reaches 1.
  std::vector<double> rising = means_of(0.0, engine);
  std::normal_distribution<double> noise(0.0, 20.0);
  for (std::size_t t = 12; t < rising.size(); ++t) rising[t] = 4000.0 - 40.0 * static_cast<double>(t) + noise(engine);
  rising[12] -= 400.0;
  EXPECT_NE(found_of(rising).find("lag_share")->verdict, Verdict::upper_limit);
}

TEST(LagStep, Refusals) {
  Engine engine(8);
  expect_refused({"after 4 of 44 frames", "8 or more before"}, [&] { fit_lag_step(means_of(0.1, engine, 4)); });
  expect_refused({"after 12 of 22", "16 or more after"}, [&] { fit_lag_step(means_of(0.1, engine, 12, 10)); });
  std::vector<double> still;
  std::normal_distribution<double> noise;
  for (int t = 0; t < 60; ++t) still.push_back(noise(engine));
  const auto largest = [&] { return fit_lag_step(still); };
  try {
    largest();
    FAIL() << "a stack without a step";
  } catch (const mtf::UsageError& error) {
    const std::string words = error.what();
    EXPECT_TRUE(words.find("no step") != std::string::npos || words.find("the light steps after") == 0) << words;
  }
  expect_refused({"0 of 0 frames"}, [] { fit_lag_step({}); });
}

}  // namespace
}  // namespace calib
