// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/command/unfinished_run.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "apps/terminal/output.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/sha256.h"

namespace apps::scene {
namespace {

constexpr std::string_view kMagic = "mtf heat, unfinished\n";

[[noreturn]] void refuse(const std::string& folder, const std::string& why) {
  throw mtf::UsageError(one_line(folder) + " holds a run that was interrupted, " + why +
                        "; --anew begins again and replaces it");
}

/// JSON has no NaN: that of a region that the camera does not see is null.
double kelvin_of(const Json& number) {
  return number.is_null() ? std::numeric_limits<double>::quiet_NaN() : number.get<double>();
}

}  // namespace

std::string unfinished_path(const std::string& folder) { return folder + "/unfinished.bin"; }

bool is_unfinished(const std::string& folder) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(unfinished_path(folder), ignored)) return false;
  std::ifstream file(unfinished_path(folder), std::ios::binary);
  std::string start(kMagic.size(), '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  return file && start == kMagic;
}

std::vector<std::string> unfinished_files(const std::string& folder) {
  return {unfinished_path(folder), folder + "/unfinished.npy", folder + "/unfinished_back.npy"};
}

void remove_unfinished(const std::string& folder) {
  for (const std::string& file : unfinished_files(folder)) std::filesystem::remove(file);
}

// A line that says what it is, the hash of all that follows, a line of JSON, the checkpoint.
void write_unfinished(const std::string& folder, const UnfinishedRun& run) {
  Json fingerprints = Json::array(), regions = Json::array();
  for (const auto& [what, print] : run.fingerprints) fingerprints.push_back({what, print});
  for (const auto& output : run.outputs.regions)
    for (const RegionTemperature& region : output) regions.push_back({region.least_k, region.mean_k, region.most_k});
  const Json head = {{"fingerprints", fingerprints}, {"times_s", run.outputs.times_s}, {"regions", regions}};
  const std::string all = json_document(head, -1) + bytes_of(run.checkpoint);
  mtf::io::write_text_file(unfinished_path(folder), std::string(kMagic) + mtf::io::sha256_hex(all) + all);
}

UnfinishedRun read_unfinished(const std::string& folder, const Fingerprints& now, std::size_t regions) {
  std::ifstream file(unfinished_path(folder), std::ios::binary);
  const std::string read{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  constexpr std::size_t kHash = 64, kBegin = kMagic.size() + kHash;
  const std::string_view bytes = std::string_view(read).substr(std::min(kBegin, read.size()));
  const std::size_t end = bytes.find('\n');
  if (end == std::string::npos || mtf::io::sha256_hex(bytes) != read.substr(kMagic.size(), kHash))
    refuse(folder, "but its unfinished.bin is damaged");
  UnfinishedRun run;
  std::size_t outputs = 0;
  try {
    const Json head = parse_json(bytes.substr(0, end));
    for (const Json& one : head.at("fingerprints").elements())
      run.fingerprints.emplace_back(one[0].get<std::string>(), one[1].get<std::string>());
    for (const Json& time : head.at("times_s").elements()) run.outputs.times_s.push_back(time.get<double>());
    outputs = run.outputs.times_s.size();
    if (outputs == 0 || head.at("regions").size() != outputs * regions) throw mtf::UsageError("regions");
    for (std::size_t i = 0; i < outputs; ++i) {
      run.outputs.regions.emplace_back();
      for (std::size_t r = 0; r < regions; ++r) {
        const Json& one = head.at("regions")[i * regions + r];
        run.outputs.regions.back().push_back({kelvin_of(one[0]), kelvin_of(one[1]), kelvin_of(one[2])});
      }
    }
  } catch (const mtf::UsageError&) {
    refuse(folder, "but its unfinished.bin is damaged");
  }
  for (std::size_t i = 0; i < now.size(); ++i)
    if (i >= run.fingerprints.size() || run.fingerprints[i] != now[i])
      refuse(folder, "and " + now[i].first + " is not what it was then");
  try {
    run.checkpoint = checkpoint_of(bytes.substr(end + 1));
    if (run.checkpoint.outputs != outputs) throw mtf::RuntimeError("outputs");
  } catch (const mtf::RuntimeError&) {
    refuse(folder, "but its unfinished.bin is damaged");
  }
  return run;
}

}  // namespace apps::scene
