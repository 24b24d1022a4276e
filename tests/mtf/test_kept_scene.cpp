// SPDX-License-Identifier: Apache-2.0
// A scene that is filtered again and again: every run has the bits of one that knows nothing of the runs before it,
// whatever plan, border value or number of threads comes next; and what is kept is used, and counted.
#include "mtf/engines/kept_scene.h"

#include <limits>

#include "mtf/plan/sensor_plan.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

constexpr std::int64_t kWidth = 150, kHeight = 131;

using Planes = std::shared_ptr<std::vector<Image>>;

Planes planes_of(Image first) {
  auto planes = std::make_shared<std::vector<Image>>();
  planes->push_back(std::move(first));
  return planes;
}

std::vector<Image> run_kept(const Plan& plan, KeptScene& scene, double border_value, int threads) {
  std::vector<Image> images;
  std::vector<ImageView<float>> out;
  for (std::size_t i = 0; i < scene.planes().size(); ++i) images.emplace_back(plan.out().width, plan.out().height);
  for (Image& image : images) out.push_back(image.view());
  plan.run(scene, out, border_value, threads);
  return images;
}

void expect_same(const Plan& plan, KeptScene& scene, double border_value, int threads) {
  const std::vector<Image> images = run_kept(plan, scene, border_value, threads);
  for (std::size_t c = 0; c < images.size(); ++c)
    EXPECT_TRUE(same_bits(images[c], run(plan, scene.planes()[c], border_value))) << "plane " << c << "\n"
                                                                                  << plan.explain();
}

System<double> even(double rms_um) {
  return with(bare(), {Component<double>::make("diffraction"), footprint(12.0), jitter(rms_um)});
}
System<double> phase(double rms_um) { return with(even(rms_um), {rc(40.0, 0)}); }
System<double> slanted(double rms_um) { return with(even(rms_um), {rc(20.0, 1), motion(20.0, 10.0 * rms_um)}); }

Plan plan_of(const System<double>& system, const SampleGrid& in, Border border, std::optional<Method> method,
             std::optional<SceneSummary> summary = std::nullopt, double tolerance = 1e-4) {
  PlanOptions options;
  options.border = border;
  options.method = method;
  options.tolerance = tolerance;
  options.scene = std::move(summary);
  options.threads = 1;
  return compile(system, in, detector_grid(system, in), options);
}

// Planes of other contrasts, one of them uniform, one whose samples at 8 x 8 places are far from its mean.
Planes several_planes() {
  Planes planes = planes_of(random_image(kWidth, kHeight, 1));
  planes->push_back(random_image(kWidth, kHeight, 2, 1e6, 1e3));
  planes->push_back(image_of(kWidth, kHeight, [](auto, auto) { return 7.0; }));
  planes->push_back(image_of(kWidth, kHeight, [](auto x, auto y) {
    for (std::int64_t j = 0; j < 8; ++j)
      if (y == (2 * j + 1) * kHeight / 16) return 0.1 * static_cast<double>(x % 7);
    return 10.0 + 0.01 * static_cast<double>(x % 5);
  }));
  return planes;
}

TEST(KeptScene, runs_have_the_bits_of_runs_without) {
  const Planes planes = several_planes();
  int parts = 0, fourier = 0, chirps = 0;
  for (const auto& system : {even, phase, slanted})
    for (const auto& [ratio_x, ratio_y] : {std::pair{1.0, 1.0}, {2.0, 3.7}, {4.0, 1.0}})
      for (const Border border : kBorders)
        for (const Method method : {Method::fft_float, Method::fft_double}) {
          const SampleGrid in = scene_grid(system(1.0), kWidth, kHeight, ratio_x, ratio_y);
          Plan plan = plan_of(system(1.0), in, border, method);
          KeptScene scene(planes);
          for (const int threads : {1, 2, 3}) {
            expect_same(plan, scene, 3.0, threads);
            plan = plan.with(system(1.0 + 0.2 * threads));
          }
          EXPECT_GT(scene.bytes(), 0);
          const std::string axes = plan.report().axes[0] + plan.report().axes[1];
          parts += axes.find("-sine") != std::string::npos ? 1 : 0;
          fourier += axes.find("fourier") != std::string::npos ? 1 : 0;
          chirps += axes.find("chirp") != std::string::npos ? 1 : 0;
        }
  EXPECT_GT(parts, 5);
  EXPECT_GT(fourier, 20);
  EXPECT_GT(chirps, 20);
}

