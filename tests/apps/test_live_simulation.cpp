// SPDX-License-Identifier: Apache-2.0

// A live view whose sensor changes between images: each image is the one that a new view of that sensor shows, whatever
// was shown, or refused, before.

#include <cstring>

#include "apps/simulate/simulate.h"
#include "tests/apps/live_images.h"
#include "tests/replaced.h"

namespace apps_test {
namespace {

const std::string kFilters = R"([[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
width = "15 um"
)";

const std::string kPlain = R"(schema = 1
name = "plain"
[frame]
focal_length = "100 mm"
pitch = "15 um"
[scene]
sample = "7.5 um"
quantity = "radiance"
[optics]
f_number = 2.5
[band]
wavelength = ["3 um", "5 um"]
)" + kFilters;

bool same_pixels(const Image& a, const Image& b) {
  return a.width() == b.width() && a.height() == b.height() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(float)) == 0;
}

/// What sliders do to a sensor, one after the other, and what a hand does that writes in the file.
std::vector<std::string> changes() {
  const auto jitter = [](const char* rms) {
    return std::string("[[presample]]\nkind = \"jitter\"\nrms = \"") + rms + "\"\n";
  };
  const std::string turned = "[[presample]]\nkind = \"linear_motion\"\ntravel = \"12 um\"\ndirection = \"35 deg\"\n";
  return {jitter("10 urad"),
          jitter("20 urad"),
          jitter("30 urad"),
          jitter("200 urad"),  // frequencies are left out
          jitter("30 urad") + turned,
          jitter("40 urad") + turned,
          jitter("40 urad") + "[[readout]]\nkind = \"gaussian\"\nsigma = \"4 um\"\n",
          jitter("50 urad") + "[[postsample]]\nkind = \"gaussian\"\nsigma = \"4 um\"\n",
          jitter("50 urad")};
}

/// The same transforms, and of the OTF the same left out: images have the same bits then.
bool same_work(const mtf::SensorPlan& a, const mtf::SensorPlan& b) {
  const auto same = [](const mtf::Plan& p, const mtf::Plan& q) {
    const mtf::PlanReport &r = p.report(), &s = q.report();
    return r.method == s.method && r.axes == s.axes && r.kept == s.kept && r.merged == s.merged &&
           r.dropped.size() == s.dropped.size() && r.predicted.flat == s.predicted.flat && p.dc() == q.dc();
  };
  return same(a.presample, b.presample) && a.post.has_value() == b.post.has_value() &&
         a.readout.has_value() == b.readout.has_value() && (!a.post || same(*a.post, *b.post)) &&
         (!a.readout || same(*a.readout, *b.readout));
}

// The device that is named reaches the plans of images that follow one another.
TEST_F(LiveSimulation, ADeviceIsAmongTheCandidates) {
  const std::vector<mtf::DeviceInfo> devices = mtf::devices().devices;
  if (devices.empty()) GTEST_SKIP() << "no device";
  apps::LiveSimulation live(temperatures(), {.device = {mtf::open_device(devices.front()), true}});
  image(live, sensor(kPlain), 0, apps::CorrectionOf::own);
  const auto& candidates = live.plan().presample.report().candidates;
  EXPECT_TRUE(std::any_of(candidates.begin(), candidates.end(),
                          [](const mtf::Candidate& c) { return c.method == mtf::Method::fft_device; }));
}

// Rows that nobody looks at may be without noise; the others are those of the whole image. Where a stage takes values
// from other rows, all of them have it.
TEST_F(LiveSimulation, NoiseOfTheRowsThatAreLookedAt) {
  const std::string noise = "[noise]\nseed = 5\ncolumn = \"40 e-\"\n[nonuniformity]\nprnu = 0.01\n[adc]\nbits = 14\n";
  const apps::CorrectionOf own = apps::CorrectionOf::own;
  const SensorConfig shown = camera(noise),
                     sharpened = camera(noise + "[[postsample]]\nkind = \"gaussian\"\nsigma = \"4 um\"\n");
  apps::LiveSimulation live(temperatures());
  const Image whole = image(live, shown, 3, own);
  EXPECT_EQ(live.noise_rows(), 1);
  const Image some = std::move(live.image(shown, 3, own, 4).planes.at(0));
  EXPECT_EQ(live.noise_rows(), 4);
  bool others_same = true;
  for (std::int64_t y = 0; y < whole.height(); ++y)
    for (std::int64_t x = 0; x < whole.width(); ++x)
      if (y % 4 == 0)
        ASSERT_EQ(some.at(x, y), whole.at(x, y)) << x << ", " << y;
      else
        others_same = others_same && some.at(x, y) == whole.at(x, y);
  EXPECT_FALSE(others_same);
  const Image filtered = image(live, sharpened, 3, own);
  EXPECT_TRUE(same_pixels(filtered, std::move(live.image(sharpened, 3, own, 4).planes.at(0))));
  EXPECT_EQ(live.noise_rows(), 1);
}

