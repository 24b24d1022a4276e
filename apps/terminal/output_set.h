// SPDX-License-Identifier: Apache-2.0
#pragma once

// All that a command writes, as one: the files of a folder, and single files. They are written beside their place and
// put into it together (mtf/io/stage.h), so that a full disk, an error or a signal leaves what was there before, and no
// half of a new set. No file that the command reads is replaced, by whatever name. Two commands that write one folder,
// or single files of which the first is the same, are told apart.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/stage.h"

namespace apps {

struct OutputPlan {
  std::string folder{};                   ///< made where it is missing, not its parents; "" for none
  bool force = false;                     ///< the folder may hold files, those of other names stay
  std::vector<std::string> names{};       ///< in the folder; those that are there and not written anew go
  std::vector<std::string> subfolders{};  ///< in the folder; what they hold from before goes
  std::vector<std::string> files{};       ///< elsewhere; "" and "-" are none
  std::vector<std::string> inputs{};      ///< all that the command reads
};

/// Whether a folder holds nothing, or only what a killed process left of files that it did not finish.
bool holds_nothing(const std::filesystem::path& folder);

class OutputSet {
 public:
  /// Refuses what is bound to fail before any work is done. Throws UsageError for outputs that are inputs, for two of
  /// one name, and for a folder that is not empty without `force`; RuntimeError where a folder is missing or cannot be
  /// written, and where another process is writing there.
  explicit OutputSet(OutputPlan plan);
  ~OutputSet();
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;

  /// Where the file `name` of the folder is written; "" for the folder itself. Throws UsageError for an input.
  std::string in(const std::string& name);
  /// Where a single file is written; "", "-" and devices are their own place. Throws UsageError for an input.
  std::string at(const std::string& file);

  /// Puts all that has been written into place. More may be written after it, for another commit.
  void commit();
  /// A commit with the result of the command, `text`, to a file, or once all is in place to standard output.
  void commit(const std::string& file, std::string_view text);

 private:
  struct Place {
    std::string folder;
    std::unique_ptr<mtf::io::Stage> stage;
  };
  /// Removes the folder that was made where nothing came of it.
  struct NewFolder {
    std::string path;
    ~NewFolder();
  };

  mtf::io::Stage& stage_of(const std::string& folder, const std::string& file);

  OutputPlan plan_;
  NewFolder fresh_;
  std::unique_ptr<mtf::io::Stage> whole_;  ///< of the folder
  std::vector<Place> places_;              ///< of single files
};

}  // namespace apps