TEST(KeptScene, any_plan_may_follow_any_other) {
  const Image first = random_image(kWidth, kHeight, 5, 10.0);
  const SceneSummary summary = *summarise(first.view(), Border::constant, 3.0);
  KeptScene scene(planes_of(first.clone()));
  const SampleGrid fine = scene_grid(bare(), kWidth, kHeight, 2.0, 2.0),
                   coarse = scene_grid(bare(), kWidth, kHeight, 1.0, 1.0);
  std::vector<Plan> plans;
  for (const Border border : kBorders) plans.push_back(plan_of(even(1.0), fine, border, {}, summary));
  plans.push_back(plan_of(even(1.0), coarse, Border::reflect, {}, summary));
  plans.push_back(plan_of(slanted(1.0), fine, Border::reflect, {}, summary));
  plans.push_back(plan_of(even(40.0), fine, Border::constant, Method::fft_cut, summary, 1e-3));  // longer canvases,
  plans.push_back(plan_of(even(30.0), fine, Border::constant, Method::fft_cut, summary, 1e-3));  // fewer frequencies
  plans.push_back(plan_of(even(60.0), fine, Border::replicate, Method::fft_float, summary));
  plans.push_back(plan_of(even(1.0), fine, Border::constant, Method::fft_double, summary));
  plans.push_back(plan_of(with(bare(), {gaussian(27.0)}), fine, Border::reflect, Method::separable, summary, 1e-3));
  plans.push_back(plan_of(bare(), coarse, Border::reflect, {}, summary));
  for (const Plan& before : plans)
    for (const Plan& after : plans)
      for (const double border_value : {3.0, 8.0}) {
        expect_same(before, scene, 3.0, 1);
        expect_same(after, scene, border_value, 2);
      }
}

// A plan of another image with the same transforms: what is kept of one cannot get into the other.
TEST(KeptScene, scenes_do_not_mix) {
  const SampleGrid in = scene_grid(bare(), kWidth, kHeight, 2.0, 2.0);
  const Plan plan = plan_of(even(1.0), in, Border::reflect, Method::fft_float);
  KeptScene a(planes_of(random_image(kWidth, kHeight, 1))), b(planes_of(random_image(kWidth, kHeight, 2)));
  for (KeptScene* scene : {&a, &b, &a, &b}) expect_same(plan, *scene, 0.0, 1);
  KeptScene moved = std::move(a);
  expect_same(plan, moved, 0.0, 1);
  moved = std::move(b);
  expect_same(plan, moved, 0.0, 1);
}

// Groups of 32 uniform rows and of columns; the filtered ones with the least contrast come out uniform.
TEST(KeptScene, uniform_lines) {
  const std::int64_t width = 320, height = 300;
  const Image noise = random_image(width, height, 3);
  int flat = 0;
  for (const bool rows : {true, false})
    for (const Border border : kBorders)
      for (const double ratio : {1.0, 2.0}) {
        const Image first = image_of(width, height, [&](auto x, auto y) {
          return 4.0 + ((rows ? y : x) < 150 ? static_cast<double>(noise.at(x, y)) : 0.0);
        });
        KeptScene scene(planes_of(first.clone()));
        const SampleGrid in = scene_grid(bare(), width, height, ratio, ratio);
        Plan plan = plan_of(slanted(1.0), in, border, Method::fft_float, summarise(first.view(), border, 4.0), 1e-2);
        for (const double border_value : {4.0, 4.0, 1.0, 1.0, 4.0}) {
          expect_same(plan, scene, border_value, 2);
          plan = plan.with(slanted(1.0 + border_value));
          flat += plan.report().predicted.flat > 0.0 ? 1 : 0;
        }
      }
  EXPECT_GT(flat, 40);
}

// A sample that is not among those of the first look at the mean is changed behind the back of the scene: runs still
// give the image of the first one, until they are told to forget.
TEST(KeptScene, what_is_kept_is_used) {
  const Planes planes = planes_of(random_image(kWidth, kHeight, 1, 5.0));
  const SampleGrid in = scene_grid(bare(), kWidth, kHeight, 2.0, 2.0);
  for (const auto& [border, method] : {std::pair{Border::reflect, Method::fft_float},
                                       {Border::constant, Method::fft_float},
                                       {Border::reflect, Method::fft_double}}) {
    KeptScene scene(planes);
    const Plan plan = plan_of(even(1.0), in, border, method), next = plan.with(even(2.0));
    run_kept(plan, scene, 0.0, 1);
    const Image expected = run(next, planes->front());
    planes->front().at(1, 1) += 3.0F;
    EXPECT_TRUE(same_bits(run_kept(next, scene, 0.0, 2).front(), expected));
    EXPECT_FALSE(same_bits(run(next, planes->front()), expected));
    // Another value beyond a constant border is another canvas.
    if (border == Border::constant) expect_same(next, scene, 1.0, 1);
    scene.forget();
    expect_same(next, scene, 0.0, 1);
  }
}

