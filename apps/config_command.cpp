// SPDX-License-Identifier: Apache-2.0

// `mtf config init | check | explain`, and how every subcommand reads its sensor file.

#include "apps/config_command.h"
#include "apps/import/config_import.h"
#include "apps/kinds.h"
#include "apps/modules/modules.h"
#include "apps/schema/schemas.h"
#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_place.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/config_tree.h"
#include "mtf/io/csv/curve_csv.h"
#include "radiometry/chain/sensor_settings.h"
#ifdef MTFKIT_HAVE_STUDY
#include "apps/study/study_shape.h"
#include "apps/sweep/sweep_parts.h"
#endif

namespace apps {
namespace {

using FileKind = ConfigOptions::FileKind;

#ifdef MTFKIT_HAVE_STUDY
constexpr auto study_starter = study::starter_study;
constexpr auto study_schema = study_file_schema;
#else
std::string study_starter() { throw mtf::UsageError("studies are not part of this build: they need Ceres and NLopt"); }
std::string study_schema() { return study_starter(); }
#endif

std::string starter_text(FileKind kind) {
  if (kind == FileKind::scene) return scenes_module().starter();
  return kind == FileKind::study ? study_starter() : mtf::io::starter_config();
}

/// What comes after a starter file is written.
std::string next_step(FileKind kind, const std::string& file) {
  if (kind == FileKind::scene)
    return "it names meshes, weather and a schedule, which `mtf scene demo -o FOLDER` writes beside the same file; "
           "next: mtf scene check " +
           file;
  const std::string check = "mtf config check " + file;
  if (kind == FileKind::study)
    return "it varies sensor.toml beside it; next, unless that is there: mtf config init -o sensor.toml; then " + check;
  return "next: " + check;
}

int init(const ConfigOptions& options, const Global& global) {
  if (emit_for_editing(options.file, starter_text(options.kind), options.force))
    note(global, "wrote " + one_line(options.file) + "; " + next_step(options.kind, shell_word(options.file)));
  return 0;
}

std::string summary(const mtf::System<double>& system) {
  std::string text = system.name.empty() ? "" : one_line(system.name) + ", ";
  for (const mtf::Stage stage : mtf::kStages)
    text += (stage == mtf::kStages.front() ? "" : ", ") + std::to_string(system.list(stage).size()) + " " +
            std::string(mtf::stage_name(stage));
  return text + " components";
}

std::string as_json(const Verdict& verdict) {
  Json json{{"file", verdict.file}, {"ok", verdict.ok}, {"name", verdict.name}, {"sha256", verdict.sha256}};
  Json& list = json["diagnostics"] = Json::array();
  for (const auto& d : verdict.diagnostics)
    list.push_back({{"severity", d.error    ? "error"
                                 : d.remark ? "note"
                                            : "warning"},
                    {"line", d.position.line},
                    {"column", d.position.column},
                    {"path", d.path},
                    {"text", d.text}});
  return json_document(json);
}

int explain(const ConfigOptions& options, const Global& global) {
  mtf::io::SensorConfig config = read_sensor(options.file, global);
  config.file = one_line(config.file);
  print(mtf::io::explain_config(config));
  print(explain_chain(config));
  return 0;
}

std::string schema_text(FileKind kind) {
  if (kind == FileKind::scene) return scenes_module().schema();
  return kind == FileKind::study ? study_schema() : sensor_file_schema();
}

/// The verdict and notes on standard output, errors as file:line:col lines on standard error; JSON has both. Returns
/// the exit code, 0 or 2.
int report_verdict(const Verdict& verdict, Format format) {
  const bool json = format == Format::json;
  if (json) print(as_json(verdict));
  if (!json && verdict.ok) print("ok: " + one_line(verdict.file) + ": " + verdict.summary + "\n");
  for (const auto& diagnostic : verdict.diagnostics) {
    const std::string line = one_line(mtf::io::format_diagnostic(diagnostic, verdict.file));
    if (diagnostic.error)
      complain(line);
    else if (!json)
      print(line + "\n");
  }
  return verdict.ok ? 0 : 2;
}

/// `mtf config check` of a sensor file. Returns the exit code. Throws RuntimeError when the file cannot be read.
int check_sensor(const std::string& file, Format format) {
  return report_verdict(sensor_verdict(mtf::io::read_text_file(file, mtf::io::cfg::kMaxBytes), file), format);
}

#ifdef MTFKIT_HAVE_STUDY
std::string summary(const study::Study& study) {
  using study::Method;
  const std::string method = study.method == Method::grid              ? "a grid"
                             : study.method == Method::latin_hypercube ? "a Latin hypercube"
                                                                       : "a Sobol sequence";
  std::string text = study.name.empty() ? "" : one_line(study.name) + ", ";
  text += plural(study.designs, "design") + " (" + method + "), " +
          (study.axes.size() == 1 ? "1 axis" : std::to_string(study.axes.size()) + " axes") + ", " +
          plural(std::ssize(study.metrics), "metric") + ", " + plural(std::ssize(study.constraints), "constraint") +
          ", " + plural(std::ssize(study.objectives), "objective");
  if (study.variants > 1) text += ", " + plural(study.variants, "sensor");
  return text;
}

/// `mtf config check` of a study. Returns the exit code. Throws RuntimeError when the file cannot be read.
int check_study(const std::string& file, Format format) {
  study::StudyResult result = study::parse_study(mtf::io::read_text_file(file, mtf::io::cfg::kMaxBytes), file);
  if (result.ok())  // what only a sweep of it would find
    for (const auto& problems : {copy_problems(result.study), study::listed_gaps(result.study)})
      result.diagnostics.insert(result.diagnostics.end(), problems.begin(), problems.end());
  const int code = report_verdict({.file = file,
                                   .ok = result.ok(),
                                   .name = result.study.name,
                                   .sha256 = result.study.sha256,
                                   .summary = summary(result.study),
                                   .diagnostics = result.diagnostics},
                                  format);
  if (code == 0 && format == Format::table) print("next: mtf sweep " + shell_word(file) + " -o trade\n");
  return code;
}
#else
int check_study(const std::string& file, Format) {
  throw mtf::UsageError(file + ": a study; this command was built without studies (they need Ceres)");
}
#endif

}  // namespace

mtf::io::SensorConfig read_sensor(const std::string& file, const Global& global) {
  std::vector<mtf::io::Diagnostic> warnings;
  mtf::io::SensorConfig config = read_sensor_file(file, &warnings);
  for (const auto& warning : warnings) note(global, one_line(mtf::io::format_diagnostic(warning, file)));
  return config;
}

mtf::io::SensorConfig load_sensor(const std::string& file, const Global& global) {
  mtf::io::SensorConfig config = read_sensor(file, global);
  if (has_chain(config) && config.system.band)
    config.system = at_its_place(config, [&] { return with_electron_rate(config.system, load_chain(config)); });
  return config;
}

std::string explain_chain(const mtf::io::SensorConfig& config) {
  if (!has_chain(config)) return {};
  TextTable on({"stage", "what it does"}), off({"left out", "why"});
  for (const radiometry::ChainStage& stage : chain_stages(config.system, load_chain(config).sensor))
    (stage.on ? on : off).add({stage.name, one_line(stage.what)});
  return "\nchain, in this order\n" + on.aligned() + "\n" + off.aligned();
}

Verdict sensor_verdict(const std::string& text, const std::string& file) {
  mtf::io::ConfigResult result = mtf::io::parse_config(text, file, sensor_schema());
  if (const std::string kind = mtf::io::cfg::another_kind(result.diagnostics, text, "frame"); !kind.empty())
    return {
        .file = file,
        .ok = false,
        .diagnostics = {{.error = true, .position = {}, .path = {}, .text = kind + "; `mtf scene check` reads it"}}};
  if (result.ok()) {
    for (mtf::io::Diagnostic& warning : chain_warnings(result.config)) result.diagnostics.push_back(std::move(warning));
    if (auto problem = chain_problem(result.config)) result.diagnostics.push_back(std::move(*problem));
  }
  return {.file = file,
          .ok = result.ok(),
          .name = result.config.system.name,
          .sha256 = result.config.sha256,
          .summary = summary(result.config.system),
          .diagnostics = result.diagnostics};
}

bool is_study_file(const std::string& file) {
  const auto tree = mtf::io::cfg::read_tree(mtf::io::read_text_file(file, mtf::io::cfg::kMaxBytes));
  return tree.root.find("axis") != nullptr || tree.root.find("sensor") != nullptr;
}

int check_config(const std::string& file, Format format) {
  return is_study_file(file) ? check_study(file, format) : check_sensor(file, format);
}

int run_config(const ConfigOptions& options, const Global& global) {
  switch (options.action) {
    case ConfigOptions::Action::init:
      return init(options, global);
    case ConfigOptions::Action::check:
      return check_config(options.file, options.format);
    case ConfigOptions::Action::explain:
      return explain(options, global);
    case ConfigOptions::Action::kinds:
      print(options.layout == ConfigOptions::Layout::markdown ? kinds_markdown(options.file)
            : options.layout == ConfigOptions::Layout::json   ? kinds_json(options.file)
                                                              : describe_kinds(options.file));
      return 0;
    case ConfigOptions::Action::schema:
      emit(options.file, schema_text(options.kind));
      return 0;
  }
  return 0;
}

}  // namespace apps
