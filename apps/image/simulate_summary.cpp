// SPDX-License-Identifier: Apache-2.0
#include "apps/image/simulate_summary.h"

#include "apps/terminal/text_table.h"

namespace apps {
namespace {

std::string quantity_text(const RunReport& report) { return report.quantity() + " [" + report.unit() + "]\n"; }

/// A line a channel: extremes, mean and standard deviation.
std::string channels_text(const SimulateResult& result) {
  TextTable table({"channel", "min", "mean", "max", "std"});
  for (std::size_t c = 0; c < result.statistics.size(); ++c) {
    const mtf::Statistics& s = result.statistics[c];
    table.add({one_line(result.names[c]), significant(s.min, 6), significant(s.mean, 6), significant(s.max, 6),
               significant(s.std, 6)});
  }
  return table.aligned({Align::left, Align::right, Align::right, Align::right, Align::right});
}

/// A tolerance as it was given; one that was computed, as a share of a count, in three digits.
std::string tolerance_text(double tolerance) {
  const std::string exact = mtf::format_double(tolerance);
  return exact.size() <= 8 ? exact : significant(tolerance, 3);
}

/// Predicted error, and the time in its parts; the last line is not ended.
std::string costs_text(const RunReport& report) {
  double total = 0.0;
  for (const auto& [name, ms] : report.timing_ms) total += ms;
  const std::string times =
      joined(report.timing_ms, [](const auto& one) { return one.first + " " + fixed(one.second, 1); });
  return "predicted error " + significant(report.plan->predicted_error, 2) + " of the scene's std (tolerance " +
         tolerance_text(report.tolerance) + ")\ntime " + fixed(total, 1) + " ms (" + times + ")";
}

std::string tiles_text(const TilesReport& tiles) {
  if (tiles.plan.whole) return "one tile: " + tiles.plan.reason + "\n";
  return std::to_string(tiles.plan.count) + " tiles of " + mtf::size_text(tiles.plan.side[0], tiles.plan.side[1]) +
         " px, halo " + mtf::size_text(tiles.plan.halo[0], tiles.plan.halo[1]) + " samples; " +
         std::to_string(tiles.tally.flat) + " flat, " + std::to_string(tiles.tally.resumed) + " from a stopped run\n";
}

std::string image_text(const SimulateResult& result) {
  const RunReport& report = result.report;
  const auto [width, height] = report.out_size();
  std::string text = one_line(report.out_path) + "  " + mtf::size_text(width, height) + "  " + quantity_text(report);
  if (report.tiles && !report.tiles->for_flat_parts)
    return text + channels_text(result) + tiles_text(*report.tiles) + costs_text(report) + ", peak memory " +
           fixed(peak_rss_mib(), 0) + " MiB\n";
  const mtf::PlanReport& plan = report.plan->presample.report();
  const mtf::SampleGrid& out = report.whole_image();
  if (out.width < plan.whole_pitches_x || out.height < plan.whole_pitches_y)
    text += "the scene holds " + mtf::size_text(plan.whole_pitches_x, plan.whole_pitches_y) +
            " whole pixels; frame.format takes the first of them\n";
  return text + channels_text(result) + costs_text(report) + "\n";
}

std::string sequence_text(const RunReport& report, const SequenceReport& s) {
  const mtf::SampleGrid& out = report.plan->out();
  std::string text = one_line(report.out_path) + "  " + plural(s.frames, "frame") + " (" + std::to_string(s.first) +
                     " to " + std::to_string(s.last) + ")  " + mtf::size_text(out.width, out.height) + "  " +
                     quantity_text(report);
  text += plural(s.schedule_changes, "change") + " of parameters; " + plural(s.plans_compiled, "plan") + " compiled, " +
          std::to_string(s.plans_updated) + " updated\n";
  text += "predicted error up to " + significant(s.predicted_error, 2) + " of a frame's std (tolerance " +
          tolerance_text(report.tolerance) + ")\n";
  const std::string times = joined(report.timing_ms, [&](const auto& one) {
    return one.first + " " + fixed(one.second / static_cast<double>(s.frames), 1);
  });
  return text + "time " + fixed(s.seconds, 2) + " s, " + significant(s.fps, 3) + " frames/s (ms a frame: " + times +
         "; " + plural(s.in_flight, "frame") + " at a time)\n";
}

std::string plan_text(const mtf::SensorPlan& plan) {
  return plan.presample.explain() + (plan.readout ? "readout\n" + plan.readout->explain() : "") +
         (plan.post ? "after sampling\n" + plan.post->explain() : "");
}

}  // namespace

std::string summary_text(const SimulateResult& result) {
  return result.report.sequence ? sequence_text(result.report, *result.report.sequence) : image_text(result);
}

std::string explain_text(const RunReport& report) {
  if (report.sequence)
    return "plan of frame " + std::to_string(report.sequence->first) + ", the first of " +
           plural(report.sequence->frames, "frame") +
           "; those after it have it too, with what the schedule changes, or one of their own\n" +
           plan_text(*report.sequence->first_plan);
  if (!report.tiles || report.tiles->plan.whole) return plan_text(*report.plan);
  const mtf::SampleGrid& canvas = report.plan->presample.in();
  const mtf::TileReport& tiles = report.tiles->plan;
  std::string head = "plan of one tile with its halo, " + mtf::size_text(canvas.width, canvas.height) +
                     " samples of the scene; all " + std::to_string(tiles.count) + " tiles share it\n";
  if (tiles.every > 0)
    head +=
        "it holds the near part of the point spread; the far part goes through a coarse image of the whole scene, a "
        "sample for " +
        std::to_string(tiles.every) + " x " + std::to_string(tiles.every) + "\n";
  return head + plan_text(*report.plan);
}

}  // namespace apps
