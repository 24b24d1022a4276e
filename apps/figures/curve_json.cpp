// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/curve_json.h"

namespace apps {

namespace {

void add_parts(Json& json, const OtfColumn& column) {
  // + 0.0 makes 0 of the negative zero, which would be printed as -0.
  Json& re = json["re"] = Json::array();
  for (const auto& h : column.otf) re.push_back(h.re + 0.0);
  Json& im = json["im"] = Json::array();
  for (const auto& h : column.otf) im.push_back(h.im + 0.0);
  if (column.has_coarse_average()) json["error"] = column.error;
}

}  // namespace

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
