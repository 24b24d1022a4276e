// SPDX-License-Identifier: Apache-2.0
#pragma once

// A folder with a sensor file, and studies of it.

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "apps/study/study.h"

namespace study_test {

inline constexpr const char* kCamera = R"(schema = 1
name = "camera"
[frame]
focal_length = "2 m"
pitch = "8 um"
integration_time = "2 ms"
format = [640, 512]
[optics]
aperture = "250 mm"
obscuration = 0.3
transmission = 0.8
[band]
wavelength = ["0.5 um", "0.7 um"]
[detector]
quantum_efficiency = 0.6
read_noise = "20 e-"
[adc]
bits = 12
electrons_per_count = "20 e-"
[[presample]]
kind = "wavefront"
zernike = [0.0, 0.0, 0.0, 0.05]
[[presample]]
kind = "footprint"
fill_factor = 0.9
[[presample]]
kind = "jitter"
rms = "1 urad"
[[presample]]
kind = "jitter"
label = "slow"
rms_x = "2 um"
rms_y = "1 um"
)";

/// A new folder with camera.toml, removed at the end.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "mtfkit_study_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
    write("camera.toml", kCamera);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(*this / name).parent_path());
    std::ofstream(*this / name, std::ios::binary) << text;
  }
  study::StudyResult parse(const std::string& text) const { return study::parse_study(text, *this / "study.toml"); }
  /// The diagnostics as lines without the folder.
  std::string lines(const std::string& text) const {
    std::string all;
    for (const auto& diagnostic : parse(text).diagnostics)
      all += mtf::io::format_diagnostic(diagnostic, "study.toml") + "\n";
    const std::string folder = path_.string() + "/";
    for (std::size_t at = 0; (at = all.find(folder, at)) != std::string::npos;) all.erase(at, folder.size());
    return all;
  }

 private:
  std::filesystem::path path_;
};

/// The head of a study of camera.toml, two lines.
inline const std::string kHead = "schema = 1\nsensor = \"camera.toml\"\n";
/// One axis and a metric.
inline const std::string kAxis = "[[axis]]\nparameter = \"pitch\"\nvalues = [\"5 um\", \"8 um\"]\n";
inline const std::string kMetrics = "[metrics]\nlist = [\"mtf_nyquist\"]\n";

}  // namespace study_test