// A view that keeps the transforms of its scene beside one that gets the scene anew with each image, and beside a call
// of its own for each image, where that has the same plan. Borders and what lies beyond them change in between.
TEST_F(LiveSimulation, WhatIsKeptOfTheSceneChangesNoBit) {
  const std::string chain = "[noise]\nseed = 5\n[nonuniformity]\nprnu = 0.01\n[adc]\nbits = 14\n",
                    distortion = "[distortion]\nk1 = -0.05\n";
  const apps::SimulateOptions options{.tolerance = 5e-5};
  for (const std::string& base : {kPlain, kSensor + chain, kSensor + chain + distortion}) {
    SCOPED_TRACE(base);
    apps::LiveSimulation live(temperatures(), options), anew(options);
    int images = 0, transforms = 0, of_the_same_plan = 0;
    const auto expect_same = [&](const SensorConfig& shown) {
      const Image kept = image(live, shown, 0, apps::CorrectionOf::own);
      const auto again = anew.image(std::move(*temperatures().image), std::make_shared<const SensorConfig>(shown), 0,
                                    apps::CorrectionOf::own);
      EXPECT_TRUE(same_pixels(kept, again.planes.front())) << live.plan().presample.explain();
      const apps::SimulateResult alone = apps::simulate(shown, temperatures(), options);
      const bool same_plan = same_work(live.plan(), *alone.report.plan);
      EXPECT_TRUE(!same_plan || same_pixels(kept, alone.images.front().planes.front()));
      ++images;
      transforms += live.plan().presample.report().method.starts_with("fft") ? 1 : 0;
      of_the_same_plan += same_plan ? 1 : 0;
    };
    for (const std::string& change : changes())
      for (const auto& [border, beyond] : {std::pair{mtf::Border::reflect, 0.0},
                                           {mtf::Border::constant, 290.0},
                                           {mtf::Border::constant, 301.0},
                                           {mtf::Border::reflect, 0.0}}) {
        SensorConfig shown = sensor(base + change);
        shown.scene.border = border;
        shown.scene.border_value = beyond;
        expect_same(shown);
        expect_same(shown);
      }
    EXPECT_GT(transforms, images / 2);
    EXPECT_GT(of_the_same_plan, images / 3);
    EXPECT_EQ(live.kept_bytes() > 0, base.find(distortion) == std::string::npos);
    EXPECT_EQ(anew.kept_bytes(), 0);
  }
}

TEST_F(LiveSimulation, ASensorWithoutAChainGetsTheSceneAndNotItsLight) {
  const SensorConfig with = camera("[adc]\nbits = 14\n"), without = sensor(kPlain);
  apps::LiveSimulation live(temperatures());
  for (const SensorConfig* shown : {&with, &without, &with})
    EXPECT_LT(difference(image(live, *shown), alone(temperatures(), *shown)), 1e-2);
}

TEST_F(LiveSimulation, ChangesOfTheSceneTableChangeTheScene) {
  const SensorConfig before = sensor(kPlain);
  apps::LiveSimulation live(file());
  image(live, before);
  const auto expect_as_alone = [&](const char* what, const auto& change) {
    SensorConfig changed = before;
    change(changed.scene);
    EXPECT_LT(difference(image(live, changed), alone(file(), changed)), kTwoPlans) << what;
    EXPECT_LT(difference(image(live, before), alone(file(), before)), kTwoPlans) << what;
  };
  expect_as_alone("gain", [](auto& scene) { scene.gain = 3.0; });
  expect_as_alone("offset", [](auto& scene) { scene.offset = 2.0; });
  SensorConfig constant = before;
  constant.scene.border = mtf::Border::constant;
  constant.scene.border_value = 5.0;
  image(live, constant);
  constant.scene.border_value = 9.0;
  EXPECT_LT(difference(image(live, constant), alone(file(), constant)), kTwoPlans);
  SensorConfig photons = before;
  photons.scene.quantity = mtf::io::Quantity::photon_radiance;
  EXPECT_EQ(live.image(before).metadata.text.at("mtf:quantity"), "radiance");
  EXPECT_EQ(live.image(photons).metadata.text.at("mtf:quantity"), "photon_radiance");
}

