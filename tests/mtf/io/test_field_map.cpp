// SPDX-License-Identifier: Apache-2.0
// Tables of numbers over the field: between positions against interpolants computed elsewhere and polynomials that have
// to come out exactly, in every unit of positions; what is wrong in a file; in a sensor file.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "mtf/components/jitter.h"
#include "mtf/components/linear_motion.h"
#include "mtf/components/psf.h"
#include "mtf/components/wavefront.h"
#include "mtf/error.h"
#include "mtf/io/config/config.h"
#include "mtf/io/csv/field_map_csv.h"
#include "mtf/io/image_io.h"
#include "mtf/otf/same_list.h"
#include "tests/expect_error.h"

namespace mtf::io {
namespace {

std::string row(std::initializer_list<double> numbers) {
  std::string line;
  for (const double number : numbers) line += (line.empty() ? "" : ",") + format_double(number);
  return line + "\n";
}

std::shared_ptr<const FieldMap> map_of(const std::string& text) { return parse_field_map_csv(text, "c.csv"); }

TEST(FieldMap, InterpolantsComputedElsewhere) {
  // Solved by NumPy from the same definition: |u|^5 and polynomials of degree 3, |u|^3 and degree 1. The coordinates
  // are not scaled there, which the interpolant does not depend on.
  std::string radial = "r,w131\n", wide = "x,y,w131\n", few = wide;
  for (const double r : {0.0, 0.3, 0.5, 0.8, 1.1}) radial += row({r, std::exp(-r * r)});
  const std::vector<std::array<double, 2>> places{{-1, -.8}, {0, -.8}, {1, -.8}, {-1, 0},  {.1, .05}, {1, 0},
                                                  {-1, .8},  {0, .8},  {1, .8},  {.5, .4}, {-.5, .3}, {.4, -.45}};
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [x, y] = places[i];
    wide += row({x, y, std::cos(x + 2.0 * y)});
    if (i < 4) few += row({x, y, std::cos(x + 2.0 * y)});
  }
  const auto along = map_of(radial);
  EXPECT_NEAR(along->at(0, FieldPoint<double>{0.1}), 0.99138138635263, 1e-12);
  EXPECT_NEAR(along->at(0, FieldPoint<double>{1.0}), 0.36644793383149, 1e-12);
  EXPECT_NEAR((*along->column[0].missed)[1], 8.82541184700991e-05, 1e-12);
  const auto map = map_of(wide);
  EXPECT_NEAR(map->at(0, FieldPoint<double>{0.2, 0.1}), 0.90370165431911, 1e-12);
  EXPECT_NEAR(map->at(0, FieldPoint<double>{-0.7, 0.6}), 0.86725768288162, 1e-12);
  EXPECT_NEAR((*map->column[0].missed)[1], 1.93462931467289, 1e-11);
  EXPECT_NEAR(map_of(few)->at(0, FieldPoint<double>{-0.2, -0.5}), 0.32755680337301, 1e-12);
}

TEST(FieldMap, PolynomialsOfTheThirdOrderAreExact) {
  std::string text = "x (mm),y (mm),w131,w222\n";
  const auto coma = [](double x, double y) { return 0.3 + 0.7 * x + x * (x * x + y * y) - 0.2 * y * y; };
  for (int j = -2; j <= 2; ++j)
    for (int i = -2; i <= 2; ++i) text += row({3.0 * i, 2.0 * j, coma(i, j), 1.0 * i * j});
  const auto map = map_of(text);
  for (const double x : {-1.7, 0.3, 1.9})
    for (const double y : {-1.9, 0.1, 1.2}) {
      EXPECT_NEAR(map->at(0, FieldPoint<double>{3.0 * x, 2.0 * y}), coma(x, y), 1e-12);
      EXPECT_NEAR(map->at(1, FieldPoint<double>{3.0 * x, 2.0 * y}), x * y, 1e-12);
    }
  EXPECT_LT((*map->column[0].missed)[1], 1e-12);
  EXPECT_FALSE(map_of("r,w\n0,0\n0.5,0.25\n1,1\n")->column[0].missed);  // a parabola takes all three
  EXPECT_NEAR(map_of("r,w\n0,0\n0.5,0.25\n1,1\n")->at(0, FieldPoint<double>{0.7}), 0.49, 1e-15);
}

TEST(FieldMap, ManyPositions) {
  std::string text = "x,y,w\n", more = text;
  for (int i = 0; i < 2100; ++i) {
    const double x = 0.8 * (2.0 * std::fmod(0.5 + i * 0.7548776662466927, 1.0) - 1.0),
                 y = 0.8 * (2.0 * std::fmod(0.5 + i * 0.5698402909980532, 1.0) - 1.0);
    more += row({x, y, std::cos(3.0 * x + 2.0 * y)});
    if (i < 800) text += row({x, y, std::cos(3.0 * x + 2.0 * y)});
  }
  const auto map = map_of(text);
  EXPECT_NEAR(map->at(0, FieldPoint<double>{0.31, -0.22}), std::cos(0.93 - 0.44), 1e-5);
  EXPECT_LT((*map->column[0].missed)[0], 1e-3);
  expect_refused({"2100 positions, at most 2000", "keep every 2th"}, [&] { map_of(more); });
}

TEST(FieldMap, WhatIsWrongInAFile) {
  const auto refused = [](const std::string& text, std::initializer_list<std::string_view> parts) {
    SCOPED_TRACE(text);
    expect_refused(parts, [&] { map_of(text); });
  };
  refused("r,w131\n0,0\n", {"c.csv: 1 position, at least 2"});
  refused("r,w131\n0,0\n1,\n", {"c.csv:3: \"\" is no finite number"});
  refused("r,w131\n0,0\n1,nan\n", {"c.csv:3: \"nan\""});
  refused("r,w131\n0,0\n1,1\n1,2\n", {"rows 2 and 3 are of one position"});
  refused("r,w131\n0.2,0\n1,1\n", {"begins at r = 0.2", "r = 0"});
  refused("r,w131\n-1,0\n0,0\n1,1\n", {"negative", "x and y"});
  refused("x,w131\n0,0\n1,1\n", {"columns x and y, or by r"});
  refused("r,x,w131\n0,0,1\n1,1,2\n", {"columns x and y, or by r"});
  refused("x,y\n0,0\n1,1\n", {"no column with values"});
  refused("x,y (mm),w\n0,0,1\n", {"x and y differ"});
  refused("r (furlong),w\n0,0\n", {"unknown unit"});
  refused("r (Hz),w\n0,0\n", {"positions in Hz"});
  refused("r (deg),w\n0,0\n95,1\n", {"c.csv:3", "90 degrees"});
  refused("r,w,w\n0,0,0\n", {"two columns are called w"});
  refused("x,y,w\n0,-1,1\n0,0,1\n0,1,2\n", {"on one line", "give their distances"});
}

class ConfigFieldMap : public testing::Test {
 protected:
  static std::string sensor(const std::string& body) {
    return "schema = 2\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\nformat = [640, 512]\n[optics]\n"
           "f_number = 2.0\nwavelength = \"4 um\"\n[[presample]]\n" +
           body;
  }
  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return name;
  }
  ConfigResult read(const std::string& body) const { return parse_config(sensor(body), (folder_ / "s.toml").string()); }
  System<double> system(const std::string& body) const {
    const ConfigResult result = read(body);
    EXPECT_TRUE(result.ok()) << format_diagnostic(result.diagnostics.front(), "s.toml");
    return result.config.system;
  }
  void expect_error(const std::string& body, std::initializer_list<std::string_view> parts) const {
    const ConfigResult result = read(body);
    ASSERT_FALSE(result.ok());
    expect_says(format_diagnostic(result.diagnostics.front(), "s.toml"), parts);
    EXPECT_EQ(std::ranges::count_if(result.diagnostics, &Diagnostic::error), 1);
  }
  const Wavefront<double>& lens(const System<double>& system) const {
    return *system.list(Stage::presample)[0].component.get_if<Wavefront<double>>();
  }
  std::filesystem::path folder_ = [] {
    const auto folder = std::filesystem::temp_directory_path() /
                        ("mtfkit_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directory(folder);
    return folder;
  }();
  ~ConfigFieldMap() override { std::filesystem::remove_all(folder_); }
};

TEST_F(ConfigFieldMap, OneNumberOrAllOfAComponent) {
  file("lens.csv", "r,w131,W222,Z4\n0,0,0,0.1\n0.5,0.35,0.25,0.15\n1,0.7,1,0.3\n");
  const System<double> whole =
      system("kind = \"wavefront\"\norientation = \"field\"\nw040 = 0.25\ntable = \"lens.csv\"\n");
  EXPECT_FALSE(whole.is_isoplanatic());
  const System<double> here = whole.at({0.48, 0.36});
  EXPECT_NEAR(*lens(here).w131, 0.42, 1e-14);
  EXPECT_NEAR(*lens(here).w222, 0.36, 1e-14);
  EXPECT_NEAR(lens(here).zernike.at(3), 0.1 + 0.2 * 0.36, 1e-14);
  EXPECT_DOUBLE_EQ(*lens(here).w040, 0.25);
  EXPECT_DOUBLE_EQ(lens(whole).zernike.at(3), 0.1);
  const System<double> single =
      system("kind = \"wavefront\"\norientation = \"field\"\nw131 = { table = \"lens.csv\", 1 = 0.1, x = 0.5 }\n");
  EXPECT_NEAR(*lens(single.at({0.48, 0.36})).w131, 0.42 + 0.1 + 0.24, 1e-14);
  file("coma.csv", "r,c\n0,0\n1,0.7\n");
  const System<double> only =
      system("kind = \"wavefront\"\norientation = \"field\"\nw131 = { table = \"coma.csv\" }\n");
  EXPECT_NEAR(*lens(only.at({0.48, 0.36})).w131, 0.42, 1e-14);
  const System<float> narrow = cast<float>(only);
  EXPECT_NEAR(*narrow.at({0.48F, 0.36F}).list(Stage::presample)[0].component.get_if<Wavefront<float>>()->w131, 0.42,
              1e-6);
}

TEST_F(ConfigFieldMap, UnitsOfPositionsAndOfValues) {
  // Half the diagonal is 6.147 mm; w131 = 0.1 x + 0.2 y, with x and y in mm, whatever the unit.
  const double radius_mm = 7.5e-3 * std::hypot(640.0, 512.0), focal_mm = 100.0;
  const auto table = [&](const std::string& unit, double per_mm, double x0, double y0, bool angle) {
    std::string text = "x " + unit + ",y " + unit + ",w131\n";
    for (const double x : {-5.0, 0.0, 5.0})
      for (const double y : {-4.0, 0.0, 4.0}) {
        const auto place = [&](double mm) { return angle ? std::atan(mm / focal_mm) / kPi * 180.0 : mm * per_mm; };
        text += row({place(x) + x0, place(y) + y0, 0.1 * x + 0.2 * y});
      }
    file("w.csv", text);
    const System<double> s = system("kind = \"wavefront\"\nw131 = { table = \"w.csv\" }\n");
    EXPECT_NEAR(*lens(s.at({0.6, -0.5})).w131, radius_mm * (0.06 - 0.1), 1e-12) << unit;
  };
  table("", 1.0 / radius_mm, 0.0, 0.0, false);
  table("(mm)", 1.0, 0.0, 0.0, false);
  table("(um)", 1000.0, 0.0, 0.0, false);
  table("[px]", 1.0 / 0.015, 320.0, 256.0, false);
  table("(deg)", 0.0, 0.0, 0.0, true);
  file("j.csv", "r (mm),rms (mrad),roll_urad\n0,0.01,300\n7,0.03,400\n");
  const System<double> s = system("kind = \"jitter\"\ntable = \"j.csv\"\n").at({1.0, 0.0});
  const auto* jitter = s.list(Stage::presample)[0].component.get_if<Jitter<double>>();
  EXPECT_NEAR(jitter->rms.x_um(s.frame), 1.0 + 2.0 * radius_mm / 7.0, 1e-12);
  EXPECT_NEAR(*jitter->roll_urad, 300.0 + 100.0 * radius_mm / 7.0, 1e-10);
}

TEST_F(ConfigFieldMap, WritingReadsBackAsTheSame) {
  file("lens.csv", "r,w131,Z4\n0,0,0.1\n0.5,0.35,0.15\n1,0.7,0.3\n");
  const ConfigResult first =
      read("kind = \"wavefront\"\norientation = \"field\"\ntable = \"lens.csv\"\nw131 = { x = 0.25 }\n");
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(first.config.files, std::vector{(folder_ / "lens.csv").string()});
  const std::string text = write_config(first.config);
  expect_says(text, {"w131 = { table = \"lens.csv\", x = 0.25 }", "{ table = \"lens.csv\" }]"});
  const ConfigResult again = parse_config(text, (folder_ / "t.toml").string());
  ASSERT_TRUE(again.ok()) << format_diagnostic(again.diagnostics.front(), "t.toml");
  EXPECT_EQ(again.config.system.field, first.config.system.field);
  EXPECT_EQ(write_config(again.config), text);
}

TEST_F(ConfigFieldMap, WhatTheFileDoesNotTellIsSaid) {
  const auto notes = [&](const std::string& body) {
    std::string text;
    for (const Diagnostic& one : read(body).diagnostics) text += format_diagnostic(one, "") + "\n";
    return text;
  };
  const std::string body = "kind = \"wavefront\"\norientation = \"field\"\ntable = \"lens.csv\"\n";
  file("lens.csv", "r,w131\n0,0\n0.5,0.35\n1,0.7\n");
  expect_says(notes(body), {"warning: presample[0]", "so few positions"});
  file("lens.csv", "r,w131\n0,0\n0.25,0.1\n0.5,0.35\n0.75,0.4\n0.9,0.6\n1,0.7\n");
  expect_says(notes(body), {"warning: presample[0]", "the 6 positions of", "w131 by", "closer together"});
  file("lens.csv", "r,w131\n0,0\n0.25,0.175\n0.5,0.35\n0.75,0.525\n0.9,0.63\n1,0.7\n");
  expect_says(notes(body), {"note: presample[0]: numbers between the 6 positions"});
  expect_says(notes("kind = \"wavefront\"\ntable = \"lens.csv\"\n"), {"kink on the optical axis"});
}

TEST_F(ConfigFieldMap, PointSpreadsAtPositions) {
  // Between two positions the OTF is the mean with linear weights of those there; the second file has another sum.
  const auto spread = [](double sigma, double shift, double sum) {
    Image samples(15, 15);
    for (int j = 0; j < 15; ++j)
      for (int i = 0; i < 15; ++i)
        samples.at(i, j) = static_cast<float>(
            sum * std::exp(-0.5 * (std::pow(i - 7 - shift, 2) + std::pow(j - 7, 2)) / (sigma * sigma)));
    return samples;
  };
  const auto alone = [&](const Image& samples) {
    Psf<double> psf;
    for (int j = 0; j < 15; ++j) psf.samples.emplace_back(samples.view().row(j), samples.view().row(j) + 15);
    psf.step = micrometres(3.0);
    System<double> s = system("kind = \"diffraction\"\n");
    s.stages[0].clear();
    s.add(Stage::presample, psf);
    return s;
  };
  const Image axis = spread(1.0, 0.0, 1.0), corner = spread(1.4, 0.8, 3.0);
  write_exr((folder_ / "axis.exr").string(), {{"Y", axis.view()}}, {});
  write_exr((folder_ / "corner.exr").string(), {{"Y", corner.view()}}, {});
  file("psfs.csv", "# spreads\nfile,r\naxis.exr,0\n# far\ncorner.exr,1\n");
  const std::string body = "kind = \"psf\"\nstep = \"3 um\"\npositions = \"psfs.csv\"\n";
  const System<double> s = system(body);
  EXPECT_FALSE(s.is_isoplanatic());
  const Freq<double> f{40.0, 25.0};
  const Complex<double> a = alone(axis).otf(f), b = alone(corner).otf(f), h = s.at({0.24, -0.32}).otf(f),
                        on_axis = s.otf(f);
  EXPECT_NEAR(h.re, 0.6 * a.re + 0.4 * b.re, 1e-14);
  EXPECT_NEAR(h.im, 0.6 * a.im + 0.4 * b.im, 1e-14);
  EXPECT_NEAR(on_axis.re, a.re, 1e-14);
  const ConfigResult first = read(body);
  EXPECT_EQ(first.config.files.size(), 3U);
  const std::string text = write_config(first.config);
  expect_says(text, {"positions = \"psfs.csv\""});
  EXPECT_EQ(parse_config(text, (folder_ / "t.toml").string()).config.system.field, first.config.system.field);

  expect_error(body + "samples = [[1]]\n", {"presample[0].positions", "together with samples"});
  write_exr((folder_ / "corner.exr").string(), {{"Y", spread(1.0, 0.0, -1.0).view()}}, {});
  expect_error(body, {"corner.exr", "the sum of the samples"});
  write_exr((folder_ / "corner.exr").string(), {{"Y", Image(13, 13).view()}}, {});
  expect_error(body, {"corner.exr: 13x13 samples", "15x15"});
  file("psfs.csv", "r,name\n0,axis.exr\n");
  expect_error(body, {"no column is called file"});
  file("psfs.csv", "r,file\n0,axis.exr\n1,none.exr\n");
  expect_error(body, {"none.exr"});
}

TEST_F(ConfigFieldMap, CurvesAtPositions) {
  // Frequencies and ends of their own; between two positions the MTF is the mean with linear weights.
  file("axis.csv", "frequency_cy_mm,mtf\n0,1\n20,0.8\n50,0.3\n90,0\n");
  file("corner.csv", "frequency_cy_mm,mtf\n0,1\n10,0.7\n30,0.2\n60,0\n");
  file("curves.csv", "file,r\naxis.csv,0\ncorner.csv,1\n");
  const std::string body = "kind = \"curve\"\npositions = \"curves.csv\"\npart = \"optics\"\n";
  const auto alone = [&](const std::string& name, double f) {
    return system("kind = \"curve\"\nfile = \"" + name + "\"\n").otf({0.6 * f, 0.8 * f}).re;
  };
  const System<double> s = system(body);
  EXPECT_FALSE(s.is_isoplanatic());
  for (const double f : {0.0, 12.0, 37.0, 70.0, 100.0}) {
    const double a = alone("axis.csv", f), b = alone("corner.csv", f);
    EXPECT_NEAR(s.otf({0.6 * f, 0.8 * f}).re, a, 1e-15) << f;
    EXPECT_NEAR(s.at({0.24, -0.32}).otf({0.6 * f, 0.8 * f}).re, 0.6 * a + 0.4 * b, 1e-14) << f;
  }
  const Component<double> there = s.at({0.24, -0.32}).list(Stage::presample)[0].component;
  EXPECT_NEAR(there.cutoff_cy_mm(s.context()), 90.0, 1e-12);
  EXPECT_FALSE(there.traits(s.context()).gain);
  const ConfigResult first = read(body);
  EXPECT_EQ(first.config.files.size(), 3U);
  const std::string text = write_config(first.config);
  expect_says(text, {"positions = \"curves.csv\""});
  const System<double> again = parse_config(text, (folder_ / "t.toml").string()).config.system;
  EXPECT_EQ(again.field, first.config.system.field);
  EXPECT_TRUE(same_list(again, first.config.system, Stage::presample));

  const auto straight = [&](const std::string& name, double end) {
    file(name, "frequency_cy_mm,mtf\n0,1\n" + std::to_string(end) + ",0\n");
  };
  straight("a.csv", 100.0), straight("b.csv", 50.0), straight("c.csv", 50.0);
  file("three.csv", "r,file\n0,a.csv\n0.5,b.csv\n1,c.csv\n");
  file("four.csv", "r,file\n0,a.csv\n0.3,b.csv\n0.6,a.csv\n1,b.csv\n");
  const auto notes = [&](const std::string& name) {
    std::string said;
    for (const Diagnostic& one : read("kind = \"curve\"\npositions = \"" + name + "\"\n").diagnostics)
      said += format_diagnostic(one, "") + "\n";
    return said;
  };
  expect_says(notes("three.csv"), {"warning: presample[0]", "so few positions"});
  expect_says(notes("four.csv"), {"warning: presample[0]", "the 4 positions of", "misses the OTF by", "closer"});

  expect_error(body + "file = \"axis.csv\"\n", {"presample[0].positions", "together with file"});
  file("corner.csv", "frequency_cy_px,mtf\n0,1\n0.5,0\n");
  expect_error(body, {"corner.csv: frequencies in cy/px", "one unit"});
  file("curves.csv", "x,y,file\n0,0,axis.csv\n0.5,0,axis.csv\n0,0.5,axis.csv\n");
  expect_error(body, {"presample[0].positions", "curves.csv covers the area", "add positions"});
  std::string many = "r,file\n";
  for (int i = 0; i <= 400; ++i) many += std::to_string(i) + ",axis.csv\n";
  file("curves.csv", many);
  expect_error(body, {"401 curves, at most 400", "keep every 2th"});
  expect_error("kind = \"curve\"\npositions = 3\n", {"presample[0].positions", "CSV file of positions"});
}

TEST_F(ConfigFieldMap, DisplacementsByAnImage) {
  // A zoom of 0.01 about the middle and a turn of 5 mrad, in blocks of 20 x 16 pixels: samples of planes, met exactly.
  const auto save = [&](const char* name, int columns, int rows, double spoilt = 0.0) {
    Image x(columns, rows), y(columns, rows);
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        const double u = (i + 0.5) * 640.0 / columns - 320.0, v = (j + 0.5) * 512.0 / rows - 256.0;
        x.at(i, j) = static_cast<float>(0.01 * u - 0.005 * v), y.at(i, j) = static_cast<float>(0.01 * v + 0.005 * u);
      }
    x.at(3, 2) += static_cast<float>(spoilt);
    write_exr((folder_ / name).string(), {{"x", x.view()}, {"y", y.view()}}, {});
  };
  save("flow.exr", 32, 25);
  const std::string body = "kind = \"flow\"\ndisplacements = \"flow.exr\"\n";
  expect_error(body, {"presample[0].displacements", "32x25 samples", "640x512"});
  save("flow.exr", 40, 32);
  const System<double> image = system(body), terms = system("kind = \"flow\"\nzoom = 0.01\nrotation = \"5 mrad\"\n");
  for (const FieldPoint<double>& q : {FieldPoint<double>{}, {0.3, -0.2}, {-0.7, 0.6}, {0.78, 0.62}})
    EXPECT_NEAR(image.at(q).otf({13.0, -7.0}).re, terms.at(q).otf({13.0, -7.0}).re, 2e-6) << q.x;  // floats of the file
  const ConfigResult first = read(body);
  const std::string text = write_config(first.config);
  expect_says(text, {"displacements = \"flow.exr\""});
  EXPECT_EQ(parse_config(text, (folder_ / "t.toml").string()).config.system.field, first.config.system.field);

