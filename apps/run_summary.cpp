// SPDX-License-Identifier: Apache-2.0
#include "apps/run_summary.h"

#include "apps/output.h"
#include "apps/text_table.h"
#include "mtf/error.h"

namespace apps {

std::string summary_head(const RunReport& report, const mtf::SampleGrid& out) {
  return one_line(report.out_path) + "  " + std::to_string(out.width) + "x" + std::to_string(out.height) + "  " +
         std::string(mtf::io::quantity_name(report.scene->quantity)) + " [" +
         std::string(mtf::io::quantity_unit(report.scene->quantity)) + "]\n";
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

}  // namespace apps
