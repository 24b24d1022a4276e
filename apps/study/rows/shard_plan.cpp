// SPDX-License-Identifier: Apache-2.0
#include "apps/study/rows/shard_plan.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>

#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/sha256.h"
#include "mtf/io/temporaries.h"

namespace study {
namespace {

using apps::Json;
namespace fs = std::filesystem;

constexpr std::size_t kShownHash = 12;  // digits of a hash in a file's name
constexpr int kNamedShards = 20;        // that a message names one by one

fs::path plan_file(const fs::path& folder) { return folder / "plan.json"; }
fs::path shards_folder(const fs::path& folder) { return folder / "shards"; }

Json read_json(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_regular_file(plan_file(folder), error))
    throw mtf::UsageError(shown(folder) + ": holds no plan.json; make a plan with `mtf sweep plan STUDY -o " +
                          shown(folder) + " --shards N`");
  std::ifstream in(plan_file(folder), std::ios::binary);
  return apps::parsed_json(std::string{std::istreambuf_iterator<char>(in), {}}).value_or(Json());
}

void check_copies(const ShardPlan& plan, const fs::path& folder) {
  std::string changed;
  for (const PlanFile& copy : plan.files)
    if (mtf::io::sha256_file((folder / copy.file).string()) != copy.sha256)
      changed += (changed.empty() ? "" : ", ") + shown(folder / copy.file);
  if (!changed.empty())
    throw mtf::UsageError(changed +
                          ": changed since the plan was made, so its shards would not belong together; put the file "
                          "back as it was, or make a new plan in another folder");
}

/// "shard 2", "shards 2, 5 and 7".
std::string shard_words(const std::vector<int>& shards) {
  std::string text = shards.size() == 1 ? "shard " : "shards ";
  const std::size_t named = std::min<std::size_t>(shards.size(), kNamedShards);
  for (std::size_t i = 0; i < named; ++i)
    text += (i == 0 ? "" : i + 1 == shards.size() ? " and " : ", ") + std::to_string(shards[i]);
  return named < shards.size() ? text + " and " + std::to_string(shards.size() - named) + " more" : text;
}

std::string run_command(const ShardPlan& plan, const fs::path& folder, int shard) {
  return "`mtf sweep run " + shown(folder) + " --shard " + std::to_string(shard) + "/" + std::to_string(plan.shards) +
         "`";
}

/// The pieces of a finished shard. Throws RuntimeError.
std::vector<RowPiece> pieces_of(const ShardPlan& plan, const fs::path& file, int shard) {
  return in_order(list_rows(file), plan.layout, shard_range(plan, shard));
}

/// Always in quotes: a script is read by people, but a name may hold anything.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// A word without what a #SBATCH line cannot hold.
std::string job_name(const std::string& name) {
  std::string text = "mtf-";
  for (const char c : name.substr(0, 40)) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (plain || text.back() != '-') text += plain ? c : '-';
  }
  while (text.back() == '-') text.pop_back();
  return text;
}

std::string slurm(const SubmitJob& job) {
  const std::string threads = job.threads > 0 ? std::to_string(job.threads) : "1";
  // --requeue: a shard whose node dies is queued again; what it had finished is not made twice.
  return "#!/bin/sh\n"
         "#SBATCH --job-name=" +
         job_name(job.name) +
         "\n"
         "#SBATCH --array=1-" +
         std::to_string(job.shards) +
         "\n"
         "#SBATCH --cpus-per-task=" +
         threads +
         "\n"
         "#SBATCH --requeue\n"
         "#SBATCH --open-mode=append\n"
         "#SBATCH --output=slurm-%A_%a.log\n"
         "exec " +
         quoted(job.command) + " sweep run " + quoted(job.plan) +
         " --threads \"${SLURM_CPUS_PER_TASK:-1}\" --progress none\n";
}

