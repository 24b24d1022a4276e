// SPDX-License-Identifier: Apache-2.0

// `mtf report DIR`: one page of HTML from the results of a sweep.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "apps/commands.h"
#include "apps/page/html.h"
#include "apps/report/report_sweep.h"
#include "apps/simulate/output_files.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/image_io.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"

namespace apps {
namespace {

struct ReportOptions {
  std::string folder;
  std::string scene;  ///< of the images of the chosen designs; "" = a computed one
  std::string out;    ///< "" = report.html in the folder
};

// The whole report as one page that needs nothing else: style, scripts, data and pictures are in it.

/// A list of JSON values, each made by `make` of an element.
template <class List, class Make>
std::string json_list(const List& list, const Make& make) {
  std::string text = "[";
  for (const auto& element : list) {
    if (text.size() > 1) text += ',';
    text += make(element);
  }
  return text + "]";
}

std::string json_texts(const std::vector<std::string>& texts) { return json_list(texts, json_text); }

/// Six digits: enough for curves that are drawn.
std::string json_curve(const std::vector<double>& values) {
  return json_list(values, [](double v) { return std::isfinite(v) ? significant(v, 6) : std::string("null"); });
}

std::string json_column(const SweepColumn& column) {
  return "{\"name\":" + json_text(column.name) + ",\"unit\":" + json_text(column.unit) +
         ",\"role\":" + json_text(column.role) + ",\"gap\":" + json_text(column.gap) +
         ",\"levels\":" + json_texts(column.levels) + "}";
}

std::string json_curve_of(const ChosenCurve& curve) {
  return "{\"label\":" + json_text(curve.label) + ",\"mtf\":" + json_curve(curve.mtf) + "}";
}

std::string json_chosen(const ChosenDesign& design) {
  std::string text = "{\"design\":" + std::to_string(design.chosen.design) + ",\"why\":" + json_text(design.chosen.why);
  if (design.problem.empty()) {
    const mtf::Frame<double>& frame = design.config.system.frame;
    text += ",\"pitch_um\":" + json_number(frame.pitch_x_um) + ",\"focal_mm\":" + json_number(frame.focal_length_mm) +
            ",\"nyquist\":" + json_number(design.nyquist_cy_mm) +
            ",\"frequency\":" + json_curve(design.frequency_cy_mm) + ",\"system\":" + json_curve(design.system.mtf) +
            ",\"components\":" + json_list(design.components, json_curve_of) +
            ",\"budget\":" + json_list(design.budget, [](const radiometry::BudgetRow& row) {
              return "[" + json_text(row.name) + "," + json_number(row.value) + "]";
            });
  }
  return text + "}";
}

/// SHA-256 in base 64, as policies name a script.
std::string script_hash(std::string_view script) {
  const std::string hex = mtf::io::sha256_hex(script);
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return "'sha256-" + base64(bytes) + "'";
}

/// What the page's script reads: columns, designs with their cells as in designs.csv, curves. JSON in which no text
/// ends a script element.
std::string report_data(const Sweep& sweep, const DesignTable& table, const std::vector<ChosenDesign>& chosen) {
  std::string text = "{\"columns\":" + json_list(sweep.columns, json_column);
  text += ",\"method\":" + json_text(sweep.method) + ",\"designs\":" + std::to_string(sweep.designs) +
          ",\"every\":" + std::to_string(table.every);
  text += ",\"axes\":" + json_list(sweep.axes, [](const SweepAxis& axis) {
            return "{\"column\":" + json_text(axis.column) + ",\"scale\":" + json_text(axis.scale) +
                   ",\"values\":" + json_list(axis.values, json_cell) + "}";
          });
  text += ",\"objectives\":" + json_list(sweep.objectives, [](const SweepObjective& objective) {
            return "{\"text\":" + json_text(objective.text) + ",\"column\":" + json_text(objective.column) +
                   ",\"maximize\":" + (objective.maximize ? "true" : "false") + "}";
          });
  text += ",\"constraints\":" + json_list(sweep.constraints, [](const SweepConstraint& constraint) {
            return "{\"text\":" + json_text(constraint.text) + ",\"columns\":" + json_texts(constraint.columns) +
                   ",\"limit\":" + json_number(constraint.limit) + ",\"relation\":" + json_text(constraint.relation) +
                   "}";
          });
  const auto number = [](std::int64_t n) { return std::to_string(n); };
  text += ",\"best\":" + json_list(sweep.best, [&](const SweepBest& best) { return number(best.design); });
  text += ",\"pareto\":" + json_list(sweep.pareto, number);
  text += ",\"indices\":" + json_list(sweep.indices, [](const SensitivityIndex& one) {
            return "[" + json_text(one.column) + "," + json_text(one.parameter) + "," + json_number(one.first) + "," +
                   json_number(one.first_sd) + "," + json_number(one.total) + "," + json_number(one.total_sd) + "]";
          });
  text += ",\"accuracy\":" + json_list(sweep.accuracy, [](const AccuracyPoint& point) {
            return "[" + json_number(point.tolerance) + "," + json_number(point.promised) + "," +
                   json_number(point.realised) + "," + json_number(point.us_per_design) + "]";
          });
  text += ",\"chosen\":" + json_list(chosen, json_chosen);
  text += ",\n\"design\":" + json_list(table.design, number) + ",\n\"cells\":[";
  for (std::size_t c = 0; c < sweep.columns.size(); ++c) {
    if (c > 0) text += ",\n";
    text += json_list(table.cells, [c](const std::vector<std::string>& cells) { return json_cell(cells[c]); });
  }
  return text + "]}\n";
}

/// `scene`: the file of the images, "" for the built-in one. Its policy allows the page's own scripts only, by their
/// hashes.
std::string report_page(const Sweep& sweep, const DesignTable& table, const std::vector<ChosenDesign>& chosen,
                        const std::string& scene) {
  const ReportFiles& files = report_files();
  const std::string title = sweep.name.empty() ? "Trade study" : html(sweep.name);
  const bool interactive = !files.library.empty();
  const std::string_view script = interactive ? files.script : std::string_view();
  const std::string about = (sweep.date.empty() ? "" : html(sweep.date) + " &middot; ") + "sweep by mtf " +
                            html(sweep.version) + " " + html(sweep.commit) + " &middot; page by mtf " +
                            html(mtf::version) + " " + html(mtf::git_commit);
  const std::vector<HtmlPart> parts{
      {"summary", "Summary", summary_section(sweep, table)},
      {"trade", "Trade space", sweep.single() ? "" : trade_section(sweep, table)},
      {"maps", "Maps", interactive ? map_section(sweep) : ""},
      {"chosen", sweep.single() ? "Data sheet" : "Chosen designs", chosen_section(sweep, table, chosen, scene)},
      {"sensitivities", "Sensitivities", sensitivity_section(sweep, table)},
      {"run", "Error and time", run_section(sweep)},
      {"definitions", "Definitions", sweep.single() ? "" : columns_section(sweep)},
      {"files", "Files", files_section(sweep, table, chosen)},
      {"notices", "",
       html_section(
           "notices", "Notices", "",
           "<details><summary>Licences of the chart libraries in this page</summary><pre class=\"wrap\">" +
               (interactive ? html_lines(files.notices) : "This build has no chart libraries: its charts are static.") +
               "</pre></details>\n")}};
  const auto element = [](std::string_view text) { return "<script>" + std::string(text) + "</script>\n"; };
  return html_page(title, about, parts, interactive ? script_hash(files.library) + " " + script_hash(script) : "'none'",
                   "<script type=\"application/json\" id=\"data\">\n" + report_data(sweep, table, chosen) +
                       "</script>\n" + element(files.library) + element(script));
}

void require_no_input(const Sweep& sweep, const ReportOptions& options, const std::string& out) {
  std::vector<std::string> inputs{"sweep.json", "designs.csv", "designs.npy", "columns.csv", sweep.study.file};
  for (const NamedFile& sensor : sweep.sensors) inputs.push_back(sensor.file);
  for (const SweepChosen& chosen : sweep.chosen) inputs.push_back(chosen.file);
  for (const std::string& input : inputs) require_different((sweep.folder / input).string(), out);
  if (!options.scene.empty()) require_different(options.scene, out);
}

/// Tells at once of a name mistyped, and of what is no image.
void require_image(const std::string& scene) {
  mtf::io::input_file_size(scene);
  try {
    static_cast<void>(mtf::io::read_info(scene));
  } catch (const mtf::RuntimeError& error) {
    throw mtf::UsageError(std::string("--scene: ") + error.what());
  }
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

int run_report(const ReportOptions& options, const Global& global) {
  const Sweep sweep = read_sweep(options.folder);
  const std::string out = options.out.empty() ? (sweep.folder / "report.html").string() : options.out;
  require_no_input(sweep, options, out);
  if (!options.scene.empty()) require_image(options.scene);
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

}  // namespace

Command report_command() {
  Command app{"report", "one page of HTML from the folder of a sweep",
              "Summary, charts to interact with, the chosen designs side by side with their curves, images and noise,\n"
              "sensitivities, error against time. The file needs nothing else: no network, no other files.",
              "  mtf report sweep\n"
              "  mtf report sweep -o study.html"};
  auto& options = options_of<ReportOptions>(app, run_report);
  add_file(app, "folder", "that `mtf sweep STUDY -o DIR` wrote", options.folder);
  add_text(app, "--scene", "FILE", "scene for images of the chosen designs; default: a computed one", options.scene);
  add_text(app, "-o,--out", "FILE", "write the page here; default: report.html in the folder", options.out);
  return app;
}

}  // namespace apps
