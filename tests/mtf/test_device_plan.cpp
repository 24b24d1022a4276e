// SPDX-License-Identifier: Apache-2.0
// Plans that filter on a device: the promise of the processor, and who does the work where the device cannot.

#include <algorithm>

#include "apps/check/reference_fft.h"
#include "mtf/device/device_filter.h"
#include "mtf/device/device_parts.h"
#include "mtf/work/stopwatch.h"
#include "tests/expect_error.h"
#include "tests/mtf/device_support.h"
#include "tests/mtf/field_systems.h"
#include "tests/mtf/plan_support.h"
#include "tests/mtf/sweep_cases.h"

namespace mtf::test {
namespace {

PlanOptions on_device(PlanOptions options) {
  options.device = {open_tested_device(), true};
  options.method = Method::fft_device;
  return options;
}

const Candidate* device_candidate(const Plan& plan) {
  const std::vector<Candidate>& list = plan.report().candidates;
  const auto found =
      std::find_if(list.begin(), list.end(), [](const Candidate& c) { return c.method == Method::fft_device; });
  return found == list.end() ? nullptr : &*found;
}

struct Sight {
  const char* what;
  System<double> system;
  double ratio;
};

// Real and complex OTFs, mirrored or not, at one to four samples a pixel.
std::vector<Sight> sights() {
  System<double> optics = with(bare(15.0, 15.0), {Component<double>::make("diffraction"), gaussian(7.0)});
  optics.optics.f_number = 6.0;
  return {{"gaussian", with(bare(), {gaussian(9.0)}), 1.0},
          {"footprint", with(bare(15.0, 15.0), {gaussian(12.0), footprint(15.0)}), 2.0},
          {"diffraction", optics, 1.0},
          {"diffraction 3", optics, 3.0},
          {"rc", with(bare(15.0, 15.0), {gaussian(9.0), rc(30.0, 0)}), 1.0},
          {"rc along y", with(bare(15.0, 15.0), {gaussian(9.0), rc(25.0, 1)}), 2.0},
          {"motion", with(bare(15.0, 15.0), {gaussian(9.0), motion(20.0, 30.0)}), 2.0},
          {"jitter", with(bare(), {jitter(80.0)}), 4.0},
          {"all", with(optics, {footprint(15.0), motion(12.0, 110.0), rc(20.0, 0)}), 4.0},
          {"sharp", with(bare(15.0, 15.0), {gaussian(1.0)}), 2.0},
          {"long", with(bare(15.0, 15.0), {gaussian(60.0)}), 1.0},
          {"nothing", with(bare(15.0, 15.0), {}), 3.0}};
}

class DevicePromise : public testing::TestWithParam<Border> {};

TEST_P(DevicePromise, holds_for_every_system) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  constexpr double kBeyond = 18.0;
  int done = 0;
  for (const Sight& sight : sights()) {
    SCOPED_TRACE(sight.what);
    // Multiples of the ratios, without factors above 7 themselves and mirrored or thrice.
    const SampleGrid in = scene_grid(sight.system, 48, 36, sight.ratio, sight.ratio);
    const SampleGrid out = detector_grid(sight.system, in);
    const Image scene = random_image(in.width, in.height, 7, 20.0, 3.0);
    const auto expected = reference_image(scene, in, out, otf_of(sight.system, Stage::presample), GetParam(), kBeyond);
    const Plan plan = compile(sight.system, in, out, on_device(options_for(scene, GetParam(), 1e-4, kBeyond)));
    ASSERT_EQ(plan.report().method, "fft_device");
    const double rms = rms_distance(run(plan, scene, kBeyond), expected) / statistics(scene.view()).std;
    const double promised = plan.report().predicted.total();
    EXPECT_LE(rms, promised) << plan.explain();
    EXPECT_LE(promised, 1e-4);
    ++done;
  }
  EXPECT_EQ(done, 12);
}

INSTANTIATE_TEST_SUITE_P(Borders, DevicePromise, testing::ValuesIn(kBorders), [](const auto& test) {
  return std::string(kBorderNames[static_cast<std::size_t>(test.param)]);
});

PlanOptions diamond_on_device(PlanOptions options) {
  options = on_device(std::move(options));
  options.method = Method::direct_diamond;
  return options;
}

// The rhombus of the founding paper: its own promise, and beside the processor's with the same taps.
TEST_P(DevicePromise, of_the_diamond_holds_and_its_sums_are_the_processors_but_for_roundings) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  constexpr double kBeyond = 18.0;
  int done = 0;
  for (const Sight& sight : sights())
    for (const double tolerance : {0.1, 1e-2, 1e-3}) {
      SCOPED_TRACE(sight.what);
      const SampleGrid in = scene_grid(sight.system, 47, 33, sight.ratio, sight.ratio);
      const SampleGrid out = detector_grid(sight.system, in);
      const Image scene = random_image(47, 33, 7, 20.0, 3.0);
      PlanOptions options = options_for(scene, GetParam(), tolerance, kBeyond);
      options.method = Method::direct_diamond;
      std::optional<Plan> processor, plan;
      try {
        processor = compile(sight.system, in, out, options);
        plan = compile(sight.system, in, out, diamond_on_device(options));
      } catch (const UsageError&) {  // wide kernels
        EXPECT_FALSE(processor) << "a kernel of the processor that the device refuses";
        continue;
      }
      ASSERT_EQ(processor->report().method, "direct_diamond");
      ASSERT_EQ(plan->report().method, "diamond_device");
      expect_says(plan->explain(), {"on " + open_tested_device()->info().name});
      const Image image = run(*plan, scene, kBeyond, 2);
      const auto expected =
          reference_image(scene, in, out, otf_of(sight.system, Stage::presample), GetParam(), kBeyond);
      const double std = statistics(scene.view()).std, promised = plan->report().predicted.total();
      EXPECT_LE(rms_distance(image, expected) / std, promised) << plan->explain();
      EXPECT_LE(promised, tolerance);
      const Image other = run(*processor, scene, kBeyond);
      const double apart = rms_distance(image, {other.data(), other.data() + other.size()}) / std;
      EXPECT_LE(apart, 2.0 * plan->report().predicted.arithmetic);
      ++done;
    }
  EXPECT_GE(done, 6);
}

