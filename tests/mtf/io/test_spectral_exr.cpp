// SPDX-License-Identifier: Apache-2.0
#include <OpenEXR/ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mtf/error.h"
#include "mtf/io/exr/spectral_exr.h"
#include "mtf/io/scene.h"
#include "tests/expect_error.h"
#include "tests/mtf/io/io_test_files.h"

namespace mtf::io {
namespace {

using io_test::TempFolder;
using Strings = std::vector<std::string>;

double wavelength(const std::string& name) {
  const auto channel = parse_spectral_channel(name);
  return channel ? channel->wavelength_um : std::nan("");
}

TEST(SpectralChannel, names_of_the_layout) {
  for (const char* name : {"S0.550,000000nm", "S0.550nm", "S0.0,55um", "S0.,55um", "S0.5,5E-7m", "S0.5,5e2nm",
                           "S0.550000pm", "S0.550,nm", "S0.5,5e+2nm"})
    EXPECT_NEAR(wavelength(name), 0.55, 1e-15) << name;
  EXPECT_EQ(wavelength("S0.550,000000nm"), 0.55);
  for (const char* name : {"S0.299,792458MHz", "S0.2,99792458E8Hz", "S0.299792,458kHz", "S0.0,299792458GHz"})
    EXPECT_NEAR(wavelength(name), 1e6, 1e-9) << name;
  EXPECT_NEAR(wavelength("S0.0,0000003EHz"), 299792458e6 / 3e11, 1e-9);
  EXPECT_NEAR(wavelength("S0.1dam"), 1e7, 0.0);
  EXPECT_EQ(parse_spectral_channel("S2.400nm")->stokes, 2);
  EXPECT_EQ(parse_spectral_channel("T.400nm")->kind, SpectralChannel::Kind::reflectance);
  EXPECT_EQ(parse_spectral_channel("T.400nm.500nm")->kind, SpectralChannel::Kind::reradiation);
}

TEST(SpectralChannel, other_names) {
  for (const char* name : {"",
                           "S0",
                           "S0.",
                           "S0.nm",
                           "S0.,nm",
                           "S0.550",
                           "S0.550nmx",
                           "S0.550xm",
                           "S4.550nm",
                           "s0.550nm",
                           "S0.550.5nm",
                           "S0.-550nm",
                           "S0.0nm",
                           "S0.1E400nm",
                           "S0.1E-400nm",
                           "S0.EHz",
                           "S0.550 nm",
                           "T",
                           "T.",
                           "T.400nm.",
                           "T.400nm.x",
                           "T.400nm.500nm.600nm",
                           "Y",
                           "R",
                           "view.S0.550nm",
                           "S0.1Ym",
                           "S0.infnm",
                           "S0.550ndam"})
    EXPECT_FALSE(parse_spectral_channel(name)) << name;
}

/// A 4 x 3 file; every channel holds io_test::sample.
void write(const std::string& path, const Strings& channels, const std::string& units = "W.m^-2.sr^-1") {
  Imf::Header header(4, 3);
  if (!units.empty()) header.insert("emissiveUnits", Imf::StringAttribute(units));
  io_test::write_scanline(path, header, channels);
}

SensorConfig sensor() {
  SensorConfig config;
  config.file = "s.toml";
  config.scene.sample_x_um = config.scene.sample_y_um = 5.0;
  return config;
}

TEST(SpectralExr, a_scene_sorted_by_wavelength_beside_its_preview) {
  const TempFolder folder;
  const std::string path = folder / "s.exr";
  write(path, {"S0.1000nm", "S0.400,000000nm", "S0.0,55um", "R", "G", "B", "A"});
  const Scene scene = load_scene(sensor(), path, {});
  EXPECT_EQ(scene.names, (Strings{"S0.400,000000nm", "S0.0,55um", "S0.1000nm"}));
  EXPECT_EQ(scene.wavelength_um, (std::vector<double>{0.4, 0.55, 1.0}));
  EXPECT_EQ(scene.quantity, Quantity::spectral_radiance);
  ASSERT_EQ(scene.planes.size(), 3U);
  EXPECT_EQ(scene.planes[1].at(2, 1), 1000.0F * io_test::sample(2, 1));  // per nm becomes per um
  EXPECT_TRUE(says(scene.warnings, "means per nm"));
}

TEST(SpectralExr, units) {
  const TempFolder folder;
  const std::string path = folder / "s.exr";
  const auto factor = [&](const std::string& units) {
    write(path, {"S0.550nm"}, units);
    return spectral_planes(path, read_image(path))->factor;
  };
  EXPECT_EQ(factor("W.m^-2.sr^-1"), 1e3);
  EXPECT_EQ(factor("W.m^-2.sr^-1.nm^-1"), 1e3);
  EXPECT_EQ(factor("W.m^-2.sr^-1.um^-1"), 1.0);
  EXPECT_EQ(factor("W.m^-2.sr^-1.m^-1"), 1e-6);
  EXPECT_EQ(factor(""), 1e3);
  EXPECT_FALSE(spectral_planes(path, read_image(path))->stated);
  expect_refused({"\"bananas\" are not known"}, [&] { factor("bananas"); });
}

// An assumption gives way to what the sensor file says, and is not called a statement of the file.
TEST(SpectralExr, units_that_are_not_stated) {
  const TempFolder folder;
  const std::string path = folder / "s.exr";
  write(path, {"S0.550nm"}, "");
  SensorConfig config = sensor();
  config.scene.quantity = Quantity::radiance;
  const Scene assumed = load_scene(config, path, {});
  EXPECT_EQ(assumed.planes[0].at(2, 1), 1000.0F * io_test::sample(2, 1));
  EXPECT_TRUE(says(assumed.warnings, "W m-2 sr-1 nm-1"));
  EXPECT_TRUE(says(assumed.warnings, "names of its channels"));
  config.scene.gain = 2.0;
  config.scene.offset = 1.0;
  const Scene given = load_scene(config, path, {});
  EXPECT_EQ(given.planes[0].at(2, 1), 2.0F * io_test::sample(2, 1) + 1.0F);
  EXPECT_EQ(given.quantity, Quantity::spectral_radiance);
  EXPECT_FALSE(says(given.warnings, "state"));
  write(path, {"S0.550nm"}, "W.m^-2.sr^-1.um^-1");
  EXPECT_TRUE(says(load_scene(config, path, {}).warnings, "gain and offset"));
}

TEST(SpectralExr, an_image_of_another_quantity_keeps_it) {
  const TempFolder folder;
  const std::string path = folder / "s.exr";
  Imf::Header header(4, 3);
  header.insert("mtf:quantity", Imf::StringAttribute("counts"));
  io_test::write_scanline(path, header, {"S0.550nm", "S0.600nm"});
  EXPECT_FALSE(spectral_planes(path, read_image(path)));
  EXPECT_EQ(load_scene(sensor(), path, {}).quantity, Quantity::counts);
}

TEST(SpectralExr, polarisation_and_reflectance_are_left_out) {
  const TempFolder folder;
  const std::string path = folder / "s.exr";
  write(path, {"S0.400nm", "S0.500nm", "S1.400nm", "S1.0,5um", "T.400nm", "T.500nm", "T.400nm.500nm"});
  const Scene scene = load_scene(sensor(), path, {});
  EXPECT_EQ(scene.names, (Strings{"S0.400nm", "S0.500nm"}));
  for (const char* part : {"polarisation (S1 to S3), 2", "reflectance (T), 2", "re-radiation"})
    EXPECT_TRUE(says(scene.warnings, part)) << part;
  EXPECT_EQ(load_scene(sensor(), path, {.channel = "S0.500nm", .layer = {}, .part = {}}).wavelength_um,
            std::vector<double>{0.5});
}

TEST(SpectralExr, refusals) {
  const TempFolder folder;
  const std::string path = folder / "s.exr";
  const auto expect = [&](const Strings& channels, std::initializer_list<std::string_view> parts) {
    write(path, channels);
    expect_refused(parts, [&] { read_image(path); });
  };
  expect({"T.400nm", "T.500nm", "R", "G", "B"}, {"T.400nm", "no S0"});
  expect({"S0.400nm", "S0.500nm", "S1.400nm"}, {"S0.500nm", "among S1.400nm"});
  expect({"S0.400nm", "T.400nm", "T.500nm"}, {"T.500nm has no S0 channel"});
  expect({"S0.400nm", "S0.0,4um"}, {"are the same wavelength"});
}

TEST(PlaneBeside, by_name) {
  const TempFolder folder;
  const std::string path = folder / "s.exr";
  write(path, {"Y", "Depth", "Material.Emissivity", "a.T", "b.T"});
  EXPECT_EQ(find_channel(path, read_info(path), {"Z", "depth"}), "Depth");
  EXPECT_EQ(find_channel(path, read_info(path), {"emissivity"}), "Material.Emissivity");
  EXPECT_EQ(find_channel(path, read_info(path), {"Z"}), "");
  EXPECT_EQ(read_plane(path, {"depth", "Z"}).at(2, 1), io_test::sample(2, 1));
  expect_refused({"2 times (a.T, b.T"}, [&] { read_plane(path, {"T"}); });
  expect_refused({"channel Z or range", "it has"}, [&] { read_plane(path, {"Z", "range"}); });
  EXPECT_EQ(read_image(path).names, Strings{"Y"});
}

}  // namespace
}  // namespace mtf::io
