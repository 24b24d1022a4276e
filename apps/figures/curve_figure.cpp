// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/curve_figure.h"

#include <algorithm>

#include "apps/terminal/text_table.h"

namespace apps {
namespace {

/// A study's mtf_nyquist is the geometric mean of both axes, so a value along one direction says which.
std::string direction_words(const Direction& direction) {
  if (direction.angle_deg == 0.0) return "along x";
  if (direction.angle_deg == 90.0) return "along y";
  return "at " + significant(direction.angle_deg, 6) + " deg";
}

/// The head of a line of the footer, as wide as the longest.
std::string head(const std::string& name, const Direction& direction) {
  const std::size_t width = ("MTF at Nyquist " + direction_words(direction)).size() + 2;
  return name + std::string(width - name.size(), ' ');
}

std::string budget(const mtf::System<double>& system, const OtfCurves& curves) {
  const OtfCurves at = otf_curves(system, {curves.figures.nyquist}, curves.direction);
  std::string text = head("MTF at Nyquist " + direction_words(curves.direction), curves.direction);
  for (const OtfColumn& component : at.components)
    text += (&component == at.components.data() ? "" : " x ") + one_line(component.label) + " " +
            fixed(modulus(component.otf.front()), 4);
  text += (at.components.empty() ? "" : " = ") + fixed(modulus(at.system.otf.front()), 4) + "\n";
  const mtf::Context<double> middle = system.context();
  const auto& list = system.list(mtf::Stage::presample);
  const auto chromatic = std::count_if(list.begin(), list.end(),
                                       [&](const auto& entry) { return entry.component.traits(middle).chromatic; });
  if (system.band && chromatic > 1)
    text += "(factors that depend on wavelength are averaged as a product: it is not the product of their averages)\n";
  return text;
}

void add_parts(Json& json, const OtfColumn& column) {
  // + 0.0 makes 0 of the negative zero, which would be printed as -0.
  Json& re = json["re"] = Json::array();
  for (const auto& h : column.otf) re.push_back(h.re + 0.0);
  Json& im = json["im"] = Json::array();
  for (const auto& h : column.otf) im.push_back(h.im + 0.0);
  if (column.has_coarse_average()) json["error"] = column.error;
}

}  // namespace

std::string curve_footer(const mtf::System<double>& system, const OtfCurves& curves) {
  const KeyFigures& figures = curves.figures;
  const std::string& unit = curves.direction.unit;
  const Direction& direction = curves.direction;
  std::string text;
  if (curves.field)
    text = "at the field point (" + significant(curves.field->x, 4) + ", " + significant(curves.field->y, 4) +
           ") half diagonals of the detector from the optical axis\n";
  text += head("cutoff", direction);
  text += figures.cutoff ? significant(*figures.cutoff, 4, true) + " " + unit : "none: no component ends the response";
  if (figures.cutoff && system.band) text += " (at " + significant(system.band->lo_um, 4) + " um)";
  text += "\n" + head("Nyquist", direction) + significant(figures.nyquist, 4, true) + " " + unit + "\n";
  if (figures.q) {
    text += head("Q", direction) + significant(*figures.q, 4, true) + " (lambda N / pitch";
    if (system.band) text += " at " + significant(0.5 * (system.band->lo_um + system.band->hi_um), 4) + " um";
    text += ")\n";
  }
  return text + budget(system, curves);
}

Figure curve_figure(const OtfCurves& curves) {
  const KeyFigures& figures = curves.figures;
  Figure figure;
  figure.title = curves.name.empty() ? "MTF" : curves.name;
  figure.x_label = "spatial frequency [" + curves.direction.unit + "]";
  if (curves.direction.angle_deg != 0.0) figure.x_label += " at " + significant(curves.direction.angle_deg, 6) + " deg";
  if (curves.field)
    figure.x_label +=
        " at field point (" + significant(curves.field->x, 4) + ", " + significant(curves.field->y, 4) + ")";
  figure.y_label = "MTF = |OTF|";
  double highest = 1.0;
  for (const OtfColumn* column : curves.columns()) {
    // The product of a single component, and that of the only list, would hide another line.
    const auto in_list = std::count_if(curves.components.begin(), curves.components.end(),
                                       [&](const OtfColumn& c) { return c.stage == column->stage; });
    const bool product = column->kind.empty() && column != &curves.system;
    if (product && (in_list < 2 || in_list == std::ssize(curves.components))) continue;
    Series series{column->label, curves.frequency, {}, column == &curves.system};
    for (const auto& h : column->otf) series.y.push_back(modulus(h));
    highest = std::max(highest, *std::max_element(series.y.begin(), series.y.end()));
    figure.series.push_back(std::move(series));
  }
  figure.vertical_lines.push_back({figures.nyquist, "Nyquist " + significant(figures.nyquist, 4)});
  if (figures.cutoff) figure.vertical_lines.push_back({*figures.cutoff, "cutoff " + significant(*figures.cutoff, 4)});
  figure.y_low = 0.0;
  figure.y_high = 1.05 * highest;
  return figure;
}

Json curves_json(const OtfCurves& curves) {
  const KeyFigures& figures = curves.figures;
  Json json;
  json["name"] = curves.name;
  json["unit"] = curves.direction.unit;
  json["angle_deg"] = curves.direction.angle_deg;
  json["nyquist"] = figures.nyquist;
  json["cutoff"] = figures.cutoff;
  json["q"] = figures.q;
  if (curves.field) json["field"] = {curves.field->x, curves.field->y};
  json["frequency"] = curves.frequency;
  json["components"] = Json::array();
  for (const OtfColumn& column : curves.components) {
    Json component{{"label", column.label}, {"kind", column.kind}, {"stage", column.stage}, {"doc", column.doc}};
    add_parts(component, column);
    json["components"].push_back(std::move(component));
  }
  for (const OtfColumn& column : curves.stages) add_parts(json[column.label] = Json::object(), column);
  add_parts(json["system"] = Json::object(), curves.system);
  return json;
}

}  // namespace apps