// Random systems, sizes, borders, tolerances and scenes, those that the device can do: `count` of them from seed
// `first`.
void sweep(std::uint64_t first, int count, std::int64_t largest_side) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  int kept = 0, elsewhere = 0;
  double closest = 0.0;
  for (std::uint64_t seed = first; kept < count; ++seed) {
    ASSERT_LT(seed - first, static_cast<std::uint64_t>(40 * count)) << "hardly a case is the device's";
    const SweepCase work = sweep_case(seed, {.least_side = 16, .largest_side = largest_side}, {});
    PlanOptions options = work.options();
    if (!options.scene) continue;
    options = on_device(std::move(options));
    std::optional<Plan> plan;
    try {
      plan = work.compile_with(options);
    } catch (const UsageError&) {  // lengths, ratios and tolerances that it cannot do
      ++elsewhere;
      continue;
    }
    if (plan->report().method != "fft_device") {  // over the field
      ++elsewhere;
      continue;
    }
    const auto exact = apps::check::exact_otf(work.system, work.stages, work.aperture, work.in);
    const auto expected = apps::check::reference_image_fft(work.scene.view(), work.in, work.out, exact, work.border,
                                                           work.border_value, 1);
    const double rms = rms_distance(run(*plan, work.scene, work.border_value), expected) / options.scene->std;
    EXPECT_LE(rms, plan->report().predicted.total()) << work.describe() << "\n" << plan->explain();
    EXPECT_LE(plan->report().predicted.total(), work.tolerance);
    closest = std::max(closest, rms / plan->report().predicted.total());
    ++kept;
  }
  std::printf("%d plans on the device kept their promise, the closest by %.2f; %d were not the device's\n", kept,
              closest, elsewhere);
}

class DeviceSweep : public testing::TestWithParam<int> {};

TEST_P(DeviceSweep, keeps_the_promise_at_random) {
  sweep(1000 + 1000 * static_cast<std::uint64_t>(GetParam()), 10, 60);
}

INSTANTIATE_TEST_SUITE_P(Ten, DeviceSweep, testing::Range(0, 4));

