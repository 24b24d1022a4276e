// SPDX-License-Identifier: Apache-2.0

// What the commands take that measure a sensor: from edges, and from flat frames.

#include "apps/characterize/characterize_options.h"
#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/modules/modules.h"

namespace apps {
namespace {

constexpr auto kMethods = enumerated<MeasureMethod>("regression", "iso12233", "both");
constexpr Choices<bool, 2> kLoss{{{"huber", true}, {"squares", false}}};
constexpr auto kUnits = enumerated<FrequencyUnit>("cy/px", "cy/mm", "lp/mm", "cy/mrad", "lw/ph");

const auto positive = between(0.0, mtf::kInfinity, " has to be above 0");

/// Reads a length such as "4.73um", in `unit`.
auto length_in(const char* unit) {
  return [unit](const std::string& option, const std::string& text) {
    try {
      const mtf::Quantity given = mtf::parse_quantity(text, mtf::Dimension::length);
      if (given.unit->dimension == mtf::Dimension::length && given.value > 0.0) return mtf::convert(given, unit);
    } catch (const mtf::UsageError& error) {
      throw mtf::UsageError(option + ": " + error.what());
    }
    throw mtf::UsageError(option + ": " + text + " has to be a length above 0, such as 4.73um or 50mm");
  };
}

void add_frequency_unit(Command& app, MeasureOptions& options) {
  add_choice(app, "--unit", "UNIT",
             "of all frequencies: cy/px (default), cy/mm, lp/mm (a line pair is a cycle), cy/mrad, or lw/ph\n"
             "(line widths per picture height: 2 x cy/px x rows of the image)",
             kUnits, options.unit);
  add_value(app, "--pitch", "LENGTH", "spacing of the pixels, such as 4.73um; for --unit cy/mm, lp/mm and cy/mrad",
            options.pitch_um, length_in("um"));
  add_value(app, "--focal-length", "LENGTH", "such as 50mm; for --unit cy/mrad", options.focal_length_mm,
            length_in("mm"));
}

void add_edge_input(Command& app, EdgeInput& input) {
  add_value(app, "--roi", "X,Y,W,H", "region with one edge, in pixels; may be given again; default: edges are found",
            input.regions, rectangle);
  add_text(app, "--roi-file", "FILE", "regions from a CSV file: x,y,width,height[,name] a line", input.region_file);
  add_value(app, "--edges", "N", "most edges found in an image; default 64", input.most, whole(1, 100'000));
  add_value(app, "--min-length", "PX", "of edges that are found; default 20", input.min_length_px, positive);
  add_value(app, "--min-cnr", "X", "contrast / noise of a pixel of edges that are found; default 8", input.min_cnr,
            positive);
  add_text(app, "--encoding", "CODE",
           "of stored values: linear, srgb, gamma (2.2), gamma:G, or a CSV file with stored and\nlinear values (OECF); "
           "default: what the file says, else linear",
           input.encoding)
      .candidates = one_of({"", "linear", "srgb", "gamma"});
  add_channel_choice(app, input.read);
  add_choice(app, "--bayer", "COLOUR", "of a mosaic, without interpolation: r, gr, gb, b, g (both greens) or all",
             as_they_are("r", "gr", "gb", "b", "g", "all"), input.bayer);
  add_choice(app, "--cfa-pattern", "PATTERN", "of the mosaic's first four pixels: rggb (default), grbg, gbrg or bggr",
             as_they_are("rggb", "grbg", "gbrg", "bggr"), input.pattern);
  add_text(app, "--mask", "FILE", "image of the same size that is 0 where there are no data", input.mask);
  add_value(app, "--noise", "SD", "of a pixel, in linear units (counts of an integer image); default: estimated",
            input.noise_sd, positive);
  add_value(app, "--saturation", "VALUE", "stored values from here on are clipped; default: the end of the scale",
            input.saturation, number);
}

}  // namespace

Command measure_command() {
  Command app{
      "measure", "the MTF from images of edges, with error bands",
      "Finds the edges, or takes those of --roi, and gives MTF and figures of merit of each along its normal, in\n"
      "cycles per pixel or another --unit, with standard deviations. No model of the sensor is needed. Angles\n"
      "are of the edge's normal, from +x (right) towards +y (down), as of mtf curve. What cannot be determined is\n"
      "left out with the reason, in json as null. Channels besides a full name: luminance, or all (each for\n"
      "itself). --plot and --annotate write the figures of the best edge and of the first image.",
      "  mtf measure edge.png\n"
      "  mtf measure edge.png --roi 10,12,80,96 --format json -o edge.json --plot edge.svg"};
  auto& options = options_of<MeasureOptions>(app, run_measure);
  add_text(app, "images", "IMAGE...", "images of any format of mtf info --formats", options.input.images).required =
      true;
  add_edge_input(app, options.input);
  add_value(app, "--order", "N", "of the polynomial that the edge follows, 1 to 5; default: by an F-test",
            options.order, whole(1, 5));
  add_flag(app, "--circle", "the edge follows a circle", options.circle);
  add_choice(app, "--method", "METHOD",
             "regression (default), iso12233 as other programs compute it, or both with why they differ", kMethods,
             options.method);
  add_frequency_unit(app, options);
  add_value(app, "--contrast-level", "C",
            "also the frequency at which the MTF falls to C, above 0 and below 1; may be given again",
            options.contrasts, between(0.0, 1.0, " has to lie between 0 and 1, such as 0.35"));
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
  return app;
}

Command fit_command() {
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
  auto& options = options_of<FitOptions>(
      app, [](const auto& given, const Global& global) { return fits_module().fit(given, global); });
  add_file(app, "sensor", "sensor file (TOML) with numbers to fit", options.sensor);
  add_text(app, "images", "IMAGE...", "images of edges (mtf info --formats)", options.input.images);
  add_edge_input(app, options.input);
  add_text(
      app, "--curve", "FILE[@DEG]",
      "MTF curves (CSV: frequency_cy_mm,mtf[,sd], or of mtf curve, of mtf measure --curves; of MTF Mapper, sfrmat and "
      "Imatest, also JSON) along a "
      "direction, default 0; may be given again",
      options.curves);
  add_choice(app, "--curve-unit", "UNIT",
             "of the frequencies of mtf curve --format csv, and of JSON without one: cy/mm, cy/mrad or cy/px",
             as_they_are("cy/mm", "cy/mrad", "cy/px"), options.curve_unit);
  add_value(app, "--curve-sd", "SD", "of the values of curves that have no column sd; default 0.01", options.curve_sd,
            positive);
  add_text(app, "--spot", "IMAGE", "image of a point source, the whole of it; may be given again", options.spots);
  add_text(app, "--conditions", "FILE", "what differs between the images: CSV with frame,parameter,value",
           options.conditions);
  add_choice(app, "--loss", "LOSS", "huber (default: outliers count less) or squares", kLoss, options.robust);
  add_value(app, "--starts", "N", "runs from different starting values; default 1", options.starts, whole(1, 1000));
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
      "  frames = \"dark/*.png\"          # PNG, TIFF, OpenEXR, an NPY cube, or raw; at least two frames\n"
      "  exposure = \"10 ms\"\n"
      "  light = false\n"
      "  [[stack]]\n"
      "  frames = \"bright/*.png\"\n"
      "  photons = 5200                  # or irradiance, relative, or the exposure alone\n"
      "Frames of blackbodies have temperature = \"308 K\" in place of it: two or more with a nominal give SiTF, NETD\n"
      "and 3-D noise in kelvin.\n"
      "The folder of --out gets sensor.toml, which every command reads, with { value, stderr } for each number;\n"
      "report.html, a page with all numbers and figures; result.json with intervals; levels.csv; defects.csv. What\n"
      "frames cannot tell is named. Where the model of photon transfer does not describe the frames, the exit code is\n"
      "3 (--allow-misfit: 0), and all files are written, as where the sensor does not describe the --edges.\n"
      "STACKS may be EMVA's own descriptor of a set of frames (*.txt) for both methods. --method emva1288 gives the\n"
      "numbers of EMVA 1288 R4.0 Linear with their standard deviations, and says where its formulas are biased and by\n"
      "how much for this camera; --out then gets result.json alone.",
      "  mtf characterize check stacks.toml\n"
      "  mtf characterize stacks.toml -o camera\n"
      "  mtf characterize stacks.toml --nominal sensor.toml --edges chart.png -o camera\n"
      "  mtf characterize EMVA1288_Data.txt --method emva1288\n"
      "  mtf characterize stacks.toml --nominal sensor.toml --format json"};
  add_file(app, "stacks", "file that describes the stacks (TOML, or EMVA's *.txt)", options.stacks).required = false;
  add_choice(app, "--method", "METHOD", "fit (default), or emva1288 for the standard's own numbers",
             enumerated<CharacterizeMethod>("fit", "emva1288"), options.method);
  add_text(app, "--nominal", "FILE", "sensor file for what frames do not tell; in place of the one that STACKS names",
           options.nominal);
  add_text(app, "--edges", "IMAGE",
           "raw image of edges, of the camera and settings of the frames: what the nominal marks fit = true is then\n"
           "fitted to it, as mtf fit does, by noise, response, full pixels, defects and crosstalk of the frames; may\n"
           "be given again",
           options.edges);
  add_text(app, "-o,--out", "FOLDER", "write sensor.toml, report.html, result.json, levels.csv and defects.csv here",
           options.out);
  add_flag(app, "--maps",
           "offset.exr and responsivity.exr beside sensor.toml, which names them in place of DSNU and PRNU",
           options.maps);
  add_flag(app, "--allow-misfit", "exit 0, not 3, where the model does not describe the frames", options.allow_misfit);
  add_choice(app, "--format", "FORMAT", "table (default) or json", kTableOrJson, options.format);
  add_force(app, options.force);
  app.run = [shared](const Global& global) {
    if (shared->stacks.empty()) throw mtf::UsageError("mtf characterize: give the file that describes the stacks");
    return fits_module().characterize(*shared, global);
  };
  Command check{"check", "stacks, frames and light of the file, and which numbers they can determine",
                "Reads the headers of the frames only.", "  mtf characterize check stacks.toml"};
  add_file(check, "stacks", "file that describes the stacks (TOML)", options.stacks);
  check.run = [shared](const Global& global) {
    shared->check = true;
    return fits_module().characterize(*shared, global);
  };
  app.commands = {check};
  return app;
}

}  // namespace apps
