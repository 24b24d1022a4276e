// SPDX-License-Identifier: Apache-2.0
#pragma once

// The keys of a study file, table by table: what the reader knows, what `mtf config kinds study` prints and what
// `mtf config schema study` tells editors.

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/component.h"

namespace study {

using mtf::FieldType;

inline constexpr std::array<std::string_view, 2> kScales{"linear", "log"};
inline constexpr std::array<std::string_view, 3> kMethods{"grid", "latin_hypercube", "sobol"};

inline constexpr mtf::FieldInfo kTolerance =
    mtf::optional_row("tolerance", 1e-12, 0.1, "1e-4",
                      "allowed error of every metric: absolute where it is plain and at most 1, else relative");
inline constexpr mtf::FieldInfo kDraws = mtf::of_type(
    FieldType::whole, mtf::optional_row("draws", 1.0, 1e6, "200", "sensors built of each design, default 200"));

/// Above the first line with brackets.
inline constexpr std::array kHeadKeys{
    mtf::of_type(FieldType::whole, mtf::required_row("schema", 1.0, 1.0, "1", "version of the file")),
    mtf::of_type(FieldType::text, mtf::optional_row("name", "\"aperture against pitch\"", "of the study")),
    mtf::of_type(FieldType::file,
                 mtf::optional_row("sensor", "\"sensor.toml\"",
                                   "sensor file that is varied, relative to the folder of the study; needed unless an "
                                   "axis is over sensor")),
    kTolerance,
    mtf::of_type(FieldType::whole, mtf::optional_row("seed", 0.0, 9007199254740992.0, "1",
                                                     "of samples and of what varies as built, default 0")),
    mtf::optional_row("constraints", "[\"mtf_nyquist > 0.1\"]",
                      "what a design has to keep: expressions with <, <=, > or >= between them"),
    mtf::optional_row("objectives", "[\"maximize mtf50\"]", "what is wanted: maximize or minimize, and an expression")};

inline constexpr std::array kAxisKeys{
    mtf::of_type(FieldType::text,
                 mtf::optional_row(
                     "parameter", "\"frame.pitch\"",
                     "what varies, by the name that mtf config explain has for it; \"sensor\" for the whole file")),
    mtf::of_type(FieldType::text,
                 mtf::optional_row("name", "\"f_number\"",
                                   "in place of parameter: a number of the study's own, for links, constraints and "
                                   "objectives")),
    mtf::optional_row("values", "[\"10 um\", \"15 um\"]", "a list of numbers, words, lists or files"),
    mtf::optional_row("from", "\"5 um\"", "in place of values: a range, of which either end may be the larger"),
    mtf::optional_row("to", "\"15 um\"", "its other end"),
    mtf::of_type(FieldType::whole,
                 mtf::optional_row("count", 1.0, 1e9, "11", "points of a grid along the range; not for samples")),
    mtf::of_type(FieldType::word, mtf::optional_row("scale", "\"log\"", "of the range, default linear"), kScales)};

inline constexpr std::array kSamplingKeys{
    mtf::of_type(FieldType::word,
                 mtf::optional_row("method", "\"sobol\"", "grid (default): all combinations, the last axis fastest"),
                 kMethods),
    mtf::of_type(FieldType::whole, mtf::optional_row("points", 1.0, 1e9, "4096", "needed but for a grid"))};

inline constexpr std::array kAsBuiltKeys{
    mtf::of_type(FieldType::text, mtf::required_row("parameter", "\"optics.obscuration\"",
                                                    "a number that differs from copy to copy of a design")),
    mtf::optional_row("sd", "\"2 %\"", "normal: standard deviation in its unit, or a share of its value"),
    mtf::optional_row("plus_minus", "\"0.1 mm\"", "in place of sd, uniform: half of the width")};

inline constexpr std::array kYieldKeys{kDraws};
inline constexpr std::array kMetricsKeys{
    mtf::optional_row("list", "[\"mtf_nyquist\", \"mtf50\"]",
                      "what is computed beside the metrics of constraints and objectives: mtf config kinds metrics")};

struct StudyTable {
  std::string_view name;
  bool list = false;  ///< [[name]], as many as are wanted
  std::string_view doc;
  std::span<const mtf::FieldInfo> keys{};  ///< none of [links] and [conditions]
};

inline constexpr std::array kStudyTables{
    StudyTable{"axis", true, "what varies, over which values; 1 to 100 of them", kAxisKeys},
    StudyTable{"sampling", false, "which designs", kSamplingKeys},
    StudyTable{"links", false,
               "what follows: PARAMETER = \"EXPRESSION\", such as focal_length = \"f_number * aperture\""},
    StudyTable{"as_built", true, "what differs from copy to copy", kAsBuiltKeys},
    StudyTable{"yield", false, "how many copies of a design", kYieldKeys},
    StudyTable{"metrics", false, "what is computed", kMetricsKeys},
    StudyTable{"conditions", false,
               "target, scene, observer and geometry of metrics that need them: mtf config kinds conditions"}};

/// Keys and tables of the top level.
std::vector<std::string_view> top_keys();

/// [conditions].
std::vector<mtf::FieldInfo> condition_fields();

/// A commented study of the starter file of sensors (`mtf config init study`).
std::string starter_study();

}  // namespace study
