// SPDX-License-Identifier: Apache-2.0

// What the commands that make images take.

#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/modules/modules.h"

namespace apps {
namespace {

constexpr std::array kRigor{std::pair{std::string_view("estimate"), false},
                            std::pair{std::string_view("measure"), true}};
constexpr std::array kResume{std::pair{std::string_view("auto"), true}, std::pair{std::string_view("no"), false}};

Setter set_tolerance(std::optional<double>& tolerance) {
  return [&tolerance](const std::string& text) {
    tolerance = number("--tolerance", text);
    if (!(*tolerance > 0.0 && *tolerance < 1.0)) throw mtf::UsageError("--tolerance: " + text + " is outside (0, 1)");
  };
}

}  // namespace

Command demo_command() {
  const auto shared = std::make_shared<DemoOptions>();
  DemoOptions& options = *shared;
  Command app{"demo", "an example of the whole chain, checked against the analytic MTF, in seconds",
              "Writes a folder with sensor file, scene, simulated image, previews and MTF plot.",
              "  mtf demo\n"
              "  mtf demo -o my-demo --tolerance 1e-5"};
  add_text(app, "-o,--out", "FOLDER", "folder to create; default mtf-demo", options.out);
  add_word(app, "--tolerance", "X", "rms error allowed; default 1e-4", set_tolerance(options.tolerance));
  add_force(app, options.force);
  app.run = [shared](const Global& global) { return run_demo(*shared, global); };
  return app;
}

constexpr std::array kOutputStages{
    std::pair{std::string_view("radiance"), std::optional(radiometry::OutputStage::radiance)},
    std::pair{std::string_view("irradiance"), std::optional(radiometry::OutputStage::irradiance)},
    std::pair{std::string_view("watts"), std::optional(radiometry::OutputStage::watts)},
    std::pair{std::string_view("electrons"), std::optional(radiometry::OutputStage::electrons)},
    std::pair{std::string_view("volts"), std::optional(radiometry::OutputStage::volts)},
    std::pair{std::string_view("dn"), std::optional(radiometry::OutputStage::dn)},
    std::pair{std::string_view("display"), std::optional(radiometry::OutputStage::display)}};

Command simulate_command() {
  const auto shared = std::make_shared<SimulateCommandOptions>();
  SimulateCommandOptions& options = *shared;
  Command app{"simulate", "a radiance image through the sensor",
              "Scenes: OpenEXR, PNG, TIFF. Output by extension: .exr (float), .png or .tif (16 bits).\n"
              "The tolerance is the rms error over the output pixels, relative to the scene's standard deviation.\n"
              "A number in a name, as in frame.%04d.exr, makes it a sequence: its frames run in parallel. A schedule\n"
              "has the header frame,parameter,value and lines such as 20,jitter.rms,8 urad: from frame 20 on the\n"
              "component labelled jitter has that rms, until a later line changes it. With a schedule the scene may\n"
              "be one image; there is an output for every frame that the schedule names, or those of --frames.",
              "  mtf simulate sensor.toml scene.exr -o out.exr\n"
              "  mtf simulate sensor.toml frame.%04d.exr -o out.%04d.exr --tolerance 1e-3 --report run.json"};
  add_file(app, "sensor", "sensor file (TOML)", options.sensor);
  add_file(app, "scene", "image of the scene, or frame.%04d.exr for a sequence", options.scene);
  add_text(app, "-o,--out", "FILE", "image to write; of a sequence out.%04d.exr; .exr to measure it (see --range)",
           options.run.out)
      .required = true;
  add_text(app, "--report", "FILE", "what was done, how exactly and how fast, as JSON", options.report);
  add_text(
      app, "--picture", "FILE",
      "draw scene and image for the eye, side by side, with colour bars (.png): counts fill little of the scale of\n"
      "an image file, which a viewer shows black",
      options.picture);
  add_channel_choice(app, options.channel, options.layer, options.part);
  add_word(app, "--tolerance", "X", "rms error allowed; default 1e-4, with [adc] in the sensor file a tenth of a count",
           set_tolerance(options.run.tolerance));
  add_choice(
      app, "--stage,--tap", "STAGE",
      "whose output is wanted, of a sensor with [detector]: radiance, irradiance, electrons (of a thermal detector "
      "watts, volts), dn (counts) or display; default: the end of its chain",
      kOutputStages, options.run.stage);
  add_choice(app, "--nan", "POLICY", "NaN and infinite pixels: refuse (default), fill or propagate", kNanPolicies,
             options.run.nan);
  add_flag(app, "--without-path",
           "leave [path] and [atmosphere] of the sensor file out, for a picture that has its air in it",
           options.without_path);
  add_flag(app, "--explain", "show what the plan left out, merged and chose", options.explain);
  add_choice(app, "--rigor", "RIGOR", "estimate (default, reproducible) or measure (times candidates first)", kRigor,
             options.run.measure);
  add_text(
      app, "--wisdom", "FILE",
      "measured run times of methods: read before, written after; default:\na file in ~/.cache/mtfkit, which may be "
      "deleted at any time",
      options.wisdom);
  add_word(app, "--frames", "RANGE", "START:STOP[:STEP], both ends; default: all frames, or those of the schedule",
           [&](const std::string& text) { options.run.frames = frame_range("--frames", text); });
  add_text(app, "--schedule", "FILE", "parameters that change over frames: CSV with frame,parameter,value",
           options.run.schedule);
  add_word(app, "--memory", "SIZE",
           "most memory to use, such as 512MiB or 2GB: the scene (OpenEXR) goes through in tiles;\n"
           "stages of a sensor with [detector] that need the whole image are refused by name.\n"
           "Without it that is done only where the whole image does not fit the machine",
           [&](const std::string& text) { options.run.memory = byte_count("--memory", text); });
  add_word(app, "--roi", "X,Y,W,H", "pixels of the output that are wanted; only what they need is computed",
           [&](const std::string& text) { options.run.region = rectangle("--roi", text); });
  add_choice(app, "--resume", "MODE", "a stopped run in tiles: auto (default) continues it, no starts over", kResume,
             options.run.resume);
  add_word(
      app, "--range", "LOW:HIGH",
      "values that become 0 and the largest number of PNG and TIFF output; default: the least and largest value\n"
      "of the image, with [adc] the counts as they are, with [agc] the values of the display. 16 bits; 8 for up to\n"
      "255 display values. By default the brightest and darkest pixels are at the ends of the scale, which\n"
      "mtf measure takes for clipping: leave a margin here, or write .exr",
      [&](const std::string& text) { options.run.range = number_range("--range", text); });
  app.run = [shared](const Global& global) { return run_simulate(*shared, global); };
  return app;
}

Command bench_command() {
  const auto shared = std::make_shared<BenchOptions>();
  BenchOptions& options = *shared;
  Command app{
      "bench", "what each tolerance costs: promised and realised error, and run time",
      "For every decade of tolerance from 1e-1 to 1e-7: the plan that is chosen, every other method that keeps the\n"
      "tolerance, and plain OpenCV, each compared with the exact image in double and timed in interleaved rounds with\n"
      "bare FFTW. Writes bench.csv, bench.json, bench.svg and bench.png. Exit code 3 when an error is above its\n"
      "promise. A tolerance that cannot be kept has a row `refused` with the one that can.\n"
      "With a scene file alone: the tolerances of mtf heat in K, with the error that is promised, the realised one\n"
      "(mtf heat --verify) and the time; heat_bench.csv, heat_bench.json and heat_bench.svg.\n"
      "With a scene file and a sensor file: rays a sample and tables of mtf render against 64 rays a sample and "
      "direct\n"
      "integration over wavelength, with times; render_bench.csv, render_bench.json and render_bench.svg.",
      "  mtf bench sensor.toml scene.exr -o bench --rounds 3 --seconds 5\n"
      "  mtf bench sensor.toml scene.exr -o bench-1 --threads 1 --rounds 3 --seconds 5 --format csv"};
  add_file(app, "sensor", "sensor file, or a scene file (TOML)", options.sensor);
  add_file(app, "scene", "image of the scene; with a scene file none, or a sensor file (.toml) of pictures of it",
           options.scene)
      .required = false;
  add_text(app, "-o,--out", "FOLDER", "folder to create", options.out).required = true;
  add_channel_choice(app, options.channel, options.layer, options.part);
  add_word(app, "--rounds", "N", "runs of each method; default 15, fewer of slow ones; with a scene file 1",
           [&](const std::string& text) { options.rounds = whole_number("--rounds", text, 1, 10000); });
  add_word(app, "--seconds", "S", "time for the whole, about; default 60", [&](const std::string& text) {
    options.seconds = number("--seconds", text);
    if (!(options.seconds >= 0.1 && options.seconds <= 1e6))
      throw mtf::UsageError("--seconds: " + text + " is outside 0.1 to 1e6");
  });
  add_choice(app, "--rigor", "RIGOR", "of plans: estimate (default) or measure; bare FFTW is always measured", kRigor,
             options.measure);
  add_word(
      app, "--tolerance", "X", "with a scene file: such as \"0.5 K\", may be given again; default: 1, 0.3 and 0.1 K",
      [&](const std::string& text) { options.tolerances_k.push_back(temperature_difference("--tolerance", text)); })
      .repeats = true;
  add_text(app, "--temperatures", "PATH",
           "of pictures of a scene file: folder that mtf heat wrote, or a table of facets", options.temperatures);
  add_word(app, "--position", "X,Y,Z", "of the camera of such pictures, m; default: [camera] of the scene file",
           [&](const std::string& text) { options.position = point("--position", text); });
  add_word(app, "--look-at", "X,Y,Z", "what it looks at, m; default: [camera] of the scene file",
           [&](const std::string& text) { options.look_at = point("--look-at", text); });
  add_format(app, "of standard output: table (default), csv or json", options.format);
  add_force(app, options.force);
  app.run = [shared](const Global& global) {
    const bool pictures = shared->scene.ends_with(".toml");
    if (!pictures && (!shared->temperatures.empty() || shared->position || shared->look_at))
      throw mtf::UsageError("--temperatures, --position and --look-at belong to a scene file with a sensor file");
    if (pictures) return scenes_module().bench_render(*shared, global);
    if (!shared->scene.empty()) {
      if (!shared->tolerances_k.empty()) throw mtf::UsageError("--tolerance belongs to a scene file without an image");
      return run_bench(*shared, global);
    }
    if (shared->channel || shared->layer || shared->part || shared->measure)
      throw mtf::UsageError("name the image of the scene; --channel, --layer, --part and --rigor belong to images");
    return scenes_module().bench_heat(*shared, global);
  };
  return app;
}

}  // namespace apps
