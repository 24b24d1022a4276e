// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "apps/options.h"

namespace apps {

enum class CharacterizeMethod { fit, emva1288 };

struct CharacterizeCommandOptions {
  std::string stacks;   ///< the file that describes them
  std::string nominal;  ///< sensor file, in place of the one that it names
  std::string out;      ///< folder
  CharacterizeMethod method = CharacterizeMethod::fit;
  bool force = false;
  bool allow_misfit = false;
  Format format = Format::table;
};

int run_characterize(const CharacterizeCommandOptions& options, const Global& global);

}  // namespace apps
