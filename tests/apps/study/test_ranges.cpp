// SPDX-License-Identifier: Apache-2.0

// Ranges of acquisition: what they hold for, with the air that lies on the way to the target.

#include <map>

#include "apps/sensor/sensor_chain.h"
#include "mtf/metrics/resolution.h"
#include "radiometry/chain/sensor_budget.h"
#include "radiometry/performance/target_at_range.h"
#include "tests/apps/study/evaluated.h"
#include "tests/apps/study/range_camera.h"
#include "tests/replaced.h"

namespace {

using namespace study_test;

void expect_ranges(const std::map<std::string, double>& found, const std::array<double, 6>& right, double relative) {
  for (std::size_t i = 0; i < right.size(); ++i)
    EXPECT_NEAR(found.at(kRanges[i]) / right[i], 1.0, relative) << kRanges[i];
}

// Computed elsewhere: FLIR92 and TR-230 from their papers' formulas, by sums over 4001 wavelengths and 6001 frequencies
// of spectra that `mtf atmosphere --range R` gives at each R; good to 4e-6. Nothing of the length of the file's own air
// is in them.
TEST(Ranges, InFogEndWhereItHidesTheTarget) {
  const Folder folder;
  std::map<std::string, double> before;
  for (const char* range : {"100 m", "2 km"}) {
    folder.write("camera.toml", camera(kFog + "range = \"" + range + "\"\n"));
    const auto found = ranges_of(folder, study_of(kTime));
    expect_ranges(found, {456.97212, 373.44814, 331.39838, 233.17014, 227.53505, 218.56159}, 5e-6);
    EXPECT_LT(found.at("error"), 1e-5);
    if (!before.empty()) {
      EXPECT_EQ(found, before);
    }
    before = found;
  }
}

// The same script without air and with Beer's law; what those models gave before air was followed. Johnson's ranges end
// at Nyquist: 5 cy/mrad x 2300 / N50.
TEST(Ranges, WithoutAirAndInBeersStayWhatTheyAre) {
  const Folder folder;
  folder.write("camera.toml", camera(""));
  expect_ranges(ranges_of(folder, study_of(kTime)),
                {11500.0 / 0.75, 11500.0 / 3.0, 11500.0 / 6.0, 25857.012, 6895.2032, 3978.0019}, 5e-6);
  const auto dim = ranges_of(folder, study_of(kTime, "[conditions]\nextinction = 0.5\n" + kConditions.substr(13)));
  EXPECT_NEAR(dim.at("ttp_range_detect") / 5032.8508, 1.0, 5e-6);
  EXPECT_NEAR(dim.at("ttp_range_recognise") / 2924.6527, 1.0, 5e-6);
  EXPECT_NEAR(dim.at("ttp_range_identify") / 2149.3168, 1.0, 5e-6);
  // 0.02 K: by contrast, below Nyquist.
  std::string faint = kConditions;
  faint = replaced(faint, "1 K", "0.02 K");
  const auto found = ranges_of(folder, study_of(kTime, faint));
  EXPECT_NEAR(found.at("johnson_range_detect") / 6981.5592, 1.0, 5e-6);
  EXPECT_NEAR(found.at("johnson_range_identify") / 872.69487, 1.0, 5e-6);
  EXPECT_EQ(found.at("ttp_range_detect"), 0.0);  // the eye sees nothing of it
}

// As much light as without air: the NETD at the aperture stays, and only the contrast falls, as extinction says.
TEST(Ranges, AirThatOnlyDimsIsBeersLaw) {
  const Folder folder;
  const std::string black = "emissivity = 1.0\n";
  const auto with = [&](const std::string& air) {
    std::string text = camera(air);
    return replaced(text, "emissivity = 0.95\n", black);
  };
  std::vector<double>
      every_100_m;  // between its ranges the radiance of a table is a straight line, which (1 - tau) is not
  for (int i = 1; i <= 90; ++i) every_100_m.push_back(100.0 * i);
  folder.write("air.csv", beer_table(0.5, every_100_m, true));
  folder.write("camera.toml", with("[path]\ntable = \"air.csv\"\nrange = \"2 km\"\n"));
  const auto table = ranges_of(folder, study_of(kTime));
  folder.write("camera.toml", with(""));
  const auto beer = ranges_of(folder, study_of(kTime, "[conditions]\nextinction = 0.5\n" + kConditions.substr(13)));
  for (const std::string& name : kRanges) EXPECT_NEAR(table.at(name) / beer.at(name), 1.0, 1e-5) << name;
  // Of four ranges the radiance is off by up to a tenth; the range of the NETD that follows is, by less than is stated.
  folder.write("air.csv", beer_table(0.5, {500.0, 2000.0, 4000.0, 9000.0}, true));
  folder.write("camera.toml", with("[path]\ntable = \"air.csv\"\nrange = \"2 km\"\n"));
  const auto coarse = ranges_of(folder, study_of(kTime));
  for (const std::string& name : kRanges) {
    EXPECT_LE(std::abs(coarse.at(name) / beer.at(name) - 1.0), coarse.at("error")) << name;
  }
}

/// ln(what the target offers / what the task needs) by the sensor file that ends at that range alone: its budget, its
/// contrast, its OTF.
double margin_at(const Folder& folder, const std::string& text, const radiometry::Conditions& c, double range_m,
                 bool bars, double cycles) {
  folder.write("there.toml", text + "range = \"" + mtf::format_double(range_m) + " m\"\n");
  const auto config = apps::read_sensor_file(folder / "there.toml");
  const apps::LoadedSensor loaded = apps::load_chain(config);
  const mtf::System<double> system = apps::with_electron_rate(config.system, loaded);
  const radiometry::Budget<double> budget = radiometry::budget_of(system, loaded.sensor, c.temperature_k);
  radiometry::Sensor clear = loaded.sensor;
  clear.path = {};
  const double share = budget.signal_per_k / radiometry::budget_of(system, clear, c.temperature_k).signal_per_k;
  mtf::ResolutionNeeds needs;
  needs.curves = true;
  needs.tolerance = 1e-8;
  const auto otf = std::make_shared<const mtf::Resolution<double>>(mtf::ResolutionMeter<double>(needs).measure(system));
  const radiometry::SensorAtRange<double> sensor{budget.netd_k * share, budget.spatial_netd_k * share, share,
                                                 radiometry::seen_otf(otf, system.frame)};
  const double frame_s = system.frame.integration_time_s;
  if (bars)
    return radiometry::BarObserver<double>(system, c, frame_s)
        .log_visibility(sensor, *c.contrast_k, 1e-3 * cycles * range_m / *c.target_size_m);
  return radiometry::DisplayObserver<double>(system, c, frame_s, radiometry::counted_cy_mrad(system, otf->cutoff_cy_mm))
             .log_cycles(sensor, *c.contrast_k, *c.target_size_m, range_m) -
         std::log(cycles);
}

// The range that a study finds is where the sensor file that ends there offers just what is needed, whatever moves with
// the range: contrast, noise, colours in the band, blur of turbulence and aerosol, the angle of a slant line.
TEST(RangesLong, TheSensorFileOfThatRangeOffersJustWhatTheTaskNeeds) {
  const Folder folder;
  const std::string summer = "[atmosphere]\nmodel = \"mid_latitude_summer\"\nhaze = \"rural\"\nvisibility = \"5 km\"\n";
  const std::string turbulence = "[[presample]]\nkind = \"turbulence\"\ncn2 = 2e-14\n";
  const std::string aerosol = "[[presample]]\nkind = \"aerosol\"\nmode = \"blur\"\ncutoff = \"5 cy/mrad\"\n";
  struct Case {
    std::string parts, air, own;
  };
  for (const Case& one : {Case{"", summer, "1 km"}, Case{turbulence, summer, "3 km"}, Case{aerosol, kFog, "300 m"},
                          Case{"", summer + "sensor_altitude = \"3 km\"\ntarget_altitude = \"0 m\"\n", "3.5 km"}}) {
    const std::string text = camera(one.parts + one.air);
    folder.write("camera.toml", text + "range = \"" + one.own + "\"\n");
    Evaluated e = evaluated(folder, study_of(kTime));
    e.at(0);
    ASSERT_EQ(e.evaluator->last_problem(), "");
    const radiometry::Conditions& c = e.study->conditions;
    int checked = 0;
    for (std::size_t i = 0; i < kRanges.size(); ++i) {
      const bool bars = i < 3;
      const double cycles = bars ? std::array{0.75, 3.0, 6.0}[i] : std::array{2.0, 7.5, 13.0}[i - 3];
      const double range = e[kRanges[i]];
      if (!(range > 0.0) || (bars && std::abs(range - 11500.0 / cycles) < 1e-3)) continue;  // nowhere; by Nyquist
      const double here = margin_at(folder, text, c, range, bars, cycles),
                   beyond = margin_at(folder, text, c, 1.01 * range, bars, cycles);
      EXPECT_LT(std::abs(here / (here - beyond)) * 0.01, e["error"]) << kRanges[i] << one.parts << one.air;
      EXPECT_LT(beyond, here);
      ++checked;
    }
    EXPECT_GE(checked, 2) << one.parts << one.air;
    EXPECT_LT(e["error"], 2e-5) << one.parts << one.air;
  }
}

// A study of a loose tolerance is off by no more than it says.
TEST(RangesLong, TheErrorHolds) {
  const Folder folder;
  folder.write("camera.toml",
               camera("[[presample]]\nkind = \"turbulence\"\ncn2 = 2e-14\n" + kFog + "range = \"1 km\"\n"));
  const std::string axes = axis("atmosphere.visibility", R"("300 m", "2 km", "20 km")");
  for (std::int64_t design = 0; design < 3; ++design) {
    const auto tight = ranges_of(folder, study_of(axes, kConditions, "1e-8"), design);
    const auto loose = ranges_of(folder, study_of(axes, kConditions, "1e-2"), design);
    for (const std::string& name : kRanges)
      EXPECT_LE(std::abs(loose.at(name) / tight.at(name) - 1.0), loose.at("error") + tight.at("error"))
          << name << design;
    EXPECT_LT(loose.at("error"), 1e-2);
    EXPECT_LT(tight.at("error"), 1e-6);
  }
}

// By tables of light, by the OTF in their colours, by the air: differences of ranges to 1e-5 over steps of 2 %.
TEST(RangesLong, HaveDerivativesInFog) {
  const Folder folder;
  folder.write("camera.toml", camera("[[presample]]\nkind = \"turbulence\"\ncn2 = 2e-14\n" + kFog +
                                     "temperature = \"294 K\"\nrange = \"1 km\"\n"));
  expect_gradient(folder,
                  study_of(axis("optics.f_number", "2.2") + axis("atmosphere.visibility", R"("1 km")") +
                               axis("presample[3].cn2", "2e-14"),
                           kConditions, "1e-4", R"("johnson_range_recognise", "ttp_range_recognise", "ttp")"),
                  0, 2e-3, 1e-4, 2e-2);
}

// The magnification follows the focal length where a display says it.
TEST(Ranges, HaveDerivatives) {
  const Folder folder;
  folder.write("camera.toml", camera(""));
  std::string display = kConditions;
  display = replaced(display, "magnification = 5.0", "display_height = \"200 mm\"\nviewing_distance = \"600 mm\"");
  expect_gradient(folder,
                  study_of(axis("frame.focal_length", R"("150 mm")") + axis("frame.pitch", R"("15 um")"), display,
                           "1e-8", R"("johnson_range_recognise", "ttp_range_recognise", "mrtd")"),
                  0, 1e-5);
}

TEST(RangesLong, DoNotDependOnTheDesignBefore) {
  const Folder folder;
  folder.write("camera.toml", camera(kFog + "range = \"1 km\"\n"));
  const std::string text =
      study_of(axis("optics.f_number", "2.0, 2.4") + axis("detector.read_noise", R"("300 e-", "600 e-")") +
               axis("atmosphere.visibility", R"("300 m", "400 m")"));
  Evaluated e = evaluated(folder, text);
  std::vector<std::vector<double>> rows;
  for (std::int64_t design = 0; design < 8; ++design) {
    e.at(design);
    rows.push_back(e.row);
  }
  for (const std::int64_t design : {6, 1, 3}) {
    Evaluated fresh = evaluated(folder, text);
    fresh.at(design);
    EXPECT_EQ(fresh.row, rows[static_cast<std::size_t>(design)]) << design;
    e.at(design);
    for (std::size_t c = 0; c < e.row.size(); ++c)
      EXPECT_EQ(e.row[c], rows[static_cast<std::size_t>(design)][c]) << design << e.columns[c].name;
  }
}

}  // namespace
