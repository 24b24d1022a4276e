// SPDX-License-Identifier: Apache-2.0

// What the commands about sensors and files take.

#include <algorithm>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/import/config_import.h"
#include "apps/kinds.h"
#include "mtf/error.h"
#include "radiometry/chain/sensor_settings.h"

namespace apps {
namespace {

constexpr auto kLayouts = enumerated<ConfigOptions::Layout>("table", "markdown", "json");
using FileKind = ConfigOptions::FileKind;
constexpr auto kFiles = enumerated<FileKind>("sensor", "study", "scene");

Command config_import_command() {
  Command app{
      "import", "what lens programs export, as part of a sensor file",
      "Reads text as OpticStudio and CODE V save it: Zernike Standard and Fringe coefficients, FFT and Huygens PSF,\n"
      "MTF against frequency; and tables of coefficients with the columns x (deg), y (deg), wavelength (um),\n"
      "Z4 (waves), ...; and point spreads in FITS of STPSF (WebbPSF) and PSFEx. One field becomes a [[presample]] "
      "block to put into a sensor file in place of diffraction;\n"
      "coefficients of several, in one file or several, a table over the field that such a block names. How a file\n"
      "was understood is said, and stands in the result as comments.",
      "  mtf config import lens.txt -o lens.toml\n"
      "  mtf config import axis.txt corner.txt -o zernike.csv"};
  auto& options = options_of<ImportOptions>(app, run_config_import);
  add_text(app, "file", "FILE", "what the lens program exported; several files are several fields", options.files)
      .required = true;
  add_text(app, "-o,--out", "FILE", "file to write; default: standard output", options.out);
  add_flag(app, "--force", "replace an existing file", options.force);
  add_choice(app, "--as", "KIND", "what the files have to be: zernike, psf or mtf; default: what they are",
             as_they_are("zernike", "psf", "mtf"), options.kind);
  add_value(app, "--field", "N", "of several fields the one that is wanted, from 1", options.field, whole(1, 10'000));
  add_text(app, "--columns", "NAMES",
           "of the rows of a listing of another layout, as in tables: \"x (deg) = 0, y (deg), wavelength (um) = 0.55, "
           "Z1-Z8 (waves)\"; - leaves one out, = is a number that is no column",
           options.columns);
  add_value(app, "--detector", "W,H", "columns and rows of the detector, for places in a FITS", options.fits.detector,
            [](const auto& name, const auto& text) {
              const std::vector<double> size = number_list(name, text);
              if (size.size() != 2 || !(std::min(size[0], size[1]) >= 1.0 && std::max(size[0], size[1]) <= 1e6))
                throw mtf::UsageError(name + ": " + text + " is no size; write it like 2048,2048");
              return std::array{static_cast<int>(size[0]), static_cast<int>(size[1])};
            });
  add_text(app, "--step", "LENGTH", "of samples in a FITS, in place of what it says: \"2 um\"", options.fits.step);
  add_choice(app, "--order", "ORDER", "of the terms of a table: noll (unit rms) or fringe (unit peak)",
             as_they_are("noll", "fringe"), options.reading.order);
  add_choice(app, "--y", "DIRECTION", "in which +y of the file points in the image: up (default) or down",
             Choices<bool, 2>{{{"up", true}, {"down", false}}}, options.reading.y_up);
  add_choice(app, "--sign", "SIGN", "of the wavefront: plus (default, as OpticStudio has it) or minus",
             Choices<double, 2>{{{"plus", 1.0}, {"minus", -1.0}}}, options.reading.sign);
  return app;
}

}  // namespace

Command curve_command() {
  Command app{"curve", "OTF of every component, of each list and of the system",
              "Tables show MTF = |OTF|. In csv the column frequency is in --unit; there is one column a component and "
              "product, or NAME_re and NAME_im where the OTF is\n"
              "not real; json has real and imaginary parts of all. Both have 17 digits. A component that depends on\n"
              "wavelength is shown averaged over the band by itself; products are averaged as a whole.\n"
              "The data of a figure FILE are written to FILE.csv.",
              "  mtf curve sensor.toml --freq 0:60:13 --unit cy/mm\n"
              "  mtf curve sensor.toml --format csv -o curve.csv --plot mtf.svg"};
  auto& options = options_of<CurveOptions>(app, run_curve);
  add_file(app, "sensor", "sensor file (TOML)", options.sensor);
  add_text(app, "--freq", "LIST", "START:STOP:COUNT (both ends) or a comma list; default: 61 up to the cutoff",
           options.frequencies);
  add_choice(app, "--unit", "UNIT", "of the frequencies: cy/mm (default), cy/mrad or cy/px",
             as_they_are("cy/mm", "cy/mrad", "cy/px"), options.unit);
  add_value(app, "--angle", "DEG",
            "direction in the focal plane, from +x (right) to +y (down); default 0.\n"
            "With cy/px the vector is in pixels of each axis: 0.5 is Nyquist along both",
            options.angle_deg, number);
  add_text(app, "--field", "X,Y",
           "place in the image whose OTF is wanted, of a sensor whose OTF changes over the field: from the optical\n"
           "axis in half diagonals of the detector, 0.7,-0.7, or as a pixel from its upper left corner, 320px,40px",
           options.field);
  add_text(app, "--map", "QUANTITY",
           "over the image, at 9 x 9 places, in place of curves: mtf@nyquist, mtf@FREQ (in --unit) or mtf50 of the\n"
           "system in the direction of --angle; with the values on the axis, their mean and the worst",
           options.map)
      .candidates = one_of({"mtf@nyquist", "mtf50"});
  add_format(app, "table (default), csv or json", options.format);
  add_text(app, "--plot", "FILE", "figure: a .svg, .pdf or .png file, or ascii for the terminal", options.plot)
      .candidates = one_of({"", "ascii"});
  add_text(app, "-o,--out", "FILE", "write the values here instead of standard output", options.out);
  return app;
}

Command budget_command() {
  Command app{
      "budget", "electrons, noise and sensitivity of a pixel",
      "For a pixel that images a surface of one temperature: electrons by their origin, every noise\n"
      "term, SNR, NETD, NEI, D*, dynamic range. It takes [detector], [nonuniformity], [noise], [noise_3d] and [adc] "
      "of\n"
      "the sensor file; spatial noise is what [correction] leaves of it. The sensor file needs [band] and [detector]:\n"
      "see mtf config kinds detector. The table has 4 digits, the share of each noise term in the variance, the MTF "
      "at\n"
      "Nyquist, and names rows of 0 in one line; csv and json have every row of the budget with 17 digits.",
      "  mtf budget sensor.toml --temperature 310 --format json\n"
      "  mtf budget sensor.toml --curves --plot mrtd.svg"};
  auto& options = options_of<BudgetOptions>(app, run_budget);
  add_file(app, "sensor", "sensor file (TOML)", options.sensor);
  add_word(app, "--temperature", "K", "of the surface, such as 288, \"288 K\" or \"15 degC\"; default 300",
           [&](const std::string& text) {
             const GivenTemperature given = temperature("--temperature", text);
             options.temperature_k = given.kelvin;
             options.temperature_has_unit = given.has_unit;
             options.temperature_given = true;
             if (!(options.temperature_k >= 0.0 && options.temperature_k <= radiometry::kMostTemperature_k))
               throw mtf::UsageError("--temperature " + text + ": a temperature in K is from 0 to 1e9");
           });
  add_flag(
      app, "--without-path",
      "of the sensor by itself: leave [path] and [atmosphere] of the file out; blur of turbulence and aerosol stays",
      options.without_path);
  add_text(app, "--field", "X,Y",
           "place in the image whose OTF is taken, of a sensor whose OTF changes over the field, as of mtf curve;\n"
           "default: the optical axis, with mean and worst of the MTF at Nyquist over the image",
           options.field);
  add_flag(app, "--curves", "MRTD against spatial frequency and MDTD against size, in place of the budget",
           options.curves);
  add_text(app, "--plot", "FILE", "figure of --curves: a .svg, .pdf or .png file", options.plot);
  add_format(app, "table (default), csv or json", options.format);
  add_text(app, "-o,--out", "FILE", "write the values here instead of standard output", options.out);
  return app;
}

Command info_command() {
  Command app{"info", "what a file holds, and the command to run next",
              "Reads images (--formats: of which formats) and sensor files (.toml).",
              "  mtf info scene.exr\n"
              "  mtf info --formats"};
  auto& options = options_of<InfoOptions>(app, run_info);
  add_text(app, "file", "FILE", "image or sensor file", options.file);
  add_flag(app, "--formats", "the formats of images: what is read, written, applied, noted and refused",
           options.formats);
  add_channel_choice(app, options.read);
  add_text(
      app, "--assume", "KEY=VALUE +- SD",
      "of a thermal camera's counts, in place of what their file says, and how uncertain it is: \"emissivity=0.9 +- "
      "0.02\",\n\"surroundings=+- 2 K\", distance, air_temperature, relative_humidity, window_transmission,\n"
      "window_temperature; may be given again. The temperatures then have standard deviations and intervals",
      options.assume);
  add_format(app, "table (default), csv (of the channels) or json", options.format);
  return app;
}

Command devices_command() {
  Command app{
      "devices", "graphics cards and other devices that filter images, each tested",
      "Opens every device and tests it: its filter against transforms in double, its random numbers and\n"
      "elementary functions bit for bit against the processor's. One that fails is not admitted to\n"
      "mtf simulate and mtf bench (--device), and the reason stands here. Times are of a filter of 1024 x 1024\n"
      "samples on the device, and of transfers from ordinary memory and back.",
      "  mtf devices\n"
      "  mtf devices --format json"};
  auto& options = options_of<DevicesOptions>(app, run_devices);
  add_choice(app, "--format", "FORMAT", "table (default) or json", kTableOrJson, options.format);
  return app;
}

Command config_command() {
  const auto shared = std::make_shared<ConfigOptions>();
  ConfigOptions& options = *shared;
  const auto action = [&](ConfigOptions::Action chosen) {
    return [shared, chosen](const Global& global) {
      shared->action = chosen;
      return run_config(*shared, global);
    };
  };
  Command app{"config", "write, check and explain sensor, study and scene files", "",
              "  mtf config check sensor.toml\n"
              "  mtf config explain sensor.toml"};
  Command init{
      "init", "a commented file to start from: of a sensor, a study or a scene",
      "A study varies the sensor file that it names; a scene names meshes and weather, which mtf scene demo writes\n"
      "beside the same scene file.",
      "  mtf config init -o my-sensor.toml\n"
      "  mtf config init study -o my-study.toml"};
  OptionSpec& words = add_text(
      init, "kind", "KIND FILE", "sensor (default), study or scene; then, or alone, the file to write, as with -o",
      [&options, kinds = std::make_shared<int>(0)](const std::string& text) {
        const auto* kind = std::ranges::find(kFiles, text, &std::pair<std::string_view, FileKind>::first);
        if (kind != kFiles.end() && options.file.empty() && (*kinds)++ == 0)
          options.kind = kind->second;
        else if (text != "-" && !text.ends_with(".toml"))
          throw mtf::UsageError(
              "'" + text +
              "': is no kind of file (one of sensor, study, scene), and the name of no file that ends "
              "in .toml; -o " +
              text + " writes one of any name");
        else if (options.file.empty())
          options.file = text;
        else
          throw mtf::UsageError("'" + text + "': " + options.file + " is the file to write already; name one");
      });
  words.repeats = true;
  words.candidates = one_of({"", "sensor", "study", "scene"});
  add_text(init, "-o,--out", "FILE", "file to write; default: standard output", [&options](const std::string& text) {
    if (!options.file.empty() && options.file != text)
      throw mtf::UsageError("-o " + text + ": " + options.file + " is the file to write already; name one");
    options.file = text;
  });
  add_flag(init, "--force", "replace an existing file", options.force);
  init.run = action(ConfigOptions::Action::init);

  Command check{"check", "all errors of a sensor or study file in one pass", "",
                "  mtf config check sensor.toml\n"
                "  mtf config check sensor.toml --format json"};
  add_file(check, "file", "sensor or study file (TOML)", options.file);
  add_choice(check, "--format", "FORMAT", "table (default) or json", kTableOrJson, options.format);
  check.run = action(ConfigOptions::Action::check);

  Command explain{"explain", "what every number becomes after units and defaults", "",
                  "  mtf config explain sensor.toml\n"
                  "  mtf config explain sensor.toml > explained.txt"};
  add_file(explain, "file", "sensor file (TOML)", options.file);
  explain.run = action(ConfigOptions::Action::explain);

  Command kinds{
      "kinds", "every component: formula, validity, source, and each parameter",
      "Describes the tables of the chain to electrons and counts too, by name: optics, detector, noise, adc, ...;\n"
      "and of studies the keys (study, conditions) and all metrics (metrics) or one (netd, mtf_nyquist, ...).\n"
      "mtf/components/README.md is the output of --format markdown. JSON has every table, with units, ranges, scale\n"
      "and defaults: for forms, sliders and checks of other programs.",
      "  mtf config kinds jitter\n"
      "  mtf config kinds metrics"};
  add_text(kinds, "kind", "KIND", "one component, table or metric; default: all components", options.file).candidates =
      [](const std::vector<std::string>&) { return names_of_kinds(); };
  add_choice(kinds, "--format", "FORMAT", "table (default), markdown or json", kLayouts, options.layout);
  kinds.run = action(ConfigOptions::Action::kinds);

  Command schema{
      "schema", "JSON Schema of sensor, study or scene files, with which editors complete and check TOML",
      "Draft-07, as taplo and the editors that use it read it. Ranges of values with units and what several\n"
      "values decide together are left to mtf config check.",
      "  mtf config schema sensor -o sensor.schema.json\n"
      "  mtf config schema study -o study.schema.json"};
  add_choice(schema, "file", "FILE", "sensor, study or scene", kFiles, options.kind).required = true;
  add_text(schema, "-o,--out", "FILE", "file to write; default: standard output", options.file);
  schema.run = action(ConfigOptions::Action::schema);
  app.commands = {init, check, explain, kinds, schema, config_import_command()};
  return app;
}

Command check_command() {
  Command app{
      "check", "the accuracy promised, verified on this machine and build",
      "Compares the kernels with tables of high precision (built in), and images filtered at the extremes of size,\n"
      "scale, contrast and OTF with slow sums in double. Exit code 3 when a promise is not kept.\n"
      "Absolute and relative errors are the worst found; each value has to keep its own allowance.",
      "  mtf check\n"
      "  mtf check --format json -o check.json"};
  auto& options = options_of<CheckOptions>(app, run_check);
  add_text(app, "--reference", "FOLDER", "check against your own tables: CSV files named and laid out as the built-in",
           options.reference);
  add_text(app, "--device", "WORD",
           "check that device alone (an id or a part of a name of mtf devices, or auto): plans that filter on it",
           options.device);
  add_format(app, "table (default), csv or json", options.format);
  add_text(app, "-o,--out", "FILE", "write the results here instead of standard output", options.out);
  return app;
}

}  // namespace apps
