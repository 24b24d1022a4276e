// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/live_simulation.h"

#include <utility>

#include "apps/simulate/frames/sequence.h"

namespace apps {
namespace {

radiometry::ChainState clone(const radiometry::ChainState& state) {
  return {.shutter = {state.shutter.before.clone()}, .lag = state.lag, .closing = state.closing, .last = state.last};
}

void require_noise_number(std::int64_t number) {
  if (number < 0 || number > kLastNoiseFrame)
    throw mtf::UsageError("frame " + std::to_string(number) + ": noise is numbered from 0 to " +
                          std::to_string(kLastNoiseFrame));
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
  Frame last;                  ///< without its scene and its planes
  std::vector<std::string> names;
  std::shared_ptr<const mtf::io::SensorConfig> corrected;  ///< by whose parameters the correction is measured,
  mtf::SampleGrid corrected_grid;                          ///< of its pixels
  bool correction_lags = false;

  SimulatedImage run(Frame& frame, CorrectionOf correction) {
    frame.warnings = warnings_of(frame);
    // Everything that one image leaves to the next is changed in a copy, which replaces it once the image is there.
    SequencePlanner next = planner;
    next.plan(frame);
    for (const std::string& text : frame.plan->presample.report().notes) frame.warnings.push_back(text);
    const bool in_sequence = correction == CorrectionOf::first_image;
    const bool known = corrected && corrected_grid == frame.plan->out();
    const bool own = known && same_correction(*corrected, frame.sensor.config());
    const bool lags = known && !own && correction == CorrectionOf::earlier &&
                      nearly_same_correction(*corrected, frame.sensor.config());
    const bool measures = !known || !(own || lags || in_sequence);
    if (measures) next.forget_correction();
    const bool goes_on = in_sequence || (!measures && same_correction(last.sensor.config(), frame.sensor.config()));
    const RadiometricChain* chain = frame.sensor.chain();
    const bool takes_earlier = lags && chain != nullptr && chain->stage == radiometry::OutputStage::display &&
                               chain->loaded.sensor.settings.correction;
    next.chain(frame, takes_earlier);
    const bool remembered = frame.sensor.remembers();
    radiometry::ChainState remembering;  // what pixels remember says nothing of those of another grid
    if (remembered && goes_on && chain_grid == frame.plan->out()) remembering = clone(chain_state);
    frame.image.frame = frame.number;
    frame.whole_levels = takes_whole_levels(options);
    frame.image.planes = run_planes(frame, remembered ? &remembering : nullptr, options.threads);
    if (frame.counted.held.any()) frame.warnings.push_back(words(frame.counted.held));
    if (std::string text = correction_warning(frame.counted.correction); !text.empty())
      frame.warnings.push_back(std::move(text));
    frame.image.metadata = metadata_of(frame);
    names = output_names(frame.input->scene.names);
    planner = std::move(next);
    if (remembered) {
      chain_state = std::move(remembering);
      chain_grid = frame.plan->out();
    }
    if (measures) {
      corrected = frame.sensor.shared_config();
      corrected_grid = frame.plan->out();
    }
    correction_lags = takes_earlier;
    frame.input = nullptr;
    frame.own = nullptr;
    last = std::move(frame);
    return std::exchange(last.image, {});
  }
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

SimulatedImage LiveSimulation::image(const mtf::io::SensorConfig& sensor, std::int64_t number, CorrectionOf correction,
                                     std::int64_t noise_rows) {
  require_noise_number(number);
  State& state = *state_;
  Frame frame;
  frame.number = number;
  frame.sensor =
      SensorRun(std::make_shared<const mtf::io::SensorConfig>(sensor), state.options.stage, &state.last.sensor);
  frame.input = state.still.of(frame.sensor);
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
  const bool unchanged = sensor == state.last.sensor.shared_config();
  frame.sensor = unchanged ? state.last.sensor : SensorRun(sensor, state.options.stage, &state.last.sensor);
  load_own(frame, {.image = std::move(scene), .filter = state.still.source().filter}, state.options.nan,
           state.options.threads);
  return state.run(frame, correction);
}

bool LiveSimulation::correction_lags() const { return state_->correction_lags; }
std::int64_t LiveSimulation::noise_rows() const { return state_->last.counted.noise_rows; }

IntegerRange LiveSimulation::integer_range() const { return state_->last.sensor.integer_range(state_->options.range); }

const std::vector<std::string>& LiveSimulation::names() const { return state_->names; }
const std::vector<std::string>& LiveSimulation::warnings() const { return state_->last.warnings; }
const mtf::SensorPlan& LiveSimulation::plan() const {
  if (!state_->last.plan) throw mtf::UsageError("there is no plan before the first image; call image() first");
  return *state_->last.plan;
}
std::int64_t LiveSimulation::kept_bytes() const { return state_->kept.bytes(); }
int LiveSimulation::plans_compiled() const { return state_->planner.compiled(); }
int LiveSimulation::plans_updated() const { return state_->planner.updated(); }

}  // namespace apps
