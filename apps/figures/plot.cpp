// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/plot.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <string_view>

#include "apps/figures/gnuplot.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/file_checks.h"
#include "mtf/units.h"

namespace apps {
namespace {

/// More points of a series do not show; the CSV has all of them.
constexpr std::size_t kMaxPoints = 4000;

// Distinct for colour-blind readers too, dark enough on white (after Okabe and Ito).
constexpr std::array<std::string_view, 7> kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                   "#e69f00", "#56b4e9", "#7f6000"};

enum class Medium { svg, pdf, png, characters };

std::string extension(const std::string& path) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos || path.find('/', dot) != std::string::npos) return "";
  std::string text = path.substr(dot);
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

Medium medium_of(const std::string& path) {
  const std::string ending = extension(path);
  if (ending == ".svg") return Medium::svg;
  if (ending == ".pdf") return Medium::pdf;
  if (ending == ".png") return Medium::png;
  throw mtf::UsageError(path + ": a figure is a .svg, .pdf or .png file, or the word ascii");
}

/// A literal: nothing is special in single quotes but the quote itself.
std::string gnuplot_string(std::string_view text) {
  std::string literal = "'";
  for (const char c : mtf::io::printable(text, 120)) literal += c == '\'' ? std::string("''") : std::string(1, c);
  return literal + "'";
}

std::string terminal(Medium medium, int columns, int rows, int panels) {
  // Panels side by side are narrower than a figure alone.
  const int percent = panels == 1 ? 100 : 75 * panels;
  const auto wide = [&](int width) { return std::to_string(width * percent / 100); };
  switch (medium) {
    case Medium::svg:
      return "svg size " + wide(960) + ",560 noenhanced font 'DejaVu Sans,Arial,sans-serif,15' background '#ffffff'";
    case Medium::pdf:
      return "pdfcairo size " + wide(20) + "cm,11.7cm noenhanced font 'DejaVu Sans,11' background '#ffffff'";
    case Medium::png:
      return "pngcairo size " + wide(1200) + ",700 noenhanced font 'DejaVu Sans,14' background '#ffffff'";
    case Medium::characters:
      break;
  }
  return "dumb noenhanced size " + std::to_string(columns) + "," + std::to_string(rows);
}

bool drawable(const Figure& figure, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!figure.log_x || x > 0.0) && (!figure.log_y || y > 0.0);
}

std::array<double, 2> x_range(const Figure& figure) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Series& series : figure.series)
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!drawable(figure, series.x[i], series.y[i])) continue;
      low = std::min(low, series.x[i]);
      high = std::max(high, series.x[i]);
    }
  if (figure.equal_axes && figure.x_range) return *figure.x_range;  // a map may be empty
  if (low > high) throw mtf::UsageError("figure '" + figure.title + "' has no point that can be drawn");
  if (figure.x_range) return *figure.x_range;
  if (low < high) return {low, high};
  const double margin = figure.log_x || low != 0.0 ? 0.1 * std::abs(low) : 1.0;
  return {low - margin, high + margin};
}

/// Name of a series' data in the script: panel and place.
std::string block_name(std::size_t panel, std::size_t index) {
  return "$d" + std::to_string(panel) + "_" + std::to_string(index);
}

std::string data_block(const Figure& figure, std::size_t panel, std::size_t index) {
  const Series& series = figure.series[index];
  const bool band = !series.low.empty();
  std::string text = block_name(panel, index) + " << END_OF_DATA\n";
  const std::size_t count = series.x.size();
  const std::size_t shown = std::min(count, kMaxPoints);
  for (std::size_t k = 0; k < shown; ++k) {
    const std::size_t i = shown < 2 ? 0 : k * (count - 1) / (shown - 1);
    if (drawable(figure, series.x[i], series.y[i]))
      text += mtf::format_double(series.x[i]) + " " + mtf::format_double(series.y[i]) +
              (band ? " " + mtf::format_double(series.low[i]) + " " + mtf::format_double(series.high[i]) : "") +
              (series.value.empty() ? "" : " " + mtf::format_double(series.value[i])) +
              (series.words.empty() ? "" : " " + series.words[i]) + "\n";
    else
      text += "\n";
  }
  return text + "END_OF_DATA\n";
}

