// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/measure_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "apps/text/message_words.h"
#include "mtf/units.h"
#include "mtf/version.h"

namespace apps {
namespace {

using calib::EdgeMeasurement;
using calib::Estimate;

struct Merit {
  const char* name;
  std::optional<Estimate> EdgeMeasurement::*value;
  bool frequency = false;
};
constexpr std::array kMerits{Merit{"mtf50", &EdgeMeasurement::mtf50, true},
                             Merit{"mtf30", &EdgeMeasurement::mtf30, true},
                             Merit{"mtf20", &EdgeMeasurement::mtf20, true},
                             Merit{"mtf10", &EdgeMeasurement::mtf10, true},
                             Merit{"mtf50p", &EdgeMeasurement::mtf50p, true},
                             Merit{"nyquist", &EdgeMeasurement::nyquist},
                             Merit{"rer", &EdgeMeasurement::rer},
                             Merit{"overshoot", &EdgeMeasurement::overshoot},
                             Merit{"fwhm_px", &EdgeMeasurement::fwhm_px},
                             Merit{"mtfa", &EdgeMeasurement::mtfa},
                             Merit{"sampling_efficiency", &EdgeMeasurement::sampling_efficiency}};

std::string merit_name(double contrast) { return "mtf" + percent_text(contrast); }

/// Names of the figures of merit, then those of the contrasts that were asked for.
std::vector<std::string> merit_names(std::span<const double> contrasts) {
  std::vector<std::string> names;
  for (const Merit& merit : kMerits) names.emplace_back(merit.name);
  for (const double contrast : contrasts) names.push_back(merit_name(contrast));
  return names;
}

/// Their values in the same order, frequencies in the unit of the edge.
std::vector<std::optional<Estimate>> merits_of(const MeasuredEdge& edge) {
  std::vector<std::optional<Estimate>> values;
  for (const Merit& merit : kMerits) {
    const std::optional<Estimate>& value = edge.edge.*merit.value;
    values.push_back(merit.frequency ? in_unit(value, edge.scale) : value);
  }
  for (const std::optional<Estimate>& frequency : edge.at_contrasts) values.push_back(in_unit(frequency, edge.scale));
  return values;
}

/// The contrasts whose names are neither known nor those of earlier ones.
std::vector<double> unknown_of(std::vector<double> contrasts, std::vector<std::string> known) {
  std::erase_if(contrasts, [&](double contrast) {
    const std::string name = merit_name(contrast);
    if (std::find(known.begin(), known.end(), name) != known.end()) return true;
    known.push_back(name);
    return false;
  });
  return contrasts;
}

// The response of ISO 12233 beside the MTF of the same edges, and why they differ.

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
  return {{"mtf50", mtf50_in_unit(figures, scale)}, {"nyquist", figures.nyquist}};
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

/// A table that leads from the MTF to the response of ISO 12233 for every edge that both methods measured, and why the
/// others were not; "" where only one method was asked for.
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

/// The columns of CSV: what ISO 12233 gives for MTF50 and at Nyquist; "" where only one method was asked for.
std::string comparison_header(const MeasureReport& report) {
  return report.method == "both" ? ",iso12233_mtf50,iso12233_nyquist" : "";
}

std::string comparison_columns(const MeasuredEdge& edge) {
  if (!edge.standard) return "";
  const FigureChange figures = figures_of(edge.standard->result);
  const auto cell = [](const std::optional<double>& value) { return "," + (value ? csv_number(*value) : ""); };
  return cell(mtf50_in_unit(figures, edge.scale)) + cell(figures.nyquist);
}

/// Figures of ISO 12233, the reasons of the difference with their sizes, and what is left; null without a comparison.
Json comparison_json(const MeasuredEdge& edge) {
  if (!edge.standard) return {};
  const calib::Iso12233Result& standard = edge.standard->result;
  Json json = comparison_figures(figures_of(standard), edge.scale);
  json["reason"] = text_or_null(standard.reason);
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

/// A table of the shifts; "" where there are none.
std::string lateral_shift_table(const MeasureReport& report) {
  TextTable table({"edge", "plane", "from", "normal [deg]", "shift [px]"});
  bool any = false;
  for (std::size_t i = 0; i < report.edges.size(); ++i) {
    const MeasuredEdge& edge = report.edges[i];
    if (!edge.shift) continue;
    any = true;
    table.add({std::to_string(i + 1), one_line(edge.channel), one_line(edge.shift->from),
               fixed(edge.edge.angle_deg.value, 2),
               fixed(edge.shift->px.value, 4) + " +- " + fixed(edge.shift->px.sd, 4)});
  }
  if (!any) return "";
  return "\nLateral colour: shift of the edge along its normal from the same edge in another plane\n" +
         table.aligned({Align::right, Align::left, Align::left, Align::right, Align::right});
}

/// Columns of CSV: lateral_shift_px, lateral_shift_px_sd, lateral_shift_from; "" where no edge has a shift, and then
/// edges have none of the columns.
std::string lateral_shift_header(const MeasureReport& report) {
  const bool any = std::any_of(report.edges.begin(), report.edges.end(),
                               [](const MeasuredEdge& edge) { return edge.shift.has_value(); });
  return any ? ",lateral_shift_px,lateral_shift_px_sd,lateral_shift_from" : "";
}

std::string lateral_shift_columns(const MeasuredEdge& edge) {
  if (!edge.shift) return ",,,";
  return "," + csv_number(edge.shift->px.value) + "," + csv_number(edge.shift->px.sd) + "," +
         csv_field(edge.shift->from);
}

/// "0.3021 +- 0.0017", as many digits as the deviation has.
std::string shown(const std::optional<Estimate>& estimate) {
  if (!estimate) return "-";
  if (!(estimate->sd > 0.0)) return fixed(estimate->value, 4);
  const int digits = std::clamp(1 - static_cast<int>(std::floor(std::log10(estimate->sd))), 2, 12);
  return fixed(estimate->value, digits) + " +- " + fixed(estimate->sd, digits);
}

std::string label_of(const MeasuredEdge& edge) {
  std::string text = one_line(edge.image);
  if (!edge.channel.empty()) text += " " + one_line(edge.channel);
  if (!edge.name.empty()) text += " " + one_line(edge.name);
  return text;
}

std::string region_text(const calib::Roi& roi) {
  return std::to_string(roi.x) + "," + std::to_string(roi.y) + "," + std::to_string(roi.width) + "," +
         std::to_string(roi.height);
}

Json as_json(const std::optional<Estimate>& estimate) {
  if (!estimate) return {};
  return {{"value", estimate->value}, {"sd", estimate->sd}};
}

/// Why values are missing: the failure of the edge, or the reason of each missing figure.
std::string reason_of(const EdgeMeasurement& edge) {
  std::string reason = edge.reason;
  for (const auto& [name, why] : edge.absent) reason += (reason.empty() ? "" : "; ") + name + ": " + why;
  return reason;
}

Json geometry(const EdgeMeasurement& edge) {
  static constexpr std::array kShapes{"line", "polynomial", "circle"};
  return {{"shape", kShapes[static_cast<std::size_t>(edge.curve.shape)]},
          {"order", edge.curve.order()},
          {"origin", {edge.curve.origin.x, edge.curve.origin.y}},
          {"bright_side_deg", edge.curve.angle_rad * 180.0 / std::numbers::pi},
          {"half_length_px", edge.curve.half_length_px},
          {"coefficient_px", edge.curve.coefficient},
          {"curvature_per_px", edge.curve.curvature_per_px}};
}

/// Where the numbers come from: what was undone to make them proportional to light.
Json provenance(const MeasuredEdge& measured) {
  const Linearisation& from = measured.linearisation;
  return {{"encoding", from.encoding},
          {"encoding_source", from.encoding_source},
          {"stated_encoding", text_or_null(from.stated.word)},
          {"stated_by", text_or_null(from.stated.source)},
          {"storage", from.storage},
          {"whole_numbers", from.integer},
          {"full_scale", from.full_scale},
          {"step_at_mid_level", measured.quantum > 0.0 ? Json(measured.quantum) : Json()},
          {"dct_rounding_sd", from.dct_rounding_sd > 0.0 ? Json(from.dct_rounding_sd) : Json()},
          {"floor", from.dark_end},
          {"saturation", from.light_end},
          {"cfa_pattern", text_or_null(from.mosaic)},
          {"mask", text_or_null(from.mask)}};
}

Json as_json(const MeasuredEdge& measured, const std::vector<std::string>& names) {
  const EdgeMeasurement& edge = measured.edge;
  Json json{{"image", measured.image}};
  json["channel"] = text_or_null(measured.channel);
  json["name"] = text_or_null(measured.name);
  json["roi"] = {edge.roi.x, edge.roi.y, edge.roi.width, edge.roi.height};
  json["linearisation"] = provenance(measured);
  json["outcome"] = edge.trouble == calib::Trouble::none ? "measured" : trouble_name(edge.trouble);
  const std::string reason = reason_of(edge);
  json["reason"] = text_or_null(reason);
  json["warnings"] = edge.warnings;
  const bool measured_it = edge.trouble == calib::Trouble::none;
  json["clipped_share"] = edge.clipped_share;
  json["angle_deg"] = measured_it ? Json(edge.angle_deg.value) : Json();
  const std::vector<std::optional<Estimate>> merits = merits_of(measured);
  for (std::size_t i = 0; i < merits.size(); ++i) json[names[i]] = as_json(merits[i]);
  if (measured.standard) json["iso12233"] = comparison_json(measured);
  if (!measured_it) {
    json["mtf"] = Json();
    return json;
  }
  if (measured.shift)
    json["lateral_shift"] = {
        {"from", measured.shift->from}, {"value", measured.shift->px.value}, {"sd", measured.shift->px.sd}};
  json["angle_sd_deg"] = edge.angle_deg.sd;
  json["edge"] = geometry(edge);
  json["position_px"] = {edge.curve.origin.x, edge.curve.origin.y};
  json["field"] = {{"x_px", measured.place.x_px},
                   {"y_px", measured.place.y_px},
                   {"radius_px", measured.place.radius_px},
                   {"direction", text_or_null(measured.place.direction)}};
  json["length_px"] = edge.length_px;
  json["sagitta_px"] = edge.sagitta_px;
  json["dark"] = edge.dark;
  json["bright"] = edge.bright;
  json["noise_sd"] = edge.noise_sd;
  json["noise_gain"] = edge.noise_gain;
  json["cnr"] = edge.cnr;
  json["oversampling"] = edge.oversampling;
  json["chi2_per_dof"] = edge.chi2_per_dof;
  json["missing_pixels"] = edge.missing;
  json["mtf"] = {
      {"frequency", in_unit(edge.frequency_cy_px, measured.scale)}, {"value", edge.mtf}, {"sd", edge.mtf_sd}};
  json["otf"] = {{"re", edge.otf_re}, {"im", edge.otf_im}};
  json["esf"] = {{"distance_px", edge.distance_px}, {"value", edge.esf}, {"sd", edge.esf_sd}};
  json["lsf"] = {{"distance_px", edge.distance_px}, {"value", edge.lsf}};
  return json;
}

}  // namespace

/// Few enough digits for 0.29 to be 29.
std::string percent_text(double contrast) { return significant(100.0 * contrast, 12); }

std::optional<Estimate> at_contrast(const MeasuredEdge& edge, double contrast, std::span<const double> further) {
  const std::vector<std::string> names = merit_names(further);
  const auto name = std::find(names.begin(), names.end(), merit_name(contrast));
  if (name == names.end()) return std::nullopt;
  return merits_of(edge)[static_cast<std::size_t>(name - names.begin())];
}

std::optional<Estimate> in_unit(const std::optional<Estimate>& cy_px, const FrequencyScale& scale) {
  if (!cy_px) return std::nullopt;
  return Estimate{cy_px->value * scale.per_cy_px, cy_px->sd * scale.per_cy_px};
}

std::vector<double> in_unit(std::vector<double> cy_px, const FrequencyScale& scale) {
  for (double& frequency : cy_px) frequency *= scale.per_cy_px;
  return cy_px;
}

void add_contrasts(MeasuredEdge& edge, std::span<const double> contrasts) {
  const std::vector<double>& frequencies = edge.edge.frequency_cy_px;
  for (const double contrast : contrasts) {
    edge.at_contrasts.push_back(calib::frequency_at(edge.edge, contrast));
    if (edge.at_contrasts.back() || frequencies.empty()) continue;
    edge.edge.absent.emplace_back(merit_name(contrast), "the MTF stays above " + percent_text(contrast) + " % up to " +
                                                            significant(frequencies.back() * edge.scale.per_cy_px, 4) +
                                                            " " + std::string(unit_name(edge.scale.unit)));
  }
}

std::vector<double> without_repetitions(const std::vector<double>& asked) { return unknown_of(asked, {}); }

std::vector<double> further_contrasts(const std::vector<double>& asked) { return unknown_of(asked, merit_names({})); }

FieldPlace field_place(const EdgeMeasurement& edge, std::int64_t width, std::int64_t height) {
  FieldPlace place{edge.curve.origin.x - 0.5 * static_cast<double>(width),
                   edge.curve.origin.y - 0.5 * static_cast<double>(height),
                   0.0,
                   width,
                   height,
                   ""};
  place.radius_px = std::hypot(place.x_px, place.y_px);
  if (!(place.radius_px > 0.0)) return place;
  const calib::Point normal = edge.curve.normal();
  const double along = std::abs(normal.x * place.x_px + normal.y * place.y_px) / place.radius_px;
  if (along > std::sqrt(0.75)) place.direction = "tangential";
  if (along < 0.5) place.direction = "sagittal";
  return place;
}

std::string measure_table(const MeasureReport& report) {
  const bool pixels = report.unit == FrequencyUnit::cy_px;
  const std::string unit = " [" + std::string(unit_symbol(report.unit)) + "]";
  std::vector<std::string> header{"edge", "region", "normal [deg]", "MTF50" + unit};
  for (const double contrast : report.contrasts) header.push_back("MTF" + percent_text(contrast) + unit);
  for (const char* heading : {"MTF at Nyquist", "FWHM [px]", "RER", "CNR", "length"}) header.emplace_back(heading);
  TextTable table(std::move(header));
  std::string notes;
  bool any = false;
  for (std::size_t i = 0; i < report.edges.size(); ++i) {
    const MeasuredEdge& measured = report.edges[i];
    const EdgeMeasurement& edge = measured.edge;
    const std::string number = std::to_string(i + 1);
    if (edge.trouble != calib::Trouble::none) {
      notes += number + "  " + label_of(measured) + " " + region_text(edge.roi) + ": " +
               std::string(trouble_name(edge.trouble)) + ": " + edge.reason + "\n";
      continue;
    }
    any = true;
    std::vector<std::string> row{number, region_text(edge.roi), fixed(edge.angle_deg.value, 2),
                                 shown(in_unit(edge.mtf50, measured.scale))};
    for (const double contrast : report.contrasts)
      row.push_back(shown(at_contrast(measured, contrast, report.further)));
    for (const auto& merit : {edge.nyquist, edge.fwhm_px, edge.rer}) row.push_back(shown(merit));
    row.push_back(std::isfinite(edge.cnr) ? significant(edge.cnr, 3) : "-");
    row.push_back(std::isfinite(edge.length_px) ? fixed(edge.length_px, 0) : "-");
    table.add(std::move(row));
    for (const auto& [name, why] : edge.absent) notes += number + "  " + name + ": " + why + "\n";
    for (const std::string& warning : edge.warnings) notes += number + "  " + warning + "\n";
  }
  std::string text;
  for (std::size_t i = 0; i < report.edges.size();) {
    std::size_t last = i;
    while (last + 1 < report.edges.size() && label_of(report.edges[last + 1]) == label_of(report.edges[i])) ++last;
    text += (last == i ? "edge " : "edges ") + std::to_string(i + 1) +
            (last == i ? "" : "-" + std::to_string(last + 1)) + ": " + label_of(report.edges[i]) + "\n";
    i = last + 1;
  }
  if (any) text += "\n" + table.aligned({Align::right, Align::left, Align::right});
  if (any)
    text += "\nMTF and frequencies along the normal of the edge, in " +
            (pixels ? "cycles per pixel" : std::string(unit_name(report.unit))) + "; " +
            (report.method == "iso12233" ? "" : "+- is one standard deviation; ") + "method " +
            (report.method == "both" ? "regression" : report.method) + "\n" + comparison_table(report) +
            lateral_shift_table(report);
  for (const FailedImage& failed : report.failed) {
    const bool named = failed.reason.find(one_line(failed.image)) != std::string::npos;
    notes += (named ? "" : one_line(failed.image) + ": ") + failed.reason + "\n";
  }
  return text + (notes.empty() ? "" : (text.empty() ? "" : "\n") + notes);
}

std::string measure_csv(const MeasureReport& report) {
  const std::string shift_header = lateral_shift_header(report);
  std::string text = "edge,image,channel,name,x,y,width,height,outcome,angle_deg";
  for (const std::string& name : merit_names(report.further)) text += "," + name + "," + name + "_sd";
  text +=
      ",cnr,length_px,sagitta_px,order,oversampling,chi2_per_dof,missing_pixels,field_x_px,field_y_px,field_radius_px,"
      "direction,encoding,reason,warnings,frequency_unit" +
      comparison_header(report) + shift_header + "\n";
  std::size_t number = 0;
  for (const MeasuredEdge& measured : report.edges) {
    const EdgeMeasurement& edge = measured.edge;
    const bool measured_it = edge.trouble == calib::Trouble::none;
    text += std::to_string(++number) + "," + csv_field(measured.image) + "," + csv_field(measured.channel) + "," +
            csv_field(measured.name) + "," + region_text(edge.roi) + "," +
            (measured_it ? "measured" : std::string(trouble_name(edge.trouble))) + "," +
            (measured_it ? csv_number(edge.angle_deg.value) : "");
    for (const std::optional<Estimate>& merit : merits_of(measured))
      text += "," + (merit ? csv_number(merit->value) + "," + csv_number(merit->sd) : std::string(","));
    if (measured_it)
      for (const double value : {edge.cnr, edge.length_px, edge.sagitta_px, static_cast<double>(edge.curve.order()),
                                 edge.oversampling, edge.chi2_per_dof, static_cast<double>(edge.missing),
                                 measured.place.x_px, measured.place.y_px, measured.place.radius_px})
        text += "," + csv_number(value);
    else
      text += ",,,,,,,,,,";
    text += "," + measured.place.direction + "," + csv_field(measured.linearisation.encoding) + "," +
            csv_field(reason_of(edge)) + "," + csv_field(joined(edge.warnings, "; ")) + "," +
            std::string(unit_symbol(report.unit)) + comparison_columns(measured) +
            (shift_header.empty() ? "" : lateral_shift_columns(measured)) + "\n";
  }
  return text;
}

std::string measure_json(const MeasureReport& report) {
  Json json{
      {"version", mtf::version}, {"method", report.method}, {"unit", unit_name(report.unit)}, {"edges", Json::array()}};
  const std::vector<std::string> names = merit_names(report.further);
  for (const MeasuredEdge& edge : report.edges) json["edges"].push_back(as_json(edge, names));
  json["left_out"] = Json::array();
  for (const LeftOutEdges& left : report.left_out)
    json["left_out"].push_back({{"image", left.image},
                                {"channel", text_or_null(left.channel)},
                                {"usable", left.usable},
                                {"not_tried", left.not_tried}});
  json["failed"] = Json::array();
  for (const FailedImage& failed : report.failed)
    json["failed"].push_back({{"image", failed.image}, {"reason", failed.reason}});
  return json_document(json, -1);
}

std::string curves_csv(const MeasureReport& report) {
  const bool pixels = report.unit == FrequencyUnit::cy_px;
  std::string text = pixels ? "edge,curve,x,value,sd\n" : "edge,curve,x,value,sd,x_unit\n";
  for (std::size_t i = 0; i < report.edges.size(); ++i) {
    const EdgeMeasurement& edge = report.edges[i].edge;
    const auto add = [&](const char* curve, const std::vector<double>& x, std::string_view x_unit,
                         const std::vector<double>& value, const std::vector<double>& sd) {
      const std::string end = pixels ? "\n" : "," + std::string(x_unit) + "\n";
      for (std::size_t k = 0; k < value.size(); ++k)
        text += std::to_string(i + 1) + "," + curve + "," + csv_number(x[k]) + "," + csv_number(value[k]) + "," +
                (k < sd.size() ? csv_number(sd[k]) : "") + end;
    };
    const std::vector<double> frequency = in_unit(edge.frequency_cy_px, report.edges[i].scale);
    const std::string_view unit = unit_symbol(report.unit);
    add("mtf", frequency, unit, edge.mtf, edge.mtf_sd);
    add("otf_re", frequency, unit, edge.otf_re, {});
    add("otf_im", frequency, unit, edge.otf_im, {});
    add("esf", edge.distance_px, "px", edge.esf, edge.esf_sd);
    add("lsf", edge.distance_px, "px", edge.lsf, {});
  }
  return text;
}

}  // namespace apps