TEST(DeviceSweepLong, keeps_the_promise_at_random) { sweep(100000, 200, 200); }

TEST(DevicePlan, is_the_processors_where_no_device_is_given) {
  const System<double> system = with(bare(), {gaussian(9.0)});
  const Image scene = random_image(48, 36, 3);
  const SampleGrid in = scene_grid(system, 48, 36, 1.0, 1.0);
  PlanOptions options = options_for(scene, Border::reflect, 1e-4);
  EXPECT_EQ(device_candidate(compile(system, in, in, options)), nullptr);
  options.method = Method::fft_device;
  expect_refused({"fft_device", "takes a device"}, [&] { compile(system, in, in, options); });
}

TEST(DevicePlan, says_why_the_processor_is_chosen) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const System<double> system = with(bare(), {gaussian(9.0)});
  const auto explained = [&](std::int64_t width, std::int64_t height, double ratio, double tolerance) {
    const Image scene = random_image(width, height, 3);
    const SampleGrid in = scene_grid(system, width, height, ratio, ratio);
    PlanOptions options = options_for(scene, Border::periodic, tolerance);
    options.device = {open_tested_device(), false};
    const Plan plan = compile(system, in, detector_grid(system, in), options);
    EXPECT_NE(plan.report().method, "fft_device");
    const Candidate* const candidate = device_candidate(plan);
    return candidate == nullptr ? std::string("no candidate") : candidate->reason + "\n" + plan.explain();
  };
  expect_says(explained(32, 32, 1.0, 1e-3), {"x the cost", "on " + open_tested_device()->info().name});
  expect_says(explained(47, 36, 1.0, 1e-3), {"factors up to 7, not 47"});
  expect_says(explained(48, 36, 1.37, 1e-3), {"canvases of whole pixels"});
  expect_says(explained(48, 36, 1.0, 3e-7), {"does not keep the tolerance"});
}

class DeviceMethods : public testing::TestWithParam<Method> {};

INSTANTIATE_TEST_SUITE_P(Both, DeviceMethods, testing::Values(Method::fft_device, Method::direct_diamond),
                         [](const auto& test) {
                           return std::string(kMethodNames[static_cast<std::size_t>(test.param)]);
                         });

// Of a mean far above the contrast, of all scales of values, of a line: as on the processor.
TEST_P(DeviceMethods, keep_the_promise_at_extremes) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const bool transforms = GetParam() == Method::fft_device;
  const System<double> system = with(bare(15.0, 15.0), {gaussian(transforms ? 15.0 : 9.0)});
  const auto expect_kept = [&](Image scene, Border border, double beyond, double tolerance) {
    SCOPED_TRACE(tolerance);
    const SampleGrid in = scene_grid(system, scene.width(), scene.height(), 2.0, 2.0);
    const SampleGrid out = detector_grid(system, in);
    PlanOptions options = on_device(options_for(scene, border, tolerance, beyond));
    options.method = GetParam();
    const Plan plan = compile(system, in, out, options);
    const auto expected = reference_image(scene, in, out, otf_of(system, Stage::presample), border, beyond);
    const Image image = run(plan, scene, beyond);
    ASSERT_TRUE(all_finite(image));
    EXPECT_LE(rms_distance(image, expected) / options.scene->std, plan.report().predicted.total()) << plan.explain();
  };
  expect_kept(random_image(48, 36, 5, 1e6, 1.0), Border::reflect, 0.0, 0.2);
  expect_kept(random_image(48, 36, 5, 1e4, 1.0), Border::constant, 1e4, 1e-2);
  for (const double scale : {1e-44, 1e-36, 1e-25, 1e25, 5e36}) {
    Image scene = random_image(48, 36, 4, 1.0);
    for (std::int64_t i = 0; i < scene.size(); ++i)
      scene.data()[i] = static_cast<float>(std::clamp<double>(scene.data()[i], -3.0, 3.0) * scale);
    expect_kept(std::move(scene), Border::periodic, 0.0, scale < 1e-40 ? 0.5 : transforms ? 1e-4 : 1e-2);
  }
  expect_kept(random_image(2, 48, 5, 1.0), Border::reflect, 0.0, transforms ? 1e-3 : 1e-2);
  expect_kept(random_image(48, 2, 5, 1.0), Border::constant, 3.0, transforms ? 1e-3 : 1e-2);
  if (!transforms) return expect_kept(random_image(2, 2, 5, 1.0), Border::replicate, 0.0, 1e-2);
  // A tolerance below what floats can keep names one that they can.
  const Image scene = random_image(48, 36, 5);
  const SampleGrid in = scene_grid(system, 48, 36, 2.0, 2.0);
  PlanOptions options = on_device(options_for(scene, Border::periodic, 1e-7));
  try {
    compile(system, in, detector_grid(system, in), options);
    ADD_FAILURE() << "accepted";
  } catch (const UnreachableTolerance& refusal) {
    options.tolerance = refusal.reachable();
    EXPECT_EQ(compile(system, in, detector_grid(system, in), options).report().method, "fft_device");
  }
}

