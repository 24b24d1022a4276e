// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/io/config/config.h"
#include "radiometry/chain/sensor_numbers.h"
#include "radiometry/chain/sensor_settings.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

// [detector] kind = "thermal" in a sensor file: volts where a photon detector has electrons, and keys of its own.

namespace radiometry {
namespace {

const std::string kHead =
    "schema = 1\n[frame]\nfocal_length = \"18 mm\"\npitch = \"17 um\"\n[optics]\nf_number = 1.0\n"
    "[band]\nwavelength = [\"8 um\", \"14 um\"]\n";
const std::string kThermal =
    "[detector]\nkind = \"thermal\"\nabsorptance = 0.8\nresponsivity = 1e5\nnetd = \"50 mK\"\nnetd_f_number = 1.0\n"
    "netd_transmission = 1.0\nnetd_temperature = \"300 K\"\n";

mtf::io::ConfigResult parse(const std::string& body) {
  return mtf::io::parse_config(kHead + body, "s.toml", sensor_tables());
}

std::string first_error(const std::string& body) {
  const mtf::io::ConfigResult result = parse(body);
  for (const mtf::io::Diagnostic& d : result.diagnostics)
    if (d.error) return d.path + ": " + d.text;
  return message_of<mtf::UsageError>([&] { sensor_settings(result.config.tables); });
}

void expect_error(const std::string& body, std::initializer_list<std::string_view> parts) {
  expect_says(first_error(body), parts);
}

/// Sides of the active area in um, of a file of that version.
std::pair<double, double> sides(int version, const std::string& body, const Overrides<double>& numbers = {}) {
  std::string text = kHead + body;
  text[text.find('1')] = static_cast<char>('0' + version);
  const mtf::io::ConfigResult result = mtf::io::parse_config(text, "s.toml", sensor_tables());
  EXPECT_TRUE(result.ok()) << text;
  EXPECT_TRUE(mtf::io::write_config(result.config).starts_with("schema = " + std::to_string(version)));
  const Pixel<double> pixel =
      pixel_numbers(result.config.system, sensor_settings(result.config.tables), numbers, {.middle = 1.0});
  return {pixel.width_um, pixel.height_um};
}

// A footprint with a width alone is a square; a detector is one in files of version 2.
TEST(DetectorSize, AWidthAloneIsASquareFromVersionTwoOn) {
  const std::array list{Override<double>{"detector.width", 12.0}};
  const Overrides<double> narrower(list);
  using Sides = std::pair<double, double>;
  for (const std::string& kind : {std::string("[detector]\n"), kThermal}) {
    EXPECT_EQ(sides(1, kind), Sides(17.0, 17.0));
    EXPECT_EQ(sides(2, kind), Sides(17.0, 17.0));
    EXPECT_EQ(sides(1, kind + "width = \"14 um\"\n"), Sides(14.0, 17.0));
    EXPECT_EQ(sides(2, kind + "width = \"14 um\"\n"), Sides(14.0, 14.0));
    EXPECT_EQ(sides(2, kind + "width = \"14 um\"\nheight = \"16 um\"\n"), Sides(14.0, 16.0));
    EXPECT_EQ(sides(2, kind + "width = \"14 um\"\n", narrower), Sides(12.0, 12.0));  // a study moves both
    EXPECT_EQ(sides(1, kind + "width = \"14 um\"\n", narrower), Sides(12.0, 17.0));
    EXPECT_EQ(sides(1, kind + "height = \"14 um\"\n"), Sides(17.0, 14.0));
    expect_says(message_of<mtf::UsageError>([&] { sides(2, kind + "height = \"14 um\"\n"); }),
                {"detector.height", "width"});
  }
}

TEST(ThermalSettings, are_read_in_volts) {
  const mtf::io::ConfigResult result =
      parse(kThermal +
            "[nonuniformity]\ndsnu = \"2 mV\"\n[noise]\nseed = 3\ncolumn = \"5 uV\"\n[noise_3d]\ntvh = \"1 uV\"\n" +
            "[adc]\nbits = 16\nvolts_per_count = \"50 uV\"\n");
  ASSERT_TRUE(result.ok()) << result.diagnostics.front().text;
  const SensorSettings settings = sensor_settings(result.config.tables);
  ASSERT_TRUE(settings.thermal && settings.detector);
  EXPECT_EQ(settings.thermal->netd_k, 0.05);
  EXPECT_EQ(settings.thermal->netd_of, NetdOf::focal_plane);
  EXPECT_EQ(settings.detector->quantum_efficiency.number, 0.8);
  EXPECT_EQ(settings.nonuniformity->dsnu_e, 2e-3);
  EXPECT_EQ(settings.noise->column_e, 5e-6);
  EXPECT_EQ(settings.noise_3d->tvh, 1e-6);
  EXPECT_EQ(settings.adc->electrons_per_count, 50e-6);
  const std::string text = mtf::io::write_config(result.config);
  expect_says(text, {"volts_per_count = \"5e-05 V\""});
  const mtf::io::ConfigResult again = mtf::io::parse_config(text, "s.toml", sensor_tables());
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(again.config.tables == result.config.tables);
}

TEST(ThermalSettings, a_wrong_unit_is_an_error_that_says_so) {
  expect_error(kThermal + "[nonuniformity]\ndsnu = \"200 e-\"\n",
               {"nonuniformity.dsnu: \"200 e-\"", "voltage", "\"2 mV\""});
  expect_error("[detector]\nquantum_efficiency = 0.7\n[nonuniformity]\ndsnu = \"2 mV\"\n",
               {"nonuniformity.dsnu: \"2 mV\"", "does not fit", "charge"});
  expect_error(kThermal + "[adc]\nbits = 14\nvolts_per_count = \"5 e-\"\n",
               {"adc.volts_per_count: \"5 e-\"", "does not fit"});
}

TEST(ThermalSettings, keys_of_photon_detectors_name_what_to_write) {
  for (const auto& [key, remedy] :
       {std::pair{"quantum_efficiency = 0.7", "write absorptance"},
        std::pair{"full_well = \"1 Me-\"", "volts_per_count"},
        std::pair{"dark_current = \"1 e-/s\"", "netd, nep, dstar"}, std::pair{"read_noise = \"1 e-\"", "readout_noise"},
        std::pair{"reset_noise = \"1 e-\"", "readout_noise"}, std::pair{"other_noise = \"1 e-\"", "readout_noise"},
        std::pair{"capacitance = \"1 fF\"", "heat_capacity"}}) {
    const std::string error = first_error(kThermal + key + "\n");
    expect_says(error, {"a thermal detector", remedy});
    EXPECT_FALSE(says(error, "unknown key")) << error;
  }
  expect_error(kThermal + "[noise]\nshot = false\n", {"noise.shot:", "thermal detector"});
  expect_error(kThermal + "[adc]\nbits = 14\nelectrons_per_count = \"3 e-\"\nvolts_per_count = \"1 uV\"\n",
               {"adc.electrons_per_count:", "in volts", "write volts_per_count"});
  expect_error(kThermal + "[adc]\nbits = 14\n", {"adc.volts_per_count: missing"});
  // And the other way round.
  expect_error("[detector]\nabsorptance = 0.8\n", {"detector.absorptance: unknown key in [detector]"});
  EXPECT_EQ(first_error("[detector]\nkind = \"photon\"\nquantum_efficiency = 0.7\n"), "");
}

TEST(ThermalSettings, flat_frames_are_those_of_blackbodies) {
  const mtf::io::ConfigResult result =
      parse(kThermal + "[correction]\ncold = \"10 degC\"\nhot = \"40 degC\"\nframes = 8\n");
  ASSERT_TRUE(result.ok()) << result.diagnostics.front().text;
  const CorrectionSettings correction = *sensor_settings(result.config.tables).correction;
  EXPECT_EQ(correction.cold_k, 283.15);
  EXPECT_EQ(correction.hot_k, 313.15);
  EXPECT_EQ(correction.frames, 8);
  expect_error(kThermal + "[correction]\nlow = 0.2\n", {"correction.low:", "full well"});
  expect_error(kThermal + "[correction]\nhigh = 0.2\n", {"correction.high:", "full well"});
  expect_error("[detector]\nquantum_efficiency = 0.7\n[correction]\ncold = \"10 degC\"\n",
               {"correction.cold: unknown key in [correction]"});
}

TEST(ThermalSettings, counts_for_a_kelvin_stand_for_responsivity_and_converter) {
  const std::string converter = "[adc]\nbits = 14\n";
  std::string by_counts = kThermal;
  by_counts = replaced(by_counts, "responsivity = 1e5", "counts_per_kelvin = 30.0");
  const mtf::io::ConfigResult result = parse(by_counts + converter);
  ASSERT_TRUE(result.ok()) << result.diagnostics.front().text;
  EXPECT_EQ(sensor_settings(result.config.tables).adc->electrons_per_count, 1e-6);
  expect_error(by_counts, {"detector.counts_per_kelvin:", "without [adc]"});
  expect_error(by_counts + converter + "volts_per_count = \"1 uV\"\n",
               {"detector.counts_per_kelvin: given beside adc.volts_per_count"});
}

TEST(ThermalSettings, frame_rates_take_the_place_of_bandwidths) {
  const std::string rate = kThermal + "netd_frame_rate = \"60 Hz\"\n";
  const mtf::io::ConfigResult result = mtf::io::parse_config(
      "schema = 1\n[frame]\nfocal_length = \"18 mm\"\npitch = \"17 um\"\nframe_time = \"40 ms\"\n" +
          kHead.substr(kHead.find("[optics]")) + rate,
      "s.toml", sensor_tables());
  ASSERT_TRUE(result.ok()) << result.diagnostics.front().text;
  const ThermalSettings thermal = *sensor_settings(result.config.tables).thermal;
  EXPECT_EQ(thermal.netd_bandwidth_hz, 30.0);
  EXPECT_EQ(thermal.bandwidth_hz, 12.5);
  expect_error(rate, {"frame.frame_time: missing; detector.netd_frame_rate"});
  expect_error(rate + "netd_bandwidth = \"30 Hz\"\n", {"detector.netd_frame_rate: given beside netd_bandwidth"});
  expect_error(rate + "noise_bandwidth = \"30 Hz\"\n", {"detector.netd_frame_rate: given beside noise_bandwidth"});
}

TEST(ThermalSettings, lag_takes_the_time_constant_of_the_pixel) {
  const std::string physics =
      "[detector]\nkind = \"thermal\"\nnoise_bandwidth = \"8 kHz\"\nheat_capacity = 3e-10\nconductance = 3e-8\n"
      "temperature = \"300 K\"\nresistance = 1e5\ntcr = -0.02\nbias = \"2 V\"\n";
  const auto lag_s = [](const std::string& body) {
    const mtf::io::ConfigResult result = parse(body);
    EXPECT_TRUE(result.ok()) << result.diagnostics.front().text;
    return sensor_settings(result.config.tables).lag->time_constant_s;
  };
  EXPECT_NEAR(lag_s(physics + "[lag]\n"), 10e-3, 1e-17);
  EXPECT_EQ(lag_s(kThermal + "[lag]\ntime_constant = \"8 ms\"\n"), 8e-3);
  expect_refused({"lag.time_constant", "0.01 s; remove it"},
                 [&] { lag_s(physics + "[lag]\ntime_constant = \"8 ms\"\n"); });
  expect_refused({"[lag]: time_constant is missing"}, [&] { lag_s(kThermal + "[lag]\n"); });
  expect_error("[detector]\nquantum_efficiency = 0.7\n[lag]\n", {"lag.time_constant: missing"});
}

}  // namespace
}  // namespace radiometry
