// SPDX-License-Identifier: Apache-2.0

// Ranges of acquisition: what they hold for, with the air that lies on the way to the target.

#include <map>

#include "apps/sensor/air_course.h"
#include "apps/sensor/sensor_air.h"
#include "apps/study/study_conditions.h"
#include "mtf/metrics/resolution.h"
#include "radiometry/light/blackbody.h"
#include "radiometry/performance/sensor_budget.h"
#include "radiometry/performance/target_at_range.h"
#include "tests/apps/study/evaluated.h"

namespace {

using study_test::Evaluated;
using study_test::evaluated;
using study_test::expect_gradient;
using study_test::Folder;

const std::string kFog = R"([atmosphere]
model = "mid_latitude_summer"
haze = "advection_fog"
visibility = "300 m"
)";
const std::string kConditions = R"([conditions]
contrast = "1 K"
target_size = "2.3 m"
frame_rate = "60 Hz"
magnification = 5.0
)";
const std::array<std::string, 6> kRanges{"johnson_range_detect", "johnson_range_recognise", "johnson_range_identify",
                                         "ttp_range_detect",     "ttp_range_recognise",     "ttp_range_identify"};

/// An MWIR camera at f/2; `air`: tables after the others.
std::string camera(const std::string& air) {
  return R"(schema = 1
[frame]
focal_length = "150 mm"
pitch = "15 um"
integration_time = "5 ms"
format = [640, 512]
[scene]
quantity = "temperature"
emissivity = 0.95
surroundings = "280 K"
[optics]
f_number = 2.0
transmission = 0.85
emissivity = 0.1
temperature = "293 K"
stop_temperature = "77 K"
obscuration = 0.2
[band]
wavelength = ["3.4 um", "4.8 um"]
[detector]
quantum_efficiency = 0.7
full_well = "400 Me-"
dark_current = "1 Me-/s"
read_noise = "300 e-"
[nonuniformity]
prnu = 0.0005
dsnu = "100 e-"
[adc]
bits = 14
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
fill_factor = 0.9
[[presample]]
kind = "jitter"
rms_x = "15 urad"
rms_y = "10 urad"
)" + air;
}

std::string study_of(const std::string& axes, const std::string& conditions = kConditions,
                     const std::string& tolerance = "1e-6", const std::string& metrics = "") {
  std::string list = metrics;
  if (list.empty())
    for (const std::string& name : kRanges) list += (list.empty() ? "\"" : ", \"") + name + "\"";
  return "schema = 1\nname = \"ranges\"\nsensor = \"camera.toml\"\ntolerance = " + tolerance + "\n" + axes +
         "[metrics]\nlist = [" + list + "]\n" + conditions;
}

std::string axis(const std::string& parameter, const std::string& values) {
  return "[[axis]]\nparameter = \"" + parameter + "\"\nvalues = [" + values + "]\n";
}
const std::string kTime = axis("frame.integration_time", R"("5 ms")");

std::map<std::string, double> ranges_of(const Folder& folder, const std::string& text, std::int64_t design = 0) {
  Evaluated e = evaluated(folder, text);
  e.at(design);
  EXPECT_EQ(e.evaluator->last_problem(), "");
  std::map<std::string, double> found{{"error", e["error"]}};
  for (const std::string& name : kRanges) found[name] = e[name];
  return found;
}

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
  faint.replace(faint.find("1 K"), 3, "0.02 K");
  const auto found = ranges_of(folder, study_of(kTime, faint));
  EXPECT_NEAR(found.at("johnson_range_detect") / 6981.5592, 1.0, 5e-6);
  EXPECT_NEAR(found.at("johnson_range_identify") / 872.69487, 1.0, 5e-6);
  EXPECT_EQ(found.at("ttp_range_detect"), 0.0);  // the eye sees nothing of it
}

/// A table of paths that obey Beer's law and radiate as a black scene of 300 K would through what they absorb.
std::string beer_table(double per_km, const std::vector<double>& ranges_m, bool radiates) {
  std::string text = "range_m,wavelength_um,transmission,radiance_W_m-2_sr-1_um-1\n";
  for (const double range : ranges_m)
    for (int i = 0; i <= 160; ++i) {
      const double um = 3.3 + 0.01 * i, tau = std::exp(-1e-3 * per_km * range);
      const double planck = radiometry::planck(radiometry::Flux::watts, um, 300.0);
      text += mtf::format_double(range) + "," + mtf::format_double(um) + "," + mtf::format_double(tau) + "," +
              mtf::format_double(radiates ? (1.0 - tau) * planck : 0.0) + "\n";
    }
  return text;
}

