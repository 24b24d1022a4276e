// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/method_report.h"

#include "apps/terminal/text_table.h"
#include "apps/text/json.h"

namespace apps {
namespace {

using calib::FigureChange;

std::optional<double> mtf50_in_unit(const FigureChange& figures, const FrequencyScale& scale) {
  return figures.mtf50_cy_px ? std::optional(*figures.mtf50_cy_px * scale.per_cy_px) : std::nullopt;
}

FigureChange figures_of(const calib::Iso12233Result& standard) { return {standard.mtf50, standard.nyquist}; }

FigureChange figures_of(const calib::EdgeMeasurement& edge) {
  return {edge.mtf50 ? std::optional(edge.mtf50->value) : std::nullopt,
          edge.nyquist ? std::optional(edge.nyquist->value) : std::nullopt};
}

Json comparison_figures(const FigureChange& figures, const FrequencyScale& scale) {
  const auto or_null = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
  return {{"mtf50", or_null(mtf50_in_unit(figures, scale))}, {"nyquist", or_null(figures.nyquist)}};
}

/// Decimals of MTF50 that are 1e-5 cycles per pixel or finer.
int decimals(const FrequencyScale& scale) {
  int digits = 5;
  for (double size = 1.0; size < scale.per_cy_px && digits > 0; size *= 10.0) --digits;
  return digits;
}

/// Of values, of changes, and of standard deviations.
enum class Sign { none, shown, either };

std::vector<std::string> comparison_row(const std::string& number, std::string_view what, const FigureChange& figures,
                                        const FrequencyScale& scale, Sign sign) {
  const auto text = [sign](const std::optional<double>& value, int digits) {
    if (!value) return std::string("-");
    const char* before = sign == Sign::either ? "+- " : sign == Sign::shown && *value >= 0.0 ? "+" : "";
    return before + fixed(*value, digits);
  };
  return {number, std::string(what), text(mtf50_in_unit(figures, scale), decimals(scale)), text(figures.nyquist, 5)};
}

}  // namespace

std::string comparison_table(const MeasureReport& report) {
  TextTable table(
      {"edge", "from the MTF to ISO 12233", "MTF50 [" + std::string(unit_symbol(report.unit)) + "]", "MTF at Nyquist"});
  std::string notes;
  bool any = false;
  for (std::size_t i = 0; i < report.edges.size(); ++i) {
    const MeasuredEdge& edge = report.edges[i];
    if (!edge.standard) continue;
    const std::string number = std::to_string(i + 1);
    if (!edge.standard->difference) {
      if (!edge.standard->result.reason.empty())
        notes += number + "  ISO 12233: " + edge.standard->result.reason + "\n";
      continue;
    }
    any = true;
    const calib::Iso12233Difference& difference = *edge.standard->difference;
    table.add(comparison_row(number, "MTF", figures_of(edge.edge), edge.scale, Sign::none));
    for (const calib::Iso12233Reason& reason : difference.reasons)
      table.add(comparison_row("", reason.reason, reason.change, edge.scale, Sign::shown));
    table.add(comparison_row("", "not explained", difference.unexplained, edge.scale, Sign::shown));
    table.add(comparison_row("", "scatter of ISO 12233 by noise", difference.scatter, edge.scale, Sign::either));
    table.add(comparison_row("", "ISO 12233", figures_of(edge.standard->result), edge.scale, Sign::none));
  }
  return (any ? "\n" + table.aligned({Align::right, Align::left, Align::right, Align::right}) : "") +
         (notes.empty() ? "" : "\n" + notes);
}

std::string comparison_header(const MeasureReport& report) {
  return report.method == "both" ? ",iso12233_mtf50,iso12233_nyquist" : "";
}

std::string comparison_columns(const MeasuredEdge& edge) {
  if (!edge.standard) return "";
  const FigureChange figures = figures_of(edge.standard->result);
  const auto cell = [](const std::optional<double>& value) { return "," + (value ? csv_number(*value) : ""); };
  return cell(mtf50_in_unit(figures, edge.scale)) + cell(figures.nyquist);
}

Json comparison_json(const MeasuredEdge& edge) {
  if (!edge.standard) return {};
  const calib::Iso12233Result& standard = edge.standard->result;
  Json json = comparison_figures(figures_of(standard), edge.scale);
  json["reason"] = standard.reason.empty() ? Json() : Json(standard.reason);
  if (!edge.standard->difference) return json;
  const calib::Iso12233Difference& difference = *edge.standard->difference;
  json["difference"] = comparison_figures(difference.total, edge.scale);
  json["reasons"] = Json::array();
  for (const calib::Iso12233Reason& reason : difference.reasons) {
    Json one{{"reason", reason.reason}};
    one.update(comparison_figures(reason.change, edge.scale));
    json["reasons"].push_back(std::move(one));
  }
  json["unexplained"] = comparison_figures(difference.unexplained, edge.scale);
  json["scatter_by_noise"] = comparison_figures(difference.scatter, edge.scale);
  return json;
}

}  // namespace apps
