// SPDX-License-Identifier: Apache-2.0
#include "apps/schema/schema_values.h"

#include <array>
#include <cctype>
#include <cmath>

#include "mtf/components/component_docs.h"
#include "mtf/field_terms.h"

namespace apps {
namespace {

using mtf::FieldInfo;

/// A regular expression for one of the units; "um" is read with the micro sign as well.
std::string unit_pattern(mtf::Dimension dimension) {
  std::string pattern;
  for (const std::string_view unit : mtf::units_of(dimension)) {
    pattern += pattern.empty() ? "" : "|";
    for (std::size_t i = 0; i < unit.size(); ++i) {
      if (i == 0 && unit.size() > 1 && unit[0] == 'u') {
        pattern += "[u\u00b5\u03bc]";
        continue;
      }
      if (unit[i] == '^' || unit[i] == '.') pattern += '\\';
      pattern += unit[i];
    }
  }
  return pattern;
}

void add_range(const FieldInfo& parameter, Json& schema) {
  if (!has_range(parameter)) return;
  if (std::isfinite(parameter.lo)) schema[parameter.lo_open ? "exclusiveMinimum" : "minimum"] = parameter.lo;
  if (std::isfinite(parameter.hi)) schema[parameter.hi_open ? "exclusiveMaximum" : "maximum"] = parameter.hi;
}

/// Of the definition of numbers of that dimension.
std::string dimension_name(mtf::Dimension dimension) {
  if (dimension == mtf::Dimension::none) return "number";
  const auto units = mtf::units_of(dimension);
  std::string name = "in_" + std::string(units.front()) + "_to_" + std::string(units.back());
  for (char& letter : name)  // a pointer into a schema has no room for others
    if (std::isalnum(static_cast<unsigned char>(letter)) == 0) letter = '_';
  return name;
}

Json reference(const std::string& name) { return {{"$ref", "#/definitions/" + name}}; }

/// A number, or a table that lets it be fitted, which has no range of its own.
Json fittable(const FieldInfo& parameter) {
  const std::string name = dimension_name(parameter.dimension);
  const Json number = parameter.dimension == mtf::Dimension::none ? number_schema(parameter) : reference(name);
  Json either{{"anyOf", {number, reference("fit_" + name), reference("field_" + name)}}};
  if (!parameter.words.empty()) either["anyOf"].push_back(words_schema(parameter.words));
  return either;
}

Json bare_value(const FieldInfo& parameter) {
  using Type = mtf::FieldType;
  switch (parameter.type) {
    case Type::number:
    case Type::size:
    case Type::frequency:
      return fittable(parameter);
    case Type::whole: {
      Json whole{{"type", "integer"}};
      add_range(parameter, whole);
      return whole;
    }
    case Type::flag:
      return {{"type", "boolean"}};
    case Type::word:
      return words_schema(parameter.words);
    case Type::numbers:
      return list_schema(fittable(parameter));
    case Type::rows:
      return list_schema(list_schema({{"type", "number"}}));
    case Type::text:
    case Type::date:
    case Type::file:
      return text_schema();
    case Type::number_or_file: {
      Json either = fittable(parameter);
      either["anyOf"].push_back(text_schema());
      return either;
    }
    case Type::pair: {
      Json pair = list_schema(number_schema(parameter));
      if (parameter.dimension == mtf::Dimension::none) pair["items"]["type"] = "integer";
      pair["minItems"] = pair["maxItems"] = 2;
      return pair;
    }
  }
  return Json::object();
}

/// What stands after `name =`, with its documentation.
Json value_schema(const mtf::FieldInfo& parameter) {
  Json schema = bare_value(parameter);
  std::string doc(parameter.doc);
  if (parameter.dimension != mtf::Dimension::none && has_range(parameter)) {
    doc += std::string(doc.empty() ? "" : "; ") + (parameter.lo_open ? "above " : "from ") +
           mtf::format_double(parameter.lo);
    if (std::isfinite(parameter.hi))
      doc += (parameter.hi_open ? " to below " : " to ") + mtf::format_double(parameter.hi);
    if (!parameter.unit.empty()) doc += " " + std::string(parameter.unit);
  }
  if (!parameter.example.empty()) doc += (doc.empty() ? "such as " : ", such as ") + std::string(parameter.example);
  if (!doc.empty()) schema["description"] = doc;
  return schema;
}

}  // namespace

Json number_schema(const mtf::FieldInfo& parameter) {
  if (parameter.dimension == mtf::Dimension::none) {
    Json number{{"type", "number"}};
    add_range(parameter, number);
    return number;
  }
  return {{"type", "string"},
          {"pattern", "^[ \\t]*\\+?-?([0-9]+\\.?[0-9]*|\\.[0-9]+)([eE][+-]?[0-9]+)?[ \\t]*(" +
                          unit_pattern(parameter.dimension) + ")[ \\t]*$"}};
}

void add_parameters(const std::vector<Parameter>& parameters, Json& table) {
  Json& properties = table["properties"];
  Json either = Json::array();
  for (const Parameter& parameter : parameters) {
    const std::string name(parameter.name);
    properties[name] = value_schema(parameter);
    const bool needed = parameter.presence == mtf::Presence::required;
    if (parameter.type == mtf::FieldType::size) {
      for (const char* axis : {"_x", "_y"}) properties[name + axis] = value_schema(parameter);
      if (needed) either.push_back({{"oneOf", {{{"required", {name}}}, {{"required", {name + "_x", name + "_y"}}}}}});
    } else if (needed) {
      table["required"].push_back(name);
    }
  }
  if (!either.empty()) table["allOf"] = std::move(either);
}

void add_number_definitions(Json& definitions) {
  for (int i = 0; i <= static_cast<int>(mtf::Dimension::rain_rate); ++i) {
    const auto dimension = static_cast<mtf::Dimension>(i);
    const Json number = number_schema({.name = {}, .dimension = dimension});
    definitions[dimension_name(dimension)] = number;
    definitions["fit_" + dimension_name(dimension)] = fit_schema("a number that mtf fit may change", number);
    const Json term{{"anyOf", {number, reference("fit_" + dimension_name(dimension))}}};
    Json terms = closed_table("a number of a presample component that changes over the field: 1 on the optical axis");
    terms["properties"]["1"] = term;
    terms["properties"]["table"] = text_schema("CSV file with the number over the field");
    for (const std::string_view name : mtf::kFieldTerms) terms["properties"][std::string(name)] = term;
    Json& field = definitions["field_" + dimension_name(dimension)] = std::move(terms);
    if (dimension == mtf::Dimension::angle)
      field = {{"anyOf", {field, words_schema(std::array<std::string_view, 1>{"field"})}}};
  }
}

Json text_schema(std::string_view doc) {
  Json schema{{"type", "string"}, {"minLength", 1}};
  if (!doc.empty()) schema["description"] = std::string(doc);
  return schema;
}

Json words_schema(std::span<const std::string_view> words) { return {{"enum", words}}; }

Json list_schema(Json items) { return {{"type", "array"}, {"items", std::move(items)}}; }

Json fit_schema(std::string_view doc, const Json& number) {
  Json table = closed_table(doc);
  for (const char* key : {"value", "min", "max", "stderr"}) table["properties"][key] = number;
  table["properties"]["fit"] = {{"type", "boolean"}};
  Json& interval = table["properties"]["interval"] = list_schema(number);
  interval["minItems"] = interval["maxItems"] = 2;
  Json prior = closed_table("what is known beforehand");
  prior["properties"] = {{"mean", number}, {"sd", number}};
  prior["required"] = {"mean", "sd"};
  table["properties"]["prior"] = std::move(prior);
  table["required"] = {"value"};
  return table;
}

Json closed_table(std::string_view doc) {
  Json table{{"type", "object"}};
  if (!doc.empty()) table["description"] = std::string(doc);
  table["additionalProperties"] = false;
  table["properties"] = Json::object();
  table["required"] = Json::array();
  return table;
}

Json schema_head(std::string_view title, std::string_view doc, int newest) {
  Json head{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", std::string(title)}};
  head.update(closed_table(doc));
  head["properties"]["schema"] = {{"description", "version of the file"}};
  for (int version = 1; version <= newest; ++version) head["properties"]["schema"]["enum"].push_back(version);
  head["required"] = {"schema"};
  return head;
}

}  // namespace apps
