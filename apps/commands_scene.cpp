// SPDX-License-Identifier: Apache-2.0

// What the commands of 3-D scenes and the live view take.

#include <algorithm>

#include "apps/arguments.h"
#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/modules/modules.h"
#include "apps/scene/command/picture_options.h"
#include "apps/scene/render/layer_file.h"

namespace apps {
namespace {

Command scene_verb(const char* name, SceneOptions::Action action, const char* doc, const char* details,
                   const char* examples) {
  Command verb{name, doc, details, examples};
  auto& options = options_of<SceneOptions>(
      verb, [](const auto& given, const Global& global) { return scenes_module().scene(given, global); });
  options.action = action;
  if (action == SceneOptions::Action::demo) {
    options.file = "mtf-scene";
    add_text(verb, "-o,--out", "FOLDER", "folder to create; default: mtf-scene", options.file);
    add_force(verb, options.force);
  } else {
    add_file(verb, "scene", "scene file (TOML)", options.file);
  }
  return verb;
}

void add_sampling(Command& app, SamplingOptions& to) {
  constexpr Choices<int, 3> points{{{"1", 1}, {"4", 2}, {"16", 4}}};
  add_value(app, "--samples-per-pitch", "N",
            "advanced: along each axis; default: 2, or as many up to 8 as the sensor's MTF asks for",
            to.samples_per_pitch, within(0.5, 64.0, "; it is from 0.5 to 64"));
  add_choice(app, "--points", "N", "advanced: 1, 4 (default) or 16, of each sample, which is their mean", points,
             to.points);
}

/// Reads a tolerance of temperatures, in K.
double heat_tolerance(const std::string& option, const std::string& text) {
  const double kelvin = temperature_difference(option, text);
  if (kelvin < 1e-4) throw mtf::UsageError(option + ": " + text + " is below 0.0001 K, which rounding does not allow");
  return kelvin;
}

/// Reads "ROLE=NAME".
std::pair<std::string, std::string> layer_channel(const std::string& option, const std::string& text) {
  const auto split = text.find('=');
  const std::string role = text.substr(0, split);
  if (split == std::string::npos || split + 1 == text.size() ||
      std::ranges::find(scene::kLayerRoles, role) == scene::kLayerRoles.end())
    throw mtf::UsageError(option + ": " + text + ": write for example depth=ViewLayer.Depth.Z");
  return {role, text.substr(split + 1)};
}

int run_either_heat(const HeatCommandOptions& options, const Global& global) {
#ifdef MTFKIT_HAVE_CALIB
  if (options.fit) return scenes_module().heat_fit(options, global);
  if (!options.fit_report.empty() || !options.fit_plot.empty() || options.allow_misfit)
    throw mtf::UsageError("--report, --plot and --allow-misfit belong to --fit");
#endif
  return scenes_module().heat(options, global);
}

}  // namespace

Command scene_command() {
  using enum SceneOptions::Action;
  Command app{"scene", "scene files: write an example, check one, explain one",
              "A scene file names meshes, the materials of their faces, place, time and weather.",
              "  mtf scene demo -o vehicle\n"
              "  mtf scene check vehicle/scene.toml"};
  app.commands.push_back(scene_verb("demo", demo, "a tracked vehicle on terrain with two days of weather",
                                    "The vehicle has 178,190 vertices and four regions; the weather is a model of "
                                    "clear days, not a measurement.",
                                    "  mtf scene demo\n  mtf scene demo -o vehicle"));
  app.commands.push_back(scene_verb("check", check, "read a scene with its meshes and weather, and say what is wrong",
                                    "", "  mtf scene check scene.toml\n  mtf scene check vehicle/scene.toml"));
  app.commands.push_back(scene_verb("explain", explain, "regions, materials and weather of a scene in numbers", "",
                                    "  mtf scene explain scene.toml\n  mtf scene explain vehicle/scene.toml"));
  return app;
}

Command render_command() {
  Command app{
      "render", "the picture of a scene that a sensor takes in, for mtf simulate",
      "Facets in the sensor's field of view: their temperature and emissivity, the light that they reflect of sky,\n"
      "ground, other surfaces and the sun, and the air before them give one radiance, weighted by\n"
      "the response of the sensor. The OpenEXR file says so, and mtf simulate takes it without options. The camera\n"
      "stands where [camera] of the scene file says; the air is that of [atmosphere] of either file. Bands from 3 to\n"
      "14 um. A sample is the mean of several points; the attribute mtf:aperture says it.\n"
      "Several sensors of one field of view are rendered at once, each to a file of its name.",
      "  mtf render vehicle/scene.toml vehicle/mwir.toml --temperatures temperatures -o scene.exr\n"
      "  mtf render vehicle/scene.toml vehicle/mwir.toml vehicle/lwir.toml --heat --time 2026-06-21T12:10:00Z "
      "-o dawn --picture dawn.png"};
  auto& options = options_of<RenderCommandOptions>(
      app, [](const auto& given, const Global& global) { return scenes_module().render(given, global); });
  add_file(app, "scene", "scene file (TOML)", options.scene);
  add_text(app, "sensor", "FILE", "sensor files (TOML): one, or several of one field of view", options.sensors)
      .required = true;
  add_text(app, "-o,--out", "PATH", "OpenEXR file to write; of several sensors a folder to create", options.out)
      .required = true;
  add_text(app, "--temperatures", "PATH",
           "folder that mtf heat wrote, or a table of facets (.npy, .csv); default: those of the scene file's regions",
           options.temperatures);
  add_flag(app, "--heat", "solve the temperatures first, as mtf heat does, until --time", options.heat);
  add_text(app, "--picture", "FILE",
           "draw radiance and the image that mtf simulate makes of it, side by side, with colour bars (.png)",
           options.picture);
  add_text(app, "--time", "INSTANT",
           "UTC, as 2026-06-21T11:40:00Z; default: the last of the folder, or the scene's start", options.time);
  add_value(app, "--position", "X,Y,Z", "of the camera, m; default: [camera] of the scene file", options.position,
            point);
  add_value(app, "--look-at", "X,Y,Z", "what it looks at, m; default: [camera] of the scene file", options.look_at,
            point);
  add_value(app, "--tolerance", "X", "of the tables of the air, relative; default 5e-6", options.tolerance, fraction());
  constexpr Choices<bool, 2> quantities{{{"weighted", false}, {"radiance", true}}};
  add_choice(app, "--quantity", "WORD", "weighted (default), by the sensor's response, or radiance in W m-2 sr-1",
             quantities, options.plain);
  add_text(app, "--from", "FILE",
           "layers of another renderer in place of the meshes: OpenEXR with depth, material and temperature",
           options.from);
  add_text(app, "--materials", "FILE",
           "with --from: CSV of index,material[,temperature_K]; default: the materials of the scene file from 0 on",
           options.materials);
  constexpr Choices<bool, 2> depths{{{"planar", true}, {"range", false}}};
  add_choice(
      app, "--depth", "WORD",
      "with --from: planar, along the optical axis (default), or range, along the ray (default of files of mtf render)",
      depths, options.planar_depth);
  std::vector<std::string> roles;
  for (const std::string_view role : scene::kLayerRoles) roles.push_back(std::string(role) + "=");
  add_value(app, "--channel", "ROLE=NAME",
            "with --from: a channel by name, of depth, material, temperature, normal.X, normal.Y, normal.Z, sunlit",
            options.channels, layer_channel)
      .candidates = one_of(roles);
  add_flag(app, "--no-air", "surfaces alone, for sensors that bring a path of their own", options.no_air);
  add_value(app, "--layer", "NAME",
            "write this too: temperature, emissivity, Z (range, m), facet, material, normal, surface (before the air), "
            "transmittance",
            options.layers, [](const std::string&, const std::string& text) { return text; })
      .candidates =
      one_of({"temperature", "emissivity", "Z", "facet", "material", "normal", "surface", "transmittance"});
  add_choice(app, "--format", "FORMAT", "of standard output: table (default) or json", kTableOrJson, options.format);
  add_force(app, options.force);
  add_sampling(app, options.sampling);
  return app;
}

Command fly_command() {
  Command app{
      "fly", "image after image of a 3-D scene, while everything may change",
      "Each frame is the picture that mtf render makes and the image that mtf simulate makes of it, in one process:\n"
      "temperatures at that time, sun and sky, the camera on its path ([camera] path of the scene file), the air, and\n"
      "the whole sensor, whose parameters a schedule may change from frame to frame. Without --temperatures the heat\n"
      "balance is worked out first. Only what has changed is done again. Prints frames a second and the time of each\n"
      "stage; without -o nothing is written. After Ctrl-C the frames that are finished stay.",
      "  mtf fly vehicle/scene.toml camera.toml --time 2026-06-22T05:00:00Z --seconds 4 -o frame.%04d.png\n"
      "  mtf fly scene.toml camera.toml --temperatures temperatures --schedule zoom.csv --frames 0:99"};
  auto& options = options_of<FlyCommandOptions>(
      app, [](const auto& given, const Global& global) { return scenes_module().fly(given, global); });
  add_file(app, "scene", "scene file (TOML)", options.scene);
  add_file(app, "sensor", "sensor file (TOML)", options.sensor);
  add_text(app, "-o,--out", "FILE", "files to write, as frame.%04d.png; .exr to measure them", options.out);
  add_value(app, "--frames", "RANGE",
            "START:STOP[:STEP], both ends, or N: 0 to N - 1; default: those of the camera's path", options.frames,
            frame_range);
  add_value(app, "--seconds", "N", "how long the flight takes, in place of --frames", options.seconds,
            within(0.0, mtf::kInfinity, " is below 0"));
  add_value(app, "--rate", "HZ", "frames a second of the flight; default 25", options.rate_hz,
            within(1e-6, 1e6, " is outside [1e-06, 1e+06]"));
  add_value(app, "--speed", "X", "of the scene's clock against the flight's; 600: ten minutes a second; default 1",
            options.speed, within(0.0, 1e6, " is outside [0, 1e6]"));
  add_text(app, "--time", "INSTANT", "of frame 0, UTC, as 2026-06-21T11:40:00Z; default: the scene's start",
           options.time);
  add_text(app, "--temperatures", "PATH", "folder that mtf heat wrote, or a table of facets (.npy, .csv)",
           options.temperatures);
  add_value(app, "--heat-tolerance", "X", "of the heat balance, with its unit; default \"0.1 K\"",
            options.heat_tolerance_k, heat_tolerance);
  add_text(app, "--report", "FILE", "write frames, rates, times of stages and what was left out as JSON",
           options.report);
  add_text(app, "--schedule", "FILE", "CSV frame,parameter,value: parameters of the sensor that change over frames",
           options.schedule);
  add_flag(app, "--no-air", "surfaces alone, for sensors that bring a path of their own", options.no_air);
  add_value(app, "--tolerance", "X",
            "rms error of the filters, as for mtf simulate; frames of less contrast than the first may miss it, with a "
            "warning",
            options.image.tolerance, fraction());
  add_value(app, "--range", "LOW:HIGH", "values that are black and white in PNG and TIFF", options.image.range,
            number_range);
  add_device(app, options.device);
  add_choice(app, "--format", "FORMAT", "of standard output: table (default) or json", kTableOrJson, options.format);
  add_value(app, "--light-every", "S",
            "advanced: of the scene's clock, for which the light of sky, sun and surfaces is kept; default 60",
            options.light_every_s, within(1e-3, 1e9, " is outside [0.001, 1e+09]"));
  add_sampling(app, options.sampling);
  return app;
}

Command heat_command() {
  Command app{
      "heat", "surface temperatures of a scene over time, by heat balance",
      "Writes a folder with temperatures of all facets (NPY) and of regions (CSV), facets.csv, times.csv,\n"
      "heat.json, a plot, and with [camera] a picture. The tolerance is that of the worst facet at any output;\n"
      "sampling errors of shadows and views are measured and stated beside it. Conduction along surfaces is\n"
      "left out, and formulas of convection and sky are good to 1 to 3 K: they are named in heat.json. Exit code 3\n"
      "where the promised error is above the tolerance, or, with --verify, below the realised one.\n"
      "After Ctrl-C the folder holds the days that are finished; the same command goes on from there, and so it does\n"
      "after a run that was killed.\n"
      "--fit writes a scene file instead: numbers { value, fit = true, min, max } of the ground's material fitted to\n"
      "its measured temperature, with their standard errors.",
      "  mtf heat vehicle/scene.toml -o temperatures\n"
      "  mtf heat scene.toml -o temperatures --tolerance \"0.5 K\" --verify"};
  auto& options = options_of<HeatCommandOptions>(app, run_either_heat);
  add_file(app, "scene", "scene file (TOML)", options.scene);
  add_text(app, "-o,--out", "PATH", "folder to create; with --fit the fitted scene file", options.out).required = true;
  add_value(app, "--tolerance", "X", "with its unit; default \"0.1 K\", with --fit \"0.05 K\"", options.tolerance_k,
            heat_tolerance);
  add_flag(app, "--every-facet", "solve each facet by itself, without classes: slower, and free of their error",
           options.every_facet);
  add_flag(
      app, "--seen",
      "only temperatures of facets that [camera] sees, of others as much as those need: faster; the others are NaN",
      options.seen);
  add_flag(app, "--verify",
           "the realised error too, against runs at a tenth of the tolerance, and errors of the tables on all facets",
           options.verify);
  add_flag(app, "--ply", "write the mesh with the last temperatures too, for ParaView, MeshLab or Blender",
           options.ply);
  add_flag(app, "--vtk", "the same as VTK, which ParaView reads with values of facets", options.vtk);
  add_value(app, "--save-every", "S",
            "seconds after which a day that is finished is saved, to go on from when the run is killed; default 10",
            options.save_every_s, whole(0, 86400));
  add_flag(app, "--anew", "begin again where the folder holds an interrupted run, which is continued otherwise",
           options.anew);
  add_flag(app, "--sensitivity",
           "run six times more, with convection, sky or materials changed, and say what it changes",
           options.sensitivity);
#ifdef MTFKIT_HAVE_CALIB
  add_flag(app, "--fit", "fit numbers of the ground that the file marks, to its measured temperature", options.fit);
  add_text(app, "--report", "FILE", "with --fit: write the results as JSON", options.fit_report);
  add_text(app, "--plot", "FILE", "with --fit: draw measured and solved temperatures (.svg, .png, .pdf)",
           options.fit_plot);
  add_flag(app, "--allow-misfit", "with --fit: exit code 0 where the model does not describe the data",
           options.allow_misfit);
#endif
  add_choice(app, "--format", "FORMAT", "of standard output: table (default) or json", kTableOrJson, options.format);
  add_force(app, options.force);
  add_value(app, "--rays", "N", "advanced: for the view of each side of a facet; default 128, more in a scene of few",
            options.rays, whole(16, 65536));
  add_value(app, "--sun-directions", "N", "advanced: of the table of shadows, a day; default 36", options.directions,
            whole(4, 1440));
  add_value(app, "--sun-points", "N", "advanced: on each facet, for its share in the sun; default 4",
            options.sun_points, whole(1, 255));
  return app;
}

Command live_command() {
  Command app{
      "live", "the live view: a scene through a sensor in the browser, with a slider for every parameter",
      "Prints the address of a page and opens it. Of a sensor file and an image, as mtf simulate; of a scene file\n"
      "and a sensor file, as mtf fly: the camera goes where the mouse takes it. Without files: the camera and scene\n"
      "of mtf demo; a 3-D scene is made by mtf scene demo. The page\n"
      "answers to this machine alone; from another one use a tunnel: ssh -L 8080:127.0.0.1:8080 host, there\n"
      "mtf live --port 8080 --no-browser, and the printed address here. It changes no file: the page hands the\n"
      "changed sensor file, the picture and the command line to the browser's downloads and clipboard.",
      "  mtf live\n"
      "  mtf live sensor.toml scene.exr --tolerance 1e-3"};
  auto& options = options_of<LiveOptions>(
      app, [](const auto& given, const Global& global) { return live_module().live(given, global); });
  add_file(app, "first", "sensor file; of a 3-D scene its scene file (TOML)", options.first).required = false;
  add_file(app, "second", "image of the scene, or frame.%04d.exr for a sequence; of a 3-D scene the sensor file",
           options.second)
      .required = false;
  add_channel_choice(app, options.read);
  add_value(app, "--tolerance", "X", "rms error allowed, at the start; default: that of mtf simulate",
            options.tolerance, fraction());
  add_choice(app, "--nan", "POLICY", "NaN and infinite pixels: refuse (default), fill or propagate", kNanPolicies,
             options.nan);
  add_text(app, "--temperatures", "PATH",
           "of a 3-D scene: folder that mtf heat wrote, or a table of facets; else the heat balance is worked out",
           options.temperatures);
  add_text(app, "--time", "INSTANT", "of the first picture of a 3-D scene, UTC; default: where temperatures begin",
           options.time);
  add_flag(app, "--no-air", "of a 3-D scene surfaces alone, for sensors that bring a path of their own",
           options.no_air);
  add_device(app, options.device);
  add_value(app, "--port", "N", "port on 127.0.0.1; default: one that is free", options.port, whole(1, 65535));
  add_flag(app, "--no-browser", "print the address only", options.no_browser);
  add_flag(app, "--stay", "go on when no page is open; else it ends a minute after the last one", options.stay);
  add_value(app, "--linger", "S", "seconds without a page until it ends; default 60", options.linger_s,
            within(1.0, 1e6, " is outside 1 to 1e6"));
  return app;
}

}  // namespace apps
