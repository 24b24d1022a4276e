// SPDX-License-Identifier: Apache-2.0

// `mtf config kinds --format json`.

#include <array>

#include "apps/kinds.h"
#include "apps/schema/schemas.h"
#include "apps/sensor/sensor_kinds.h"
#include "apps/text/json.h"
#include "mtf/components/component_docs.h"
#ifdef MTFKIT_HAVE_STUDY
#include "apps/study/design/metric_list.h"
#include "apps/study/study_shape.h"
#include "mtf/error.h"
#endif

namespace apps {
namespace {

Json parameter_json(const Parameter& parameter) {
  Json json{{"name", parameter.name},
            {"type", type_name(parameter.type)},
            {"unit", parameter.unit},
            {"units", mtf::units_of(parameter.dimension)}};
  if (has_range(parameter)) {
    json["min"] = parameter.lo;
    json["max"] = parameter.hi;
    json["min_open"] = parameter.lo_open;
    json["max_open"] = parameter.hi_open;
    json["scale"] = wants_log_scale(parameter) ? "log" : "linear";
  }
  if (!parameter.words.empty()) json["words"] = parameter.words;
  json["presence"] = presence_name(parameter.presence);
  if (!parameter.default_value.empty()) json["default"] = parameter.default_value;
  json["example"] = parameter.example;
  json["doc"] = parameter.doc;
  return json;
}

Json component_json(const ComponentKind& kind) {
  Json json{{"kind", kind.kind}, {"doc", kind.doc}, {"notes", kind.notes}, {"source", kind.source}};
  json["lists"] = Json::array();
  for (const mtf::Stage stage : mtf::kStages)
    if (kind.stages.allows(stage)) json["lists"].push_back(std::string(stage_name(stage)));
  json["parameters"] = Json::array(kind.parameters, parameter_json);
  json["example"] = kind.example;
  return json;
}

Json table_json(const TableKind& kind) {
  return {{"name", kind.name},
          {"doc", kind.doc},
          {"condition", kind.condition},
          {"parameters", Json::array(kind.parameters, parameter_json)}};
}

#ifdef MTFKIT_HAVE_STUDY
Json metric_json(const study::MetricInfo& metric) {
  return {{"name", metric.name},
          {"unit", metric.unit},
          {"definition", metric.definition},
          {"source", metric.source},
          {"needs", metric.needs}};
}

/// Of a study file; null for another name.
Json study_json(const std::string& kind) {
  if (kind == "metrics") return {{"metrics", Json::array(study::metric_catalogue(), metric_json)}};
  if (const auto metric = study::find_metric(kind)) return {{"metrics", Json::array(std::array{*metric}, metric_json)}};
  if (kind == "study")
    throw mtf::UsageError(
        "--format json has [conditions] and metrics of a study; all of its keys are in "
        "`mtf config schema study`");
  if (kind != "conditions") return {};
  TableKind table{.name = "conditions", .doc = "what metrics take from outside of the sensor", .parameters = {}};
  for (const mtf::FieldInfo& field : study::condition_fields()) table.parameters.push_back({field});
  return {{"components", Json::array()}, {"tables", {table_json(table)}}};
}
#else
Json study_json(const std::string&) { return {}; }
#endif

}  // namespace

std::string kinds_json(const std::string& kind) {
  require_kind(kind);
  if (const Json of_study = study_json(kind); !of_study.is_null()) return json_document(of_study, 1);
  const SensorKinds kinds = sensor_kinds();
  Json json{{"components", Json::array()}, {"tables", Json::array()}};
  for (const auto* tables : {&kinds.own_tables, &kinds.tables})
    for (const TableKind& table : *tables)
      if (kind.empty() || table.name == kind) json["tables"].push_back(table_json(table));
  if (kind.empty())
    json["components"] = Json::array(kinds.components, component_json);
  else if (json["tables"].empty())
    json["components"].push_back(component_json(component_kind(kind)));
  return json_document(json, 1);
}

}  // namespace apps