TEST_F(LiveSimulation, ThePlanFollowsBorderAndAperture) {
  const SensorConfig before = sensor(kPlain);
  SensorConfig periodic = before, box = before;
  periodic.scene.border = mtf::Border::periodic;
  box.scene.aperture = mtf::io::Aperture::box;
  apps::LiveSimulation live(file());
  for (const SensorConfig* shown :
       std::initializer_list<const SensorConfig*>{&before, &periodic, &before, &box, &before})
    EXPECT_LT(difference(image(live, *shown), alone(file(), *shown)), kTwoPlans);
  EXPECT_GT(difference(alone(file(), periodic), alone(file(), before)), 1e-2);
  EXPECT_GT(difference(alone(file(), box), alone(file(), before)), 1e-2);
}

TEST_F(LiveSimulation, FiltersSplitWhereNoiseComesBetween) {
  const std::string readout = "[[readout]]\nkind = \"gaussian\"\nsigma = \"4 um\"\n";
  const SensorConfig without = sensor(kPlain + readout), with = camera(readout);
  apps::LiveSimulation live(temperatures());
  for (const SensorConfig* shown : {&without, &with, &without})
    EXPECT_LT(difference(image(live, *shown), alone(temperatures(), *shown)), 1e-2);
}

TEST_F(LiveSimulation, TheDefaultToleranceIsThatOfTheImage) {
  const SensorConfig coarse = camera("[adc]\nbits = 8\n"), fine = camera("[adc]\nbits = 16\n"), none = camera();
  apps::LiveSimulation live(temperatures());
  const auto tolerance = [&](const SensorConfig& sensor) {
    image(live, sensor);
    return live.plan().options.tolerance;
  };
  const double of_coarse = tolerance_alone(temperatures(), coarse), of_fine = tolerance_alone(temperatures(), fine);
  ASSERT_GT(of_coarse, 10.0 * of_fine);
  EXPECT_EQ(tolerance(coarse), of_coarse);
  EXPECT_EQ(tolerance(fine), of_fine);
  apps::LiveSimulation again(temperatures());
  image(again, coarse);
  image(again, none);
  EXPECT_EQ(again.plan().options.tolerance, 1e-4);
}

TEST_F(LiveSimulation, AToleranceThatWasLoosenedIsTriedAnewForAnotherSensor) {
  const SensorConfig before = sensor(kPlain);
  SensorConfig hard = before;
  hard.scene.offset = 1e4;
  apps::LiveSimulation live(file());
  image(live, hard);
  ASSERT_GT(live.plan().options.tolerance, 1e-4);
  ASSERT_FALSE(live.warnings().empty());
  const int compiled = live.plans_compiled();
  image(live, hard);
  EXPECT_EQ(live.plans_compiled(), compiled);
  image(live, before);
  EXPECT_EQ(live.plan().options.tolerance, 1e-4);
}

// A frame of little contrast among others: its own promise gives way, and that of the others is kept again.
TEST_F(LiveSimulation, AFrameWithoutContrastLeavesTheToleranceToTheNext) {
  const auto shown = std::make_shared<const SensorConfig>(camera());
  const auto of_contrast = [](double amplitude) {
    mtf::io::Scene scene;
    scene.quantity = mtf::io::Quantity::temperature;
    scene.planes.push_back(ramp(300.0, amplitude));
    return scene;
  };
  for (const bool loosen : {true, false}) {
    apps::LiveSimulation live({.tolerance = 1e-3, .loosen = loosen});
    live.image(of_contrast(5.0), shown, 0);
    EXPECT_EQ(live.plan().options.tolerance, 1e-3);
    if (!loosen) {
      EXPECT_THROW(live.image(of_contrast(2e-3), shown, 1), mtf::UnreachableTolerance);
      continue;
    }
    for (int frame = 1; frame < 4; ++frame) {
      live.image(of_contrast(2e-3), shown, frame);
      EXPECT_GT(live.plan().options.tolerance, 1e-3);
    }
    EXPECT_EQ(live.plans_compiled(), 2);
    live.image(of_contrast(5.0), shown, 4);
    EXPECT_EQ(live.plan().options.tolerance, 1e-3);
    EXPECT_TRUE(live.warnings().empty());
    EXPECT_EQ(live.plans_compiled(), 3);
    // Contrast that fades to 3e-4 in 50 frames takes a plan for each factor of 2 or somewhat less.
    std::size_t warned = 0;
    double amplitude = 5.0;
    for (int frame = 5; frame < 55; ++frame, amplitude *= 0.85) {
      live.image(of_contrast(amplitude), shown, frame);
      warned += live.warnings().size();
    }
    EXPECT_LE(live.plans_compiled(), 20);
    EXPECT_LE(warned, 6u);
  }
  apps::LiveSimulation never({.tolerance = 1e-12, .loosen = true});
  EXPECT_THROW(never.image(of_contrast(5.0), shown, 0), mtf::UnreachableTolerance);
}

