// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names of the temporaries that output files are written under, what becomes of those that killed processes left, and
// the list of those that a signal has to remove.

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

/// Whether `file` is such a temporary, of any target.
bool is_dead_temporary(const std::string& file);

/// Whether the file system is one that several machines may have mounted: their locks can be of one machine each.
bool is_shared(int descriptor) noexcept;

/// A file, or a folder with all in it, that `remove_temporaries` removes, for as long as this lives; of a folder that
/// is new with it, `beside_it` says so, the folder around it too where that is empty then. Of more than 32 at once some
/// are not on the list: they are only removed by who made them.
class ListedTemporary {
 public:
  ListedTemporary(const std::string& name, bool beside_it = false);
  ~ListedTemporary();
  ListedTemporary(const ListedTemporary&) = delete;
  ListedTemporary& operator=(const ListedTemporary&) = delete;

 private:
  int slot_;
};

/// A short piece of work that a stop waits for: the signals of a stop come after it on this thread, a handler on
/// another thread waits a while. A thread that comes later than the stop waits for the end of the process.
class Unstopped {
 public:
  Unstopped();
  ~Unstopped();
  Unstopped(const Unstopped&) = delete;
  Unstopped& operator=(const Unstopped&) = delete;

 private:
  sigset_t before_{};
};

/// Removes every temporary on the list; files that other threads create afterwards wait for the end of the process.
/// Async-signal-safe: meant for the SIGINT handler of a command, right before it ends the process.
void remove_temporaries() noexcept;

/// Removes a folder with all in it, links as links. Async-signal-safe. False where something stays.
bool remove_tree(const char* folder) noexcept;

}  // namespace mtf::io
