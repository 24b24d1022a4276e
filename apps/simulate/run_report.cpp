// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/run_report.h"

#include <sys/resource.h>

#include "apps/text/json.h"
#include "mtf/engines/fft/fftw.h"
#include "mtf/version.h"

namespace apps {
namespace {

Json plan_json(const mtf::Plan& plan) {
  const mtf::PlanReport& r = plan.report();
  Json dropped = Json::array();
  for (const mtf::Dropped& d : r.dropped) dropped.push_back({{"label", d.label}, {"bound", d.bound}});
  Json omitted = Json::array(), candidates = Json::array();
  for (const mtf::Omission& o : r.omitted)
    omitted.push_back({{"what", o.what}, {"bound", o.bound}, {"saved_ms", o.saved_ms}});
  for (const mtf::Candidate& c : r.candidates) {
    Json one = {{"method", mtf::kMethodNames[static_cast<std::size_t>(c.method)]},
                {"detail", c.detail},
                {"possible", c.possible}};
    if (c.possible) {
      one["predicted_error"] = c.predicted.total();
      one["cost_ms"] = c.cost_ms;
      one["measured"] = c.measured;
    }
    one["reason"] = c.reason;
    candidates.push_back(one);
  }
  const mtf::PredictedError& e = r.predicted;
  Json json{{"method", r.method},
            {"size", r.size},
            {"axes", r.axes},
            {"frequencies_kept", r.kept},
            {"frequencies_available", r.available},
            {"dropped", dropped},
            {"merged", r.merged},
            {"omitted", omitted},
            {"candidates", candidates},
            {"wavelengths", r.wavelengths},
            {"notes", r.notes},
            {"tolerance", r.tolerance},
            {"predicted_error", e.total()},
            {"predicted_parts",
             {{"dropped", e.dropped},
              {"table", e.table},
              {"band", e.band},
              {"cut", e.cut},
              {"wrap", e.wrap},
              {"kernel", e.kernel},
              {"flat_lines", e.flat},
              {"arithmetic", e.arithmetic}}},
            {"otf_bytes", r.otf_bytes},
            {"buffer_bytes", r.run_bytes}};
  if (r.field.points > 0) {
    json["field"] = {{"points", r.field.points},
                     {"modes", r.field.modes},
                     {"tiles", r.field.tiles},
                     {"one_otf_error", r.field.one_otf_error}};
    if (const auto& ranges = r.field.ranges)
      json["field"]["range_m"] = {ranges->nearest_m, ranges->farthest_m},
      json["field"]["least_weight"] = ranges->least_weight;
    json["predicted_parts"]["field"] = e.modes;
  }
  return json;
}

Json held_json(const radiometry::HeldPixels& held) {
  return {{"pixels", held.pixels},
          {"at_full_well", held.full_well},
          {"at_most_count", held.most_count},
          {"at_least_count", held.least_count}};
}

Json sequence_json(const SequenceReport& s) {
  Json json = {{"frames", s.frames},
               {"first", s.first},
               {"last", s.last},
               {"seconds", s.seconds},
               {"fps", s.fps},
               {"frames_at_a_time", s.in_flight},
               {"plans_compiled", s.plans_compiled},
               {"plans_updated", s.plans_updated},
               {"schedule_changes", s.schedule_changes},
               {"predicted_error", s.predicted_error},
               {"frames_with_bad_pixels", s.frames_with_bad_pixels}};
  json["saturated_frames"] = Json::array();
  for (const auto& [frame, held] : s.saturated) {
    Json one{{"frame", frame}};
    one.update(held_json(held));
    json["saturated_frames"].push_back(std::move(one));
  }
  if (!s.schedule.empty()) json["schedule"] = s.schedule;
  if (!s.schedule.empty()) json["schedule_sha256"] = s.schedule_sha256;
  return json;
}

Json chain_json(const ChainReport& chain) {
  Json stages = Json::array();
  for (const radiometry::ChainStage& stage : chain.stages)
    stages.push_back({{"name", stage.name}, {"on", stage.on}, {"what", stage.what}});
  Json saturation = held_json(chain.held);
  saturation["share"] = chain.held.share();
  saturation["defective_or_blinking"] = held_json(chain.held_defects);
  saturation["warning"] = chain.held.any() ? Json(words(chain.held)) : Json();
  Json json = {{"tap", chain.stage},
               {"stages", stages},
               {"timing_ms", Json::object(chain.timing_ms)},
               {"saturation", saturation},
               {"pixels_at_full_well", chain.well.high},
               {"pixels_at_least_count", chain.adc.low},
               {"pixels_at_most_count", chain.adc.high},
               {"drained_e", chain.spilled.drained_e},
               {"left_at_edges_e", chain.spilled.left_e}};
  if (chain.correction)
    json["correction"] = {{"bad_pixels", chain.correction->bad.size()},
                          {"flat_frames", held_json(chain.correction->saturated)}};
  return json;
}

// The plan is that of one tile; sizes are those of the whole run.
void add_tiles(Json& json, const TilesReport& tiles) {
  json["scene_size"] = {tiles.scene.width, tiles.scene.height};
  json["whole_pixels_in_scene"] = tiles.whole_pixels;
  json["tiles"] = {{"count", tiles.plan.count},         {"flat", tiles.tally.flat},
                   {"resumed", tiles.tally.resumed},    {"size", tiles.plan.side},
                   {"halo", tiles.plan.halo},           {"post_halo", tiles.plan.post_halo},
                   {"coarse_every", tiles.plan.every},  {"halo_error", tiles.plan.halo_error},
                   {"in_flight", tiles.plan.in_flight}, {"saved_ms", tiles.tally.saved_ms},
                   {"bytes", tiles.plan.bytes}};
  if (tiles.plan.whole) json["tiles"]["whole"] = tiles.plan.reason;
}

}  // namespace

void ChainReport::add(const radiometry::ChainFrame& frame) {
  well.low += frame.well.low;
  well.high += frame.well.high;
  adc.low += frame.adc.low;
  adc.high += frame.adc.high;
  spilled.drained_e += frame.spilled.drained_e;
  spilled.left_e += frame.spilled.left_e;
  held += frame.held;
  held_defects += frame.held_defects;
  if (frame.correction) correction = frame.correction;
}

std::string RunReport::quantity() const {
  return chain ? chain->quantity : std::string(mtf::io::quantity_name(scene.quantity));
}

std::string RunReport::unit() const {
  return chain ? chain->unit : std::string(mtf::io::quantity_unit(scene.quantity));
}

double peak_rss_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

std::array<std::int64_t, 2> RunReport::out_size() const {
  if (region) return {(*region)[2], (*region)[3]};
  return {whole_image().width, whole_image().height};
}

std::string to_json(const RunReport& r) {
  const mtf::PlanReport& plan = r.plan->presample.report();
  Json json;
  json["version"] = mtf::version;
  json["git_commit"] = mtf::git_commit;
  json["fft"] = mtf::fft::version();
  json["sensor"] = r.sensor_file;
  json["config_sha256"] = r.sensor_sha256;
  json["scene"] = r.scene_path;
  json["out"] = r.out_path;
  json["scene_encoding"] = r.scene.encoding.encoding.name;
  json["scene_encoding_source"] = r.scene.encoding.source;
  json["channels"] = r.scene.names;
  json["quantity"] = r.quantity();
  json["units"] = r.unit();
  json["scene_size"] = {plan.in.width, plan.in.height};
  json["scene_step_um"] = {plan.in.step_x_um, plan.in.step_y_um};
  json["whole_pixels_in_scene"] = {plan.whole_pitches_x, plan.whole_pitches_y};
  json["out_size"] = r.out_size();
  json["out_step_um"] = {plan.out.step_x_um, plan.out.step_y_um};
  json["tolerance"] = r.tolerance;
  json["plan"] = plan_json(r.plan->presample);
  if (r.plan->post) {
    // The object speaks of the whole run; each step's own share stands beside it.
    json["presample_plan"] = json["plan"];
    json["post_plan"] = plan_json(*r.plan->post);
    const double post = r.plan->post->report().predicted.total();
    const double gain = (r.plan->predicted_error - post) / plan.predicted.total();
    for (auto& [name, part] : json["plan"]["predicted_parts"].items()) part = part.get<double>() * gain;
    json["plan"]["predicted_parts"]["after_sampling"] = post;
  }
  json["plan"]["tolerance"] = r.tolerance;
  json["plan"]["predicted_error"] = r.plan->predicted_error;
  for (const auto& [name, ms] : r.timing_ms) json["timing_ms"][name] = ms;
  if (r.chain) json["chain"] = chain_json(*r.chain);
  if (r.sequence) json["sequence"] = sequence_json(*r.sequence);
  json["peak_rss_mib"] = peak_rss_mib();
  json["warnings"] = r.warnings;
  if (!r.bad_pixels.empty()) json["bad_pixels"] = r.bad_pixels;
  if (!r.integer_scaling.empty())
    json["integer_output"] = {{"bits", r.scaling.bits},
                              {"gain", r.scaling.gain},
                              {"offset", r.scaling.offset},
                              {"clamped", r.clamped},
                              {"meaning", r.integer_scaling}};
  if (r.tiles) add_tiles(json, *r.tiles);
  // Names of files may hold any bytes; the report stays valid UTF-8.
  return json_document(json);
}

}  // namespace apps