std::string threads_option(const SubmitJob& job) {
  return job.threads > 0 ? " --threads " + std::to_string(job.threads) : "";
}

std::string parallel(const SubmitJob& job) {
  const std::string threads = std::to_string(job.threads);
  const std::string jobs =
      job.threads > 0 ? "\"$(($(nproc) > " + threads + " ? $(nproc) / " + threads + " : 1))\"" : "1";
  // In the environment, because GNU parallel replaces {}, {.}, {/} and more wherever they stand in its command.
  return "#!/bin/sh\n"
         "# Again after a failure: finished shards are left out, failed ones run again.\n"
         "MTF=" +
         quoted(job.command) + "\nPLAN=" + quoted(job.plan) +
         "\nPARALLEL_SHELL=/bin/sh\nexport MTF PLAN PARALLEL_SHELL\n"
         "exec parallel --will-cite --jobs " +
         jobs +
         " --joblog \"$PLAN/parallel.log\" --resume-failed \\\n"
         "  '\"$MTF\" sweep run \"$PLAN\" --shard {}/" +
         std::to_string(job.shards) + threads_option(job) + " --progress none' ::: $(seq 1 " +
         std::to_string(job.shards) + ")\n";
}

std::string local(const SubmitJob& job) {
  return "#!/bin/sh\nset -e\nfor shard in $(seq 1 " + std::to_string(job.shards) + "); do\n  " + quoted(job.command) +
         " sweep run " + quoted(job.plan) + " --shard \"$shard/" + std::to_string(job.shards) + "\"" +
         threads_option(job) + " --progress none\ndone\n";
}

}  // namespace

void write_plan(const ShardPlan& plan, const fs::path& folder) {
  Json files = Json::array();
  for (const PlanFile& copy : plan.files) files.push_back({{"file", copy.file}, {"sha256", copy.sha256}});
  const Json json = {{"schema", 1},
                     {"kind", "sweep plan"},
                     {"version", plan.version},
                     {"commit", plan.commit},
                     {"study", {{"name", plan.name}, {"sha256", plan.study_sha256}}},
                     {"tolerance", plan.tolerance},
                     {"designs", plan.designs},
                     {"columns", plan.layout.columns},
                     {"key", plan.layout.key},
                     {"shards", plan.shards},
                     {"files", files}};
  std::error_code error;
  fs::create_directory(shards_folder(folder), error);
  if (error) throw mtf::RuntimeError("cannot create " + shown(shards_folder(folder)) + ": " + error.message());
  mtf::io::write_text_file(plan_file(folder).string(), apps::json_document(json));
}

ShardPlan read_plan(const fs::path& folder) {
  const Json json = read_json(folder);
  ShardPlan plan;
  try {
    if (json.at("schema").get<int>() != 1 || json.at("kind").get<std::string>() != "sweep plan")
      throw mtf::UsageError("");
    plan.version = json.at("version").get<std::string>();
    plan.commit = json.at("commit").get<std::string>();
    plan.name = json.at("study").at("name").get<std::string>();
    plan.study_sha256 = json.at("study").at("sha256").get<std::string>();
    plan.tolerance = json.at("tolerance").get<double>();
    plan.designs = json.at("designs").get<std::int64_t>();
    plan.shards = json.at("shards").get<int>();
    plan.layout = {json.at("key").get<std::string>(), json.at("columns").get<int>()};
    for (const Json& copy : json.at("files").elements())
      plan.files.push_back({copy.at("file").get<std::string>(), copy.at("sha256").get<std::string>()});
    for (const PlanFile& copy : plan.files) {  // nothing outside of the folder
      const fs::path name = fs::path(copy.file).lexically_normal();
      if (name.empty() || name.is_absolute() || *name.begin() == "..") throw mtf::UsageError("");
    }
    if (plan.shards < 1 || plan.shards > plan.designs || plan.shards > kMostShards || plan.layout.columns < 1)
      throw mtf::UsageError("");
  } catch (const std::exception&) {
    throw mtf::UsageError(shown(plan_file(folder)) +
                          ": is not a plan as `mtf sweep plan` writes it; make the plan again in another folder");
  }
  check_copies(plan, folder);
  return plan;
}

