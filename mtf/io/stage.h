// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files that are put into place together. They are written in a folder beside their place, the stage, and moved when
// all of them are whole and on the disk: what they replace stays until then, and stays for good where anything fails. A
// stage holds a lock, so that two commands into one place are told apart.
//
//   folder/.mtf-new/          of all files of a folder; of single files folder/.NAME.mtf-new/, named after the first
//     lock                    held by the process that writes
//     new/                    the files as they are written; ready/ from the moment on that all of them are whole
//     gone/                   an empty file for each name that the new files leave no place for
//     old/                    what has been replaced, until all is in place
//
// A process that is killed leaves its stage: one without ready/ is of no use, and the next stage of that place removes
// it; one with ready/ is finished by it first, so that no finished file is lost.

#include <optional>
#include <string>
#include <vector>

#include "mtf/io/temporaries.h"

namespace mtf::io {

class Stage {
 public:
  /// For files in `folder`, which is there; `name` is "" for the folder as a whole. A folder that was made for them is
  /// `fresh`: a stop removes it. Throws RuntimeError where the folder cannot be written into, and where another process
  /// holds the stage; `shown` is what messages call the place.
  Stage(std::string folder, const std::string& name, bool fresh, const std::string& shown);
  ~Stage();  ///< without a commit nothing has changed
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// Where the file `name` of the folder is written until the commit; the folders of "chosen/best.toml" are made. Of ""
  /// where all are.
  std::string at(const std::string& name) const;

  /// The files written so far.
  std::vector<std::string> names() const;

  // A commit. Of several stages all are made ready, then all moved, then all finished; when one throws, undo() of all
  // brings back what was there; where that fails the stage stays, and the next one of that place puts the new files
  // in place. `gone`: names of files and folders that leave their place where they are there and not
  // written anew.
  void make_ready(const std::vector<std::string>& gone);
  void move();
  void undo() noexcept;
  void finish() noexcept;  ///< after which more files may be written, for another commit

 private:
  struct Step {
    std::string name;
    bool placed = false, replaced = false;  ///< a new file is there; what was there is in old/
  };

  void open(const std::string& shown);
  void close() noexcept;
  void place(const std::string& name);
  void set_aside(const std::string& name);
  std::string in(const std::string& part, const std::string& name) const { return stage_ + "/" + part + "/" + name; }

  std::string folder_, stage_;
  bool fresh_, committing_ = false;
  bool stuck_ = false;  ///< a file could not be brought back: the stage stays as a killed process leaves it
  int lock_ = -1;
  std::vector<Step> steps_;
  std::optional<ListedTemporary> listed_;
};

/// Whether `name` in a folder is a stage.
bool is_stage(const std::string& name);

/// The text with the names of files as they are after the commit.
std::string without_stages(std::string text);

}  // namespace mtf::io
