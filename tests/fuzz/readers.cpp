// SPDX-License-Identifier: Apache-2.0

// One reader of files under libFuzzer: fuzz_readers --reader=NAME CORPUS..., `--readers` lists the names. What a reader
// may do with any file is return or throw mtf::Error; another exception, a crash, a leak, what the sanitizers report,
// 2 GiB or ten seconds (tests/fuzz/run) is a finding. Sensor files that are accepted have to be accepted again as
// they are written, with an OTF that is finite.

#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "apps/characterize/emva_descriptor.h"
#include "apps/characterize/stacks_file.h"
#include "apps/scene/import/helper/mesh_readers.h"
#include "apps/scene/scene_file/scene_file.h"
#include "apps/scene/weather/weather_file.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/study/study.h"
#include "apps/text/json.h"
#include "calib/find/roi_file.h"
#include "mtf/error.h"
#include "mtf/io/codecs/encoding.h"
#include "mtf/io/config/schedule.h"
#include "mtf/io/csv/air_profile_csv.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/csv/curve_samples.h"
#include "mtf/io/csv/field_map_csv.h"
#include "mtf/io/csv/spectrum_csv.h"
#include "mtf/io/csv/tape7.h"
#include "mtf/io/designs/design_columns.h"
#include "mtf/io/designs/mtf_listing.h"
#include "mtf/io/designs/psf_fits.h"
#include "mtf/io/designs/psf_listing.h"
#include "mtf/io/designs/zernike_listing.h"
#include "mtf/io/image_formats.h"
#include "mtf/io/npy.h"
#include "tests/fuzz/toml_mutation.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

struct Reader {
  std::string name;    ///< of the reader and of its folder of seeds
  std::string ending;  ///< of the file's name
  std::function<void(const std::string& text, const std::string& path)> read;
  bool toml = false;
};

[[noreturn]] void finding(const std::string& what) {
  std::fprintf(stderr, "FINDING: %s\n", what.c_str());
  std::abort();
}

void read_image(const std::string&, const std::string& path) {
  mtf::io::read_info(path);
  mtf::io::read_image(path);
}

void read_sensor(const std::string& text, const std::string& path) {
  const auto tables = radiometry::sensor_tables();
  const mtf::io::ConfigResult read = mtf::io::parse_config(text, path, tables);
  if (!read.ok()) return;
  const mtf::io::ConfigResult again = mtf::io::parse_config(mtf::io::write_config(read.config), path, tables);
  if (!again.ok())
    finding("what was accepted is refused as it is written: " +
            mtf::io::format_diagnostic(again.diagnostics.front(), path));
  const auto& system = read.config.system;
  if (system.is_isoplanatic())
    for (const double f_cy_mm : {0.0, 1e-3, 1.0, 30.0, 500.0}) {
      const auto otf = system.otf({f_cy_mm, 0.1 * f_cy_mm});
      if (!std::isfinite(otf.re) || !std::isfinite(otf.im)) finding("an OTF that is not finite");
    }
  apps::load_chain(read.config);
}

/// Arrays of frames, which `mtf characterize` takes in pieces.
void read_npy(const std::string&, const std::string& path) {
  mtf::io::NpyReader reader(path);
  std::vector<float> values(16);
  reader.read(0, values);
}

void read_tables(const mtf::io::DesignText& lines) {
  const std::function<void()> kinds[] = {[&] { mtf::io::read_zernike_listing(lines, {}); },
                                         [&] { mtf::io::read_psf_listing(lines, {}); },
                                         [&] { mtf::io::read_mtf_listing(lines, {}); }};
  for (const auto& read : kinds) try {
      read();
    } catch (const mtf::Error&) {  // of another kind of listing
    }
}

void read_listing(const std::string& text, const std::string& path) {
  const mtf::io::DesignText lines = mtf::io::design_text(text, path);
  read_tables(lines);
  mtf::io::field_scan_columns(lines);
}

/// A first line that names the columns, and the listing.
void read_columns(const std::string& text, const std::string& path) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  mtf::io::DesignRemarks remarks;
  const mtf::io::DesignText table =
      mtf::io::with_columns(mtf::io::design_text(text.substr(end), path), text.substr(0, end), remarks);
  read_tables(table);
}

mtf::io::SensorConfig starter() { return mtf::io::parse_config(mtf::io::starter_config(), "sensor.toml").config; }

/// Readers of meshes report by exceptions of the standard library to the program that they are part of.
template <class Read>
void mesh(Read read) {
  try {
    read();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::runtime_error&) {
  }
}

