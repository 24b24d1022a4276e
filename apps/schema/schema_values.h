// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of TOML files as JSON Schema (draft-07): a number with its unit is a string of a pattern, a plain number has
// its range. A schema cannot compare "15 um" with a range in mm: that is left to `mtf config check`.

#include "apps/sensor/sensor_kinds.h"
#include "apps/text/json.h"

namespace apps {

/// One number, in a unit of its dimension. `lo`, `hi`: of plain ones.
Json number_schema(const mtf::FieldInfo& parameter);

/// What value_schema() refers to: numbers of each dimension, and such numbers as tables of a fit.
void add_number_definitions(Json& definitions);

/// The parameters into `properties` of a table, and what of them is required: a size also as NAME_x and NAME_y.
void add_parameters(const std::vector<Parameter>& parameters, Json& table);

Json text_schema(std::string_view doc = {});
Json words_schema(std::span<const std::string_view> words);
Json list_schema(Json items);
/// { value = ..., fit = true, min = ..., max = ..., prior = { mean, sd }, stderr = ..., interval = ... } of such a
/// number.
Json fit_schema(std::string_view doc, const Json& number);

/// A table without other keys than those that are added.
Json closed_table(std::string_view doc);

/// The head that names the dialect, the kind of file and its versions, 1 to `newest`.
Json schema_head(std::string_view title, std::string_view doc, int newest = 1);

}  // namespace apps
