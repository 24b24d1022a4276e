// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/options.h"
#include "mtf/io/config/config.h"

namespace apps {

struct StacksFile;

enum class CharacterizeMethod { fit, emva1288 };

struct CharacterizeCommandOptions {
  std::string stacks;              ///< the file that describes them
  std::string nominal;             ///< sensor file, in place of the one that it names
  std::vector<std::string> edges;  ///< images of edges, to which the nominal's fit = true is fitted after the frames
  std::string out;                 ///< folder
  bool check = false;              ///< say what could be determined, from headers alone
  CharacterizeMethod method = CharacterizeMethod::fit;
  bool force = false;
  bool maps = false;  ///< of offset and responsivity, in the folder
  bool allow_misfit = false;
  Format format = Format::table;
};

/// Of `check`, on standard output. Throws as look_at_stacks(), and UsageError, after the output, where a run will.
void check_stacks(const StacksFile& file, const std::optional<mtf::io::SensorConfig>& nominal, Format format,
                  int threads);

int run_characterize(const CharacterizeCommandOptions& options, const Global& global);

}  // namespace apps
