// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "mtf/io/csv/spectrum_csv.h"
#include "mtf/io/csv/tape7.h"
#include "radiometry/light/path_planes.h"

// From files to radiometry: what mtf/io reads as plain numbers is what the types here are made of.

namespace radiometry {
namespace {

const std::string kFolder = MTFKIT_SOURCE_DIR "/notebooks-data/curves/made_up_mwir_";

Spectrum curve(const std::string& name, const std::string& column) {
  mtf::io::SpectrumColumns read = mtf::io::read_spectrum_csv(kFolder + name + ".csv", {column});
  return make_spectrum(read.source, std::move(read.wavelength_um), std::move(read.columns.at(0)), 1.0);
}

PathTable table_of(const mtf::io::PathColumns& path) {
  return {path.source, path.range_m, path.wavelength_um, path.transmission, path.radiance};
}

SpectralCamera camera() {
  return {.band = {3.0, 5.2},
          .optics = {constant_spectrum("optics", 0.9)},
          .cold_filter = {curve("cold_filter", "transmission")},
          .quantum_efficiency = {curve("quantum_efficiency", "quantum_efficiency")}};
}

TEST(SpectralFiles, air_as_warm_as_the_scene_changes_nothing) {
  // Absorbing air at the temperature of a blackbody scene: it emits what it absorbs, at every range. Straight lines
  // between the samples of the table, and radiance by range, leave a few thousandths.
  const PathTable table = table_of(mtf::io::read_path_csv(kFolder + "path.csv"));
  const RangeTable ranges(scene_band(camera()), table, 288.15);
  const double scene = band_radiances(camera(), Surface{288.15}, Path{}, {}).scene;
  EXPECT_EQ(ranges.longest_m(), 4000.0);
  for (const double r : {250.0, 500.0, 1000.0, 2000.0, 4000.0}) {
    EXPECT_LT(ranges.transmission(r), 0.95);
    EXPECT_GT(ranges.transmission(r), 0.2);
    EXPECT_NEAR((ranges.transmission(r) * scene + ranges.radiance(r)) / scene, 1.0, 5e-3) << r;
  }
}

TEST(SpectralFiles, tape7_is_a_table_of_paths) {
  const std::string header =
      "    FREQ  TOT_TRANS  PTH_THRML  THRML_SCT  SURF_EMIS   SOL_SCAT  SING_SCAT  GRND_RFLT  DRCT_RFLT  TOTAL_RAD\n";
  std::string text;
  for (const int run : {1, 2})
    text += header + " 2000.00 0." + std::to_string(9 - run) + "0000000 1.0000E-07\n 3000.00 0." +
            std::to_string(8 - run) + "0000000 2.0000E-08\n-9999.\n";
  const PathTable table = table_of(mtf::io::path_columns(mtf::io::parse_tape7(text, "t.tp7"), {1000.0, 2000.0}));
  const Path path = table.at(2000.0);
  EXPECT_EQ(evaluate(path.transmission, 5.0), 0.7);
  EXPECT_NEAR(evaluate(path.radiance, 5.0), 1e-7 * 1e4 * 400.0, 1e-15);  // 1 um is 400 cm^-1 at 5 um
  EXPECT_NEAR(evaluate(path.radiance, 1e4 / 3000.0), 2e-8 * 1e4 * 900.0, 1e-15);
}

}  // namespace
}  // namespace radiometry
