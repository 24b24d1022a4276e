// SPDX-License-Identifier: Apache-2.0

// `mtf report DIR`: one page of HTML from the results of a sweep.

#include <algorithm>
#include <filesystem>

#include "apps/options.h"
#include "apps/report/report_files.h"
#include "apps/report/report_page.h"
#include "apps/simulate/output_files.h"
#include "apps/terminal/output.h"
#include "mtf/error.h"
#include "mtf/io/file_checks.h"

namespace apps {
namespace {

void require_no_input(const Sweep& sweep, const ReportOptions& options, const std::string& out) {
  std::vector<std::string> inputs{"sweep.json", "designs.csv", "designs.npy", "columns.csv", sweep.study.file};
  for (const NamedFile& sensor : sweep.sensors) inputs.push_back(sensor.file);
  for (const SweepChosen& chosen : sweep.chosen) inputs.push_back(chosen.file);
  for (const std::string& input : inputs) require_different((sweep.folder / input).string(), out);
  if (!options.scene.empty()) require_different(options.scene, out);
}

/// What is left for designs in a page of two million bytes.
TableLimits room_for_designs(const std::vector<ChosenDesign>& chosen) {
  constexpr std::int64_t kPage = 1'850'000, kHtml = 300'000;  // static charts, tables, shown files
  const ReportFiles& files = report_files();
  std::size_t taken =
      files.page.size() + files.style.size() + files.script.size() + files.library.size() + files.notices.size();
  for (const ChosenDesign& design : chosen) {
    taken += kMostOfImage + 2 * design.text.size();
    // A curve is six digits a point.
    taken += 9 * design.frequency_cy_mm.size() * (design.components.size() + 2);
  }
  TableLimits limits;
  limits.bytes = std::clamp(kPage - kHtml - static_cast<std::int64_t>(taken), std::int64_t{100'000}, kPage / 2);
  return limits;
}

}  // namespace

int run_report(const ReportOptions& options, const Global& global) {
  const Sweep sweep = read_sweep(options.folder);
  const std::string out = options.out.empty() ? (sweep.folder / "report.html").string() : options.out;
  require_no_input(sweep, options, out);
  if (!options.scene.empty()) mtf::io::input_file_size(options.scene);  // tells at once of a name mistyped
  std::vector<ChosenDesign> chosen = load_chosen(sweep);
  const DesignTable table = read_designs(sweep, room_for_designs(chosen));
  simulate_chosen(chosen, options.scene, sweep.temperature_k, global);
  for (const ChosenDesign& design : chosen)
    if (!design.problem.empty())
      note(global, "note: design " + std::to_string(design.chosen.design) +
                       " is shown without curves: " + one_line(design.problem));
  const std::string page = report_page(sweep, table, chosen, options.scene);
  emit(out, page);
  if (out == "-") return 0;  // standard output is the report
  std::string text = std::to_string(sweep.designs) + " designs";
  if (!table.whole()) text += ", " + std::to_string(table.design.size()) + " of them in the page";
  print(text + ", " + std::to_string(chosen.size()) + " chosen\nwritten to " + one_line(out) + " (" +
        mtf::io::shown_bytes(static_cast<double>(page.size())) + ")\n");
  return 0;
}

}  // namespace apps
