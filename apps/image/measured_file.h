// SPDX-License-Identifier: Apache-2.0
#pragma once

// The run times that --rigor measure has measured, kept per host: in the file of --wisdom, else under
// $XDG_CACHE_HOME/mtfkit (or ~/.cache/mtfkit) by the name of the processor.

#include <string>

#include "apps/options.h"

namespace apps {

/// Reads it where measuring is asked for or a file is named. A named file that is missing will be made; one that holds
/// something else is a UsageError; a cache that cannot be read is started over, with a note.
void read_measured(const SimulateCommandOptions& options, const Global& global);

/// Writes it back. A named file that cannot be written is a RuntimeError, the cache a note.
void write_measured(const SimulateCommandOptions& options, const Global& global);

}  // namespace apps
