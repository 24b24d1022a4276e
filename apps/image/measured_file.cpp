// SPDX-License-Identifier: Apache-2.0
#include "apps/image/measured_file.h"

#include <cstdlib>
#include <filesystem>

#include "apps/bench/machine.h"
#include "apps/terminal/output.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/plan/measured.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargest = std::size_t{16} << 20;

// The fastest method of one processor may be slow on another: home folders are shared between machines.
std::string processor_name() {
  std::string name = this_machine().cpu;
  if (name.empty()) name = "unknown";
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}

fs::path cache_file() {
  const auto folder = [](const char* variable) {
    const char* value = std::getenv(variable);
    return value == nullptr || *value != '/' ? fs::path() : fs::path(value);
  };
  fs::path base = folder("XDG_CACHE_HOME");
  if (base.empty() && !folder("HOME").empty()) base = folder("HOME") / ".cache";
  return base.empty() ? fs::path() : base / "mtfkit" / ("measured-" + processor_name());
}

}  // namespace

void read_measured(const SimulateCommandOptions& options, const Global& global) {
  std::error_code error;
  if (options.wisdom.empty()) {
    const fs::path cache = cache_file();
    if (!options.run.measure || !fs::is_regular_file(cache, error)) return;
    bool known = false;
    try {
      known = mtf::import_measured(mtf::io::read_text_file(cache.string(), kLargest));
    } catch (const mtf::Error&) {  // as good as none
    }
    if (!known) note(global, "note: " + one_line(cache.string()) + " is damaged; its run times are measured again");
    return;
  }
  if (!fs::exists(options.wisdom, error)) {
    note(global, "note: " + one_line(options.wisdom) + " is created for the run times that are measured now");
    return;
  }
  if (!fs::is_regular_file(options.wisdom, error) ||
      !mtf::import_measured(mtf::io::read_text_file(options.wisdom, kLargest)))
    throw mtf::UsageError("--wisdom: " + one_line(options.wisdom) +
                          " does not hold what measuring has learnt here; name another file");
}

void write_measured(const SimulateCommandOptions& options, const Global& global) {
  if (!options.wisdom.empty()) {
    mtf::io::write_text_file(options.wisdom, mtf::export_measured());
    return;
  }
  const fs::path cache = cache_file();
  if (!options.run.measure || cache.empty()) return;
  try {
    fs::create_directories(cache.parent_path());
    mtf::io::write_text_file(cache.string(), mtf::export_measured());
  } catch (const std::exception& e) {
    note(global, "note: the measured run times are not kept: " + one_line(e.what()));
  }
}

}  // namespace apps