/// Transforms take phase too; a kernel of it would be wide.
System<double> system_for(Method method, const Component<double>& with_phase) {
  if (method == Method::fft_device) return with(bare(15.0, 15.0), {gaussian(9.0), with_phase});
  return with(bare(15.0, 15.0), {gaussian(9.0)});
}

TEST_P(DeviceMethods, give_the_same_bits_again_for_several_planes_in_place) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const System<double> system = system_for(GetParam(), motion(20.0, 30.0));
  const SampleGrid in = scene_grid(system, 48, 36, 2.0, 2.0), out = detector_grid(system, in);
  std::vector<Image> scenes;
  for (unsigned seed = 0; seed < 3; ++seed) scenes.push_back(random_image(48, 36, seed, 10.0));
  scenes.push_back(image_of(48, 36, [](auto, auto) { return 4.5; }));  // takes no filter
  PlanOptions options = on_device(options_for(scenes[0], Border::reflect, 1e-2));
  options.method = GetParam();
  const Plan plan = compile(system, in, out, options);
  ASSERT_TRUE(plan.report().method.ends_with("_device"));
  std::vector<Image> alone, together;
  std::vector<ImageView<const float>> from;
  std::vector<ImageView<float>> to;
  for (const Image& scene : scenes) alone.push_back(run(plan, scene, 0.0, 2));
  for (const Image& scene : scenes) together.push_back(scene.clone());
  for (Image& image : together) {
    from.push_back(image.view());
    to.push_back({image.data(), out.width, out.height, out.width});
  }
  plan.run(from, to);
  for (Image& image : together) image.reshape(out.width, out.height);
  for (std::size_t i = 0; i < scenes.size(); ++i) EXPECT_TRUE(same_bits(alone[i], together[i])) << i;
  Image bad = scenes[0].clone();
  bad.at(7, 5) = std::numeric_limits<float>::quiet_NaN();
  expect_refused<RuntimeError>({"NaN or infinite"}, [&] { run(plan, bad); });
  EXPECT_TRUE(same_bits(run(plan, scenes[0]), alone[0])) << "bad pixels are no failure of the device";
}

TEST_P(DeviceMethods, are_done_by_the_processor_where_the_device_fails) {
  const std::optional<DeviceInfo> info = tested_device();
  if (!info) GTEST_SKIP() << "no device";
  const System<double> system = system_for(GetParam(), rc(30.0, 0));
  const SampleGrid in = scene_grid(system, 48, 36, 2.0, 2.0), out = detector_grid(system, in);
  const Image scene = random_image(48, 36, 9, 10.0);
  const auto expected = reference_image(scene, in, out, otf_of(system, Stage::presample), Border::reflect, 0.0);
  PlanOptions options = options_for(scene, Border::reflect, 1e-2);
  options.method = GetParam();
  for (const bool insisted : {false, true}) {
    options.device = {open_device(*info, DeviceFault::run), insisted};
    const Plan plan = compile(system, in, out, options);
    EXPECT_TRUE(plan.report().method.ends_with("_device"));
    EXPECT_FALSE(options.device.device->failure());
    if (insisted) {
      EXPECT_THROW(run(plan, scene), DeviceError);
    } else {
      for (int again = 0; again < 2; ++again)
        EXPECT_LE(rms_distance(run(plan, scene), expected) / options.scene->std, 1e-2);
    }
    ASSERT_TRUE(options.device.device->failure());
    expect_says(*options.device.device->failure(), {"a fault that was asked for"});
  }
}