/// Labels stand above the plot, one line higher when they would run into the one before. Characters have no room for
/// them: there they are in the x label.
std::string vertical_lines(const Figure& figure, std::array<double, 2> range, Medium medium) {
  const auto fraction = [&](double x) {
    if (figure.log_x) return std::log(x / range[0]) / std::log(range[1] / range[0]);
    return (x - range[0]) / (range[1] - range[0]);
  };
  std::string text, labels;
  double last = -1.0;
  bool raised = false;
  for (const VerticalLine& line : figure.vertical_lines) {
    if (!(line.x >= range[0] && line.x <= range[1])) continue;
    const double at = fraction(line.x);
    raised = last >= 0.0 && std::abs(at - last) < 0.22 && !raised;
    last = at;
    const std::string x = mtf::format_double(line.x);
    text += "set arrow from first " + x + ", graph 0 to first " + x + ", graph 1 nohead back";
    if (medium != Medium::characters)
      text += " lc rgb '#808080' lw 1.4 dt (6,4)\nset label " + gnuplot_string(line.label) + " at first " + x +
              ", graph " + (raised ? "1.07" : "1.025") + " center tc rgb '#505050'";
    text += "\n";
    labels += (labels.empty() ? "   | " : ", ") + line.label;
  }
  if (medium == Medium::characters) text += "set xlabel " + gnuplot_string(figure.x_label + labels) + "\n";
  return text;
}

std::string style(const Series& series, std::size_t index, Medium medium) {
  if (series.mark != Mark::line) {
    // Filled shapes of gnuplot, one after the other; a ring around what is emphasised.
    constexpr std::array kShapes{7, 5, 9, 13, 11, 15};
    if (medium == Medium::characters) return "points";
    const char* size = series.mark == Mark::large_points ? " ps 2.4" : " ps 1.3";
    if (series.emphasised) return std::string("points pt 6 lc rgb '#000000' lw 2.2") + size;
    return "points pt " + std::to_string(kShapes[index % kShapes.size()]) + " lc rgb '" +
           std::string(kColours[index % kColours.size()]) + "'" + size;
  }
  const std::string with = series.x.size() == 1 ? "points pt 7" : "lines";
  if (medium == Medium::characters) return with;
  if (series.emphasised) return with + " lc rgb '#000000' lw 3.2";
  return with + " lc rgb '" + std::string(kColours[index % kColours.size()]) + "' lw 1.6" +
         (index >= kColours.size() && series.x.size() > 1 ? " dt (8,3)" : "");
}

/// A map: points in colour, with their words next to them.
std::string map_commands(const Figure& figure, std::size_t panel) {
  std::string text = "set size ratio -1\nunset key\nset tmargin 4.5\nset border 15 lc rgb '#404040'\n";
  text += "set tics nomirror out scale 0.6\nset grid lc rgb '#e4e4e4' lt 1 lw 0.8\n";
  text += "set palette defined (0 '#352a87', 1 '#0f77db', 2 '#10b1b2', 3 '#d1ba58', 4 '#f9fb0e')\n";
  text += "set cbrange [" + mtf::format_double(figure.colour_range[0]) + ":" +
          mtf::format_double(figure.colour_range[1]) + "]\nset cblabel " + gnuplot_string(figure.colour_label) + "\n";
  std::string plots;
  for (std::size_t i = 0; i < figure.series.size(); ++i) {
    const Series& series = figure.series[i];
    const std::string block = std::string(plots.empty() ? "plot " : ", ") + block_name(panel, i);
    if (series.x.empty()) {
      text += "set label 'none' at graph 0.5, graph 0.5 center tc rgb '#505050'\n";
      plots += std::string(plots.empty() ? "plot " : ", ") + "NaN notitle";
      continue;
    }
    plots += block + " using 1:2:3 notitle with points pt 7 ps 1.9 palette";
    if (!series.words.empty())
      plots += ", " + block_name(panel, i) + " using 1:2:4 notitle with labels offset 0,1 tc rgb '#303030'";
  }
  return text + plots + "\n";
}

std::string plot_commands(const Figure& figure, std::size_t panel, Medium medium, bool narrow) {
  const std::array<double, 2> range = x_range(figure);
  const bool characters = medium == Medium::characters;
  std::string text = "unset arrow\nunset label\nunset logscale\n";
  if (!figure.title.empty())
    text += "set title " + gnuplot_string(figure.title) + (characters ? "\n" : " offset 0,1.3\n");
  text += "set xlabel " + gnuplot_string(figure.x_label) + "\nset ylabel " + gnuplot_string(figure.y_label) + "\n";
  text += "set xrange [" + mtf::format_double(range[0]) + ":" + mtf::format_double(range[1]) + "]\n";
  text += "set yrange [" + (figure.y_low ? mtf::format_double(*figure.y_low) : "*") + ":" +
          (figure.y_high ? mtf::format_double(*figure.y_high) : "*") + "]\n";
  if (figure.log_x) text += "set logscale x\n";
  if (figure.log_y) text += "set logscale y\nset format y '%.0e'\n";
  if (figure.equal_axes && !characters) return text + map_commands(figure, panel);
  text += vertical_lines(figure, range, medium);
  text += characters || narrow ? "set key outside bottom center horizontal\n"
                               : "set key outside right center Left reverse samplen 2 spacing 1.25\n";
  if (!characters)
    text +=
        "set tmargin 4.5\nset border 3 lc rgb '#404040'\nset tics nomirror out scale 0.6\n"
        "set grid lc rgb '#e4e4e4' lt 1 lw 0.8\n";
  std::string plots;
  std::size_t thin = 0;
  for (std::size_t i = 0; i < figure.series.size(); ++i)
    if (!figure.series[i].low.empty() && !characters)
      plots += std::string(plots.empty() ? "plot " : ", ") + block_name(panel, i) +
               " using 1:3:4 notitle with filledcurves fc rgb '#b8d4ea' fs solid noborder";
  for (std::size_t i = 0; i < figure.series.size(); ++i)
    plots += std::string(plots.empty() ? "plot " : ", ") + block_name(panel, i) + " using 1:2 title " +
             gnuplot_string(figure.series[i].name) + " with " +
             style(figure.series[i], figure.series[i].emphasised ? 0 : thin++, medium);
  return text + plots + "\n";
}

