// SPDX-License-Identifier: Apache-2.0
#pragma once

// A sensor file with a chain to electrons, and commands that read it.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "mtf/io/image_io.h"
#include "tests/apps/command.h"

namespace apps_test {

using Json = nlohmann::json;
using mtf::Image;

inline const std::string kSensor = R"(schema = 1
name = "chain"
[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "10 ms"
[scene]
sample = "7.5 um"
quantity = "temperature"
[optics]
f_number = 2.5
transmission = 0.85
[band]
wavelength = ["3 um", "5 um"]
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
width = "15 um"
[detector]
width = "14.25 um"
quantum_efficiency = 0.75
full_well = "10 Me-"
read_noise = "500 e-"
)";

inline void write_flat(const fs::path& path, float value, const std::string& quantity = "temperature") {
  Image image(64, 48);
  std::fill_n(image.data(), image.size(), value);
  mtf::io::Metadata metadata;
  metadata.text["mtf:quantity"] = quantity;
  mtf::io::write_exr(path.string(), {{"Y", image.view()}}, metadata);
}

inline Image read(const fs::path& path) { return std::move(mtf::io::read_image(path.string(), {}).planes.front()); }

class ChainSensor : public testing::Test {
 protected:
  void SetUp() override { write_flat(scratch / "t300.exr", 300.0F); }
  void sensor(const std::string& more, const std::string& from = "", const std::string& to = "") const {
    std::string text = kSensor + more;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    write_file(scratch / "s.toml", text);
  }
  void expect_refused(const std::string& command, std::initializer_list<std::string_view> parts, int status = 2) const {
    SCOPED_TRACE(command);
    expect_error(scratch.run(command), status, parts);
    EXPECT_FALSE(fs::exists(scratch / "out.exr"));
  }
  Json budget() const { return Json::parse(scratch.run("mtf budget s.toml --format json").out)["terms"]; }
  const Scratch scratch;
};

}  // namespace apps_test