// Where frequencies are left out, a jitter that grows leaves out more, now and then: most plans share the transforms of
// the one before. The change of a sample that nobody was told of shows where they do not.
TEST(KeptScene, plans_that_differ_little_share_what_is_kept) {
  const Planes planes = planes_of(random_image(1024, 16, 1, 5.0));
  const SampleGrid in = scene_grid(bare(), 1024, 16, 4.0, 4.0);
  KeptScene scene(planes);
  Plan plan = plan_of(even(10.0), in, Border::reflect, Method::fft_cut, {}, 1e-3);
  const std::int64_t kept = plan.report().kept[0];
  ASSERT_LT(kept, 900);
  int remade = 0;
  for (int i = 0; i < 40; ++i) {
    run_kept(plan, scene, 0.0, 1);
    plan = plan.with(even(10.0 + 0.2 * i));
    planes->front().at(1, 1) += 1.0F;
    const Image image = std::move(run_kept(plan, scene, 0.0, 1).front());
    remade += same_bits(image, run(plan, planes->front())) ? 1 : 0;
    scene.forget();
  }
  EXPECT_LT(plan.report().kept[0], kept - 96);
  EXPECT_GE(remade, 3);
  EXPECT_LT(remade, 20);
}

TEST(KeptScene, its_memory_is_counted) {
  const SampleGrid in = scene_grid(bare(), 128, 96, 2.0, 2.0);
  KeptScene scene(planes_of(random_image(128, 96, 1)));
  EXPECT_EQ(scene.bytes(), 0);
  const std::int64_t plane = 128 * 96 * 4;
  run_kept(plan_of(even(1.0), in, Border::reflect, Method::fft_float), scene, 0.0, 1);
  EXPECT_EQ(scene.bytes(), plane);
  run_kept(plan_of(even(1.0), in, Border::reflect, Method::fft_double), scene, 0.0, 1);
  EXPECT_EQ(scene.bytes(), 2 * plane);
  run_kept(plan_of(even(1.0), in, Border::periodic, Method::fft_float), scene, 0.0, 1);
  EXPECT_LE(scene.bytes(), plane + plane / 3);  // 65 frequencies of 128 samples, in blocks of 16
  scene.forget();
  EXPECT_EQ(scene.bytes(), 0);
}

TEST(KeptScene, a_failed_run_leaves_nothing_behind) {
  const Planes planes = planes_of(random_image(kWidth, kHeight, 1));
  planes->front().at(1, 1) = std::numeric_limits<float>::quiet_NaN();
  const SampleGrid in = scene_grid(bare(), kWidth, kHeight, 2.0, 2.0);
  const Plan plan = plan_of(even(1.0), in, Border::reflect, Method::fft_float);
  KeptScene scene(planes);
  EXPECT_THROW(run_kept(plan, scene, 0.0, 1), RuntimeError);
  EXPECT_THROW(run_kept(plan, scene, 0.0, 1), RuntimeError);
  EXPECT_EQ(scene.bytes(), 0);
}

TEST(KeptScene, misuse_is_refused) {
  EXPECT_THROW(KeptScene(nullptr), UsageError);
  EXPECT_TRUE(KeptScene().planes().empty());
  const SampleGrid in = scene_grid(bare(), kWidth, kHeight, 2.0, 2.0);
  const Plan plan = plan_of(even(1.0), in, Border::reflect, Method::fft_float);
  KeptScene none, smaller(planes_of(random_image(kWidth - 1, kHeight, 1)));
  Image image(plan.out().width, plan.out().height);
  const ImageView<float> out = image.view();
  EXPECT_THROW(plan.run(none, std::span(&out, 1)), UsageError);
  EXPECT_THROW(plan.run(smaller, std::span(&out, 1)), UsageError);
}

TEST(KeptScene, filters_after_the_sampling_see_the_same) {
  System<double> system = even(1.0);
  system.add(Stage::readout, gaussian(6.0));
  system.add(Stage::postsample, gaussian(9.0));
  const SampleGrid in = scene_grid(system, kWidth, kHeight, 2.0, 2.0);
  for (const bool separate : {false, true}) {
    PlanOptions options;
    options.threads = 1;
    options.separate_readout = separate;
    SensorPlan plan = compile_sensor(system, in, options);
    KeptScene scene(several_planes());
    std::vector<ImageView<const float>> views;
    for (const Image& plane : scene.planes()) views.push_back(plane.view());
    for (const double rms : {1.0, 2.0, 3.0}) {
      const std::vector<Image> kept = plan.run(scene, 0.0, 2), fresh = plan.run(views, 0.0, 1);
      for (std::size_t c = 0; c < fresh.size(); ++c) EXPECT_TRUE(same_bits(kept[c], fresh[c]));
      System<double> next = system;
      next.list(Stage::presample).back().component = jitter(rms);
      plan = plan.with(next);
    }
  }
}

}  // namespace
}  // namespace mtf::test