TEST_F(LiveSimulation, AFailedImageLeavesNothingToTheNext) {
  const std::string lag = "[lag]\ntime_constant = \"20 ms\"\n";
  const SensorConfig good = camera(lag + "[adc]\nbits = 14\n");
  // Its flat frames saturate the converter: refused after the lag, which remembers less light.
  std::string text =
      kSensor + lag + "[adc]\nbits = 8\nelectrons_per_count = \"10 e-\"\n[correction]\nlow = 0.2\nhigh = 0.8\n";
  text = replaced(text, "transmission = 0.85", "transmission = 0.30");
  const SensorConfig bad = sensor(text);
  apps::LiveSimulation live(temperatures()), undisturbed(temperatures());
  EXPECT_TRUE(same_pixels(image(live, good, 1), image(undisturbed, good, 1)));
  EXPECT_THROW(live.image(bad, 2), mtf::UsageError);
  EXPECT_TRUE(same_pixels(image(live, good, 3), image(undisturbed, good, 3)));
  EXPECT_EQ(live.plans_compiled(), undisturbed.plans_compiled());
  EXPECT_EQ(live.plans_updated(), undisturbed.plans_updated());
}

TEST_F(LiveSimulation, PixelsOfAnotherGridRememberNothing) {
  const SensorConfig before = camera("[lag]\ntime_constant = \"20 ms\"\n");
  SensorConfig coarse = before;
  coarse.system.frame.pitch_x_um = coarse.system.frame.pitch_y_um = 30.0;
  apps::LiveSimulation live(temperatures());
  image(live, before, 1);
  EXPECT_LT(difference(image(live, coarse, 2), alone(temperatures(), coarse)), kTwoPlans);
  EXPECT_LT(difference(image(live, before, 3), alone(temperatures(), before)), kTwoPlans);
}

// The electron rate of the band is made anew for every image: equal values ask for nothing.
TEST_F(LiveSimulation, ASensorThatStaysKeepsItsPlan) {
  const auto with_source = [&](const std::string& temperature) {
    std::string text = kSensor;
    text = replaced(text, "sample =", "source_temperature = \"" + temperature + "\"\nsample =");
    return sensor(text);
  };
  const SensorConfig warm = with_source("300 K"), hot = with_source("900 K");
  apps::LiveSimulation live(temperatures());
  for (int i = 0; i < 3; ++i) image(live, warm);
  EXPECT_EQ(live.plans_compiled(), 1);
  EXPECT_EQ(live.plans_updated(), 0);
  image(live, hot);  // another rate, other weights of the wavelengths
  EXPECT_EQ(live.plans_compiled() + live.plans_updated(), 2);
  EXPECT_LT(difference(image(live, hot), alone(temperatures(), hot)), kTwoPlans);
}

// A tolerance of a share of a count falls as the contrast rises, here by 3 % from image to image to 2.4 times the
// first.
TEST_F(LiveSimulation, AContrastThatRisesSlowlyTakesFewPlans) {
  std::string text = kSensor + "[adc]\nbits = 14\n";
  text = replaced(text, "\"temperature\"", "\"radiance\"");
  SensorConfig shown = sensor(text);
  apps::LiveSimulation live(file());
  double gain = 0.01;
  for (int i = 0; i < 30; ++i, gain *= 1.03) {
    shown.scene.gain = gain;
    image(live, shown);
    EXPECT_LE(live.plan().options.tolerance, tolerance_alone(file(), shown) * (1.0 + 1e-6)) << i;
  }
  EXPECT_LE(live.plans_compiled(), 3);
  EXPECT_EQ(live.plans_updated(), 0);
  shown.scene.gain = 2.5 * gain;
  const int before = live.plans_compiled();
  image(live, shown);
  EXPECT_EQ(live.plans_compiled(), before + 1);  // beyond the room
}

}  // namespace
}  // namespace apps_test
