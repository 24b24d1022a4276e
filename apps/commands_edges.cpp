// SPDX-License-Identifier: Apache-2.0

// What the commands take that measure a sensor: from edges, and from flat frames.

#include "apps/characterize/characterize_options.h"
#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/modules/modules.h"

namespace apps {
namespace {

constexpr std::array kMethods{std::pair{std::string_view("regression"), MeasureMethod::regression},
                              std::pair{std::string_view("iso12233"), MeasureMethod::iso12233},
                              std::pair{std::string_view("both"), MeasureMethod::both}};
constexpr std::array kLoss{std::pair{std::string_view("huber"), true}, std::pair{std::string_view("squares"), false}};
constexpr std::array kCurveUnits{std::pair{std::string_view("cy/mm"), 0}, std::pair{std::string_view("cy/mrad"), 1},
                                 std::pair{std::string_view("cy/px"), 2}};
constexpr std::array kBayer{std::pair{std::string_view("r"), 0},  std::pair{std::string_view("gr"), 1},
                            std::pair{std::string_view("gb"), 2}, std::pair{std::string_view("b"), 3},
                            std::pair{std::string_view("g"), 4},  std::pair{std::string_view("all"), 5}};
constexpr std::array kPatterns{std::pair{std::string_view("rggb"), 0}, std::pair{std::string_view("grbg"), 1},
                               std::pair{std::string_view("gbrg"), 2}, std::pair{std::string_view("bggr"), 3}};

constexpr std::array kUnits{std::pair{std::string_view("cy/px"), FrequencyUnit::cy_px},
                            std::pair{std::string_view("cy/mm"), FrequencyUnit::cy_mm},
                            std::pair{std::string_view("lp/mm"), FrequencyUnit::lp_mm},
                            std::pair{std::string_view("cy/mrad"), FrequencyUnit::cy_mrad},
                            std::pair{std::string_view("lw/ph"), FrequencyUnit::lw_ph}};

double positive(const std::string& option, const std::string& text) {
  const double value = number(option, text);
  if (!(value > 0.0)) throw mtf::UsageError(option + ": " + text + " has to be above 0");
  return value;
}

/// A length such as "4.73um", in `unit`.
double length(const std::string& option, const std::string& text, std::string_view unit) {
  try {
    const mtf::Quantity given = mtf::parse_quantity(text, mtf::Dimension::length);
    if (given.unit->dimension == mtf::Dimension::length && given.value > 0.0) return mtf::convert(given, unit);
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(option + ": " + error.what());
  }
  throw mtf::UsageError(option + ": " + text + " has to be a length above 0, such as 4.73um or 50mm");
}

void add_contrast_level(Command& app, std::vector<double>& contrasts) {
  add_word(app, "--contrast-level", "C",
           "also the frequency at which the MTF falls to C, above 0 and below 1; may be given again",
           [&contrasts](const std::string& text) {
             const double contrast = number("--contrast-level", text);
             if (!(contrast > 0.0 && contrast < 1.0))
               throw mtf::UsageError("--contrast-level: " + text + " has to lie between 0 and 1, such as 0.35");
             contrasts.push_back(contrast);
           })
      .repeats = true;
}

void add_frequency_unit(Command& app, MeasureOptions& options) {
  add_choice(app, "--unit", "UNIT",
             "of all frequencies: cy/px (default), cy/mm, lp/mm (a line pair is a cycle), cy/mrad, or lw/ph\n"
             "(line widths per picture height: 2 x cy/px x rows of the image)",
             kUnits, options.unit);
  add_word(app, "--pitch", "LENGTH", "spacing of the pixels, such as 4.73um; for --unit cy/mm, lp/mm and cy/mrad",
           [&options](const std::string& text) { options.pitch_um = length("--pitch", text, "um"); });
  add_word(app, "--focal-length", "LENGTH", "such as 50mm; for --unit cy/mrad",
           [&options](const std::string& text) { options.focal_length_mm = length("--focal-length", text, "mm"); });
}

void add_edge_input(Command& app, EdgeInput& input) {
  add_word(app, "--roi", "X,Y,W,H", "region with one edge, in pixels; may be given again; default: edges are found",
           [&](const std::string& text) { input.regions.push_back(rectangle("--roi", text)); })
      .repeats = true;
  add_text(app, "--roi-file", "FILE", "regions from a CSV file: x,y,width,height[,name] a line", input.region_file);
  add_word(app, "--edges", "N", "most edges found in an image; default 64",
           [&](const std::string& text) { input.most = whole_number("--edges", text, 1, 100'000); });
  add_word(app, "--min-length", "PX", "of edges that are found; default 20",
           [&](const std::string& text) { input.min_length_px = positive("--min-length", text); });
  add_word(app, "--min-cnr", "X", "contrast / noise of a pixel of edges that are found; default 8",
           [&](const std::string& text) { input.min_cnr = positive("--min-cnr", text); });
  add_text(app, "--encoding", "CODE",
           "of stored values: linear, srgb, gamma (2.2), gamma:G, or a CSV file with stored and\nlinear values (OECF); "
           "default: what the file says, else linear",
           input.encoding)
      .candidates = one_of({"", "linear", "srgb", "gamma"});
  add_channel_choice(app, input.channel, input.layer, input.part);
  add_word(app, "--bayer", "COLOUR", "of a mosaic, without interpolation: r, gr, gb, b, g (both greens) or all",
           [&](const std::string& text) { input.bayer = kBayer[choice("--bayer", text, kBayer)].first; })
      .candidates = one_of(kBayer);
  add_word(app, "--cfa-pattern", "PATTERN", "of the mosaic's first four pixels: rggb (default), grbg, gbrg or bggr",
           [&](const std::string& text) { input.pattern = kPatterns[choice("--cfa-pattern", text, kPatterns)].first; })
      .candidates = one_of(kPatterns);
  add_text(app, "--mask", "FILE", "image of the same size that is 0 where there are no data", input.mask);
  add_word(app, "--noise", "SD", "of a pixel, in linear units (counts of an integer image); default: estimated",
           [&](const std::string& text) { input.noise_sd = positive("--noise", text); });
  add_word(app, "--saturation", "VALUE", "stored values from here on are clipped; default: the end of the scale",
           [&](const std::string& text) { input.saturation = number("--saturation", text); });
}

}  // namespace

Command measure_command() {
  const auto shared = std::make_shared<MeasureOptions>();
  MeasureOptions& options = *shared;
  Command app{
      "measure", "the MTF from images of edges, with error bands",
      "Finds the edges, or takes those of --roi, and gives MTF and figures of merit of each along its normal, in\n"
      "cycles per pixel or another --unit, with standard deviations. No model of the sensor is needed. Angles\n"
      "are of the edge's normal, from +x (right) towards +y (down), as of mtf curve. What cannot be determined is\n"
      "left out with the reason, in json as null. Channels besides a full name: luminance, or all (each for\n"
      "itself). --plot and --annotate write the figures of the best edge and of the first image.",
      "  mtf measure edge.png\n"
      "  mtf measure edge.png --roi 10,12,80,96 --format json -o edge.json --plot edge.svg"};
  OptionSpec& images = add_text(app, "images", "IMAGE...", "OpenEXR, PNG, TIFF or JPEG",
                                [&](const std::string& text) { options.input.images.push_back(text); });
  images.required = images.repeats = true;
  add_edge_input(app, options.input);
  add_word(app, "--order", "N", "of the polynomial that the edge follows, 1 to 5; default: by an F-test",
           [&](const std::string& text) { options.order = whole_number("--order", text, 1, 5); });
  add_flag(app, "--circle", "the edge follows a circle", options.circle);
  add_choice(app, "--method", "METHOD",
             "regression (default), iso12233 as other programs compute it, or both with why they differ", kMethods,
             options.method);
  add_frequency_unit(app, options);
  add_contrast_level(app, options.contrasts);
  add_format(app, "table (default), csv (a line an edge) or json", options.format);
  add_text(app, "-o,--out", "FILE", "write the values here instead of standard output", options.out);
  add_text(
      app, "--table", "FILE",
      "CSV with a line an image and direction: best and median MTF50, and those of each --contrast-level; share of "
      "edges that were refused",
      options.table);
  add_text(app, "--curves", "FILE", "MTF, OTF, ESF and LSF of all edges as CSV", options.curves);
  add_text(app, "--plot", "FILE",
           "figure of ESF, LSF and MTF with error band: .svg, .pdf or .png; its data in FILE.csv", options.plot);
  add_text(app, "--map", "FILE",
           "maps of MTF50 over the image, one of sagittal and one of tangential edges; their data in FILE.csv",
           options.map);
  add_text(app, "--annotate", "FILE", "PNG of the image with the edges drawn", options.annotate);
  app.run = [shared](const Global& global) { return run_measure(*shared, global); };
  return app;
}

Command fit_command() {
  const auto shared = std::make_shared<FitOptions>();
  FitOptions& options = *shared;
  Command app{
      "fit", "the sensor's parameters from its images, and which of them the data do not determine",
      "Fits every number of the sensor file that is written { value = ..., fit = true } to the pixels of edges, to\n"
      "MTF curves of other instruments and to images of point sources, all in one fit. min, max and prior = { mean, sd "
      "}\n"
      "in the same table are used. Parameters that the data do not determine are reported as such, without a\n"
      "standard error. Where exposure, focus or band differ between images, a conditions file (frame,parameter,value; "
      "the frame\n"
      "is the number of the image on the command line, from 1) says how, as a schedule does for simulate.\n"
      "The status is converged_model_wrong where the residuals have structure that noise does not explain: all files\n"
      "are written, and the exit code is 3 (--allow-misfit: 0). Where the effect of a parameter vanishes at a bound,\n"
      "as that of a diffusion length at 0 does, it and its partners have intervals by profile likelihood.",
      "  mtf fit sensor.toml edge.png -o fitted.toml\n"
      "  mtf fit sensor.toml edge.png --format json --report fit.json --plot fit.svg"};
  add_file(app, "sensor", "sensor file (TOML) with numbers to fit", options.sensor);
  add_text(app, "images", "IMAGE...", "images of edges: OpenEXR, PNG, TIFF or JPEG", [&](const std::string& text) {
    options.input.images.push_back(text);
  }).repeats = true;
  add_edge_input(app, options.input);
  add_text(app, "--curve", "FILE[@DEG]",
           "MTF curves (CSV: frequency_cy_mm,mtf[,sd], or of mtf curve, or of mtf measure --curves) along a "
           "direction, default 0; may be given again",
           [&](const std::string& text) { options.curves.push_back(text); })
      .repeats = true;
  add_word(app, "--curve-unit", "UNIT", "of the frequencies of mtf curve --format csv: cy/mm, cy/mrad or cy/px",
           [&](const std::string& text) {
             options.curve_unit = kCurveUnits[choice("--curve-unit", text, kCurveUnits)].first;
           })
      .candidates = one_of(kCurveUnits);
  add_word(app, "--curve-sd", "SD", "of the values of curves that have no column sd; default 0.01",
           [&](const std::string& text) { options.curve_sd = positive("--curve-sd", text); });
  add_text(app, "--spot", "IMAGE", "image of a point source, the whole of it; may be given again",
           [&](const std::string& text) { options.spots.push_back(text); })
      .repeats = true;
  add_text(app, "--conditions", "FILE", "what differs between the images: CSV with frame,parameter,value",
           options.conditions);
  add_choice(app, "--loss", "LOSS", "huber (default: outliers count less) or squares", kLoss, options.robust);
  add_word(app, "--starts", "N", "runs from different starting values; default 1",
           [&](const std::string& text) { options.starts = whole_number("--starts", text, 1, 1000); });
  add_flag(app, "--profile",
           "profile-likelihood intervals of every parameter, also where no bound at which an effect vanishes is near",
           options.profile);
  add_flag(app, "--allow-misfit", "exit 0, not 3, where the sensor does not describe the data", options.allow_misfit);
  add_flag(app, "--residual-otf", "OTF of the residuals as an estimate of the systematic error", options.residual_otf);
  add_choice(app, "--format", "FORMAT", "table (default) or json", kTableOrJson, options.format);
  add_text(app, "-o,--out", "FILE", "the sensor file with fitted values and standard errors", options.out);
  add_text(app, "--report", "FILE", "everything that was found, as JSON", options.report);
  add_text(app, "--plot", "FILE", "figure of the fitted and the measured MTF: .svg, .pdf or .png; its data in FILE.csv",
           options.plot);
  add_text(app, "--residuals", "FOLDER", "residual images in standard deviations, an OpenEXR file an edge",
           options.residuals);
  add_force(app, options.force);
  app.run = [shared](const Global& global) { return fits_module().fit(*shared, global); };
  return app;
}

Command characterize_command() {
  const auto shared = std::make_shared<CharacterizeCommandOptions>();
  CharacterizeCommandOptions& options = *shared;
  Command app{
      "characterize", "gain, noise, response and non-uniformity of a camera from its own flat frames",
      "STACKS (TOML) lists stacks of flat frames at several exposures, with how much light each had:\n"
      "  [camera]\n"
      "  bits = 12\n"
      "  [[stack]]\n"
      "  frames = \"dark/*.png\"          # PNG, TIFF, OpenEXR, or one NPY cube; at least two frames\n"
      "  exposure = \"10 ms\"\n"
      "  light = false\n"
      "  [[stack]]\n"
      "  frames = \"bright/*.png\"\n"
      "  photons = 5200                  # or irradiance, relative, or the exposure alone\n"
      "The folder of --out gets sensor.toml, which every command reads, with { value, stderr } for each number;\n"
      "result.json with intervals; levels.csv. What frames cannot tell is named. Where the model of photon transfer\n"
      "does not describe the frames, the exit code is 3 (--allow-misfit: 0), and all files are written.",
      "  mtf characterize stacks.toml -o camera\n"
      "  mtf characterize stacks.toml --nominal sensor.toml --format json"};
  add_file(app, "stacks", "file that describes the stacks (TOML)", options.stacks);
  add_text(app, "--nominal", "FILE", "sensor file for what frames do not tell; in place of the one that STACKS names",
           options.nominal);
  add_text(app, "-o,--out", "FOLDER", "write sensor.toml, result.json and levels.csv here", options.out);
  add_flag(app, "--allow-misfit", "exit 0, not 3, where the model does not describe the frames", options.allow_misfit);
  add_choice(app, "--format", "FORMAT", "table (default) or json", kTableOrJson, options.format);
  add_force(app, options.force);
  app.run = [shared](const Global& global) { return fits_module().characterize(*shared, global); };
  return app;
}

}  // namespace apps
