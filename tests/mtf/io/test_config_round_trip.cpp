// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "mtf/components/curve.h"
#include "mtf/components/gaussian.h"
#include "mtf/io/config/config.h"
#include "mtf/io/config/round_trip.h"
#include "mtf/otf/same_list.h"
#include "tests/expect_error.h"
#include "tests/mtf/conformance.h"

namespace mtf::io {
namespace {

// A sensor file with the curve file of the examples beside it; the folder goes away at the end.
struct Folder {
  std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / ("mtfkit_config_" + std::to_string(::getpid()));
  Folder() {
    std::filesystem::create_directories(path);
    std::ofstream(path / "lens.csv") << "frequency_cy_mm,mtf\n0,1\n20,0.7\n40,0.35\n60,0\n";
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

std::string sensor_path() {
  static const Folder folder;
  return (folder.path / "s.toml").string();
}

void expect_same(const SensorConfig& a, const SensorConfig& b, const std::string& text) {
  const System<double>&s = a.system, &t = b.system;
  EXPECT_EQ(s.name, t.name);
  EXPECT_TRUE(same_bits(s.frame.focal_length_mm, t.frame.focal_length_mm)) << text;
  EXPECT_TRUE(same_bits(s.frame.pitch_x_um, t.frame.pitch_x_um)) << text;
  EXPECT_TRUE(same_bits(s.frame.pitch_y_um, t.frame.pitch_y_um)) << text;
  EXPECT_TRUE(same_bits(s.frame.integration_time_s, t.frame.integration_time_s)) << text;
  EXPECT_EQ(s.frame.columns, t.frame.columns);
  EXPECT_EQ(s.frame.rows, t.frame.rows);
  EXPECT_TRUE(same_bits(s.optics.f_number, t.optics.f_number)) << text;
  EXPECT_TRUE(same_bits(s.optics.aperture_mm, t.optics.aperture_mm)) << text;
  EXPECT_TRUE(same_bits(s.optics.obscuration, t.optics.obscuration)) << text;
  EXPECT_TRUE(same_bits(s.optics.wavelength_um, t.optics.wavelength_um)) << text;
  ASSERT_EQ(s.band.has_value(), t.band.has_value()) << text;
  if (s.band) {
    EXPECT_TRUE(same_bits(s.band->lo_um, t.band->lo_um) && same_bits(s.band->hi_um, t.band->hi_um)) << text;
  }
  for (const Stage stage : kStages) {
    ASSERT_EQ(s.list(stage).size(), t.list(stage).size()) << text;
    for (std::size_t i = 0; i < s.list(stage).size(); ++i) {
      const auto &x = s.list(stage)[i], &y = t.list(stage)[i];
      EXPECT_EQ(x.label, y.label) << text;
      ASSERT_EQ(x.component.kind(), y.component.kind()) << text;
      const auto f = x.component.fields(), g = y.component.fields();
      for (std::size_t k = 0; k < f.size(); ++k)
        std::visit(
            [&](const auto* u) {
              const auto* v = std::get<std::remove_cvref_t<decltype(*u)>*>(g[k].value);
              EXPECT_TRUE(same_bits(*u, *v)) << x.label << "." << f[k].info->name << "\n" << text;
            },
            f[k].value);
    }
  }
  EXPECT_TRUE(same_bits(a.scene.sample_x_um, b.scene.sample_x_um) &&
              same_bits(a.scene.sample_y_um, b.scene.sample_y_um))
      << text;
  EXPECT_EQ(a.scene.quantity, b.scene.quantity);
  EXPECT_TRUE(same_bits(a.scene.gain, b.scene.gain) && same_bits(a.scene.offset, b.scene.offset)) << text;
  EXPECT_EQ(a.scene.encoding ? a.scene.encoding->name : "", b.scene.encoding ? b.scene.encoding->name : "") << text;
  EXPECT_EQ(a.scene.border, b.scene.border);
  EXPECT_TRUE(same_bits(a.scene.border_value, b.scene.border_value)) << text;
  EXPECT_EQ(a.scene.aperture, b.scene.aperture);
  EXPECT_TRUE(same_bits(a.scene.aperture_size, b.scene.aperture_size)) << text;
  EXPECT_TRUE(same_bits(a.scene.aperture_curve, b.scene.aperture_curve)) << text;
  EXPECT_TRUE(same_bits(a.scene.aperture_gain_limit, b.scene.aperture_gain_limit)) << text;
  ASSERT_EQ(a.fits.size(), b.fits.size()) << text;
  for (std::size_t i = 0; i < a.fits.size(); ++i) {
    const FitSpec &f = a.fits[i], &g = b.fits[i];
    EXPECT_EQ(f.path, g.path);
    EXPECT_EQ(f.fit, g.fit);
    EXPECT_TRUE(same_bits(f.min, g.min) && same_bits(f.max, g.max) && same_bits(f.stderr_value, g.stderr_value))
        << text;
    EXPECT_EQ(f.prior, g.prior) << text;
  }
}

std::string first_error(const ConfigResult& result) {
  for (const auto& d : result.diagnostics)
    if (d.error) return format_diagnostic(d, "");
  return "";
}

/// Written text read again gives the same; writing that again gives the same text.
void expect_round_trip(const SensorConfig& config) {
  const std::string text = write_config(config);
  const ConfigResult again = parse_config(text, config.file);
  ASSERT_TRUE(again.ok()) << first_error(again) << "\n" << text;
  expect_same(config, again.config, text);
  EXPECT_EQ(write_config(again.config), text);
}

const std::string kHead =
    "schema = 1\nname = \"a \\\"b\\\" \\\\ \\u0007 µ\"\n[frame]\nfocal_length = \"0.1 m\"\npitch = \"0.015 mm\"\n"
    "format = [64, 51]\nintegration_time = \"10 ms\"\n[optics]\naperture = \"5 cm\"\n[band]\n"
    "wavelength = [\"3400 nm\", \"4.8 um\"]\n";

/// Whether a field says how time becomes place, and so wants a cutoff in time.
bool is_scan(const FieldInfo& info) {
  return info.dimension == Dimension::velocity || info.dimension == Dimension::rate ||
         info.dimension == Dimension::temporal;
}

std::string example_line(const FieldInfo& info, bool scanned) {
  const bool in_time = scanned && info.dimension == Dimension::cutoff;
  return std::string(info.name) + " = " + (in_time ? "\"400 kHz\"" : std::string(info.example)) + "\n";
}

// Every field of every kind gets into a file that is accepted, alone beside the required ones and all together.
TEST(ConfigRoundTrip, EveryFieldOfEveryKind) {
  for (const std::string_view kind : component_kinds()) {
    const Component<double> component = Component<double>::make(kind);
    const std::string stage(component.stages().presample ? "presample"
                            : component.stages().readout ? "readout"
                                                         : "postsample");
    const auto fields = component.fields();
    std::vector<bool> accepted(fields.size());
    for (std::size_t chosen = 0; chosen <= fields.size(); ++chosen) {
      std::string text = kHead + "[[" + stage + "]]\nkind = \"" + std::string(kind) + "\"\n";
      std::vector<std::size_t> written;
      for (std::size_t i = 0; i < fields.size(); ++i) {
        const FieldInfo& info = *fields[i].info;
        if (info.presence != Presence::required && i != chosen && chosen != fields.size()) continue;
        text += example_line(info, chosen < fields.size() && is_scan(*fields[chosen].info));
        written.push_back(i);
      }
      const ConfigResult result = parse_config(text, sensor_path());
      if (!result.ok()) continue;  // fields that exclude each other
      for (const std::size_t i : written) accepted[i] = true;
      expect_round_trip(result.config);
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      // A field that only qualifies others (a direction, a wind) is accepted together with up to three of them.
      const std::size_t n = fields.size();
      for (std::size_t others = 0; others < n * n * n && !accepted[i]; ++others) {
        const std::size_t a = others % n, b = others / n % n, c = others / (n * n);
        if (a < b || b < c) continue;
        std::string text = kHead + "[[" + stage + "]]\nkind = \"" + std::string(kind) + "\"\n";
        for (std::size_t k = 0; k < n; ++k)
          if (k == i || k == a || k == b || k == c || fields[k].info->presence == Presence::required)
            text += example_line(*fields[k].info, is_scan(*fields[i].info));
        const ConfigResult result = parse_config(text, sensor_path());
        if (!result.ok()) continue;
        accepted[i] = true;
        expect_round_trip(result.config);
      }
      EXPECT_TRUE(accepted[i]) << kind << "." << fields[i].info->name << " is never accepted";
    }
  }
}

TEST(ConfigRoundTrip, EveryConformanceCase) {
  std::size_t tried = 0;
  for (const test::Case& c : test::conformance_cases()) {
    const Component<double>& component = test::only_component(c.system);
    Component<double> read = Component<double>::make(component.kind());
    ++tried;
    EXPECT_EQ(round_trip(component.kind(), component.fields(), read.fields()), "") << c.name;
  }
  EXPECT_GE(tried, 3000u);
}

enum class Table { right, same_name_twice, name_of_the_kind };

/// A blur with two fields, not in the list of components.
template <class S, Table table>
struct Blur : Gaussian<S> {
  S share{};

  static constexpr auto fields() {
    constexpr std::string_view name = table == Table::right             ? "share"
                                      : table == Table::same_name_twice ? "sigma"
                                                                        : "kind";
    return std::tuple_cat(Gaussian<S>::fields(),
                          std::tuple{Field{&Blur::share, FieldInfo{.name = name, .hi = 1.0, .example = "0.5"}}});
  }
};
template <class S>
using Right = Blur<S, Table::right>;
template <class S>
using SameNameTwice = Blur<S, Table::same_name_twice>;
template <class S>
using NameOfTheKind = Blur<S, Table::name_of_the_kind>;

TEST(ConfigRoundTrip, TablesOfAnOwnComponent) {
  const conformance::Outcome right = check_round_trip<Right>();
  EXPECT_EQ(conformance::describe_failures({right}), "");
  EXPECT_GE(right.compared, 10u);
  EXPECT_EQ(check_round_trip<SameNameTwice>().failed, right.compared);
  EXPECT_EQ(check_round_trip<NameOfTheKind>().failed, right.compared);
}

TEST(ConfigRoundTrip, SceneFormsAndUnits) {
  for (const std::string scene :
       {"sample = \"3.75 um\"", "sample_x = \"3.1 um\"\nsample_y = \"0.0029 mm\"", "ifov = \"37.5 urad\"",
        "gsd = \"0.19 m\"\nrange = \"5 km\"",
        "gain = 0.1\noffset = -7\nquantity = \"counts\"\nencoding = \"gamma:2.2\"",
        "border = \"constant\"\nborder_value = 0.3", "aperture = \"box\"",
        "aperture = \"box\"\naperture_size = \"0.25 px\"",
        "aperture = \"gaussian\"\naperture_size_x = \"1 arcsec\"\naperture_size_y = \"2 um\"\naperture_gain_limit = 5",
        "aperture = \"curve\"\naperture_file = \"lens.csv\""}) {
    const ConfigResult result = parse_config(kHead + "[scene]\n" + scene + "\n", sensor_path());
    ASSERT_TRUE(result.ok()) << scene << first_error(result);
    expect_round_trip(result.config);
  }
}

TEST(ConfigRoundTrip, ResolvedValues) {
  const ConfigResult result = parse_config(kHead + "[scene]\ngsd = \"0.1 m\"\nrange = \"2 km\"\n", sensor_path());
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result.config.system.frame.focal_length_mm, 100.0);
  EXPECT_EQ(result.config.system.frame.pitch_y_um, 15.0);
  EXPECT_EQ(result.config.system.frame.integration_time_s, 0.01);
  EXPECT_EQ(result.config.system.optics.aperture_mm, 50.0);
  EXPECT_DOUBLE_EQ(result.config.scene.sample_x_um.value(), 5.0);  // 50 urad x 100 mm
  EXPECT_EQ(result.config.system.band->lo_um, 3.4);
  EXPECT_EQ(result.config.system.name, "a \"b\" \\ \a \xC2\xB5");
}

TEST(ConfigRoundTrip, CutoffsInTimeKeepTheirUnit) {
  const std::string filters =
      "[[presample]]\nkind = \"rc_highpass\"\ncutoff = \"80 Hz\"\nscan_rate = \"20 rad/s\"\ndc = \"remove\"\n"
      "[[readout]]\nkind = \"butterworth\"\npoles = 3\npixel_clock = \"10 MHz\"\n"
      "cutoff = { value = \"4 MHz\", fit = true, min = \"300 kHz\", max = \"0.01 GHz\", stderr = \"5 kHz\" }\n";
  const ConfigResult result = parse_config(kHead + filters, sensor_path());
  ASSERT_TRUE(result.ok()) << first_error(result);
  expect_round_trip(result.config);
  const std::string text = write_config(result.config);
  expect_says(text, {"cutoff = \"80 Hz\"", "value = \"4 MHz\"", "min = \"0.3 MHz\"", "max = \"10 MHz\"",
                     "pixel_clock = \"1e+07 Hz\"", "dc = \"remove\""});
  // 80 Hz at 20 rad/s x 100 mm; 0.4 cycles/pixel at 15 um.
  const std::string explained = explain_config(result.config);
  expect_says(explained, {"\"80 Hz\"", "0.04 cy/mm", "26.66666667 cy/mm", "10000000 Hz"});
}

TEST(ConfigRoundTrip, FitTables) {
  const ConfigResult result = parse_config(
      "schema = 1\n[frame]\nfocal_length = { value = \"0.1 m\", fit = true, min = \"90 mm\", max = \"11 cm\" }\n"
      "integration_time = { value = \"0 s\", fit = false }\npitch "
      "= \"15 um\"\n"
      "[[presample]]\nkind = \"jitter\"\nrms_x = { value = \"8 urad\", fit = true, min = \"0 urad\", max = \"0.05 "
      "mrad\", "
      "prior = { mean = \"7 urad\", sd = \"1 urad\" }, stderr = \"0.3 urad\" }\n"
      "rms_y = { value = \"1 um\", interval = [\"0 m\", \"3.92 um\"] }\n"
      "[[readout]]\nkind = \"rc_lowpass\"\ncutoff = { value = \"0.6 cy/px\", fit = false, min = \"0.1 cy/px\" }\n",
      sensor_path());
  ASSERT_TRUE(result.ok()) << first_error(result);
  ASSERT_EQ(result.config.fits.size(), 5u);
  EXPECT_EQ(result.config.fits[3].interval, (std::array<double, 2>{0.0, 3.92}));
  EXPECT_DOUBLE_EQ(result.config.fits[3].sd(), 1.0);
  EXPECT_EQ(result.config.fits[0].path, "frame.focal_length");
  EXPECT_DOUBLE_EQ(result.config.fits[0].max.value(), 110.0);
  EXPECT_EQ(result.config.fits[2].path, "presample[0].rms_x");
  EXPECT_DOUBLE_EQ(result.config.fits[2].max.value(), 50.0);
  EXPECT_EQ(result.config.fits[2].prior, (std::array<double, 2>{7.0, 1.0}));
  EXPECT_EQ(result.config.fits[2].stderr_value, 0.3);
  EXPECT_FALSE(result.config.fits[3].fit);
  expect_round_trip(result.config);
}

TEST(ConfigRoundTrip, Labels) {
  const auto labels = [](const SensorConfig& config) {
    std::vector<std::string> all;
    for (const auto& entry : config.system.list(Stage::presample)) all.push_back(entry.label);
    return all;
  };
  const std::string jitter = "[[presample]]\nkind = \"jitter\"\nrms = \"1 um\"\n";
  const ConfigResult result = parse_config(
      kHead + jitter + jitter + "label = \"mount\"\n" + jitter + "label = \"jitter\"\n" + jitter, sensor_path());
  ASSERT_TRUE(result.ok()) << first_error(result);
  EXPECT_EQ(labels(result.config), (std::vector<std::string>{"jitter_2", "mount", "jitter", "jitter_3"}));
  expect_round_trip(result.config);
}

TEST(ConfigRoundTrip, CurveFilesFollowTheDestination) {
  const ConfigResult result =
      parse_config(kHead + "[[presample]]\nkind = \"curve\"\nfile = \"./lens.csv\"\n", sensor_path());
  ASSERT_TRUE(result.ok()) << first_error(result);
  expect_says(write_config(result.config), {"file = \"lens.csv\""});
  const std::string elsewhere = write_config(result.config, "/nowhere/fitted.toml");
  EXPECT_TRUE(parse_config(elsewhere, "/nowhere/fitted.toml").ok()) << elsewhere;
}

TEST(ConfigRoundTrip, CurvesInLinesStayInLines) {
  const std::string lines = "file = \"\"\"\nfrequency_cy_px,mtf\n0,1\n0.1,0.7\n0.3333333333333333,-0.125\n\"\"\"\n";
  const ConfigResult result =
      parse_config(kHead + "[[presample]]\nkind = \"curve\"\n" + lines + "axis = \"x\"\n", sensor_path());
  ASSERT_TRUE(result.ok()) << first_error(result);
  const auto& component = result.config.system.list(Stage::presample).back().component;
  ASSERT_NE(component.get_if<CurveOtf<double>>(), nullptr);
  const Curve& curve = *component.get_if<CurveOtf<double>>()->curve.curves.front();
  EXPECT_EQ(curve.frequency, (std::vector<double>{0.0, 0.1, 0.3333333333333333}));
  EXPECT_EQ(curve.value, (std::vector<double>{1.0, 0.7, -0.125}));
  EXPECT_EQ(curve.unit->name, "cy/px");
  const std::string elsewhere = write_config(result.config, "/nowhere/fitted.toml");
  expect_says(elsewhere, {lines});
  expect_round_trip(result.config);
}

double random_double(std::mt19937_64& random, double lo, double hi) {
  std::uniform_real_distribution<double> flat(0.0, 1.0);
  // Half of them spread over the magnitudes, with all bits of the mantissa.
  const double value = random() % 2 ? lo + (hi - lo) * flat(random) : hi * std::exp2(-36.0 * flat(random));
  return value > lo && value < hi ? value : 0.5 * (lo + hi);
}

TEST(ConfigRoundTrip, RandomDoubles) {
  std::mt19937_64 random(20240301);
  const auto draw = [&](double lo, double hi) { return random_double(random, lo, hi); };
  const std::vector<std::string_view> extents{"nm", "um", "mm", "in", "nrad", "urad", "deg", "arcmin", "px"};
  const auto unit = [&](const std::vector<std::string_view>& names) {
    return find_unit(names[random() % names.size()]);
  };
  for (int round = 0; round < 300; ++round) {
    SensorConfig config;
    config.file = sensor_path();
    System<double>& system = config.system;
    system.frame = {draw(0.0, 1e7), draw(0.0, 1e6), draw(0.0, 1e6), draw(0.0, 1e9), 3, 4};
    system.optics = {.f_number = draw(0.1, 1e4), .aperture_mm = {}, .obscuration = draw(0.0, 1.0), .wavelength_um = {}};
    const double lo = draw(0.01, 1e4);
    system.band = Band{lo, lo * 1.5};
    config.scene.sample_x_um = draw(0.0, 1e6);
    config.scene.sample_y_um = draw(0.0, 1e6);
    config.scene.gain = draw(-1e300, 1e300);
    config.scene.offset = 12345678901234567168.0;
    config.scene.border = Border::constant;
    config.scene.border_value = -draw(0.0, 1e300);
    for (const std::string_view kind : component_kinds()) {
      // Not those whose fields exclude each other or whose random values are refused.
      if (kind == "linear_motion" || kind == "curve" || kind == "rms_wavefront" || kind == "bolometer" ||
          kind == "turbulence" || kind == "random_wavefront" || kind == "accelerated_motion" || kind == "aerosol" ||
          kind == "vibration" || kind == "unsharp" || kind == "interpolation" || kind == "display_flat_panel" ||
          kind == "eye")
        continue;
      Component<double> component = Component<double>::make(kind);
      if (component.is_pupil() && kind != (round % 2 == 0 ? "diffraction" : "wavefront")) continue;
      for (auto& field : component.fields()) {
        const FieldInfo& info = *field.info;
        if (info.name == "fill_factor" || info.name == "wavelength_reference") continue;
        if (auto* const* v = std::get_if<std::optional<double>*>(&field.value); v && !is_scan(info))
          **v = info.lo == -10.0                  ? draw(-1.0, 1.0)       // waves: their sum is limited
                : info.name == "vignetting_rim"   ? 1.0 + draw(0.0, 1.0)  // that leaves some of the pupil
                : info.name == "vignetting_shift" ? draw(0.0, 0.5)
                                                  : draw(info.lo, info.hi);
        const bool one_size = kind == "tdi" || kind == "sample_and_hold";  // along one direction
        if (auto* const* v = std::get_if<AxisPair<double>*>(&field.value))
          **v = {{draw(info.lo, info.hi), unit(extents)}, {draw(info.lo, info.hi), unit(extents)}, !one_size};
        if (auto* const* v = std::get_if<SpatialFrequency<double>*>(&field.value))
          **v = {draw(info.lo, info.hi), unit({"cy/mm", "cy/mrad", "cy/px"})};
        if (auto* const* v = std::get_if<int*>(&field.value)) **v = 1 + static_cast<int>(random() % 20);
        if (auto* const* v = std::get_if<Coefficients<double>*>(&field.value))
          **v = {draw(0.0, 0.01), -draw(0.0, 0.01)};
        if (auto* const* v = std::get_if<Taps<double>*>(&field.value))
          **v = info.name == "vertices"
                    ? Taps<double>{{1.0 + draw(0.0, 1e5), 3.0}, {-draw(0.0, 1e6), 5.0}, {0.25, -draw(0.0, 1e6)}}
                : kind == "psf" ? Taps<double>{{draw(0.0, 1e-6), draw(1.0, 1e6), draw(0.0, 1e-6)}}
                                : Taps<double>{{draw(-1e6, 1e6), 3.0, -draw(0.0, 1e6)}};
      }
      const Stages stages = component.stages();
      system.add(stages.presample ? Stage::presample
                 : stages.readout ? Stage::readout
                                  : Stage::postsample,
                 std::move(component));
    }
    expect_round_trip(config);
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace mtf::io
