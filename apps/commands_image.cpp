// SPDX-License-Identifier: Apache-2.0

// What the commands that make images take.

#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/modules/modules.h"

namespace apps {
namespace {

constexpr auto kRigor = enumerated<bool>("estimate", "measure");
constexpr Choices<bool, 2> kResume{{{"auto", true}, {"no", false}}};
constexpr auto kOutputStages = enumerated<radiometry::OutputStage>(radiometry::kOutputStageNames);

int run_any_bench(const BenchOptions& options, const Global& global) {
  const bool pictures = options.scene.ends_with(".toml");
  if (!pictures && (!options.temperatures.empty() || options.position || options.look_at))
    throw mtf::UsageError("--temperatures, --position and --look-at belong to a scene file with a sensor file");
  if (pictures) return scenes_module().bench_render(options, global);
  if (!options.scene.empty()) {
    if (!options.tolerances_k.empty()) throw mtf::UsageError("--tolerance belongs to a scene file without an image");
    return run_bench(options, global);
  }
  if (options.read.channel || options.read.layer || options.read.part || options.measure || options.device != "cpu")
    throw mtf::UsageError(
        "name the image of the scene; --channel, --layer, --part, --rigor and --device belong to images");
  return scenes_module().bench_heat(options, global);
}

}  // namespace

Command demo_command() {
  Command app{"demo", "an example of the whole chain, checked against the analytic MTF, in seconds",
              "Writes a folder with sensor file, scene, simulated image, previews and MTF plot.",
              "  mtf demo\n"
              "  mtf demo -o my-demo --tolerance 1e-5"};
  auto& options = options_of<DemoOptions>(app, run_demo);
  add_text(app, "-o,--out", "FOLDER", "folder to create; default mtf-demo", options.out);
  add_value(app, "--tolerance", "X", "rms error allowed; default 1e-4", options.tolerance, fraction());
  add_force(app, options.force);
  return app;
}

Command simulate_command() {
  Command app{
      "simulate", "a radiance image through the sensor",
      "Scenes: images of any format of mtf info --formats. Output by extension: .exr, .hdr (ENVI; float), .png or\n"
      ".tif (16 bits).\n"
      "The tolerance is the rms error over the output pixels, relative to the scene's standard deviation.\n"
      "A number in a name, as in frame.%04d.exr, makes it a sequence: its frames run in parallel. A schedule\n"
      "has the header frame,parameter,value and lines such as 20,jitter.rms,8 urad: from frame 20 on the\n"
      "component labelled jitter has that rms, until a later line changes it. With a schedule or --frames\n"
      "the scene may be one image; there is an output for every frame that the schedule names, or those of\n"
      "--frames, each with noise of its own.",
      "  mtf simulate sensor.toml scene.exr -o out.exr\n"
      "  mtf simulate sensor.toml frame.%04d.exr -o out.%04d.exr --tolerance 1e-3 --report run.json"};
  auto& options = options_of<SimulateCommandOptions>(app, run_simulate);
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
  add_channel_choice(app, options.read);
  add_value(app, "--tolerance", "X",
            "rms error allowed; default 1e-4, with [adc] in the sensor file a tenth of a count", options.run.tolerance,
            fraction());
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
  add_device(app, options.device);
  add_text(
      app, "--wisdom", "FILE",
      "measured run times of methods: read before, written after; default:\na file in ~/.cache/mtfkit, which may be "
      "deleted at any time",
      options.wisdom);
  add_value(app, "--frames", "RANGE",
            "START:STOP[:STEP], both ends, or N: 0 to N - 1; default: all frames, or those of the schedule",
            options.run.frames, frame_range);
  add_text(app, "--schedule", "FILE", "parameters that change over frames: CSV with frame,parameter,value",
           options.run.schedule);
  add_value(
      app, "--memory", "SIZE",
      "most memory to use, such as 512MiB or 2GB: the scene (OpenEXR, ENVI, FITS, PGM, BMP) goes through in tiles;\n"
      "stages of a sensor with [detector] that need the whole image are refused by name.\n"
      "Without it that is done only where the whole image does not fit the machine",
      options.run.memory, byte_count);
  add_value(app, "--roi", "X,Y,W,H", "pixels of the output that are wanted; only what they need is computed",
            options.run.region, rectangle);
  add_choice(app, "--resume", "MODE", "a stopped run in tiles: auto (default) continues it, no starts over", kResume,
             options.run.resume);
  add_word(
      app, "--range", "LOW:HIGH",
      "values that become 0 and the largest number of PNG and TIFF output; default: the least and largest value\n"
      "of the image, with [adc] the counts as they are, with [agc] the values of the display. 16 bits; 8 for up to\n"
      "255 display values. By default the brightest and darkest pixels are at the ends of the scale, which\n"
      "mtf measure takes for clipping: leave a margin here, or write .exr",
      [&](const std::string& text) { options.run.range = number_range("--range", text); });
  return app;
}

Command bench_command() {
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
  auto& options = options_of<BenchOptions>(app, run_any_bench);
  add_file(app, "sensor", "sensor file, or a scene file (TOML)", options.sensor);
  add_file(app, "scene", "image of the scene; with a scene file none, or a sensor file (.toml) of pictures of it",
           options.scene)
      .required = false;
  add_text(app, "-o,--out", "FOLDER", "folder to create", options.out).required = true;
  add_channel_choice(app, options.read);
  add_value(app, "--rounds", "N", "runs of each method; default 15, fewer of slow ones; with a scene file 1",
            options.rounds, whole(1, 10000));
  add_value(app, "--seconds", "S", "time for the whole, about; default 60", options.seconds,
            within(0.1, 1e6, " is outside 0.1 to 1e6"));
  add_choice(app, "--rigor", "RIGOR", "of plans: estimate (default) or measure; bare FFTW is always measured", kRigor,
             options.measure);
  add_device(app, options.device);
  add_value(app, "--tolerance", "X",
            "with a scene file: such as \"0.5 K\", may be given again; default: 1, 0.3 and 0.1 K", options.tolerances_k,
            temperature_difference);
  add_text(app, "--temperatures", "PATH",
           "of pictures of a scene file: folder that mtf heat wrote, or a table of facets", options.temperatures);
  add_value(app, "--position", "X,Y,Z", "of the camera of such pictures, m; default: [camera] of the scene file",
            options.position, point);
  add_value(app, "--look-at", "X,Y,Z", "what it looks at, m; default: [camera] of the scene file", options.look_at,
            point);
  add_format(app, "of standard output: table (default), csv or json", options.format);
  add_force(app, options.force);
  return app;
}

}  // namespace apps
