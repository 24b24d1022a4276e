// SPDX-License-Identifier: Apache-2.0

// `mtf config check` of a study.

#include "apps/sweep/study_file.h"

#include "apps/config_command.h"
#include "apps/terminal/output.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/config/config_tree.h"
#include "mtf/io/csv/curve_csv.h"
#ifdef MTFKIT_HAVE_CALIB
#include "apps/study/study.h"
#include "apps/sweep/sweep_parts.h"
#endif

namespace apps {

bool is_study_file(const std::string& file) {
  const auto tree = mtf::io::cfg::read_tree(mtf::io::read_text_file(file, mtf::io::cfg::kMaxBytes));
  return tree.root.find("axis") != nullptr || tree.root.find("sensor") != nullptr;
}

#ifdef MTFKIT_HAVE_CALIB
namespace {

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

}  // namespace

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

}  // namespace apps