// As much light as without air: the NETD at the aperture stays, and only the contrast falls, as extinction says.
TEST(Ranges, AirThatOnlyDimsIsBeersLaw) {
  const Folder folder;
  const std::string black = "emissivity = 1.0\n";
  const auto with = [&](const std::string& air) {
    std::string text = camera(air);
    return text.replace(text.find("emissivity = 0.95\n"), 18, black);
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
  const auto otf = mtf::ResolutionMeter<double>(needs).measure(system);
  const radiometry::SensorAtRange<double> sensor{
      budget.netd_k * share, budget.spatial_netd_k * share, share, [&](mtf::Axis axis, double f) {
        return (axis == mtf::Axis::x ? otf.curve_x : otf.curve_y).modulus(system.frame.cy_mm_from_mrad(f));
      }};
  const double frame_s = system.frame.integration_time_s;
  if (bars)
    return radiometry::BarObserver<double>(system, c, frame_s)
        .log_visibility(sensor, *c.contrast_k, 1e-3 * cycles * range_m / *c.target_size_m);
  return radiometry::DisplayObserver<double>(system, c, frame_s, radiometry::counted_cy_mrad(system, otf.cutoff_cy_mm))
             .log_cycles(sensor, *c.contrast_k, *c.target_size_m, range_m) -
         std::log(cycles);
}

// The range that a study finds is where the sensor file that ends there offers just what is needed, whatever moves with
// the range: contrast, noise, colours in the band, blur of turbulence and aerosol, the angle of a slant line.
TEST(Ranges, TheSensorFileOfThatRangeOffersJustWhatTheTaskNeeds) {
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
TEST(Ranges, TheErrorHolds) {
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

TEST(Ranges, HaveDerivatives) {
  const Folder folder;
  folder.write("camera.toml", camera("[[presample]]\nkind = \"turbulence\"\ncn2 = 2e-14\n" + kFog +
                                     "temperature = \"294 K\"\nrange = \"1 km\"\n"));
  const std::string list = R"("johnson_range_recognise", "ttp_range_recognise", "ttp")";
  expect_gradient(
      folder,
      study_of(axis("frame.integration_time", R"("5 ms")") + axis("optics.f_number", "2.2") +
                   axis("atmosphere.visibility", R"("1 km")") + axis("atmosphere.temperature", R"("290 K")") +
                   axis("atmosphere.range", R"("1 km")") + axis("presample[3].cn2", "2e-14"),
               kConditions, "1e-8", list),
      0, 2e-5);
  // The magnification follows the focal length where a display says it.
  folder.write("camera.toml", camera(""));
  std::string display = kConditions;
  display.replace(display.find("magnification = 5.0"), 19,
                  "display_height = \"200 mm\"\nviewing_distance = \"600 mm\"");
  expect_gradient(folder,
                  study_of(axis("frame.focal_length", R"("150 mm")") + axis("frame.pitch", R"("15 um")"), display,
                           "1e-8", R"("johnson_range_recognise", "ttp_range_recognise", "mrtd")"),
                  0, 1e-5);
}

TEST(Ranges, DoNotDependOnTheDesignBefore) {
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

/// Why the first metric has no number, before any design or of the first.
std::string reason(const Folder& folder, const std::string& text) {
  Evaluated e = evaluated(folder, text);
  const std::vector<std::string> gaps = e.evaluator->gaps();
  for (std::size_t c = 0; c < e.columns.size(); ++c)
    if (!gaps[c].empty()) return gaps[c];
  e.at(0);
  return e.evaluator->last_refusal() + e.evaluator->last_problem();
}

void expect_reason(const Folder& folder, const std::string& text, const std::vector<std::string>& parts) {
  const std::string why = reason(folder, text);
  for (const std::string& part : parts) EXPECT_NE(why.find(part), std::string::npos) << why << "\nhas no: " << part;
}

TEST(Ranges, AirThatCannotBeFollowedIsRefusedWithTheRemedy) {
  const Folder folder;
  const auto with = [&](const std::string& air) { folder.write("camera.toml", camera(air)); };
  const std::string study = study_of(kTime, kConditions, "1e-4", "\"ttp_range_detect\"");
  with("[path]\ntransmission = 0.8\n");
  expect_reason(folder, study, {"holds for one range", "[atmosphere]", "path.table", "extinction"});
  folder.write("air.csv", beer_table(0.5, {2000.0}, false));
  with("[path]\ntable = \"air.csv\"\nrange = \"1 km\"\n");
  expect_reason(folder, study, {"path.table holds one range", "mtf atmosphere --table"});
  with(
      "[atmosphere]\nmodel = \"tropical\"\nsensor_altitude = \"3 km\"\ntarget_altitude = \"0 m\"\nzenith_angle = \"120 "
      "deg\"\n");
  expect_reason(folder, study, {"zenith_angle", "give range"});
  with("[[presample]]\nkind = \"turbulence\"\nlabel = \"seeing\"\nfried_parameter = \"50 mm\"\n");
  expect_reason(folder, study, {"\"seeing\"", "path of its own", "cn2"});
  const std::string depth = "[atmosphere]\nmodel = \"tropical\"\n";
  std::string by_pixel = camera(depth);
  by_pixel.replace(by_pixel.find("emissivity = 0.95"), 0, "depth_channel = \"Z\"\n");
  folder.write("camera.toml", by_pixel);
  expect_reason(folder, study, {"range of each pixel", "depth_channel"});
}

TEST(Ranges, ATaskThatSucceedsBeyondWhatIsKnownSaysWhereThatEnds) {
  const Folder folder;
  folder.write("air.csv", beer_table(0.05, {500.0, 1000.0, 2000.0}, false));
  folder.write("camera.toml", camera("[path]\ntable = \"air.csv\"\nrange = \"1 km\"\n"));
  Evaluated e = evaluated(folder, study_of(kTime));
  e.at(0);
  EXPECT_TRUE(std::isnan(e["ttp_range_detect"]));
  EXPECT_TRUE(std::isfinite(e["johnson_range_identify"]));  // at Nyquist, 1.9 km
  for (const char* part : {"johnson_range_detect", "still succeeds at 2000 m", "air.csv ends"})
    EXPECT_NE(e.evaluator->last_refusal().find(part), std::string::npos) << e.evaluator->last_refusal();
  EXPECT_EQ(e.evaluator->last_caution(), "limited by the Nyquist frequency in johnson_range_identify");
  // A mast of 10 m sees the ground to 11.3 km: (2 x 6371 km x 10 m)^(1/2), and a little more by refraction.
  folder.write("camera.toml", camera("[atmosphere]\nmodel = \"us_standard_1976\"\nsensor_altitude = \"10 m\"\n"
                                     "target_altitude = \"0 m\"\nrange = \"1 km\"\n"));
  expect_reason(folder, study_of(kTime, kConditions, "1e-4", "\"johnson_range_detect\""),
                {"still succeeds at 12", "the horizon hides the target"});
}

TEST(Ranges, NeedToKnowAtWhichAngleTheObserverSeesThePicture) {
  const Folder folder;
  folder.write("camera.toml", camera(""));
  std::string blind = kConditions;
  blind.replace(blind.find("magnification = 5.0\n"), 20, "");
  Evaluated e =
      evaluated(folder, study_of(kTime, blind, "1e-4", R"("ttp", "ttp_range_detect", "johnson_range_detect")"));
  const auto gaps = e.evaluator->gaps();
  for (std::size_t c = 0; c < e.columns.size(); ++c)
    if (e.columns[c].name.starts_with("ttp")) {
      EXPECT_EQ(gaps[c], "no [conditions] magnification, or display_height and viewing_distance");
    }
  e.at(0);
  EXPECT_TRUE(std::isnan(e["ttp_range_detect"]));
  EXPECT_TRUE(std::isfinite(e["johnson_range_detect"]));  // its observer has no optics
  // 200 mm at 600 mm, 512 rows of 15 um behind 150 mm: (1/3)/(7.68/150) = 6.5104. The picture is 18.92 x 23.54 degrees.
  const auto viewing = radiometry::viewing_of(
      radiometry::Conditions{.display_height_m = 0.2, .viewing_distance_m = 0.6}, e.study->base.system.frame);
  EXPECT_NEAR(viewing.magnification, 6.510416666666667, 1e-12);
  EXPECT_NEAR(viewing.field_deg, std::sqrt(18.924644416051233 * 23.536577864041288), 1e-9);
  const auto display = ranges_of(
      folder, study_of(kTime, blind + "display_height = \"200 mm\"\nviewing_distance = \"600 mm\"\n", "1e-6"));
  const auto given = ranges_of(folder, study_of(kTime, blind + "magnification = 6.510416666666667\n", "1e-6"));
  // The picture of a magnification alone has 10 degrees; in a larger one the eye sees a little more.
  EXPECT_GT(display.at("ttp_range_detect") / given.at("ttp_range_detect"), 1.01);
  EXPECT_LT(display.at("ttp_range_detect") / given.at("ttp_range_detect"), 1.1);
  folder.write("camera.toml", [&] {
    std::string text = camera("");
    return text.replace(text.find("format = [640, 512]\n"), 20, "");
  }());
  expect_reason(folder,
                study_of(kTime, blind + "display_height = \"200 mm\"\nviewing_distance = \"600 mm\"\n", "1e-4",
                         "\"ttp_range_detect\""),
                {"no [frame] format"});
}

TEST(Ranges, ConditionsThatContradictTheSensorOrEachOtherAreErrors) {
  const Folder folder;
  const auto told = [&](const std::string& air, const std::string& more, const std::string& axes = kTime) {
    folder.write("camera.toml", camera(air));
    return folder.lines(study_of(axes, kConditions + more, "1e-4", "\"gsd\""));
  };
  const std::string fog = kFog + "range = \"1 km\"\n";
  const auto expect = [](const std::string& text, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << text << "\nhas no: " << part;
  };
  EXPECT_EQ(told(fog, ""), "");
  EXPECT_EQ(told(fog, "range = \"1000 m\"\n"), "");
  expect(told(fog, "extinction = 0.2\n"),
         {"15:14: error: conditions.extinction", "[atmosphere] of camera.toml", "remove"});
  expect(told("[path]\ntransmission = 0.8\n", "extinction = 0.0\n"),
         {"conditions.extinction", "[path] of camera.toml"});
  expect(told(fog, "range = \"5 km\"\n"), {"conditions.range", "is 5000 m", "1000 m long", "give both the same"});
  EXPECT_EQ(told("[path]\ntransmission = 0.8\n", "range = \"5 km\"\n"), "");
  expect(told(fog, "range = \"1 km\"\n", axis("atmosphere.range", R"("1 km", "2 km")")),
         {"conditions.range", "the study changes the range", "remove it"});
  // From space the air is shorter than the line of sight.
  const std::string down =
      "[atmosphere]\nmodel = \"us_standard_1976\"\nsensor_altitude = \"100 km\"\n"
      "target_altitude = \"0 m\"\nrange = \"100 km\"\n";
  EXPECT_EQ(told(down, "range = \"500 km\"\n"), "");
  expect(told(down, "range = \"50 km\"\n"), {"conditions.range"});
  expect(told("", "display_height = \"0.2 m\"\nviewing_distance = \"0.6 m\"\n"),
         {"conditions.magnification", "remove one"});
  expect(folder.lines(study_of(kTime, "[conditions]\ndisplay_height = \"0.2 m\"\n")),
         {"conditions.display_height", "needs viewing_distance"});
}

// Without [conditions] range the ground sample is that at the end of the air, design by design.
TEST(Ranges, OfTheGroundSampleIsThatOfTheAir) {
  const Folder folder;
  folder.write("camera.toml", camera(kFog + "range = \"1 km\"\n"));
  Evaluated e = evaluated(folder, study_of(axis("atmosphere.range", R"("100 m", "400 m")"), kConditions, "1e-4",
                                           R"("gsd", "niirs_giqe5", "grd")"));
  for (const std::int64_t design : {0, 1}) {
    e.at(design);
    EXPECT_NEAR(e["gsd"], (design == 0 ? 0.01 : 0.04), 1e-12);
  }
  e.at(0);
  EXPECT_TRUE(std::isfinite(e["grd"]));
}

TEST(Ranges, StudiesSayWhoseTheyAre) {
  const Folder folder;
  folder.write("camera.toml", camera(kFog + "range = \"1 km\"\n"));
  const auto lines = [&](const std::string& text) { return study::condition_lines(*evaluated(folder, text).study); };
  const auto all = lines(study_of(kTime));
  ASSERT_EQ(all.size(), 6u);
  EXPECT_EQ(all[0], "observer of bars: signal-to-noise ratio 2.5, eye time 0.1 s, 60 Hz");
  for (const char* part :
       {"barten_short_squared", "34.26 cd/m^2", "magnification 5", "picture of 10 deg", "5 K from dark"})
    EXPECT_NE(all[1].find(part), std::string::npos) << all[1];
  EXPECT_EQ(all[2], "target: 2.3 m, 1 K warmer than its background of 300 K");
  EXPECT_NE(all[3].find("V50 2, 7.5, 13"), std::string::npos) << all[3];
  EXPECT_NE(all[4].find("N50 0.75, 3, 6"), std::string::npos) << all[4];
  EXPECT_EQ(
      all[5],
      "air: [atmosphere] model mid_latitude_summer, haze advection_fog, visibility 300 m, range 1000 m; ranges are "
      "solved with the air up to each of them");
  EXPECT_TRUE(lines(study_of(kTime, kConditions, "1e-4", "\"netd\"")).empty());
  EXPECT_EQ(lines(study_of(kTime, kConditions, "1e-4", "\"mrtd\"")).size(), 2u);  // observer and air
}

}  // namespace
