// SPDX-License-Identifier: Apache-2.0

// From the scene to the light on the detector's samples.

#include "radiometry/chain/steps/stage_rows.h"

namespace radiometry {
namespace {

FocalPlane focal_plane_of(const FrameRun& run, const mtf::SampleGrid& grid) {
  return on_grid(run.chain.detector, run.maps.origin(), grid.width, grid.height, grid.step_x_um, grid.step_y_um);
}

}  // namespace

std::span<const StageRow> optics_rows() {
  using enum StageRow::Part;
  static constexpr StageRow kRows[] = {
      {.name = "distortion",
       .part = optics,
       .whole_image = "moves light across the image",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& radial = sensor.settings.distortion;
         if (!radial) return {false, "no [distortion]"};
         return {true, "k1 " + rounded(radial->k1) + ", k2 " + rounded(radial->k2) + ", k3 " + rounded(radial->k3) +
                           "; interpolation MTF at a quarter cycle a sample " + rounded(distortion_mtf(0.25))};
       },
       .step = [](FrameRun& run, mtf::Image& scene) -> void {
         const CompiledChain& chain = run.chain;
         const mtf::Image& given = run.kept != nullptr ? run.kept->planes().front() : scene;
         mtf::Image moved(given.width(), given.height());
         distort(given.view(), *chain.settings.distortion, focal_plane_of(run, chain.plan.in()), moved.view(), {},
                 chain.plan.options.border, static_cast<float>(run.border), run.threads);
         scene = std::move(moved);
         run.kept = nullptr;
       }},
      {.name = "presample", .part = optics, .words = filters<mtf::Stage::presample>},
      // The pitch samples the image, one sample a pixel or position, without a filter too.
      {.name = "presample",
       .part = optics,
       .step = [](FrameRun& run, mtf::Image& scene) -> void {
         const mtf::Plan& plan = run.chain.plan.presample;
         if (run.kept == nullptr && !run.may_stay) return filter(plan, run, scene);
         mtf::Image image(plan.out().width, plan.out().height);
         const mtf::ImageView<float> out = image.view();
         if (run.kept == nullptr)
           run.on_device = plan.run_on_device(scene.view(), out, run.border, run.threads);
         else if (run.may_stay)
           run.on_device = plan.run_on_device(*run.kept, out, run.border, run.threads);
         else
           plan.run(*run.kept, std::span(&out, 1), run.border, run.threads);
         run.kept = nullptr;
         std::swap(scene, image);
         if (run.on_device) run.given = std::move(image);
         run.border *= plan.dc();
       }},
      {.name = "veiling glare",
       .part = optics,
       .whole_image = "adds the mean of the whole image",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const VeilingGlare glare = sensor.settings.glare.value_or(VeilingGlare{});
         return said(terms({{"spread", glare.fraction}, {"added", glare.offset}}, "of the mean"), "no [veiling_glare]");
       },
       .step = [](FrameRun& run, mtf::Image& radiance) -> void {
         const double mean = finite_mean(radiance.view());
         add_glare(radiance.view(), *run.chain.settings.glare, mean, run.threads);
         mtf::Image beyond(1, 1);
         beyond.at(0, 0) = static_cast<float>(run.border);
         add_glare(beyond.view(), *run.chain.settings.glare, mean, 1);
         run.border = beyond.at(0, 0);
       }},
      {.name = "ghost",
       .part = optics,
       .whole_image = "adds the image mirrored at its axis",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& ghost = sensor.settings.ghost;
         return said(ghost ? rounded(ghost->fraction) + " of the light, mirrored" : "", "no [ghost]");
       },
       .step = [](FrameRun& run, mtf::Image& radiance) -> void {
         const Ghost& ghost = *run.chain.settings.ghost;
         const mtf::Image mirrored = ghost_image(radiance.view(), ghost, focal_plane_of(run, run.chain.plan.out()));
         add_ghost(radiance.view(), ghost, mirrored.view(), run.threads);
       }}};
  return kRows;
}

}  // namespace radiometry