RowRange shard_range(const ShardPlan& plan, int shard) {
  const std::int64_t whole = plan.designs / plan.shards, rest = plan.designs % plan.shards, before = shard - 1;
  return {before * whole + std::min(before, rest), whole + (before < rest ? 1 : 0)};
}

fs::path shard_file(const ShardPlan& plan, const fs::path& folder, int shard) {
  const std::string part = plan.layout.key + " " + std::to_string(shard) + "/" + std::to_string(plan.shards);
  return shards_folder(folder) /
         ("part-" + std::to_string(shard) + "-" + mtf::io::sha256_hex(part).substr(0, kShownHash));
}

fs::path parts_folder(const fs::path& shard_file) { return shard_file.string() + ".parts"; }

void remove_parts(const fs::path& shard_file) {
  std::error_code ignored;
  fs::remove_all(parts_folder(shard_file), ignored);
  mtf::io::remove_dead_temporaries(shard_file.string());
}

std::vector<RowPiece> find_shard(const ShardPlan& plan, const fs::path& folder, int shard) {
  const fs::path file = shard_file(plan, folder, shard);
  std::error_code error;
  if (!fs::exists(file, error)) return {};
  std::vector<RowPiece> pieces = pieces_of(plan, file, shard);
  std::vector<double> rows;
  for (const RowPiece& piece : pieces) read_rows(piece, rows);
  return pieces;
}

std::vector<fs::path> files_in_shards(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(shards_folder(folder), error)) {
    const std::string name = entry.path().filename().string();
    // A shard that is being written has its name with .tmp.<process>.
    if (entry.is_regular_file(error) && name.find(".tmp.") == std::string::npos) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<RowPiece> all_shards(const ShardPlan& plan, const fs::path& folder) {
  std::vector<RowPiece> pieces;
  std::vector<int> missing;
  std::set<fs::path> expected;
  std::string problems;
  const auto report = [&](const std::string& text) { problems += (problems.empty() ? "" : "\n") + text; };
  for (int shard = 1; shard <= plan.shards; ++shard) {
    const fs::path file = shard_file(plan, folder, shard);
    expected.insert(file);
    std::error_code error;
    if (!fs::exists(file, error)) {
      missing.push_back(shard);
      continue;
    }
    try {
      for (RowPiece& piece : find_shard(plan, folder, shard)) pieces.push_back(std::move(piece));
    } catch (const DamagedRows& problem) {
      report("shard " + std::to_string(shard) + ": " + problem.what() + ": " + run_command(plan, folder, shard));
    } catch (const mtf::RuntimeError& problem) {
      report("shard " + std::to_string(shard) + ": " + problem.what());
    }
  }
  if (!missing.empty())
    report(shard_words(missing) + " of " + std::to_string(plan.shards) + (missing.size() == 1 ? " is" : " are") +
           " missing; make each with " + run_command(plan, folder, missing[0]));
  for (const fs::path& file : files_in_shards(folder))
    if (!expected.contains(file))
      report(shown(file) + ": foreign: no shard of this plan has that name; move it elsewhere");
  if (!problems.empty()) throw mtf::RuntimeError(problems);
  return in_order(std::move(pieces), plan.layout, {0, plan.designs});
}

std::string submit_script(const SubmitJob& job) {
  return job.engine == Engine::slurm ? slurm(job) : job.engine == Engine::parallel ? parallel(job) : local(job);
}

std::string script_name(Engine engine) {
  return engine == Engine::slurm      ? "submit.slurm.sh"
         : engine == Engine::parallel ? "submit.parallel.sh"
                                      : "submit.local.sh";
}

}  // namespace study
