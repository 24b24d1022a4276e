// SPDX-License-Identifier: Apache-2.0

// The chosen designs side by side.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "apps/demo/demo_scene.h"
#include "apps/page/html.h"
#include "apps/page/svg.h"
#include "apps/report/report_sweep.h"
#include "apps/simulate/simulate.h"
#include "apps/study/rows/sweep_rows.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/io/codecs/codecs.h"
#include "radiometry/light/blackbody.h"

namespace apps {
namespace {

using Chosen = std::vector<ChosenDesign>;

std::vector<std::string> header_of(const std::string& first, const Chosen& chosen) {
  std::vector<std::string> header{first};
  for (const ChosenDesign& design : chosen)
    header.push_back("<span class=\"key\" data-design=\"" + std::to_string(design.chosen.design) + "\">" +
                     std::to_string(design.chosen.design) + "</span>");
  return header;
}

std::vector<std::size_t> all_but_first(const Chosen& chosen) {
  std::vector<std::size_t> columns(chosen.size());
  for (std::size_t i = 0; i < columns.size(); ++i) columns[i] = i + 1;
  return columns;
}

/// How far a metric of a row may be wrong, by the row's largest error, which counts absolute for plain numbers up to 1,
/// else relative; the standard deviation of a yield.
std::string spread_of(const Sweep& sweep, const std::vector<std::string>& cells, std::size_t column) {
  const SweepColumn& of = sweep.columns[column];
  const std::optional<double> value = cell_value(cells[column]);
  if (value && of.role == "yield") return significant(study::yield_error(*value, static_cast<int>(sweep.draws)), 2);
  const auto error = sweep.column("error");
  if (!value || !error || of.role != "metric") return "";
  return significant(
      cell_value(cells[*error]).value_or(NAN) * (of.unit.empty() && std::abs(*value) <= 1.0 ? 1.0 : std::abs(*value)),
      2);
}

/// The chosen designs side by side; of the only one also errors and what its quantities are.
std::string values(const Sweep& sweep, const DesignTable& table, const Chosen& chosen) {
  std::vector<std::string> header = header_of("Design", chosen), why{"chosen as"};
  if (sweep.single()) header.insert(header.end(), {"&plusmn;", "What it is"});
  for (const ChosenDesign& design : chosen) why.push_back("<span class=\"why\">" + html(design.chosen.why) + "</span>");
  HtmlTable rows("Values of the chosen designs", header,
                 sweep.single() ? std::vector<std::size_t>{1, 2} : all_but_first(chosen));
  if (!sweep.single()) rows.add(why);
  for (std::size_t c = 0; c < sweep.columns.size(); ++c) {
    const SweepColumn& column = sweep.columns[c];
    if (!column.gap.empty()) continue;
    std::vector<std::string> cells{
        column_html(column) + (column.unit.empty() ? "" : " <span class=\"unit\">" + html(column.unit) + "</span>")};
    for (const ChosenDesign& design : chosen) {
      const auto row = table.row(design.chosen.design);
      const std::string cell = row ? table.cells[*row][c] : "";
      const bool yes_or_no = column.role == "feasible" || column.role == "pareto";
      cells.push_back(yes_or_no ? (cell == "1" ? "yes" : "no") : html_value(cell));
    }
    if (sweep.single()) cells.insert(cells.end(), {spread_of(sweep, table.cells[0], c), html(column.definition)});
    rows.add(cells);
  }
  return rows.html() +
         (sweep.single()
              ? "<p>&plusmn;: a metric is wrong by at most this, estimated; of the yield one standard deviation.</p>\n"
              : "");
}

std::string problems(const Chosen& chosen) {
  std::string text;
  for (const ChosenDesign& design : chosen)
    if (!design.problem.empty())
      text += "<p class=\"gap\"><strong>Design " + std::to_string(design.chosen.design) +
              "</strong> has no curves, budget and image: " + html(design.problem) + ".</p>\n";
  return text;
}

std::string static_curves(const Chosen& chosen) {
  Figure figure;
  figure.title = "MTF of the chosen designs, along x";
  figure.x_label = "spatial frequency along x (cy/mm)";
  figure.y_label = "MTF";
  figure.y_low = 0.0;
  figure.y_high = 1.0;
  for (const ChosenDesign& design : chosen)
    if (design.problem.empty())
      figure.series.push_back({.name = "design " + std::to_string(design.chosen.design),
                               .x = design.frequency_cy_mm,
                               .y = design.system.mtf});
  return svg_figure(figure);
}

/// What each component leaves at Nyquist along x: the budget of the MTF.
std::string component_budget(const Chosen& chosen) {
  std::vector<std::pair<std::string, std::string>> labels;  // with what they are
  for (const ChosenDesign& design : chosen)
    for (const ChosenCurve& curve : design.components)
      if (std::none_of(labels.begin(), labels.end(), [&](const auto& l) { return l.first == curve.label; }))
        labels.emplace_back(curve.label, curve.doc);
  if (labels.empty()) return "";
  HtmlTable rows("MTF at Nyquist along x, by component", header_of("Component", chosen), all_but_first(chosen));
  for (const auto& [label, doc] : labels) {
    std::vector<std::string> cells{"<abbr title=\"" + html(doc) + "\">" + html(label) + "</abbr>"};
    for (const ChosenDesign& design : chosen) {
      const auto found = std::find_if(design.components.begin(), design.components.end(),
                                      [&, name = label](const auto& curve) { return curve.label == name; });
      cells.push_back(found == design.components.end() ? html_value("") : html_value(found->at_nyquist));
    }
    rows.add(cells);
  }
  std::vector<std::string> product{"<strong>system</strong>"},
      nyquist{"Nyquist frequency along x <span class=\"unit\">cy/mm</span>"};
  for (const ChosenDesign& design : chosen) {
    product.push_back(design.problem.empty() ? html_value(design.system.at_nyquist) : html_value(""));
    nyquist.push_back(design.problem.empty() ? html_value(design.nyquist_cy_mm) : html_value(""));
  }
  rows.add(product);
  rows.add(nyquist);
  return rows.html();
}

std::string images(const Chosen& chosen, const std::string& scene) {
  std::string text =
      "<h3>Simulated images</h3>\n<p>" +
      (scene.empty()
           ? std::string("One computed scene of the same angular size for all, as <code>mtf simulate</code> images it "
                         "with noise: temperatures about the study's where sensors take temperatures, below "
                         "3 &micro;m sunlit ground.")
           : "The scene <code>" + html(scene) + "</code>, its middle part of the same angle for all.") +
      " Each is stretched between its own quantiles of 0.5 and 99.5 %, so contrast against noise can be compared, "
      "brightness cannot; values beyond these are clipped to black or white. The OTF is kept to 0.2 %, half a grey "
      "value.</p>\n<div class=\"images\">";
  std::string gaps;
  for (const ChosenDesign& design : chosen) {
    const ChosenImage& image = design.image;
    const std::string number = std::to_string(design.chosen.design);
    if (image.data_uri.empty()) {
      if (design.problem.empty())
        gaps += "<p class=\"gap\"><strong>Design " + number + "</strong> has no image: " + html(design.image_gap) +
                ".</p>\n";
      continue;
    }
    std::string notes;
    for (const std::string& note : image.notes) notes += "<br>" + html(note);
    text += "<figure><img src=\"" + image.data_uri +
            "\" width=\"220\" height=\"220\" alt=\"simulated image of design " + number +
            "\"><figcaption><span class=\"key\" data-design=\"" + number + "\">" + number + "</span> " +
            html(design.chosen.why) + "<br><span class=\"greys\"><span>&le; " + significant(image.low, 4) +
            "</span><span>" + html(image.unit) + "</span><span>&ge; " + significant(image.high, 4) +
            "</span></span><small>" + std::to_string(image.width) + " &times; " + std::to_string(image.height) + " px" +
            notes + "</small></figcaption></figure>\n";
  }
  return text + "</div>\n" + gaps;
}

std::string noise_budget(const Chosen& chosen, double temperature_k) {
  const auto with = std::find_if(chosen.begin(), chosen.end(), [](const auto& d) { return !d.budget.empty(); });
  std::string gaps;
  for (const ChosenDesign& design : chosen)
    if (design.budget.empty() && design.problem.empty())
      gaps += "<p class=\"gap\"><strong>Design " + std::to_string(design.chosen.design) +
              "</strong> has no noise budget: " + html(design.budget_gap) + ".</p>\n";
  for (const ChosenDesign& design : chosen)
    if (!design.saturation.empty())
      gaps += "<p class=\"gap\"><strong>Design " + std::to_string(design.chosen.design) + "</strong> is " +
              html(design.saturation) + ".</p>\n";
  if (with == chosen.end()) return "<h3>Noise budget</h3>\n" + gaps;
  const std::string surface = mtf::format_double(temperature_k) + " K";
  HtmlTable rows("Noise budget of a pixel that images " + surface, header_of("Term", chosen), all_but_first(chosen));
  for (std::size_t i = 0; i < with->budget.size(); ++i) {
    const radiometry::BudgetRow& row = with->budget[i];
    std::vector<std::string> cells{"<abbr title=\"" + html(row.doc) + "\">" + html(row.name) +
                                   "</abbr> <span class=\"unit\">" + html(row.unit) + "</span>"};
    for (const ChosenDesign& design : chosen) {
      const auto same = std::ranges::find_if(
          design.budget, [&](const auto& other) { return other.name == row.name && other.unit == row.unit; });
      cells.push_back(same == design.budget.end() ? html_value("")
                      : same->saturated           ? "saturated"
                                                  : html_value(same->value));
    }
    rows.add(cells);
  }
  std::vector<Bar> bars;
  std::string unit;  // of the first design: volts and electrons do not share an axis
  for (const ChosenDesign& design : chosen)
    for (const radiometry::BudgetRow& row : design.budget) {
      if (row.name != "temporal" || !row.refused.empty()) continue;
      if (unit.empty()) unit = row.unit;
      if (row.unit == unit) bars.push_back({"design " + std::to_string(design.chosen.design), row.value, 0.0});
    }
  return "<h3>Noise budget</h3>\n<p>Of a pixel on the optical axis that images a surface of " + surface +
         ", as in <code>mtf budget</code>. Variances add: bars are shares of the temporal variance.</p>\n" +
         html_chart("noise",
                    svg_bars("Temporal noise", (unit == "V" ? "volts" : "electrons") + std::string(" rms"), bars)) +
         "<details><summary>All terms</summary>" + rows.html() + "</details>\n" + gaps;
}

constexpr std::int64_t kPixels = 160;                  // of the design with the smallest pixels, a side
constexpr std::int64_t kSamplesAPixel = 4;             // of the scene
constexpr std::int64_t kMostPixels = 1 << 26;          // of a scene file
constexpr double kTolerance = 2e-3;                    // half a grey value of the picture
constexpr double kSun_k = 5772.0, kSun_sr = 6.794e-5;  // IAU 2015 nominal values; solid angle at 1 au

double ifov_urad(const mtf::Frame<double>& frame, mtf::Axis axis) {
  return frame.pitch_um(axis) / frame.focal_length_mm * 1e3;
}

/// The landscape, normalised: mean 0, standard deviation 1.
mtf::Image landscape() {
  mtf::Image image = demo_landscape(kPixels * kSamplesAPixel);
  const mtf::Statistics s = mtf::statistics(image.view());
  for (float& v : std::span(image.data(), static_cast<std::size_t>(image.size())))
    v = static_cast<float>((static_cast<double>(v) - s.mean) / s.std);
  return image;
}

/// Temperatures about the study's, 5 K rms of 300 K; in sunlight, for bands below 3 um, radiance of reflectances about
/// 0.25 under a sun 45 degrees high.
void give_values(const mtf::io::SensorConfig& config, double temperature_k, mtf::io::Scene& scene) {
  const double middle_um = config.system.context().wavelength_um;
  const double lo = config.system.band ? config.system.band->lo_um : 0.95 * middle_um;
  const double hi = config.system.band ? config.system.band->hi_um : 1.05 * middle_um;
  const bool thermal = lo >= 3.0 || config.scene.quantity == mtf::io::Quantity::temperature;
  scene.quantity = thermal ? mtf::io::Quantity::temperature : mtf::io::Quantity::radiance;
  const double sun = radiometry::band_radiance(radiometry::Flux::watts, lo, hi, kSun_k) * kSun_sr *
                     std::numbers::sqrt2 / 2.0 / std::numbers::pi;
  mtf::Image& plane = scene.planes.front();
  for (float& v : std::span(plane.data(), static_cast<std::size_t>(plane.size()))) {
    const double x = static_cast<double>(v);
    v = static_cast<float>(thermal ? temperature_k * std::max(0.0, 1.0 + x / 60.0)
                                   : sun * std::max(0.02, 0.25 + 0.08 * x));
  }
}

SceneSource built_in(const mtf::io::SensorConfig& config, const mtf::Image& picture, double temperature_k,
                     double sample_urad) {
  const double step_um = sample_urad * config.system.frame.focal_length_mm * 1e-3;
  mtf::io::Scene scene;
  scene.names = {"Y"};
  scene.grid = {picture.width(), picture.height(), step_um, step_um};
  scene.planes.push_back(picture.clone());
  give_values(config, temperature_k, scene);
  return {.image = std::move(scene)};
}

SceneSource from_file(const std::string& path) {
  const mtf::io::FileInfo info = mtf::io::read_info(path);
  if (info.width * info.height > kMostPixels)
    throw mtf::UsageError(path + ": has more than " + std::to_string(kMostPixels) +
                          " pixels; give a part of it as --scene");
  return {.file = path};
}

mtf::Image image_of(mtf::io::SensorConfig config, SceneSource source, int threads, ChosenImage& out) {
  if (source.image) {  // it has no blur of its own, and nothing is known of what lies around it
    config.scene.aperture = mtf::io::Aperture::point;
    config.scene.border = mtf::Border::reflect;
  }
  SimulateResult result = [&] {
    try {
      return simulate(config, clone(source), {.tolerance = kTolerance, .threads = threads});
    } catch (const mtf::UnreachableTolerance&) {  // without one, the least that can be kept is used, with a warning
      return simulate(config, std::move(source), {.threads = threads});
    }
  }();
  out.notes = result.report.warnings;
  if (result.report.chain) out.unit = result.report.unit();
  return std::move(result.images.front().planes.front());
}

/// The middle of the image, no larger than that.
mtf::Image middle(const mtf::Image& image, std::int64_t width, std::int64_t height) {
  const std::int64_t w = std::clamp<std::int64_t>(width, 1, image.width()),
                     h = std::clamp<std::int64_t>(height, 1, image.height());
  return copy_of(part_of(image.view(), {(image.width() - w) / 2, (image.height() - h) / 2, w, h}));
}

/// Grey values between the quantiles of 0.5 and 99.5 %.
mtf::io::RasterData grey(const mtf::Image& image, ChosenImage& out) {
  std::vector<float> sorted(image.data(), image.data() + image.size());
  std::sort(sorted.begin(), sorted.end());
  const auto quantile = [&](double share) {
    return static_cast<double>(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]);
  };
  out.low = quantile(0.005);
  out.high = quantile(0.995);
  const double range = out.high > out.low ? out.high - out.low : 1.0;
  mtf::io::RasterData data{image.width(), image.height(), 1, 8, {}, {}};
  data.samples.reserve(sorted.size());
  for (std::int64_t i = 0; i < image.size(); ++i)
    data.samples.push_back(static_cast<std::uint16_t>(
        std::lround(255.0 * std::clamp((static_cast<double>(image.data()[i]) - out.low) / range, 0.0, 1.0))));
  return data;
}

std::string png(const mtf::io::RasterData& data) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
  if (!file) throw mtf::RuntimeError("there is no room for temporary files; set TMPDIR to a folder that has some");
  if (mtf::io::codecs().encode_png(fileno(file.get()), data) != 0)
    throw mtf::RuntimeError("a temporary file cannot be written; is the disk full?");
  std::string bytes;
  std::rewind(file.get());
  for (int c = std::fgetc(file.get()); c != EOF; c = std::fgetc(file.get())) bytes += static_cast<char>(c);
  return bytes;
}

}  // namespace

