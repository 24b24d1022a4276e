// SPDX-License-Identifier: Apache-2.0
// The same bits: for any number of threads, from several threads at once, for planes together or apart, for strided
// views, and for a plan made from another one.
#include <thread>

#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

struct Bench {
  System<double> system;
  SampleGrid in;
  Border border;
};

std::vector<Bench> setups() {
  const auto even = with(bare(), {Component<double>::make("diffraction"), footprint(12.0)});
  const auto uneven = with(bare(), {Component<double>::make("diffraction"), rc(40.0, 0)});
  const auto slanted = with(uneven, {rc(20.0, 1), motion(20.0, 40.0)});
  return {{even, scene_grid(even, 260, 203, 2.0, 3.7), Border::reflect},
          {uneven, scene_grid(uneven, 131, 240, 3.7, 2.0), Border::reflect},
          {uneven, scene_grid(uneven, 128, 96, 1.0, 1.0), Border::replicate},
          {slanted, scene_grid(slanted, 160, 131, 2.0, 1.0), Border::reflect},
          {even, scene_grid(even, 200, 150, 4.0, M_PI), Border::constant}};
}

Plan plan_of(const Bench& s, int threads, std::optional<Method> method = std::nullopt) {
  PlanOptions options;
  options.border = s.border;
  options.threads = threads;
  options.method = method;
  return compile(s.system, s.in, detector_grid(s.system, s.in), options);
}

TEST(PlanThreads, number_of_threads_changes_no_bit) {
  for (const Bench& s : setups()) {
    const Image scene = random_image(s.in.width, s.in.height, 1, 10.0);
    const Image one = run(plan_of(s, 1), scene, 2.0, 1);
    for (const int planning : {1, 2, 0})
      for (const int threads : {2, 3, 0}) EXPECT_TRUE(same_bits(one, run(plan_of(s, planning), scene, 2.0, threads)));
  }
}

TEST(PlanThreads, run_is_re_entrant) {
  for (const Bench& s : setups()) {
    const Plan plan = plan_of(s, 1);
    const Image a = random_image(s.in.width, s.in.height, 1), b = random_image(s.in.width, s.in.height, 2, 100.0);
    const Image expected_a = run(plan, a), expected_b = run(plan, b);
    int wrong_a = 0, wrong_b = 0;
    std::thread other([&] {
      for (int i = 0; i < 10; ++i) wrong_b += same_bits(expected_b, run(plan, b, 0.0, 2)) ? 0 : 1;
    });
    for (int i = 0; i < 10; ++i) wrong_a += same_bits(expected_a, run(plan, a, 0.0, 1)) ? 0 : 1;
    other.join();
    EXPECT_EQ(wrong_a, 0);
    EXPECT_EQ(wrong_b, 0);
  }
}

TEST(PlanThreads, planes_together_equal_planes_one_by_one) {
  for (const Bench& s : setups()) {
    const Plan plan = plan_of(s, 1);
    std::vector<Image> scenes, together;
    // Different scales and means, one of them flat: no plane may affect another.
    scenes.push_back(random_image(s.in.width, s.in.height, 1));
    scenes.push_back(random_image(s.in.width, s.in.height, 2, 1e6, 1e3));
    scenes.push_back(image_of(s.in.width, s.in.height, [](auto, auto) { return 7.0; }));
    scenes.push_back(random_image(s.in.width, s.in.height, 3, 0.0, 1e-20));
    std::vector<ImageView<const float>> in;
    std::vector<ImageView<float>> out;
    for (const Image& scene : scenes) {
      together.emplace_back(plan.out().width, plan.out().height);
      in.push_back(scene.view());
    }
    for (Image& image : together) out.push_back(image.view());
    for (const int threads : {1, 2}) {
      plan.run(in, out, 3.0, threads);
      for (std::size_t i = 0; i < scenes.size(); ++i)
        EXPECT_TRUE(same_bits(together[i], run(plan, scenes[i], 3.0))) << "plane " << i;
    }
  }
}

