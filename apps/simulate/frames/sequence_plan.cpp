// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/sequence_plan.h"

#include <algorithm>
#include <numeric>

#include "apps/sensor/sensor_place.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/text/words.h"
#include "mtf/same_list.h"

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

const mtf::System<double>& system_of(const mtf::io::SensorConfig& sensor, const RadiometricChain* radiometric) {
  return radiometric != nullptr ? radiometric->system : sensor.system;
}

mtf::System<double> with_rate(mtf::System<double> system, std::shared_ptr<const mtf::ElectronRate> rate) {
  if (system.band) system.band->rate = std::move(rate);
  return system;
}

/// The weights of the band, which differ from frame to frame where pixels have ranges, make no other sensor.
bool same_but_for_rate(const mtf::System<double>& a, const mtf::System<double>& b) {
  return same_system(a, b) || same_system(with_rate(a, nullptr), with_rate(b, nullptr));
}

int steps_of(const RadiometricChain* radiometric) {
  return radiometric != nullptr ? radiometric->samples_a_pitch() : 1;
}

}  // namespace

SequencePlanner::SequencePlanner(const SimulateOptions& options, int threads)
    : asked_(options.tolerance.has_value()), may_loosen_(!asked_ || options.loosen) {
  base_.tolerance = options.tolerance.value_or(base_.tolerance);
  base_.rigor = options.measure ? mtf::Rigor::measure : mtf::Rigor::estimate;
  base_.threads = threads;
}

mtf::PlanOptions SequencePlanner::options_for(const mtf::io::SensorConfig& sensor, const RadiometricChain* radiometric,
                                              const SceneInput& input) const {
  mtf::PlanOptions options = base_;
  options.border = sensor.scene.border;
  options.separate_readout = radiometric != nullptr;
  options.aperture = aperture_of(sensor.scene, input.scene);
  if (radiometric != nullptr && !asked_ && input.summary)
    options.tolerance = radiometric->tolerance(base_.tolerance, input.summary->std);
  return options;
}

double SequencePlanner::roomy_tolerance(const RadiometricChain* radiometric, const SceneInput& input,
                                        double tolerance) const {
  if (radiometric == nullptr || asked_ || !input.summary || !plan_ || !plan_->options.scene) return tolerance;
  const auto wanted = [&](double std) { return radiometric->tolerance(base_.tolerance, std); };
  const bool served_before =
      plan_->options.tolerance <= std::max(wanted(plan_->options.scene->std), loosened_) * kRounding;
  if (!served_before || plan_->options.tolerance <= tolerance * kRounding) return tolerance;
  return std::max(wanted(kRoomContrast * input.summary->std), loosened_);
}

std::shared_ptr<const mtf::SensorPlan> SequencePlanner::compile(const mtf::System<double>& system,
                                                                const RadiometricChain* radiometric,
                                                                const SceneInput& input, mtf::PlanOptions options,
                                                                std::vector<std::string>& warnings) {
  ++compiled_;
  const SceneDifficulty met = input.summary ? harder(met_, difficulty(*input.summary)) : met_;
  const double own = options.tolerance;
  const double roomy = roomy_tolerance(radiometric, input, own);
  const auto attempt = [&](const std::optional<mtf::SceneSummary>& summary, double tolerance) {
    options.scene = summary;
    options.tolerance = tolerance;
    return std::make_shared<const mtf::SensorPlan>(
        mtf::compile_sensor(system, input.scene.grid, options, steps_of(radiometric)));
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
    if (!may_loosen_ || (asked_ && plan_ == nullptr) || !(e.reachable() < 1.0)) throw;
    loosened_for_ = difficulty(*input.summary);
    // Room for contrast that fades on.
    loosened_ = std::min(kRoomStorage * e.reachable(), std::midpoint(e.reachable(), 1.0));
    if (const double unseen = radiometric != nullptr && !asked_ ? radiometric->unseen_tolerance(own) : 0.0;
        e.reachable() <= unseen)
      loosened_ = std::min(loosened_, unseen);
    const SceneDifficulty fading{loosened_for_.storage * kRoomStorage, loosened_for_.canvas};
    std::shared_ptr<const mtf::SensorPlan> plan;
    try {
      plan = attempt(summary_of(fading, input.summary->std), loosened_);
    } catch (const mtf::UnreachableTolerance&) {
      loosened_ = e.reachable();
      plan = attempt(input.summary, loosened_);
    }
    if (asked_ || radiometric == nullptr || loosened_ > radiometric->unseen_tolerance(own))
      warnings.push_back("the " + std::string(asked_ ? "" : "default ") + "tolerance " + mtf::format_double(own) +
                         " cannot be kept for this scene; " + significant(loosened_, 2) +
                         " is used until one has twice the contrast");
    return plan;
  }
}

std::shared_ptr<const mtf::SensorPlan> SequencePlanner::plan_for(const mtf::io::SensorConfig& sensor,
                                                                 const RadiometricChain* radiometric,
                                                                 const SceneInput& input,
                                                                 std::vector<std::string>& warnings) {
  std::optional<mtf::System<double>> own;  // of an image whose pixels have ranges
  if (input.rate) own = with_rate(system_of(sensor, radiometric), input.rate);
  const mtf::System<double>& system = own ? *own : system_of(sensor, radiometric);
  mtf::PlanOptions options = options_for(sensor, radiometric, input);
  const bool filters_alike = plan_ && same_filters(plan_->options, options);
  const bool unchanged = filters_alike && same_system(plan_->system, system);
  const bool same_sensor = filters_alike && same_but_for_rate(plan_->system, system);
  if (!same_sensor || !same_values(scene_, sensor.scene)) loosened_ = 0.0;  // another sensor may keep its default
  if (loosened_ > 0.0 && input.summary && easier_by_half(difficulty(*input.summary), loosened_for_)) loosened_ = 0.0;
  scene_ = sensor.scene;
  options.tolerance = std::max(options.tolerance, loosened_);
  // A uniform frame asks for no tolerance; equal ones may differ by rounding.
  const bool tight = filters_alike && (!input.summary || plan_->options.tolerance <= options.tolerance * kRounding);
  const bool fits = tight && plan_->in() == input.scene.grid && serves(plan_->options.scene, input.summary) &&
                    mtf::sensor_grid(system, input.scene.grid, steps_of(radiometric)) == plan_->out();
  if (!fits) return plan_ = compile(system, radiometric, input, options, warnings);
  if (unchanged) return plan_;
  try {
    plan_ = std::make_shared<const mtf::SensorPlan>(plan_->with(system));
    ++(plan_->updated ? updated_ : compiled_);
  } catch (const mtf::UnreachableTolerance&) {
    plan_ = compile(system, radiometric, input, options, warnings);
  }
  return plan_;
}

std::shared_ptr<const radiometry::Chain> SequencePlanner::chain_for(
    const mtf::io::SensorConfig& sensor, const std::shared_ptr<const RadiometricChain>& radiometric,
    const std::shared_ptr<const mtf::SensorPlan>& plan, bool keep_shading) {
  if (chain_radiometric_ != radiometric || chain_plan_ != plan || chain_keeps_shading_ != keep_shading)
    chain_ = at_its_place(sensor, [&] {
      return std::make_shared<const radiometry::Chain>(*plan, radiometric->system, radiometric->loaded.sensor,
                                                       radiometry::Origin{}, base_.threads, chain_.get(), keep_shading);
    });
  chain_radiometric_ = radiometric;
  chain_plan_ = plan;
  chain_keeps_shading_ = keep_shading;
  return chain_;
}

}  // namespace apps
