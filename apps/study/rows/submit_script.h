// SPDX-License-Identifier: Apache-2.0
#pragma once

// Scripts that run the shards of a plan with a queueing system.

#include <string>

namespace study {

enum class Engine { slurm, parallel, local };

struct SubmitJob {
  Engine engine = Engine::slurm;
  std::string command;  ///< path of `mtf`
  std::string plan;     ///< absolute path of the folder
  std::string name;     ///< name of the study, for the queue's list
  int shards = 1;
  int threads = 0;  ///< threads of one shard; 0 = all that the job has
};

/// The script, for sh: a Slurm job array of `mtf sweep run PLAN` (#SBATCH lines; run by sbatch), a call of GNU parallel
/// with a job log that --resume goes on from, or the shards one after another.
std::string submit_script(const SubmitJob& job);

/// The script's name in the plan: "submit.slurm.sh".
std::string script_name(Engine engine);

}  // namespace study
