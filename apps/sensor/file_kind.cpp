// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/file_kind.h"

#include <algorithm>
#include <initializer_list>

#include "mtf/error.h"
#include "mtf/io/config/config_tree.h"
#include "mtf/io/csv/curve_csv.h"

namespace apps {
namespace {

std::string words(FileKind kind) {
  return kind == FileKind::sensor ? "a sensor file" : kind == FileKind::study ? "a study" : "a 3-D scene";
}

std::string reader_of(FileKind kind, const std::string& file) {
  return kind == FileKind::sensor  ? "`mtf config check " + file + "` checks it, and `mtf simulate` images with it"
         : kind == FileKind::study ? "`mtf config check " + file + "` checks it, and `mtf sweep` runs it"
                                   : "`mtf scene check " + file + "` checks it, and `mtf render` makes pictures of it";
}

}  // namespace

FileKind file_kind(const std::string& file) {
  const auto tree = mtf::io::cfg::read_tree(mtf::io::read_text_file(file, mtf::io::cfg::kMaxBytes));
  const auto has_any = [&](std::initializer_list<const char*> keys) {
    return std::ranges::any_of(keys, [&](const char* key) { return tree.root.find(key) != nullptr; });
  };
  return has_any({"place", "weather", "material", "mesh"}) ? FileKind::scene
         : has_any({"axis", "sensor"})                     ? FileKind::study
         : has_any({"frame", "presample", "optics"})       ? FileKind::sensor
                                                           : FileKind::unclear;
}

void require_kind(const std::string& file, FileKind wanted) {
  const FileKind kind = file_kind(file);
  if (kind != wanted && kind != FileKind::unclear)
    throw mtf::UsageError(file + ": this is " + words(kind) + ", not " + words(wanted) + "; " + reader_of(kind, file));
}

}  // namespace apps