  expect_error(body + "shift = \"1 px\"\n", {"presample[0].displacements", "together with shift"});
  save("flow.exr", 40, 32, std::nan(""));
  expect_error(body, {"along x is not finite in column 3, row 2"});
  write_exr((folder_ / "flow.exr").string(), {{"Y", Image(40, 32).view()}}, {});
  expect_error(body, {"no channel x", "channels x and y"});
  save("flow.exr", 20000, 2);
  expect_error(body, {"20000x2 samples", "2 to 2^14 along each axis and 2^25 at most"});
  // The same as planes and interleaved, by another writer (NPY 1.0 by hand).
  const auto npy = [&](const char* shape, bool planes) {
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::string(shape) + "), }";
    header.resize(117, ' ');
    std::ofstream out(folder_ / "flow.npy", std::ios::binary);
    out << std::string("\x93NUMPY\x01\x00", 8) << std::string("\x76\x00", 2) << header << '\n';
    for (int k = 0; k < 40; ++k) {
      const int place = planes ? k % 20 : k / 2, axis = planes ? k / 20 : k % 2;
      const float value = static_cast<float>(axis == 0 ? 0.25 * (place % 5) : -0.5 * (place / 5));
      out.write(reinterpret_cast<const char*>(&value), 4);
    }
  };
  const std::string other = "kind = \"flow\"\ndisplacements = \"flow.npy\"\n";
  for (const bool planes : {true, false}) {
    npy(planes ? "2, 4, 5" : "4, 5, 2", planes);
    const auto shift = [&](double x, double y) {
      const System<double> s = system(other);
      return s.at(s.field_point(x, y)).list(Stage::presample)[0].component.get_if<Flow<double>>()->shift;
    };
    EXPECT_NEAR(shift(128.0 * 1.5, 128.0 * 2.5).x.value, 0.25, 1e-12);  // the middle of a sample
    EXPECT_NEAR(shift(128.0 * 2.75, 128.0 * 0.5).x.value, 0.5625, 1e-12);
    EXPECT_NEAR(shift(0.0, 512.0).y.value, -1.75, 1e-12);  // beyond the last middle
  }
  npy("5, 4", true);
  expect_error(other, {"no two planes"});
}