std::vector<Reader> readers() {
  using Text = const std::string&;
  std::vector<Reader> all;
  for (const mtf::io::ImageFormat& format : mtf::io::image_formats()) {
    std::string name;
    for (const char c : format.name)
      if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += static_cast<char>(std::tolower(c));
    all.push_back({name, std::string(format.endings[0]), read_image});
  }
  const std::vector<Reader> texts = {
      {"npy", ".npy", read_npy},
      {"sensor", ".toml", read_sensor, true},
      {"study", ".toml", [](Text text, Text path) { study::parse_study(text, path); }, true},
      {"scene", ".toml", [](Text, Text path) { apps::scene::load_scene(path); }, true},
      {"stacks", ".toml", [](Text text, Text path) { apps::parse_stacks(text, path); }, true},
      {"emva", ".txt",
       [](Text, Text path) {
         if (apps::is_emva_descriptor(path)) apps::load_emva_descriptor(path);
       }},
      {"json", ".json", [](Text text, Text) { apps::parse_json(text); }},
      {"schedule", ".csv", [](Text text, Text path) { mtf::io::parse_schedule(text, path, starter()); }},
      {"curve", ".csv", [](Text text, Text path) { mtf::io::parse_curve_csv(text, path); }},
      {"samples", ".csv", [](Text text, Text path) { mtf::io::parse_curve_samples(text, path); }},
      {"spectrum", ".csv", [](Text text, Text path) { mtf::io::parse_spectrum_csv(text, path, {"transmission"}); }},
      {"path", ".csv", [](Text text, Text path) { mtf::io::parse_path_csv(text, path); }},
      {"air", ".csv", [](Text text, Text path) { mtf::io::parse_air_profile_csv(text, path); }},
      {"tape7", ".tp7", [](Text text, Text path) { mtf::io::parse_tape7(text, path); }},
      {"field", ".csv", [](Text text, Text path) { mtf::io::parse_field_map_csv(text, path); }},
      {"oecf", ".csv", [](Text text, Text path) { mtf::io::parse_oecf(text, path); }},
      {"regions", ".csv", [](Text text, Text path) { calib::parse_roi_file(text, path); }},
      {"listing", ".txt", read_listing},
      {"columns", ".txt", read_columns},
      {"pointspread", ".fits",
       [](Text, Text path) {
         mtf::io::read_psf_fits(path, {.detector = {{64, 64}}});
       }},
      {"weather", ".csv", [](Text text, Text path) { apps::scene::parse_weather(text, path); }},
      {"gltf", ".gltf", [](Text text, Text) { mesh([&] { apps::scene::read_gltf(".gltf", text, ""); }); }},
      {"glb", ".glb", [](Text text, Text) { mesh([&] { apps::scene::read_gltf(".glb", text, ""); }); }},
      {"obj", ".obj", [](Text text, Text) { mesh([&] { apps::scene::read_obj(text); }); }},
      {"ply", ".ply", [](Text text, Text) { mesh([&] { apps::scene::read_ply(text); }); }},
      {"stl", ".stl", [](Text text, Text) { mesh([&] { apps::scene::read_stl(text); }); }},
  };
  all.insert(all.end(), texts.begin(), texts.end());
  return all;
}

/// In memory, with the raw numbers that an ENVI header describes beside it; gone with the process.
class Folder {
 public:
  Folder() : path_("/dev/shm/mtfkit-fuzz-" + std::to_string(::getpid())) {
    std::filesystem::create_directory(path_);
    std::ofstream(path_ + "/input.img") << std::string(96, 'x');
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

const Reader* chosen = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  static const std::vector<Reader> all = readers();
  for (int i = 1; i < *argc; ++i) {
    const std::string_view word = (*argv)[i];
    for (const Reader& reader : all) {
      if (word == "--readers") std::printf("%s%s\n", reader.name.c_str(), reader.toml ? " toml" : "");
      if (word == "--reader=" + reader.name) chosen = &reader;
    }
    if (word == "--readers") std::exit(0);
  }
  if (chosen == nullptr) {
    std::fprintf(stderr, "name a reader: --reader=NAME; --readers lists them\n");
    std::exit(2);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::string path = folder.path() + "/input" + chosen->ending;
  std::ofstream(path, std::ios::binary) << text;
  try {
    chosen->read(text, path);
  } catch (const mtf::Error&) {
  } catch (const std::exception& error) {
    finding(std::string("an exception that is none of the toolkit's: ") + error.what());
  }
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  if (!chosen->toml || seed % 8 == 0) return LLVMFuzzerMutate(data, size, max_size);
  const std::string text = fuzz::mutated_toml({reinterpret_cast<const char*>(data), size}, seed / 8);
  const std::size_t length = std::min(text.size(), max_size);
  std::memcpy(data, text.data(), length);
  return length;
}

extern "C" std::size_t LLVMFuzzerCustomCrossOver(const std::uint8_t* first, std::size_t first_size,
                                                 const std::uint8_t* second, std::size_t second_size, std::uint8_t* out,
                                                 std::size_t max_size, unsigned int seed) {
  const std::string_view a(reinterpret_cast<const char*>(first), first_size);
  const std::string_view b(reinterpret_cast<const char*>(second), second_size);
  const std::string text =
      chosen->toml ? fuzz::crossed_toml(a, b, seed)
                   : std::string(a.substr(0, seed % (a.size() + 1))) + std::string(b.substr(seed % (b.size() + 1)));
  const std::size_t length = std::min(text.size(), max_size);
  std::memcpy(out, text.data(), length);
  return length;
}
