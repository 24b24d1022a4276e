// SPDX-License-Identifier: Apache-2.0

// `mtf check`: the promised accuracy of all numbers, compared with references on this machine and build.

#include "apps/check/check.h"

#include "apps/options.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

using check::CheckResult;

std::string_view verdict(const CheckResult& result) { return result.passed ? "PASS" : "FAIL"; }

std::string as_table(const std::vector<CheckResult>& results) {
  TextTable table({"component", "case", "values", "worst abs", "worst rel", "", "promise"});
  for (const CheckResult& r : results)
    table.add({r.component, r.name, std::to_string(r.count), significant(r.worst_abs, 2), significant(r.worst_rel, 2),
               std::string(verdict(r)), r.promise});
  std::string text =
      table.aligned({Align::left, Align::left, Align::right, Align::right, Align::right, Align::left, Align::left});
  for (const CheckResult& r : results)
    if (!r.passed) text += "FAIL " + r.component + ", " + r.name + ": " + one_line(r.failure) + "\n";
  return text;
}

std::string as_csv(const std::vector<CheckResult>& results) {
  TextTable table({"component", "case", "values", "worst_abs", "worst_rel", "promise", "result", "failure"});
  for (const CheckResult& r : results)
    table.add({r.component, r.name, std::to_string(r.count), significant(r.worst_abs, 17), significant(r.worst_rel, 17),
               r.promise, std::string(verdict(r)), one_line(r.failure)});
  return table.csv();
}

std::string as_json(const std::vector<CheckResult>& results, std::size_t failed) {
  Json json;
  json["passed"] = failed == 0;
  json["failed"] = failed;
  json["checks"] = Json::array();
  for (const CheckResult& r : results) {
    Json item{{"component", r.component}, {"case", r.name},       {"values", r.count}, {"worst_abs", r.worst_abs},
              {"worst_rel", r.worst_rel}, {"promise", r.promise}, {"passed", r.passed}};
    if (!r.passed) item["failure"] = one_line(r.failure);
    json["checks"].push_back(std::move(item));
  }
  return json_document(json);
}

}  // namespace

int run_check(const CheckOptions& options, const Global& global) {
  const mtf::Stopwatch watch;
  const check::Tables tables = options.reference.empty() ? check::Tables() : check::Tables(options.reference);
  std::vector<CheckResult> results;
  std::size_t failed = 0;
  mtf::DeviceChoice device = device_of(options.device, global);
  device.insisted = true;  // the processor is not to take over
  std::int64_t values = 0;
  for (const check::Check& each : check::all_checks(device)) {
    results.push_back(run(each, tables));
    failed += results.back().passed ? 0U : 1U;
    values += results.back().count;
  }
  const double seconds = watch.seconds();
  const std::string summary =
      (failed == 0 ? "all " + std::to_string(results.size()) + " checks passed"
                   : std::to_string(failed) + " of " + std::to_string(results.size()) + " checks FAILED") +
      ": " + std::to_string(values) + " values in " + fixed(seconds, 1) + " s";
  const bool table = options.format == Format::table;
  emit(options.out, table                           ? as_table(results) + summary + "\n"
                    : options.format == Format::csv ? as_csv(results)
                                                    : as_json(results, failed));
  if (!table || !options.out.empty()) note(global, summary);
  return failed == 0 ? 0 : 3;
}

}  // namespace apps
