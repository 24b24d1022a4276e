// SPDX-License-Identifier: Apache-2.0

// `mtf report DIR`: one page of HTML from what a sweep left.

#include <filesystem>

#include "apps/options.h"
#include "apps/output.h"
#include "apps/report_page.h"
#include "mtf/error.h"
#include "mtf/io/file_checks.h"

namespace apps {
namespace {

void require_no_input(const Sweep& sweep, const ReportOptions& options, const std::string& out) {
  std::vector<std::string> inputs{"sweep.json", "designs.csv", "designs.npy", sweep.study.file};
  for (const NamedFile& sensor : sweep.sensors) inputs.push_back(sensor.file);
  for (const SweepChosen& chosen : sweep.chosen) inputs.push_back(chosen.file);
  for (const std::string& input : inputs) require_different((sweep.folder / input).string(), out);
  if (!options.scene.empty()) require_different(options.scene, out);
}

}  // namespace

int run_report(const ReportOptions& options, const Global& global) {
  const Sweep sweep = read_sweep(options.folder);
  const std::string out = options.out.empty() ? (sweep.folder / "report.html").string() : options.out;
  require_no_input(sweep, options, out);
  if (!options.scene.empty()) mtf::io::input_file_size(options.scene);  // tells at once of a name mistyped
  const DesignTable table = read_designs(sweep);
  std::vector<ChosenDesign> chosen = load_chosen(sweep);
  simulate_chosen(chosen, options.scene, global);
  for (const ChosenDesign& design : chosen)
    if (!design.problem.empty())
      note(global, "note: design " + std::to_string(design.chosen.design) + " is shown without curves: " +
                       one_line(design.problem));
  const std::string page = report_page(sweep, table, chosen, options.scene);
  emit(out, page);
  if (out == "-") return 0;  // standard output is the report
  std::string text = std::to_string(sweep.designs) + " designs";
  if (!table.whole()) text += ", " + std::to_string(table.design.size()) + " of them in the page";
  print(text + ", " + std::to_string(chosen.size()) + " chosen ones\nwritten to " + one_line(out) + " (" +
        mtf::io::shown_bytes(static_cast<double>(page.size())) + ")\n");
  return 0;
}

}  // namespace apps