TEST(PlanThreads, strided_views_give_the_same_bits_and_touch_nothing_between_rows) {
  for (const Bench& s : setups()) {
    const Plan plan = plan_of(s, 1);
    const Image scene = random_image(s.in.width, s.in.height, 4, 5.0);
    const Image expected = run(plan, scene, 1.0);
    // The view starts off the alignment of the buffer, and NaN stands where nobody may read.
    const std::int64_t stride = s.in.width + 7, out_stride = plan.out().width + 3;
    std::vector<float> wide(static_cast<std::size_t>(stride * s.in.height + 1), std::nanf(""));
    for (std::int64_t y = 0; y < s.in.height; ++y)
      std::copy_n(scene.view().row(y), s.in.width, wide.data() + 1 + y * stride);
    std::vector<float> out(static_cast<std::size_t>(out_stride * plan.out().height + 1), -1.0F);
    const ImageView<const float> from{wide.data() + 1, s.in.width, s.in.height, stride};
    const ImageView<float> to{out.data() + 1, plan.out().width, plan.out().height, out_stride};
    plan.run(from, to, 1.0, 2);
    EXPECT_EQ(out.front(), -1.0F);
    for (std::int64_t y = 0; y < plan.out().height; ++y)
      for (std::int64_t x = 0; x < out_stride - (y + 1 == plan.out().height ? 3 : 0); ++x)
        ASSERT_EQ(to.row(y)[x], x < plan.out().width ? expected.at(x, y) : -1.0F) << x << ", " << y;
  }
}

TEST(PlanThreads, output_may_be_the_input) {
  const System<double> system = with(bare(), {Component<double>::make("diffraction"), rc(40.0, 0)});
  const SampleGrid in{96, 64, 15.0, 12.0};
  const Plan plan = compile(system, in, detector_grid(system, in), {});
  Image image = random_image(96, 64, 4);
  const Image expected = run(plan, image);
  plan.run(image.view(), image.view(), 0.0, 2);
  EXPECT_TRUE(same_bits(image, expected));
}

TEST(PlanThreads, identity_copies_the_input) {
  const SampleGrid in{33, 17, 15.0, 12.0};
  System<double> system = bare();
  const Plan plan = compile(system, in, detector_grid(system, in), {});
  EXPECT_EQ(plan.report().method, "identity");
  const Image scene = random_image(33, 17, 4);
  EXPECT_TRUE(same_bits(run(plan, scene), scene));
  system.frame.columns = 5;
  const Image cropped = run(compile(system, in, detector_grid(system, in), {}), scene);
  EXPECT_EQ(cropped.width(), 5);
  EXPECT_EQ(cropped.at(4, 16), scene.at(4, 16));
}

Method method_of(const Plan& plan) {
  const auto at = std::find(kMethodNames.begin(), kMethodNames.end(), plan.report().method);
  return static_cast<Method>(at - kMethodNames.begin());
}

TEST(PlanWith, gives_the_bits_of_a_new_plan) {
  for (const Bench& s : setups()) {
    const Plan first = plan_of(s, 1);
    const Image scene = random_image(s.in.width, s.in.height, 4, 5.0);
    for (const auto& system : {with(s.system, {jitter(2.0)}), with(s.system, {rc(30.0, 1)}),
                               with(bare(), {jitter(50.0)}), with(bare(), {motion(10.0, 20.0)})}) {
      Bench other = s;
      other.system = system;
      const Plan derived = first.with(system), fresh = plan_of(other, 1, method_of(derived));
      EXPECT_TRUE(same_bits(run(fresh, scene, 3.0), run(derived, scene, 3.0)));
      EXPECT_EQ(fresh.report().axes, derived.report().axes);
      EXPECT_EQ(fresh.report().predicted.total(), derived.report().predicted.total());
      const Plan back = derived.with(s.system), again = plan_of(s, 1, method_of(back));
      EXPECT_TRUE(same_bits(run(back, scene, 3.0), run(again, scene, 3.0)));
    }
  }
}

}  // namespace
}  // namespace mtf::test
