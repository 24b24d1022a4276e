// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/command/unfinished_run.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <type_traits>

#include "apps/terminal/output.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

class Writer {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (add(values), ...);
  }
  template <class T>
  void add(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class T>
  void add(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    add(values.size());
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  void add(const std::string& text) {
    add(text.size());
    bytes_.append(text);
  }
  /// How many of something follow.
  std::size_t count(std::size_t size, std::size_t) {
    add(size);
    return size;
  }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : left_(bytes) {}
  template <class... T>
  void operator()(T&... values) {
    (take_into(values), ...);
  }
  template <class T>
  void take_into(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&value, take(1, sizeof value), sizeof value);
  }
  template <class T>
  void take_into(std::vector<T>& values) {
    const std::size_t size = count(0);
    const char* from = take(size, sizeof(T));
    values.resize(size);
    if (size > 0) std::memcpy(values.data(), from, size * sizeof(T));
  }
  void take_into(std::string& text) {
    const std::size_t size = count(0);
    text.assign(take(size, 1), size);
  }
  std::size_t count(std::size_t) {
    std::size_t size = 0;
    take_into(size);
    return size;
  }
  /// The same of things of at least that many bytes.
  std::size_t count(std::size_t, std::size_t bytes) {
    const std::size_t size = count(0);
    if (size > left_.size() / bytes) damaged();
    return size;
  }
  bool at_end() const { return left_.empty(); }
  [[noreturn]] static void damaged() { damaged_checkpoint(); }

 private:
  const char* take(std::size_t count, std::size_t size) {
    if (count > left_.size() / size) damaged();
    const char* from = left_.data();
    left_.remove_prefix(count * size);
    return from;
  }
  std::string_view left_;
};

template <class Archive, class Grid>
void grid(Archive& a, Grid& g) {
  a(g.capacity, g.conductance, g.depth_m, g.layer_m, g.inner_w_m2_k);
}

template <class Archive, class State>
void state(Archive& a, State& s) {
  a(s.time_s, s.facets, s.fine, s.doubled, s.coarse, s.step_s);
}

template <class Archive, class Batch>
void batch(Archive& a, Batch& b) {
  a(b.wanted_k, b.run.name, b.run.units, b.run.sample, b.run.nodes, b.run.promised, b.run.steps, b.run.drift);
  grid(a, b.fine);
  grid(a, b.coarse);
  a(b.request, b.step_tolerance_k, b.depth_k);
  for (auto* each : {&b.all, &b.sample, &b.promise}) state(a, *each);
}

/// All of it, whichever way.
template <class Archive, class Saved>
void all_of(Archive& a, Saved& c) {
  a(c.windows, c.outputs, c.exchange_k, c.left_out, c.warmest_k, c.iterations, c.view_spread);
  a(c.batches.window, c.batches.emitted, c.batches.beyond_sample);
  constexpr std::size_t kLeast = 256;  // bytes of a batch
  const std::size_t count = a.count(c.batches.batch.size(), kLeast);
  if constexpr (!std::is_const_v<Saved>) c.batches.batch.resize(count);
  for (auto& one : c.batches.batch) batch(a, one);
}

template <class... Vectors>
std::string hash_of(const Vectors&... vectors) {
  Writer bytes;
  bytes(vectors...);
  return mtf::io::sha256_hex(bytes.bytes());
}

std::string hash_of_tables(const ThermalScene& scene) {
  std::string hashes;
  for (const heat::Schedule* schedule : scene.schedules()) hashes += hash_of(schedule->time_s, schedule->value);
  for (const Material& material : scene.materials) hashes += hash_of(material.source_w_m2, material.back_source_w_m2);
  for (const Region& region : scene.regions)
    if (region.table) hashes += hash_of(region.table->utc_s, region.table->front_k);
  return mtf::io::sha256_hex(hashes);
}

/// As bytes of this machine, and back; throws RuntimeError for bytes that are none.
std::string bytes_of(const Checkpoint& checkpoint) {
  Writer writer;
  all_of(writer, checkpoint);
  return std::move(writer.bytes());
}

Checkpoint checkpoint_of(std::string_view bytes) {
  Reader reader(bytes);
  Checkpoint checkpoint;
  all_of(reader, checkpoint);
  if (!reader.at_end()) Reader::damaged();
  return checkpoint;
}

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

Fingerprints fingerprints_of(const SceneFile& file, const HeatScene& scene, const HeatOptions& options) {
  const Surroundings& s = scene.surroundings;
  const radiometry::scene::Facets& facets = scene.facets();
  std::string emissivities;
  for (const Material& material : scene.material)
    emissivities += hash_of(material.emissivity(false), material.emissivity(true));
  return {
      {"the scene file", file.sha256},
      {"a mesh", hash_of(facets.vertices, facets.triangles, facets.facet_of, scene.input.region_of, scene.opposite)},
      {"the weather",
       hash_of(s.time_s, s.air_k, s.wind_m_s, s.vapour_pa, s.direct_w_m2, s.diffuse_w_m2, s.sky_longwave_w_m2)},
      {"a spectrum of emissivity", mtf::io::sha256_hex(emissivities)},
      {"a table of temperatures or fluxes", hash_of_tables(scene.input)},
      {"an option (--tolerance, --rays, --sun-directions, --sun-points, --every-facet or --seen)",
       hash_of(options.tolerance_k, options.directions, options.rays, options.sun_points, options.patches,
               options.every_facet, options.seen)},
      {"the program", std::string(mtf::version) + " " + std::string(mtf::git_commit)}};
}

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
