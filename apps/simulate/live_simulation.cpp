// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/live_simulation.h"

#include "apps/simulate/frames/frame.h"
#include "apps/simulate/sensor_image.h"

namespace apps {
namespace {

radiometry::ChainState clone(const radiometry::ChainState& state) {
  return {.shutter = {state.shutter.before.clone()}, .lag = state.lag, .closing = state.closing, .last = state.last};
}

}  // namespace

struct LiveSimulation::State {
  State(SceneSource scene, const SimulateOptions& asked)
      : options(asked), still(std::move(scene), asked.nan, asked.threads), planner(asked, asked.threads) {}

  SimulateOptions options;
  StillScene still;
  mtf::KeptScene kept;  ///< the planes of `still`
  SequencePlanner planner;
  radiometry::ChainState chain_state;
  mtf::SampleGrid chain_grid;  ///< of the images that chain_state remembers
  std::vector<std::string> names, warnings;
  std::shared_ptr<const mtf::SensorPlan> plan;
  std::shared_ptr<const mtf::io::SensorConfig> sensor;  ///< of the last image, with its chain
  std::shared_ptr<const RadiometricChain> radiometric;
  std::shared_ptr<const mtf::io::SensorConfig> corrected;  ///< by whose parameters the correction is measured,
  mtf::SampleGrid corrected_grid;                          ///< of its pixels
  bool correction_lags = false;
  std::int64_t noise_rows = 1;

  SimulatedImage run(Frame& frame, CorrectionOf correction);
  mtf::KeptScene* kept_of(const std::shared_ptr<const SceneInput>& input) {
    if (&kept.planes() != &input->scene.planes) kept = mtf::KeptScene({input, &input->scene.planes});
    return &kept;
  }
};

LiveSimulation::LiveSimulation(SceneSource scene, const SimulateOptions& options)
    : state_(std::make_unique<State>(std::move(scene), options)) {}
LiveSimulation::~LiveSimulation() = default;
LiveSimulation::LiveSimulation(LiveSimulation&&) noexcept = default;
LiveSimulation& LiveSimulation::operator=(LiveSimulation&&) noexcept = default;

namespace {

void require_noise_number(std::int64_t number) {
  if (number < 0 || number > kLastNoiseFrame)
    throw mtf::UsageError("frame " + std::to_string(number) + ": noise is numbered from 0 to " +
                          std::to_string(kLastNoiseFrame));
}

}  // namespace

SimulatedImage LiveSimulation::image(const mtf::io::SensorConfig& sensor, std::int64_t number, CorrectionOf correction,
                                     std::int64_t noise_rows) {
  require_noise_number(number);
  State& state = *state_;
  Frame frame;
  frame.number = number;
  frame.sensor = std::make_shared<const mtf::io::SensorConfig>(sensor);
  frame.radiometric = radiometric_chain_of(sensor, state.options.stage, state.sensor.get(), state.radiometric.get());
  frame.input = state.still.of(frame.sensor, frame.radiometric.get());
  frame.kept = state.kept_of(frame.input);
  frame.noise_rows = noise_rows;
  return state.run(frame, correction);
}

SimulatedImage LiveSimulation::image(mtf::io::Scene scene, const std::shared_ptr<const mtf::io::SensorConfig>& sensor,
                                     std::int64_t number, CorrectionOf correction) {
  require_noise_number(number);
  State& state = *state_;
  Frame frame;
  frame.number = number;
  frame.sensor = sensor;
  frame.radiometric = sensor == state.sensor ? state.radiometric
                                             : radiometric_chain_of(*sensor, state.options.stage, state.sensor.get(),
                                                                    state.radiometric.get());
  frame.input = std::make_shared<const SceneInput>(
      load_input({.image = std::move(scene), .filter = state.still.source().filter}, *sensor, frame.radiometric.get(),
                 state.options.nan, state.options.threads));
  return state.run(frame, correction);
}

SimulatedImage LiveSimulation::State::run(Frame& frame, CorrectionOf correction) {
  frame.warnings = frame.input->scene.warnings;
  for (std::string& text : mtf::io::sampling_warnings(frame.sensor->system, frame.input->scene.grid))
    frame.warnings.push_back(std::move(text));
  // Everything that one image leaves to the next is changed in a copy, which replaces it once the image is there.
  SequencePlanner next = planner;
  frame.plan = next.plan_for(*frame.sensor, frame.radiometric.get(), *frame.input, frame.warnings);
  for (const std::string& text : frame.plan->presample.report().notes) frame.warnings.push_back(text);
  const bool in_sequence = correction == CorrectionOf::first_image;
  const bool known = corrected && corrected_grid == frame.plan->out();
  const bool own = known && same_correction(*corrected, *frame.sensor);
  const bool lags =
      known && !own && correction == CorrectionOf::earlier && nearly_same_correction(*corrected, *frame.sensor);
  const bool measures = !known || !(own || lags || in_sequence);
  if (measures) next.forget_correction();
  const bool goes_on = in_sequence || (!measures && same_correction(*sensor, *frame.sensor));
  const bool takes_earlier = lags && frame.radiometric &&
                             frame.radiometric->stage == radiometry::OutputStage::display &&
                             frame.radiometric->loaded.sensor.settings.correction;
  if (frame.radiometric) frame.chain = next.chain_for(*frame.sensor, frame.radiometric, frame.plan, takes_earlier);
  const bool remembered = frame.radiometric && remembers(*frame.radiometric);
  radiometry::ChainState remembering;  // what pixels remember says nothing of those of another grid
  if (remembered && goes_on && chain_grid == frame.plan->out()) remembering = clone(chain_state);
  frame.image.frame = frame.number;
  frame.image.planes = run_planes(frame, remembered ? &remembering : nullptr, options.threads);
  if (frame.counted.held.any()) frame.warnings.push_back(words(frame.counted.held));
  frame.image.metadata = metadata_of(frame);
  names = output_names(frame.input->scene.names);
  planner = std::move(next);
  if (remembered) {
    chain_state = std::move(remembering);
    chain_grid = frame.plan->out();
  }
  warnings = std::move(frame.warnings);
  plan = frame.plan;
  sensor = frame.sensor;
  radiometric = frame.radiometric;
  if (measures) {
    corrected = frame.sensor;
    corrected_grid = frame.plan->out();
  }
  correction_lags = takes_earlier;
  this->noise_rows = frame.counted.noise_rows;
  return std::move(frame.image);
}

bool LiveSimulation::correction_lags() const { return state_->correction_lags; }
std::int64_t LiveSimulation::noise_rows() const { return state_->noise_rows; }

IntegerRange LiveSimulation::integer_range() const {
  return apps::integer_range(state_->radiometric.get(), state_->options);
}

const std::vector<std::string>& LiveSimulation::names() const { return state_->names; }
const std::vector<std::string>& LiveSimulation::warnings() const { return state_->warnings; }
const mtf::SensorPlan& LiveSimulation::plan() const {
  if (!state_->plan) throw mtf::UsageError("there is no plan before the first image; call image() first");
  return *state_->plan;
}
std::int64_t LiveSimulation::kept_bytes() const { return state_->kept.bytes(); }
int LiveSimulation::plans_compiled() const { return state_->planner.compiled(); }
int LiveSimulation::plans_updated() const { return state_->planner.updated(); }

}  // namespace apps
