// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/sensor_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "mtf/otf/same_list.h"
#include "mtf/words.h"

namespace mtf {
// Plan::run has read all input before it writes any output; where the output is no larger it takes the input's place.
std::vector<Image> run_in_place(const Plan& plan, std::vector<Image> images, double border_value, int threads) {
  const std::int64_t width = plan.out().width, height = plan.out().height;
  const bool fits = width * height <= plan.in().width * plan.in().height;
  std::vector<Image> larger;
  std::vector<ImageView<const float>> in;
  std::vector<ImageView<float>> out;
  for (Image& image : images) {
    if (image.width() != plan.in().width || image.height() != plan.in().height)
      throw UsageError("a plane is " + size_text(image.width(), image.height()) + ", the plan was made for " +
                       size_text(plan.in().width, plan.in().height));
    if (!fits) larger.emplace_back(width, height);
    in.push_back(image.view());
    out.push_back(fits ? ImageView<float>{image.data(), width, height, width} : larger.back().view());
  }
  plan.run(in, out, border_value, threads);
  if (!fits) return larger;
  for (Image& image : images) image.reshape(width, height);
  return images;
}

SceneSummary after_sampling(SceneSummary scene, const PlanOptions& options, const SampleGrid& in,
                            const SampleGrid& out) {
  const double correction = options.aperture.kind == SceneAperture::Kind::point ? 1.0 : options.aperture.gain_limit;
  scene.canvas_norm *=
      std::sqrt(std::max(1.0, in.area_um2() / out.area_um2()) * samples_per_pixel(in, out)) * correction;
  scene.largest *= correction;
  scene.error *= correction;
  scene.flat_rows = scene.flat_columns = 0.0;  // the filter has brought light from elsewhere
  // Held edges repeat what may be the largest value; nine images make their canvas.
  if (options.border == Border::replicate || options.border == Border::constant)
    scene.canvas_norm = std::max(scene.canvas_norm, 6.0 * scene.largest);
  return scene;
}

namespace {

bool has_filters(const System<double>& system) {
  return !system.list(Stage::readout).empty() || !system.list(Stage::postsample).empty();
}

System<double> finer(System<double> system, int samples_a_pitch) {
  system.frame.pitch_x_um /= samples_a_pitch;
  system.frame.pitch_y_um /= samples_a_pitch;
  system.frame.columns *= samples_a_pitch;
  system.frame.rows *= samples_a_pitch;
  return system;
}

double largest_gain(const std::optional<Plan>& filter) {
  return filter ? std::max(1.0, filter->report().largest_gain) : 1.0;
}

double error_of(const std::optional<Plan>& filter) { return filter ? filter->report().predicted.total() : 0.0; }

std::vector<Image> planes_of(const SampleGrid& grid, std::size_t count) {
  std::vector<Image> planes;
  for (std::size_t i = 0; i < count; ++i) planes.emplace_back(grid.width, grid.height);
  return planes;
}

std::vector<ImageView<float>> views_of(std::vector<Image>& planes) {
  std::vector<ImageView<float>> views;
  for (Image& plane : planes) views.push_back(plane.view());
  return views;
}

// The error of a step passes through the filters that follow it.
double predict(const Plan& presample, const std::optional<Plan>& readout, const std::optional<Plan>& post) {
  const double sampled = presample.report().predicted.total() * largest_gain(readout) + error_of(readout);
  return sampled * largest_gain(post) + error_of(post);
}

}  // namespace

SampleGrid sensor_grid(const System<double>& system, const SampleGrid& scene, int samples_a_pitch) {
  return detector_grid(finer(system, samples_a_pitch), scene);
}

SensorPlan compile_sensor(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                          int samples_a_pitch) {
  const System<double> finer_system = finer(system, samples_a_pitch);
  const SampleGrid detector = detector_grid(finer_system, scene);
  const auto listed = [&](Stage stage) { return !system.list(stage).empty(); };
  const bool separate = options.separate_readout && listed(Stage::readout);
  const bool filters = separate ? listed(Stage::postsample) : has_filters(system);
  const double share = 1.0 / (1.0 + (separate ? 1.0 : 0.0) + (filters ? 1.0 : 0.0));
  PlanOptions after = options;
  after.aperture = {};
  after.spectrum = nullptr;  // of the scene, not of what the detector has sampled
  if (options.scene) after.scene = after_sampling(*options.scene, options, scene, detector);
  // A refusal speaks of the whole tolerance, not of the share that one step was given, and of what all steps can keep.
  const auto in_share = [&](PlanOptions own, double part, const auto& compile_step) {
    own.tolerance = part * options.tolerance;
    try {
      return compile_step(own);
    } catch (const UnreachableTolerance& e) {
      PlanOptions looser = options;
      looser.tolerance = e.reachable() / part;
      if (part < 1.0 && looser.tolerance < 1.0) try {
          compile_sensor(system, scene, looser, samples_a_pitch);
        } catch (const UnreachableTolerance& later) {
          looser.tolerance = later.reachable();
        }
      if (part == 1.0) throw;
      throw unreachable_tolerance(options.tolerance, looser.tolerance, options.scene);
    }
  };
  const auto filter = [&](std::span<const Stage> stages, double part) {
    return in_share(after, part,
                    [&](const PlanOptions& own) { return compile_post(finer_system, detector, stages, own); });
  };
  const auto sampled = [&](const PlanOptions& own) { return compile(system, scene, detector, own); };
  // Of defocus by range an image is a mean over the weights that reach each pixel, which are few here and there.
  if (options.range_m && filters && after.scene)
    if (const auto ranges = in_share(options, share, sampled).report().field.ranges)
      after.scene->canvas_norm /= ranges->least_weight;
  constexpr std::array both{Stage::readout, Stage::postsample};
  std::optional<Plan> post, readout;
  if (filters) post = filter(std::span(both).subspan(separate ? 1 : 0), share);
  if (separate) readout = filter(std::span(both).first(1), share / largest_gain(post));
  const double first = share / (largest_gain(post) * largest_gain(readout));
  const Plan presample = in_share(options, first, sampled);
  return {presample, readout, post, predict(presample, readout, post), system, options, samples_a_pitch};
}

SensorPlan SensorPlan::with(const System<double>& other) const {
  const auto kept = [&](Stage stage) { return system.list(stage).empty() == other.list(stage).empty(); };
  const bool filters = has_filters(system) == has_filters(other) &&
                       (!options.separate_readout || (kept(Stage::readout) && kept(Stage::postsample)));
  if (sensor_grid(other, in(), samples_a_pitch) != out() || !filters)
    return compile_sensor(other, in(), options, samples_a_pitch);
  const auto same = [&](Stage stage) { return same_list(system, other, stage); };
  try {
    SensorPlan plan = *this;
    plan.system = other;
    plan.updated = true;
    if (!same(Stage::presample)) plan.presample = presample.with(other);
    if (readout && !same(Stage::readout)) plan.readout = readout->with(finer(other, samples_a_pitch));
    if (post && !((readout || same(Stage::readout)) && same(Stage::postsample)))
      plan.post = post->with(finer(other, samples_a_pitch));
    plan.predicted_error = predict(plan.presample, plan.readout, plan.post);
    if (plan.predicted_error <= options.tolerance) return plan;
  } catch (const UnreachableTolerance&) {  // of a share: other shares may do
  }
  return compile_sensor(other, in(), options, samples_a_pitch);
}

std::vector<Image> SensorPlan::run(std::span<const ImageView<const float>> scene, double border_value,
                                   int threads) const {
  std::vector<Image> sampled = planes_of(out(), scene.size());
  presample.run(scene, views_of(sampled), border_value, threads);
  return run_filters(std::move(sampled), border_value, threads);
}

std::vector<Image> SensorPlan::run(KeptScene& scene, double border_value, int threads) const {
  std::vector<Image> sampled = planes_of(out(), scene.planes().size());
  presample.run(scene, views_of(sampled), border_value, threads);
  return run_filters(std::move(sampled), border_value, threads);
}

std::vector<Image> SensorPlan::run(std::vector<Image>&& scene, double border_value, int threads) const {
  return run_filters(run_in_place(presample, std::move(scene), border_value, threads), border_value, threads);
}

std::vector<Image> SensorPlan::run_filters(std::vector<Image> sampled, double border_value, int threads) const {
  double border = presample.dc() * border_value;
  for (const std::optional<Plan>* filter : {&readout, &post}) {
    if (!*filter) continue;
    sampled = run_in_place(**filter, std::move(sampled), border, threads);
    border *= (*filter)->dc();
  }
  return sampled;
}

SensorPlan compile_sensor(const System<double>& system, const SceneView& scene, PlanOptions options,
                          int samples_a_pitch) {
  const SampleGrid grid = grid_of(scene, system.frame);
  sensor_grid(system, grid, samples_a_pitch);  // a grid that no sensor can have is refused before the samples are read
  options.scene = summarise(scene.samples, options.border, scene.border_value);
  return compile_sensor(system, grid, options, samples_a_pitch);
}

Image SensorPlan::run(const SceneView& scene, int threads) const {
  const SampleGrid grid = grid_of(scene, system.frame);
  if (grid != in())
    throw UsageError("the scene is " + size_text(grid.width, grid.height) + " samples of " +
                     format_double(grid.step_x_um) + " um by " + format_double(grid.step_y_um) +
                     " um, the plan was made for " + size_text(in().width, in().height) + " of " +
                     format_double(in().step_x_um) + " um by " + format_double(in().step_y_um) +
                     " um; compile a plan for this scene");
  std::vector<Image> image = run(std::span(&scene.samples, 1), scene.border_value, threads);
  return std::move(image.front());
}

}  // namespace mtf