TEST_F(ConfigFieldMap, WhatCannotBeIsRefused) {
  const std::string lens = "kind = \"wavefront\"\n";
  expect_error(lens + "table = \"none.csv\"\n", {"s.toml:11:9", "presample[0].table", "none.csv"});
  expect_error("kind = \"jitter\"\ntable = \"none.csv\"\n", {"none.csv"});  // rms is not missing besides
  expect_error(lens + "table = 3\n", {"presample[0].table", "CSV file"});
  file("short.csv", "r (mm),w131\n0,0\n5,1\n");
  expect_error(lens + "table = \"short.csv\"\n", {"presample[0].w131", "short.csv covers r = 0 to 5 mm", "r = 6.147"});
  file("narrow.csv", "x,y,w131\n-1,-0.3,0\n1,-0.3,0\n0,1,1\n");
  expect_error(lens + "w131 = { table = \"narrow.csv\" }\n",
               {"presample[0].w131", "x = -1 to 1", "(-0.7809, -0.6247)"});
  file("typo.csv", "r,w113\n0,0\n1,1\n");
  expect_error(lens + "table = \"typo.csv\"\n", {"the column w113 is no number", "w131"});
  file("two.csv", "r,a,b\n0,0,0\n1,1,1\n");
  expect_error(lens + "w131 = { table = \"two.csv\" }\n", {"has no column w131", "a, b"});
  file("bare.csv", "r,rms\n0,0\n1,1\n");
  expect_error("kind = \"jitter\"\ntable = \"bare.csv\"\n", {"has no unit", "rms ("});
  file("unit.csv", "r,w131 (um)\n0,0\n1,1\n");
  expect_error(lens + "table = \"unit.csv\"\n", {"has a unit", "plain number"});
  file("good.csv", "r,w131\n0,0\n1,1\n");
  expect_error(lens + "table = \"good.csv\"\nw131 = 0.3\n", {"presample[0].w131", "is a column of", "1 = 0.3"});
  file("negative.csv", "r,rms (um)\n0,2\n0.6,0.1\n1,3\n");
  expect_error("kind = \"jitter\"\ntable = \"negative.csv\"\n", {"presample[0].rms", "field point"});
  const ConfigResult readout = parse_config(
      sensor("kind = \"diffraction\"\n[[readout]]\nkind = \"crosstalk\"\nside = { table = \"good.csv\" }\n"),
      (folder_ / "s.toml").string());
  expect_says(format_diagnostic(readout.diagnostics.front(), "s.toml"), {"readout[0].side", "[[presample]]"});
}

}  // namespace
}  // namespace mtf::io