std::string chosen_section(const Sweep& sweep, const DesignTable& table, const Chosen& chosen,
                           const std::string& scene) {
  if (chosen.empty()) return html_section("chosen", "Chosen designs", "", "<p class=\"gap\">The sweep chose none.</p>");
  std::string body = problems(chosen) + values(sweep, table, chosen);
  if (std::any_of(chosen.begin(), chosen.end(), [](const auto& d) { return d.problem.empty(); }))
    body +=
        "<h3>MTF</h3>\n" + html_chart("curves", static_curves(chosen)) +
        "<p>What each component leaves of the modulation at Nyquist, along x; the metric <code>mtf_nyquist</code> is "
        "the geometric mean of both axes:</p>\n" +
        component_budget(chosen) + images(chosen, scene) + noise_budget(chosen, sweep.temperature_k);
  if (sweep.single()) return html_section("chosen", "Data sheet", html(chosen[0].name), body);
  return html_section("chosen", "Chosen designs", "The best of each objective, and some from along the Pareto front.",
                      body);
}

// Simulated images of the chosen designs, as `mtf simulate` makes them, of one scene.

void simulate_chosen(std::vector<ChosenDesign>& designs, const std::string& scene, double temperature_k,
                     const Global& global) {
  double finest_urad = HUGE_VAL;
  for (const ChosenDesign& design : designs)
    if (design.problem.empty())
      for (const mtf::Axis axis : {mtf::Axis::x, mtf::Axis::y})
        finest_urad = std::min(finest_urad, ifov_urad(design.config.system.frame, axis));
  if (!std::isfinite(finest_urad)) return;
  const mtf::Image picture = scene.empty() ? landscape() : mtf::Image();
  for (ChosenDesign& design : designs) {
    if (!design.problem.empty()) continue;
    try {
      const mtf::io::SensorConfig& config = design.config;
      SceneSource source =
          scene.empty() ? built_in(config, picture, temperature_k, finest_urad / static_cast<double>(kSamplesAPixel))
                        : from_file(scene);
      const mtf::Image whole = image_of(config, std::move(source), global.threads, design.image);
      const auto pixels = [&](mtf::Axis axis) {
        return std::llround(static_cast<double>(kPixels) * finest_urad / ifov_urad(config.system.frame, axis));
      };
      const mtf::Image part = middle(whole, pixels(mtf::Axis::x), pixels(mtf::Axis::y));
      design.image.width = part.width();
      design.image.height = part.height();
      design.image.data_uri = "data:image/png;base64," + base64(png(grey(part, design.image)));
    } catch (const std::exception& error) {
      design.image_gap = one_line(error.what());
    }
  }
}

}  // namespace apps
