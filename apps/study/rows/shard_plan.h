// SPDX-License-Identifier: Apache-2.0
#pragma once

// A sweep cut into shards that any machines make in any order. The folder PLAN holds copies of the study and of every
// file it names, plan.json (what the shards belong to, and the hash of each copy), and in shards/ the finished
// shards: part-<number>-<hash of what it is a part of>, row files (row_file.h). A shard appears whole or not at all;
// one that is there is not made again.

#include <string>
#include <vector>

#include "apps/study/rows/row_file.h"

namespace study {

/// A copied file, by its name in the folder.
struct PlanFile {
  std::string file, sha256;

  bool operator==(const PlanFile&) const = default;
};

struct ShardPlan {
  std::string version, commit;     ///< version and commit of the program that made it
  std::string name, study_sha256;  ///< name of the study, and the hash that Study has
  double tolerance = 0.0;
  std::int64_t designs = 0;
  int shards = 1;  ///< 1 to designs
  RowLayout layout;
  std::vector<PlanFile> files;  ///< the study first

  bool operator==(const ShardPlan&) const = default;
};

inline constexpr int kMostShards = 100'000;

/// Writes plan.json and makes shards/. Throws RuntimeError.
void write_plan(const ShardPlan& plan, const std::filesystem::path& folder);

/// Reads plan.json and holds every copied file against its hash. Throws UsageError when the folder has no plan or a
/// copy has changed, naming it; RuntimeError when something cannot be read.
ShardPlan read_plan(const std::filesystem::path& folder);

/// Designs of shard 1 ... plan.shards: as even as can be.
RowRange shard_range(const ShardPlan& plan, int shard);

/// The path of the shard once it is finished.
std::filesystem::path shard_file(const ShardPlan& plan, const std::filesystem::path& folder, int shard);

/// The folder of its pieces while it is made.
std::filesystem::path parts_folder(const std::filesystem::path& shard_file);

/// Removes what a finished shard was made of: its folder of pieces and the temporaries of processes that were killed.
/// Another process that still makes the same shard fails, and finds it finished. What cannot be removed stays.
void remove_parts(const std::filesystem::path& shard_file);

/// Its pieces when it is finished and its numbers are as written. Throws RuntimeError for a damaged or foreign file.
/// The result is empty when the file is not there.
std::vector<RowPiece> find_shard(const ShardPlan& plan, const std::filesystem::path& folder, int shard);

/// The pieces of all shards in the order of the designs, their numbers as written. Throws RuntimeError with a line for
/// every shard that is missing, damaged or foreign; the folder stays as it is.
std::vector<RowPiece> all_shards(const ShardPlan& plan, const std::filesystem::path& folder);

/// Finished files in shards/ whatever they belong to.
std::vector<std::filesystem::path> files_in_shards(const std::filesystem::path& folder);

// Scripts that run the shards of a plan with a queueing system.

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