TEST(DevicePlan, runs_again_on_a_device_whose_memory_was_taken) {
  const std::optional<DeviceInfo> info = tested_device();
  if (!info) GTEST_SKIP() << "no device";
  const System<double> system = with(bare(15.0, 15.0), {gaussian(9.0)});
  const SampleGrid in = scene_grid(system, 48, 36, 2.0, 2.0), out = detector_grid(system, in);
  const Image scene = random_image(48, 36, 9, 10.0);
  PlanOptions options = options_for(scene, Border::reflect, 1e-4);
  options.method = Method::fft_device;
  options.device = {open_device(*info, DeviceFault::memory), true};
  const Plan plan = compile(system, in, out, options);
  EXPECT_THROW(run(plan, scene), DeviceMemoryError);
  expect_says(options.device.device->failure().value(), {"no memory left"});
  options.device.device->parts().fault = DeviceFault::none;
  const auto expected = reference_image(scene, in, out, otf_of(system, Stage::presample), Border::reflect, 0.0);
  EXPECT_LE(rms_distance(run(plan, scene), expected) / options.scene->std, 1e-4);
}

TEST(DevicePlan, leaves_an_otf_that_changes_over_the_field_to_the_processor) {
  if (!open_tested_device()) GTEST_SKIP() << "no device";
  const System<double> system = seidel(0.1, 0.5, 0.5, 0.5, 0.0);
  const SampleGrid in = scene_grid(system, 64, 48, 1.0, 1.0);
  const Image scene = random_image(64, 48, 2);
  PlanOptions options = options_for(scene, Border::reflect, 1e-3);
  options.device = {open_tested_device(), false};
  const Plan plan = compile(system, in, in, options);
  EXPECT_EQ(plan.report().method, "field_modes");
  expect_says(plan.explain(), {"its modes are the processor's work", open_tested_device()->info().name});
  options.device = {};
  EXPECT_TRUE(same_bits(run(plan, scene), run(compile(system, in, in, options), scene)));
}

// Times of whole filters: on the device alone, and with transfers and the host's own passes. Printed for reports.
TEST(DeviceTimesLong, of_filters) {
  const auto device = open_tested_device();
  if (!device) GTEST_SKIP() << "no device";
  struct Size {
    std::int64_t width, height;
    double ratio;
  };
  for (const Size size : {Size{640, 512, 1.0}, Size{1024, 1024, 1.0}, Size{1280, 1024, 1.0}, Size{2560, 2048, 2.0},
                          Size{4096, 4096, 1.0}}) {
    const System<double> system = with(bare(15.0, 15.0), {gaussian(9.0)});
    const SampleGrid in = scene_grid(system, size.width, size.height, size.ratio, size.ratio);
    const Image scene = random_image(size.width, size.height, 3, 10.0);
    Stopwatch watch;
    const Plan plan =
        compile(system, in, detector_grid(system, in), on_device(options_for(scene, Border::periodic, 1e-4)));
    const double plan_ms = watch.ms();
    Image image(plan.out().width, plan.out().height);
    std::vector<double> whole, kernels;
    device->parts().kernels_ms = 0.0;
    for (int i = 0; i < 15; ++i) {
      watch = Stopwatch();
      plan.run(scene.view(), image.view());
      whole.push_back(watch.ms());
      kernels.push_back(*device->parts().kernels_ms);
    }
    device->parts().kernels_ms.reset();
    std::sort(whole.begin(), whole.end());
    std::sort(kernels.begin(), kernels.end());
    EXPECT_GT(kernels.front(), 0.0);
    EXPECT_GT(whole.front(), kernels.front());
    std::printf(
        "%lldx%lld to %lldx%lld: on the device %.3f ms (median %.3f), whole %.3f (%.3f), predicted %.3f; plan %.0f "
        "ms\n",
        static_cast<long long>(size.width), static_cast<long long>(size.height), static_cast<long long>(image.width()),
        static_cast<long long>(image.height()), kernels.front(), kernels[7], whole.front(), whole[7],
        device_candidate(plan)->cost_ms, plan_ms);
  }
}

}  // namespace
}  // namespace mtf::test
