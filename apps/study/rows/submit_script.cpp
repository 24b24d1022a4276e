// SPDX-License-Identifier: Apache-2.0
#include "apps/study/rows/submit_script.h"

namespace study {
namespace {

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

std::string submit_script(const SubmitJob& job) {
  return job.engine == Engine::slurm ? slurm(job) : job.engine == Engine::parallel ? parallel(job) : local(job);
}

std::string script_name(Engine engine) {
  return engine == Engine::slurm      ? "submit.slurm.sh"
         : engine == Engine::parallel ? "submit.parallel.sh"
                                      : "submit.local.sh";
}

}  // namespace study