std::string script(std::span<const Figure> figures, Medium medium, int columns, int rows) {
  const int panels = static_cast<int>(figures.size());
  std::string text = "set encoding utf8\nset terminal " + terminal(medium, columns, rows, panels) + "\n";
  for (std::size_t panel = 0; panel < figures.size(); ++panel)
    for (std::size_t i = 0; i < figures[panel].series.size(); ++i) text += data_block(figures[panel], panel, i);
  if (panels > 1) text += "set multiplot layout 1," + std::to_string(panels) + "\n";
  for (std::size_t panel = 0; panel < figures.size(); ++panel)
    text += plot_commands(figures[panel], panel, medium, panels > 1);
  return text;
}

bool draw(const std::string& path, std::span<const Figure> figures) {
  const auto drawing = run_gnuplot(script(figures, medium_of(path), 0, 0));
  if (drawing) mtf::io::write_text_file(path, *drawing);
  return drawing.has_value();
}

}  // namespace

std::string figure_data_path(const std::string& path) { return path + ".csv"; }

void check_figure_path(const std::string& path) { static_cast<void>(medium_of(path)); }

bool write_figure(const std::string& path, const Figure& figure) {
  static_cast<void>(x_range(figure));  // a figure without anything to draw is refused before anything is written
  check_figure_path(path);
  mtf::io::write_text_file(figure_data_path(path), figure_csv(figure));
  return draw_figure(path, figure);
}

bool write_figures(const std::string& path, std::span<const Figure> figures) {
  check_figure_path(path);
  std::string text = "figure,series,x,y,low,high\n";
  for (const Figure& figure : figures) {
    static_cast<void>(x_range(figure));
    for (const Series& series : figure.series)
      for (std::size_t i = 0; i < series.x.size(); ++i) {
        text += csv_field(figure.y_label) + "," + csv_field(series.name) + "," + csv_number(series.x[i]) + "," +
                csv_number(series.y[i]);
        text += series.low.empty() ? ",,\n" : "," + csv_number(series.low[i]) + "," + csv_number(series.high[i]) + "\n";
      }
  }
  mtf::io::write_text_file(figure_data_path(path), text);
  return draw(path, figures);
}

bool draw_figure(const std::string& path, const Figure& figure) { return draw(path, {&figure, 1}); }
bool draw_figures(const std::string& path, std::span<const Figure> figures) { return draw(path, figures); }

std::optional<std::string> ascii_figure(const Figure& figure, int columns, int rows) {
  auto drawing = run_gnuplot(script({&figure, 1}, Medium::characters, columns, rows));
  if (!drawing) return std::nullopt;
  std::string text;
  for (std::size_t at = drawing->find_first_not_of("\f\n"); at < drawing->size();) {
    const std::size_t end = std::min(drawing->find('\n', at), drawing->size());
    std::string line = drawing->substr(at, end - at);
    line.erase(line.find_last_not_of(' ') + 1);
    if (!line.empty() || !text.empty()) text += line + "\n";
    at = end + 1;
  }
  text.erase(text.find_last_not_of('\n') + 1);
  return text + "\n";
}

std::string figure_csv(const Figure& figure) {
  const auto& all = figure.series;
  const bool shared = std::all_of(all.begin(), all.end(), [&](const Series& s) { return s.x == all.front().x; });
  if (!shared) {
    std::string text = "series," + csv_field(figure.x_label) + "," + csv_field(figure.y_label) + "\n";
    for (const Series& series : all)
      for (std::size_t i = 0; i < series.x.size(); ++i)
        text += csv_field(series.name) + "," + csv_number(series.x[i]) + "," + csv_number(series.y[i]) + "\n";
    return text;
  }
  std::string text = csv_field(figure.x_label);
  for (const Series& series : all) text += "," + csv_field(series.name);
  text += "\n";
  for (std::size_t i = 0; !all.empty() && i < all.front().x.size(); ++i) {
    text += csv_number(all.front().x[i]);
    for (const Series& series : all) text += "," + csv_number(series.y[i]);
    text += "\n";
  }
  return text;
}

}  // namespace apps
