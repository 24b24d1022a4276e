// SPDX-License-Identifier: Apache-2.0

// The chosen designs side by side.

#include <algorithm>
#include <cmath>

#include "apps/report/report_html.h"
#include "apps/report/report_sections.h"
#include "apps/report/report_svg.h"
#include "apps/terminal/text_table.h"

namespace apps {
namespace {

using Chosen = std::vector<ChosenDesign>;

std::vector<std::string> header_of(const std::string& first, const Chosen& chosen) {
  std::vector<std::string> header{first};
  for (const ChosenDesign& design : chosen)
    header.push_back("<span class=\"key\" data-design=\"" + std::to_string(design.chosen.design) + "\">" +
                     std::to_string(design.chosen.design) + "</span>");
  return header;
}

std::vector<std::size_t> all_but_first(const Chosen& chosen) {
  std::vector<std::size_t> columns(chosen.size());
  for (std::size_t i = 0; i < columns.size(); ++i) columns[i] = i + 1;
  return columns;
}

std::string values(const Sweep& sweep, const DesignTable& table, const Chosen& chosen) {
  HtmlTable rows("Values of the chosen designs", header_of("Design", chosen), all_but_first(chosen));
  std::vector<std::string> why{"chosen as"};
  for (const ChosenDesign& design : chosen) why.push_back("<span class=\"why\">" + html(design.chosen.why) + "</span>");
  rows.add(why);
  for (std::size_t c = 0; c < sweep.columns.size(); ++c) {
    const SweepColumn& column = sweep.columns[c];
    if (!column.gap.empty()) continue;
    std::vector<std::string> cells{
        column_html(column) + (column.unit.empty() ? "" : " <span class=\"unit\">" + html(column.unit) + "</span>")};
    for (const ChosenDesign& design : chosen) {
      const auto row = table.row(design.chosen.design);
      const std::string cell = row ? table.cells[*row][c] : "";
      const bool yes_or_no = column.role == "feasible" || column.role == "pareto";
      cells.push_back(yes_or_no ? (cell == "1" ? "yes" : "no") : html_value(cell));
    }
    rows.add(cells);
  }
  return rows.html();
}

std::string problems(const Chosen& chosen) {
  std::string text;
  for (const ChosenDesign& design : chosen)
    if (!design.problem.empty())
      text += "<p class=\"gap\"><strong>Design " + std::to_string(design.chosen.design) +
              "</strong> has no curves, budget and image: " + html(design.problem) + ".</p>\n";
  return text;
}

std::string static_curves(const Chosen& chosen) {
  Figure figure;
  figure.title = "MTF of the chosen designs, along x";
  figure.x_label = "spatial frequency along x (cy/mm)";
  figure.y_label = "MTF";
  figure.y_low = 0.0;
  figure.y_high = 1.0;
  for (const ChosenDesign& design : chosen)
    if (design.problem.empty())
      figure.series.push_back({.name = "design " + std::to_string(design.chosen.design),
                               .x = design.frequency_cy_mm,
                               .y = design.system.mtf});
  return svg_figure(figure);
}

/// What each component leaves at Nyquist along x: the budget of the MTF.
std::string component_budget(const Chosen& chosen) {
  std::vector<std::pair<std::string, std::string>> labels;  // with what they are
  for (const ChosenDesign& design : chosen)
    for (const ChosenCurve& curve : design.components)
      if (std::none_of(labels.begin(), labels.end(), [&](const auto& l) { return l.first == curve.label; }))
        labels.emplace_back(curve.label, curve.doc);
  if (labels.empty()) return "";
  HtmlTable rows("MTF at Nyquist along x, by component", header_of("Component", chosen), all_but_first(chosen));
  for (const auto& [label, doc] : labels) {
    std::vector<std::string> cells{"<abbr title=\"" + html(doc) + "\">" + html(label) + "</abbr>"};
    for (const ChosenDesign& design : chosen) {
      const auto found = std::find_if(design.components.begin(), design.components.end(),
                                      [&, name = label](const auto& curve) { return curve.label == name; });
      cells.push_back(found == design.components.end() ? html_value("") : html_value(found->at_nyquist));
    }
    rows.add(cells);
  }
  std::vector<std::string> product{"<strong>system</strong>"},
      nyquist{"Nyquist frequency along x <span class=\"unit\">cy/mm</span>"};
  for (const ChosenDesign& design : chosen) {
    product.push_back(design.problem.empty() ? html_value(design.system.at_nyquist) : html_value(""));
    nyquist.push_back(design.problem.empty() ? html_value(design.nyquist_cy_mm) : html_value(""));
  }
  rows.add(product);
  rows.add(nyquist);
  return rows.html();
}

std::string images(const Chosen& chosen, const std::string& scene) {
  std::string text =
      "<h3>Simulated images</h3>\n<p>" +
      (scene.empty()
           ? std::string("One computed scene of the same angular size for all, as <code>mtf simulate</code> images it "
                         "with noise: temperatures about the study's where sensors take temperatures, below "
                         "3 &micro;m sunlit ground.")
           : "The scene <code>" + html(scene) + "</code>, its middle part of the same angle for all.") +
      " Each is stretched between its own quantiles of 0.5 and 99.5 %, so contrast against noise can be compared, "
      "brightness cannot; values beyond these are clipped to black or white. The OTF is kept to 0.2 %, half a grey "
      "value.</p>\n<div class=\"images\">";
  std::string gaps;
  for (const ChosenDesign& design : chosen) {
    const ChosenImage& image = design.image;
    const std::string number = std::to_string(design.chosen.design);
    if (image.data_uri.empty()) {
      if (design.problem.empty())
        gaps += "<p class=\"gap\"><strong>Design " + number + "</strong> has no image: " + html(design.image_gap) +
                ".</p>\n";
      continue;
    }
    std::string notes;
    for (const std::string& note : image.notes) notes += "<br>" + html(note);
    text += "<figure><img src=\"" + image.data_uri +
            "\" width=\"220\" height=\"220\" alt=\"simulated image of design " + number +
            "\"><figcaption><span class=\"key\" data-design=\"" + number + "\">" + number + "</span> " +
            html(design.chosen.why) + "<br><span class=\"greys\"><span>&le; " + significant(image.low, 4) +
            "</span><span>" + html(image.unit) + "</span><span>&ge; " + significant(image.high, 4) +
            "</span></span><small>" + std::to_string(image.width) + " &times; " + std::to_string(image.height) + " px" +
            notes + "</small></figcaption></figure>\n";
  }
  return text + "</div>\n" + gaps;
}

std::string noise_budget(const Chosen& chosen, double temperature_k) {
  const auto with = std::find_if(chosen.begin(), chosen.end(), [](const auto& d) { return !d.budget.empty(); });
  std::string gaps;
  for (const ChosenDesign& design : chosen)
    if (design.budget.empty() && design.problem.empty())
      gaps += "<p class=\"gap\"><strong>Design " + std::to_string(design.chosen.design) +
              "</strong> has no noise budget: " + html(design.budget_gap) + ".</p>\n";
  for (const ChosenDesign& design : chosen)
    if (!design.saturation.empty())
      gaps += "<p class=\"gap\"><strong>Design " + std::to_string(design.chosen.design) + "</strong> is " +
              html(design.saturation) + ".</p>\n";
  if (with == chosen.end()) return "<h3>Noise budget</h3>\n" + gaps;
  const std::string surface = mtf::format_double(temperature_k) + " K";
  HtmlTable rows("Noise budget of a pixel that images " + surface, header_of("Term", chosen), all_but_first(chosen));
  for (std::size_t i = 0; i < with->budget.size(); ++i) {
    const radiometry::BudgetRow& row = with->budget[i];
    std::vector<std::string> cells{"<abbr title=\"" + html(row.doc) + "\">" + html(row.name) +
                                   "</abbr> <span class=\"unit\">" + html(row.unit) + "</span>"};
    for (const ChosenDesign& design : chosen) {
      const auto same = std::find_if(design.budget.begin(), design.budget.end(), [&](const auto& other) {
        return other.name == row.name && other.unit == row.unit;
      });
      cells.push_back(same == design.budget.end() ? html_value("")
                      : same->saturated           ? "saturated"
                                                  : html_value(same->value));
    }
    rows.add(cells);
  }
  std::vector<Bar> bars;
  std::string unit;  // of the first design: volts and electrons do not share an axis
  for (const ChosenDesign& design : chosen)
    for (const radiometry::BudgetRow& row : design.budget) {
      if (row.name != "temporal" || !row.refused.empty()) continue;
      if (unit.empty()) unit = row.unit;
      if (row.unit == unit) bars.push_back({"design " + std::to_string(design.chosen.design), row.value, 0.0});
    }
  return "<h3>Noise budget</h3>\n<p>Of a pixel on the optical axis that images a surface of " + surface +
         ", as in <code>mtf budget</code>. Variances add: bars are shares of the temporal variance.</p>\n" +
         html_chart("noise",
                    svg_bars("Temporal noise", (unit == "V" ? "volts" : "electrons") + std::string(" rms"), bars)) +
         "<details><summary>All terms</summary>" + rows.html() + "</details>\n" + gaps;
}

}  // namespace

std::string chosen_section(const Sweep& sweep, const DesignTable& table, const Chosen& chosen,
                           const std::string& scene) {
  if (chosen.empty()) return html_section("chosen", "Chosen designs", "", "<p class=\"gap\">The sweep chose none.</p>");
  std::string body = problems(chosen) + values(sweep, table, chosen);
  if (std::any_of(chosen.begin(), chosen.end(), [](const auto& d) { return d.problem.empty(); }))
    body +=
        "<h3>MTF</h3>\n" + html_chart("curves", static_curves(chosen)) +
        "<p>What each component leaves of the modulation at Nyquist, along x; the metric <code>mtf_nyquist</code> is "
        "the geometric mean of both axes:</p>\n" +
        component_budget(chosen) + images(chosen, scene) + noise_budget(chosen, sweep.temperature_k);
  return html_section("chosen", "Chosen designs", "The best of each objective, and some from along the Pareto front.",
                      body);
}

}  // namespace apps
