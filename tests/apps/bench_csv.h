// SPDX-License-Identifier: Apache-2.0
#pragma once

// bench.csv read back, and small scenes to bench.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"
#include "tests/csv_fields.h"

namespace apps_test {

using Row = std::map<std::string, std::string>;

inline std::vector<Row> read_rows(const std::string& csv) {
  std::istringstream text(csv);
  std::string line;
  std::getline(text, line);
  const std::vector<std::string> names = fields_of(line);
  std::vector<Row> rows;
  while (std::getline(text, line)) {
    const std::vector<std::string> fields = fields_of(line);
    EXPECT_EQ(fields.size(), names.size()) << line;
    for (std::size_t i = 0; i < std::min(names.size(), fields.size()); ++i) {
      if (i == 0) rows.emplace_back();
      rows.back()[names[i]] = fields[i];
    }
  }
  return rows;
}

inline double value(const Row& row, const std::string& name) { return std::strtod(row.at(name).c_str(), nullptr); }
inline bool is_rival(const Row& row) { return row.at("method").starts_with("opencv_"); }

/// An edge, a ripple and bright points.
inline void write_bench_scene(const fs::path& path, std::int64_t width, std::int64_t height) {
  mtf::Image scene(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    for (std::int64_t x = 0; x < width; ++x) {
      const double ripple = std::sin(0.9 * static_cast<double>(x)) * std::cos(0.4 * static_cast<double>(y));
      const double edge = 2 * x + y > width ? 2.0 : 0.0, points = (x * 7 + y * 13) % 101 == 0 ? 6.0 : 0.0;
      scene.at(x, y) = static_cast<float>(5.0 + edge + 0.3 * ripple + points);
    }
  mtf::io::write_exr(path.string(), {{"Y", scene.view()}}, {});
}

/// A sensor file: pitch 12 um, `samples` of the scene to a pitch.
inline void write_bench_sensor(const fs::path& path, double samples, const std::string& border,
                               const std::string& stages) {
  std::ostringstream text;
  text << "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"12 um\"\n[scene]\nsample = \"" << 12.0 / samples
       << " um\"\nquantity = \"radiance\"\nborder = \"" << border << "\"\n"
       << (border == "constant" ? "border_value = 4.0\n" : "") << "[optics]\nf_number = 3.0\nwavelength = \"4.0 um\"\n"
       << stages;
  write_file(path, text.str());
}

inline const std::string kDiffraction = "[[presample]]\nkind = \"diffraction\"\n";
inline const std::string kSeparable =
    "[[presample]]\nkind = \"footprint\"\nwidth = \"12 um\"\n[[presample]]\nkind = \"jitter\"\nrms = \"20 um\"\n";
inline const std::string kQuick = " --rounds 2 --seconds 2 --threads 1 ";

}  // namespace apps_test
