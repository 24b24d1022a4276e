// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the command line says, as plain values: main.cpp fills these (and is the only file that sees CLI11), each
// subcommand is one function that takes its struct and returns the exit code. Errors are thrown (mtf/error.h).

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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
  Format format = Format::table;
  std::string plot;  ///< .svg, .pdf, .png or "ascii"
  std::string out;   ///< "" = stdout
};

struct InfoOptions {
  std::string file;
  Format format = Format::table;
  std::optional<std::string> channel, layer;
  std::optional<int> part;
};

struct ConfigOptions {
  enum class Action { init, check, explain, kinds } action = Action::check;
  std::string file;  ///< init: where to write, "" = stdout; kinds: the one to show, "" = all
  bool force = false;
  Format format = Format::table;
  bool markdown = false;  ///< kinds: as mtf/components/README.md
};

enum class NanPolicy { refuse, fill, propagate };

/// First and last frame of a sequence, and from one to the next.
struct FrameRange {
  std::int64_t first = 0, last = 0, step = 1;
};

struct SimulateOptions {
  std::string sensor, scene, out, report;
  std::optional<std::string> channel, layer;
  std::optional<int> part;
  std::optional<double> tolerance;
  NanPolicy nan = NanPolicy::refuse;
  bool explain = false;
  bool measure = false;                               ///< --rigor measure
  std::string wisdom;                                 ///< file with what measuring learnt; read before, written after
  std::optional<double> range_low, range_high;        ///< of 16-bit output; default: extremes of the image
  std::optional<FrameRange> frames;                   ///< of a sequence; default: all on disk, or those of the schedule
  std::string schedule;                               ///< CSV of parameters that change over frames; "" = none
  std::optional<std::int64_t> memory;                 ///< bytes that may be in use; the scene goes through in tiles
  std::optional<std::array<std::int64_t, 4>> region;  ///< x, y, width, height in pixels
  bool resume = true;                                 ///< go on from what a stopped run left
};

struct DemoOptions {
  std::string out = "mtf-demo";
  std::optional<double> tolerance;
  bool force = false;
};

struct BenchOptions {
  std::string sensor, scene, out;
  std::optional<std::string> channel, layer;
  std::optional<int> part;
  int rounds = 15;
  double seconds = 60.0;  ///< for everything, about
  Format format = Format::table;
  bool measure = false;  ///< --rigor measure
  bool force = false;
};

struct CheckOptions {
  std::string reference;  ///< folder of tables to use in place of the built-in ones; "" = none
  Format format = Format::table;
  std::string out;  ///< "" = stdout
};

int run_curve(const CurveOptions& options, const Global& global);
int run_info(const InfoOptions& options, const Global& global);
int run_config(const ConfigOptions& options, const Global& global);
int run_simulate(const SimulateOptions& options, const Global& global);
int run_bench(const BenchOptions& options, const Global& global);
int run_demo(const DemoOptions& options, const Global& global);
int run_check(const CheckOptions& options, const Global& global);

}  // namespace apps
