// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/sequence.h"

#include <algorithm>
#include <numeric>

#include "apps/simulate/simulate_parts.h"
#include "apps/text/message_words.h"
#include "mtf/otf/same_list.h"

namespace apps {
namespace {

// Room for frames that are harder to keep the promise for: storage costs little, the canvas scales everything. A
// reflected canvas is twice the image for every frame.
constexpr double kRoomStorage = 2.0, kRoomCanvas = 1.1, kRounding = 1.0 + 1e-6;
constexpr double kRoomContrast = 2.0;
constexpr double kFloatUnit = 0x1p-24, kSmallestFloat = 0x1p-150;  // of float32: relative, and half a denormal step

SceneDifficulty difficulty(const mtf::SceneSummary& scene) {
  return {(std::max(scene.largest * kFloatUnit, kSmallestFloat) + scene.error) / scene.std,
          scene.canvas_norm / scene.std};
}

SceneDifficulty harder(const SceneDifficulty& a, const SceneDifficulty& b) {
  return {std::max(a.storage, b.storage), std::max(a.canvas, b.canvas)};
}

/// By a factor of 2 in one, and about as hard in the other at most.
bool easier_by_half(const SceneDifficulty& a, const SceneDifficulty& b) {
  const double storage = a.storage / b.storage, canvas = a.canvas / b.canvas;
  return std::min(storage, canvas) < 0.5 && std::max(storage, canvas) < kRoomCanvas;
}

/// The summary, on the scale of a scene, of one that is as hard.
mtf::SceneSummary summary_of(const SceneDifficulty& d, double std) {
  return {std, d.storage * std / kFloatUnit, d.canvas * std};
}

/// True when a plan compiled for `plan` keeps its promise for a scene of this summary; a flat one asks for nothing.
bool serves(const std::optional<mtf::SceneSummary>& plan, const std::optional<mtf::SceneSummary>& scene) {
  if (!scene) return true;
  if (!plan) return false;
  const SceneDifficulty able = difficulty(*plan), needed = difficulty(*scene);
  return needed.storage <= able.storage && needed.canvas <= able.canvas;
}

bool same_system(const mtf::System<double>& a, const mtf::System<double>& b) {
  return std::all_of(mtf::kStages.begin(), mtf::kStages.end(),
                     [&](mtf::Stage stage) { return mtf::same_list(a, b, stage); });
}

bool same_extent(const mtf::Extent<double>& a, const mtf::Extent<double>& b) {
  return a.value == b.value && a.unit == b.unit;
}

bool same_aperture(const mtf::SceneAperture& a, const mtf::SceneAperture& b) {
  const bool same_curve =
      a.curve == b.curve || (a.curve && b.curve && a.curve->unit == b.curve->unit &&
                             a.curve->frequency == b.curve->frequency && a.curve->value == b.curve->value);
  return a.kind == b.kind && same_extent(a.size.x, b.size.x) && same_extent(a.size.y, b.size.y) &&
         a.size.split == b.size.split && same_curve && a.gain_limit == b.gain_limit;
}

/// True when plans with these options filter alike, but for their errors.
bool same_filters(const mtf::PlanOptions& a, const mtf::PlanOptions& b) {
  return a.border == b.border && a.separate_readout == b.separate_readout && same_aperture(a.aperture, b.aperture);
}

mtf::System<double> with_rate(mtf::System<double> system, std::shared_ptr<const mtf::ElectronRate> rate) {
  if (system.band) system.band->rate = std::move(rate);
  return system;
}

/// The weights of the band, which differ from frame to frame where pixels have ranges, make no other sensor.
bool same_but_for_rate(const mtf::System<double>& a, const mtf::System<double>& b) {
  return same_system(a, b) || same_system(with_rate(a, nullptr), with_rate(b, nullptr));
}

}  // namespace

SequencePlanner::SequencePlanner(const SimulateOptions& options, int threads)
    : asked_{.tolerance = options.tolerance,
             .loosen = options.loosen,
             .measure = options.measure,
             .device = options.device,
             .threads = threads} {}

double SequencePlanner::roomy_tolerance(const Frame& frame, double tolerance) const {
  const std::optional<mtf::SceneSummary>& scene = frame.input->summary;
  if (frame.sensor.is_linear() || asked_.tolerance || !scene || !plan_ || !plan_->options.scene) return tolerance;
  const auto wanted = [&](double std) { return frame.sensor.tolerance({}, std); };
  const bool served_before =
      plan_->options.tolerance <= std::max(wanted(plan_->options.scene->std), loosened_) * kRounding;
  if (!served_before || plan_->options.tolerance <= tolerance * kRounding) return tolerance;
  return std::max(wanted(kRoomContrast * scene->std), loosened_);
}

std::shared_ptr<const mtf::SensorPlan> SequencePlanner::compile(const mtf::System<double>& system, Frame& frame,
                                                                mtf::PlanOptions options) {
  ++compiled_;
  const SceneInput& input = *frame.input;
  const bool asked = asked_.tolerance.has_value();
  const SceneDifficulty met = input.summary ? harder(met_, difficulty(*input.summary)) : met_;
  const double own = options.tolerance;
  const double roomy = roomy_tolerance(frame, own);
  const auto attempt = [&](const std::optional<mtf::SceneSummary>& summary, double tolerance) {
    options.scene = summary;
    options.tolerance = tolerance;
    return std::make_shared<const mtf::SensorPlan>(
        mtf::compile_sensor(system, input.scene.grid, options, frame.sensor.samples_a_pitch()));
  };
  const auto kept = [&](std::shared_ptr<const mtf::SensorPlan> plan) {
    met_ = met;
    return plan;
  };
  const double canvas = options.border == mtf::Border::reflect ? kRounding : kRoomCanvas;
  const SceneDifficulty room{met.storage * kRoomStorage, met.canvas * canvas};
  std::vector<double> with_room;  // tolerances, the one for more contrast first
  if (input.summary && roomy != own) with_room.push_back(roomy);
  if (input.summary) with_room.push_back(own);
  for (const double tolerance : with_room) try {
      return kept(attempt(summary_of(room, input.summary->std), tolerance));
    } catch (const mtf::UnreachableTolerance&) {  // there is less room
    }
  try {
    return kept(attempt(input.summary, own));
  } catch (const mtf::UnreachableTolerance& e) {
    // What was asked for gives way to single frames, not to all of them.
    if ((asked && (!asked_.loosen || plan_ == nullptr)) || !(e.reachable() < 1.0)) throw;
    loosened_for_ = difficulty(*input.summary);
    // Room for contrast that fades on.
    loosened_ = std::min(kRoomStorage * e.reachable(), std::midpoint(e.reachable(), 1.0));
    const double unseen = asked ? 0.0 : frame.sensor.unseen_tolerance(own);
    if (e.reachable() <= unseen) loosened_ = std::min(loosened_, unseen);
    const SceneDifficulty fading{loosened_for_.storage * kRoomStorage, loosened_for_.canvas};
    std::shared_ptr<const mtf::SensorPlan> plan;
    try {
      plan = attempt(summary_of(fading, input.summary->std), loosened_);
    } catch (const mtf::UnreachableTolerance&) {
      loosened_ = e.reachable();
      plan = attempt(input.summary, loosened_);
    }
    if (loosened_ > unseen)
      frame.warnings.push_back("the " + std::string(asked ? "" : "default ") + "tolerance " + mtf::format_double(own) +
                               " cannot be kept for this scene; " + significant(loosened_, 2) +
                               " is used until one has twice the contrast");
    return plan;
  }
}

void SequencePlanner::plan(Frame& frame) {
  const SceneInput& input = *frame.input;
  const mtf::io::SceneDefaults& scene = frame.sensor.config().scene;
  std::optional<mtf::System<double>> own;  // of an image whose pixels have ranges
  if (input.rate) own = system_for(frame.sensor, input);
  const mtf::System<double>& system = own ? *own : frame.sensor.system();
  mtf::PlanOptions options = plan_options_of(asked_, frame.sensor, input.scene, input.summary);
  const bool filters_alike = plan_ && same_filters(plan_->options, options);
  const bool unchanged = filters_alike && same_system(plan_->system, system);
  const bool same_sensor = filters_alike && same_but_for_rate(plan_->system, system);
  if (!same_sensor || !same_values(scene_, scene)) loosened_ = 0.0;  // another sensor may keep its default
  if (loosened_ > 0.0 && input.summary && easier_by_half(difficulty(*input.summary), loosened_for_)) loosened_ = 0.0;
  scene_ = scene;
  options.tolerance = std::max(options.tolerance, loosened_);
  // A uniform frame asks for no tolerance; equal ones may differ by rounding.
  const bool tight = filters_alike && (!input.summary || plan_->options.tolerance <= options.tolerance * kRounding);
  const bool fits = tight && plan_->in() == input.scene.grid && serves(plan_->options.scene, input.summary) &&
                    mtf::sensor_grid(system, input.scene.grid, frame.sensor.samples_a_pitch()) == plan_->out();
  if (!fits) {
    plan_ = compile(system, frame, options);
  } else if (!unchanged)
    try {
      plan_ = std::make_shared<const mtf::SensorPlan>(plan_->with(system));
      ++(plan_->updated ? updated_ : compiled_);
    } catch (const mtf::UnreachableTolerance&) {
      plan_ = compile(system, frame, options);
    }
  frame.plan = plan_;
}

void SequencePlanner::chain(Frame& frame, bool keep_shading) {
  if (frame.sensor.is_linear()) return;
  if (!frame.sensor.has_chain_of(chain_sensor_) || chain_plan_ != frame.plan || chain_keeps_shading_ != keep_shading)
    chain_ = chain_of(frame.sensor, *frame.plan, asked_.threads, chain_.get(), keep_shading);
  chain_sensor_ = frame.sensor;
  chain_plan_ = frame.plan;
  chain_keeps_shading_ = keep_shading;
  frame.chain = chain_;
}

}  // namespace apps
