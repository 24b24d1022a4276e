// SPDX-License-Identifier: Apache-2.0
#include "mtf/sensor_plan.h"

#include <algorithm>
#include <cmath>

#include "mtf/same_list.h"

namespace mtf {
namespace {

// Plan::run has read all input before it writes any output; where the output is no larger it takes the input's place.
std::vector<Image> run_in_place(const Plan& plan, std::vector<Image> images, double border_value, int threads) {
  const std::int64_t width = plan.out().width, height = plan.out().height;
  const bool fits = width * height <= plan.in().width * plan.in().height;
  std::vector<Image> larger;
  std::vector<ImageView<const float>> in;
  std::vector<ImageView<float>> out;
  for (Image& image : images) {
    if (image.width() != plan.in().width || image.height() != plan.in().height)
      throw UsageError("a plane is " + std::to_string(image.width()) + "x" + std::to_string(image.height()) +
                       ", the plan was made for " + std::to_string(plan.in().width) + "x" +
                       std::to_string(plan.in().height));
    if (!fits) larger.emplace_back(width, height);
    in.push_back(image.view());
    out.push_back(fits ? ImageView<float>{image.data(), width, height, width} : larger.back().view());
  }
  plan.run(in, out, border_value, threads);
  if (!fits) return larger;
  for (Image& image : images) image.reshape(width, height);
  return images;
}

}  // namespace

SceneSummary behind_sampling(SceneSummary scene, const PlanOptions& options, const SampleGrid& in,
                             const SampleGrid& out) {
  const double correction = options.aperture.kind == SceneAperture::Kind::point ? 1.0 : options.aperture.gain_limit;
  scene.canvas_norm *=
      std::sqrt(std::max(1.0, in.area_um2() / out.area_um2()) * samples_per_pixel(in, out)) * correction;
  scene.largest *= correction;
  scene.flat_rows = 0.0;  // light from elsewhere has reached them
  // Held edges repeat what may be the largest value; nine images make their canvas.
  if (options.border == Border::replicate || options.border == Border::constant)
    scene.canvas_norm = std::max(scene.canvas_norm, 6.0 * scene.largest);
  return scene;
}

namespace {

bool has_filters(const System<double>& system) {
  return !system.list(Stage::readout).empty() || !system.list(Stage::postsample).empty();
}

double largest_gain(const Plan& post) { return std::max(1.0, post.report().largest_gain); }

// What the sampled image errs by passes through the filters behind it.
double predict(const Plan& presample, const std::optional<Plan>& post) {
  const double sampled = presample.report().predicted.total();
  return post ? sampled * largest_gain(*post) + post->report().predicted.total() : sampled;
}

}  // namespace

SensorPlan compile_sensor(const System<double>& system, const SampleGrid& scene, const PlanOptions& options) {
  const SampleGrid detector = detector_grid(system, scene);
  if (!has_filters(system)) {
    const Plan plan = compile(system, scene, detector, options);
    return {plan, std::nullopt, predict(plan, std::nullopt), system, options};
  }
  constexpr std::array stages{Stage::readout, Stage::postsample};
  PlanOptions half = options;
  half.tolerance = 0.5 * options.tolerance;
  half.aperture = {};
  half.spectrum = nullptr;  // of the scene, not of what the detector has sampled
  if (options.scene) half.scene = behind_sampling(*options.scene, options, scene, detector);
  // A refusal speaks of the whole tolerance, not of the share that one step was given, and of what all steps can keep.
  const auto in_share = [&](double share, const auto& compile_step) {
    try {
      return compile_step();
    } catch (const UnreachableTolerance& e) {
      PlanOptions looser = options;
      looser.tolerance = e.reachable() / share;
      if (looser.tolerance < 1.0) try {
          compile_sensor(system, scene, looser);
        } catch (const UnreachableTolerance& later) {
          looser.tolerance = later.reachable();
        }
      throw unreachable_tolerance(options.tolerance, looser.tolerance, options.scene);
    }
  };
  const Plan post = in_share(0.5, [&] { return compile_post(system, detector, stages, half); });
  const double gain = largest_gain(post);
  PlanOptions first = options;
  first.tolerance = half.tolerance / gain;
  const Plan presample = in_share(0.5 / gain, [&] { return compile(system, scene, detector, first); });
  return {presample, post, predict(presample, post), system, options};
}

SensorPlan SensorPlan::with(const System<double>& other) const {
  if (detector_grid(other, in()) != out() || has_filters(other) != post.has_value())
    return compile_sensor(other, in(), options);
  const auto same = [&](Stage stage) { return same_list(system, other, stage); };
  try {
    SensorPlan plan = *this;
    plan.system = other;
    plan.updated = true;
    if (!same(Stage::presample)) plan.presample = presample.with(other);
    if (post && !(same(Stage::readout) && same(Stage::postsample))) plan.post = post->with(other);
    plan.predicted_error = predict(plan.presample, plan.post);
    if (plan.predicted_error <= options.tolerance) return plan;
  } catch (const UnreachableTolerance&) {  // of a share: other shares may do
  }
  return compile_sensor(other, in(), options);
}

std::vector<Image> SensorPlan::run(std::span<const ImageView<const float>> scene, double border_value,
                                   int threads) const {
  std::vector<Image> sampled;
  std::vector<ImageView<float>> views;
  for (std::size_t i = 0; i < scene.size(); ++i) sampled.emplace_back(out().width, out().height);
  for (Image& image : sampled) views.push_back(image.view());
  presample.run(scene, views, border_value, threads);
  return post ? run_in_place(*post, std::move(sampled), presample.dc() * border_value, threads) : std::move(sampled);
}

std::vector<Image> SensorPlan::run(std::vector<Image>&& scene, double border_value, int threads) const {
  std::vector<Image> sampled = run_in_place(presample, std::move(scene), border_value, threads);
  return post ? run_in_place(*post, std::move(sampled), presample.dc() * border_value, threads) : std::move(sampled);
}

}  // namespace mtf
