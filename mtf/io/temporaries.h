// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names of the temporaries that output files are written under, and what becomes of those that killed processes left.

#include <string>

namespace mtf::io {

/// "folder/name.tmp." for "folder/name"; the process id follows, and "." with a number where it has several.
std::string temporary_stem(const std::string& target);

/// Locks a temporary that this process has just created, for as long as the descriptor is open: who holds the lock
/// lives. False when another process took the file for a dead one's and removed it meanwhile.
bool claim_temporary(int descriptor) noexcept;

/// Removes the temporaries of `target` that killed processes left: no process of that id runs on this machine, nobody
/// holds the lock, and, where other machines may write into the folder too and locks may not be seen there, the file is
/// untouched for a day. A process searches a folder once. A file that cannot be read or removed stays.
void remove_dead_temporaries(const std::string& target);

}  // namespace mtf::io
