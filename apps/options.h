// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the command line says, as plain values: main.cpp fills these (and is the only file that sees CLI11), each
// subcommand is one function that takes its struct and returns the exit code. Errors are thrown (mtf/error.h).

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/simulate/simulate_options.h"
#include "apps/text/frequency_unit.h"
#include "mtf/io/image_io.h"

namespace apps {

enum class Format { table, csv, json };
enum class Progress { automatic, plain, json, none };

/// Options that work before and after the subcommand.
struct Global {
  int threads = 0;  ///< 0 = all cores
  bool quiet = false;
  Progress progress = Progress::automatic;
};

struct CurveOptions {
  std::string sensor;
  std::string frequencies;  ///< "START:STOP:COUNT" (both ends) or a comma list; "" = 0 to the smaller of cutoff and 2
                            ///< Nyquist, 61
  std::string unit = "cy/mm";
  double angle_deg = 0.0;
  std::string field;  ///< a field point, "0.7,0.7", or a pixel, "320px,40px"; "" = on the optical axis
  std::string map;    ///< "mtf@nyquist", "mtf@0.25" or "mtf50" over the image in place of curves
  Format format = Format::table;
  std::string plot;  ///< .svg, .pdf, .png or "ascii"
  std::string out;   ///< "" = stdout
};

struct DevicesOptions {
  Format format = Format::table;
};

struct InfoOptions {
  std::string file;
  bool formats = false;  ///< the table of image formats, in place of a file
  Format format = Format::table;
  mtf::io::ReadOptions read;        ///< which channels of the image
  std::vector<std::string> assume;  ///< of counts of a thermal camera, as in simulate/stated_camera.h
};

struct ConfigOptions {
  enum class Action { init, check, explain, kinds, schema } action = Action::check;
  enum class Layout { table, markdown, json };
  enum class FileKind { sensor, study, scene };
  std::string file;                  ///< init, schema: where to write, "" = stdout; kinds: the one to show, "" = all
  FileKind kind = FileKind::sensor;  ///< init, schema: of which files
  bool force = false;
  Format format = Format::table;
  Layout layout = Layout::table;  ///< kinds; markdown is mtf/components/README.md
};

/// `mtf simulate`.
struct SimulateCommandOptions {
  std::string sensor, scene, report;
  std::string picture;        ///< PNG of scene and image for the eye, "" = none
  mtf::io::ReadOptions read;  ///< which channels of the image
  bool explain = false;
  std::string wisdom;         ///< file with what measuring learnt; read before, written after
  bool without_path = false;  ///< [path] and [atmosphere] of the sensor are left out
  std::string device = "cpu";
  SimulateOptions run;  ///< all that is for the library
};

/// `mtf live`.
struct LiveOptions {
  std::string first, second;       ///< sensor file and image, or scene file and sensor file; both "": the demo
  std::string temperatures, time;  ///< of a 3-D scene, as for `mtf fly`
  bool no_air = false;
  mtf::io::ReadOptions read;  ///< which channels of the image
  std::optional<double> tolerance;
  NanPolicy nan = NanPolicy::refuse;
  std::string device = "cpu";
  int port = 0;             ///< 0 = any free one
  bool no_browser = false;  ///< else opened where there is a desktop
  bool stay = false;        ///< without a page too
  double linger_s = 60.0;   ///< without a page, until it ends
};

struct BudgetOptions {
  std::string sensor;
  double temperature_k = 300.0;  ///< of the surface that the pixel images
  bool temperature_has_unit = true, temperature_given = false;
  bool without_path = false;  ///< of the sensor by itself: its [path] and [atmosphere] are left out
  std::string field;          ///< field point whose OTF is taken, as of CurveOptions; "" = on the optical axis
  bool curves = false;        ///< MRTD and MDTD as curves, in place of the budget
  std::string plot;           ///< figure of the curves: .svg, .pdf or .png
  Format format = Format::table;
  std::string out;  ///< "" = stdout
};

struct DemoOptions {
  std::string out = "mtf-demo";
  std::optional<double> tolerance;
  bool force = false;
};

struct BenchOptions {
  std::string sensor;  ///< or, without an image or with a sensor file, a scene file
  std::string scene;   ///< image; "" = `sensor` is a scene file; a sensor file (.toml) of pictures of it
  std::string out;
  mtf::io::ReadOptions read;                               ///< which channels of the image
  std::optional<int> rounds;                               ///< else 15; of a scene file 1
  double seconds = 60.0;                                   ///< for everything, about
  std::vector<double> tolerances_k;                        ///< of a scene file; empty: 1, 0.3 and 0.1
  std::string temperatures;                                ///< of pictures: a folder of `mtf heat` or a table of facets
  std::optional<std::array<double, 3>> position, look_at;  ///< of pictures, m
  Format format = Format::table;
  bool measure = false;  ///< --rigor measure
  std::string device = "cpu";
  bool force = false;
};

/// Images of edges, and how their values become proportional to light.
struct EdgeInput {
  std::vector<std::string> images;
  mtf::io::ReadOptions read;  ///< which channels; also "luminance", or "all": each colour for itself
  std::string encoding;  ///< linear, srgb, gamma:2.2, or a CSV file of stored and linear values; "" = as the file says
  std::string bayer;     ///< "", or the colours to take of a mosaic: r, gr, gb, b, g, all
  std::string pattern;   ///< of the mosaic; "" = rggb
  std::string mask;      ///< image that is 0 where there are no data; "" = none
  std::vector<std::array<std::int64_t, 4>> regions;  ///< x, y, width, height; none: found
  std::string region_file;
  int most = 64;                               ///< edges found in an image
  double min_length_px = 20.0, min_cnr = 8.0;  ///< of edges that are found
  std::optional<double> noise_sd;              ///< of a pixel, in linear units
  std::optional<double> saturation;            ///< stored values from here on are clipped
};

/// How `mtf measure` takes the MTF: by regression, after ISO 12233, or both with the reasons of their difference.
enum class MeasureMethod { regression, iso12233, both };

struct MeasureOptions {
  EdgeInput input;
  std::optional<int> order;  ///< of the edge curve
  bool circle = false;
  MeasureMethod method = MeasureMethod::regression;
  FrequencyUnit unit = FrequencyUnit::cy_px;
  std::optional<double> pitch_um, focal_length_mm;  ///< for the unit
  std::vector<double> contrasts;                    ///< whose frequencies are wanted
  Format format = Format::table;
  std::string out;       ///< "" = stdout
  std::string table;     ///< CSV with a line an image; "" = none
  std::string curves;    ///< CSV of all curves; "" = none, as the others below
  std::string plot;      ///< figure of the best edge's ESF, LSF and MTF
  std::string map;       ///< maps of MTF50 over the image
  std::string annotate;  ///< PNG of the image with the edges drawn
};

struct FitOptions {
  std::string sensor;
  EdgeInput input;                  ///< images of edges, none or more
  std::vector<std::string> curves;  ///< FILE or FILE@DEGREES
  double curve_sd = 0.01;           ///< of the values of a curve
  std::string curve_unit;           ///< of frequencies without one
  std::vector<std::string> spots;   ///< images of point sources
  std::string conditions;           ///< CSV of what differs between images; "" = nothing
  bool robust = true;
  int starts = 1;
  bool profile = false;
  bool residual_otf = false;
  bool allow_misfit = false;      ///< exit 0 also where the sensor does not describe the data
  Format format = Format::table;  ///< of standard output: table or json
  std::string out;                ///< fitted sensor file; "" = none, as the others below
  std::string report;             ///< JSON
  std::string plot;               ///< figure of the fitted and the measured MTF
  std::string residuals;          ///< folder of residual images
  bool force = false;
};

struct CheckOptions {
  std::string reference;  ///< folder of tables to use in place of the built-in ones; "" = none
  std::string device = "cpu";
  Format format = Format::table;
  std::string out;  ///< "" = stdout
};

/// What may stand before a name, in place of a study.
inline constexpr std::array<std::string_view, 4> kSweepVerbs{"plan", "run", "merge", "submit"};

/// `mtf sweep` and its verbs.
struct SweepOptions {
  enum class Engine { slurm, parallel, local };
  std::vector<std::string> words;  ///< STUDY, or a verb and what it is about
  std::string out;                 ///< folder; "" = not given
  bool force = false;
  std::optional<double> tolerance;          ///< in place of the study's
  Format format = Format::table;            ///< of standard output: table or json
  bool accuracy = false;                    ///< error against run time, at every tolerance
  std::optional<int> shards;                ///< to plan
  std::optional<std::array<int, 2>> shard;  ///< to run: number from 1, and of how many
  std::optional<Engine> engine;
  bool submit = false;
};

/// `mtf optimize`.
struct OptimizeCommandOptions {
  std::string study;
  std::vector<double> weights;   ///< by objective; empty = not given
  std::optional<int> objective;  ///< from 1
  bool each = false;             ///< every objective for itself
  bool search = false;           ///< --method search
  int starts = 8;
  Format format = Format::table;  ///< of standard output: table or json
  std::string out;                ///< sensor file of the best design, with --each a folder; "" = none
  std::string report;             ///< JSON; "" = none
  bool force = false;
};

/// `mtf scene`.
struct SceneOptions {
  enum class Action { demo, check, explain } action = Action::check;
  std::string file;  ///< demo: the folder to create
  bool force = false;
};

/// `mtf heat`.
struct HeatCommandOptions {
  std::string scene, out;
  std::optional<double> tolerance_k;  ///< else 0.1, with `fit` 0.05
  int rays = 128;                     ///< of the view of each side of a facet
  int directions = 36;                ///< of the table of shadows, a day
  int sun_points = 4;                 ///< of each facet
  bool every_facet = false;           ///< no classes
  bool seen = false;                  ///< only facets that the camera of the scene sees
  bool verify = false;                ///< the realised error too
  bool ply = false, vtk = false;
  double save_every_s = 10.0;  ///< what a run that is killed goes on from is written so often, after a day
  bool anew = false;           ///< an interrupted run in the folder is not continued
  bool sensitivity = false;    ///< six more runs, with one thing changed each
  bool force = false;
  bool fit = false;  ///< numbers of the ground to what was measured; `out` is the fitted scene file then
  std::string fit_report, fit_plot;  ///< of a fit: JSON and figure
  bool allow_misfit = false;
  Format format = Format::table;  ///< of standard output: table or json
};

int run_curve(const CurveOptions& options, const Global& global);
int run_devices(const DevicesOptions& options, const Global& global);
/// All devices, each opened and tested, as JSON: what `mtf devices --format json` prints.
std::string devices_report();
/// The device that --device names; says why "auto" finds none. Throws as mtf::choose_device.
mtf::DeviceChoice device_of(const std::string& word, const Global& global);
int run_info(const InfoOptions& options, const Global& global);
int run_config(const ConfigOptions& options, const Global& global);
int run_simulate(const SimulateCommandOptions& options, const Global& global);
int run_bench(const BenchOptions& options, const Global& global);
int run_bench_heat(const BenchOptions& options, const Global& global);
int run_bench_render(const BenchOptions& options, const Global& global);
int run_demo(const DemoOptions& options, const Global& global);
int run_live(const LiveOptions& options, const Global& global);
int run_budget(const BudgetOptions& options, const Global& global);
int run_measure(const MeasureOptions& options, const Global& global);
int run_fit(const FitOptions& options, const Global& global);
int run_sweep(const SweepOptions& options, const Global& global);
int run_optimize(const OptimizeCommandOptions& options, const Global& global);
int run_check(const CheckOptions& options, const Global& global);
int run_scene(const SceneOptions& options, const Global& global);
int run_heat(const HeatCommandOptions& options, const Global& global);
int run_heat_fit(const HeatCommandOptions& options, const Global& global);

}  // namespace apps
