// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/run_summary.h"

#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"

namespace apps {

std::string summary_head(const RunReport& report, const mtf::SampleGrid& out) {
  return one_line(report.out_path) + "  " + std::to_string(out.width) + "x" + std::to_string(out.height) + "  " +
         report.quantity() + " [" + report.unit() + "]\n";
}

std::string summary_channels(const std::vector<std::string>& names, const std::vector<mtf::Statistics>& statistics) {
  TextTable table({"channel", "min", "mean", "max", "std"});
  for (std::size_t c = 0; c < statistics.size(); ++c) {
    const mtf::Statistics& s = statistics[c];
    table.add({one_line(names[c]), significant(s.min, 6), significant(s.mean, 6), significant(s.max, 6),
               significant(s.std, 6)});
  }
  return table.aligned({Align::left, Align::right, Align::right, Align::right, Align::right});
}

std::string summary_costs(const RunReport& report) {
  double total = 0.0;
  std::string times;
  for (const auto& [name, ms] : report.timing_ms) {
    times += (times.empty() ? "" : ", ") + name + " " + fixed(ms, 1);
    total += ms;
  }
  return "predicted error " + significant(report.plan->predicted_error, 2) + " of the scene's std (tolerance " +
         mtf::format_double(report.tolerance) + ")\ntime " + fixed(total, 1) + " ms (" + times + ")";
}

std::string explain_text(const mtf::SensorPlan& plan) {
  return plan.presample.explain() + (plan.readout ? "readout\n" + plan.readout->explain() : "") +
         (plan.post ? "after sampling\n" + plan.post->explain() : "");
}

std::string explain_tiles(const mtf::SensorPlan& plan, const mtf::TileReport& tiles) {
  if (tiles.whole) return explain_text(plan);
  const mtf::SampleGrid& canvas = plan.presample.in();
  std::string head = "plan of one tile with its halo, " + std::to_string(canvas.width) + "x" +
                     std::to_string(canvas.height) + " samples of the scene; all " + std::to_string(tiles.count) +
                     " tiles share it\n";
  if (tiles.every > 0)
    head +=
        "it holds the near part of the point spread; the far part goes through a coarse image of the whole scene, a "
        "sample for " +
        std::to_string(tiles.every) + " x " + std::to_string(tiles.every) + "\n";
  return head + explain_text(plan);
}

}  // namespace apps
