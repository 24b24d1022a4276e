// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/plot.h"

#include <algorithm>
#include <cctype>

#include "apps/figures/gnuplot.h"
#include "apps/figures/gnuplot_script.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/units.h"

namespace apps {
namespace {

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

std::string figures_csv(std::span<const Figure> figures) {
  std::string text = "figure,series,x,y,low,high\n";
  for (const Figure& figure : figures)
    for (const Series& series : figure.series)
      for (std::size_t i = 0; i < series.x.size(); ++i) {
        text += csv_field(figure.y_label) + "," + csv_field(series.name) + "," + csv_number(series.x[i]) + "," +
                csv_number(series.y[i]);
        text += series.low.empty() ? ",,\n" : "," + csv_number(series.low[i]) + "," + csv_number(series.high[i]) + "\n";
      }
  return text;
}

bool draw(const std::string& path, std::span<const Figure> figures) {
  const auto drawing = run_gnuplot(gnuplot_script(figures, medium_of(path)));
  if (drawing) mtf::io::write_text_file(path, *drawing);
  return drawing.has_value();
}

}  // namespace

std::string figure_data_path(const std::string& path) { return path + ".csv"; }

void check_figure_path(const std::string& path) { static_cast<void>(medium_of(path)); }

bool write_figure(const std::string& path, const Figure& figure) {
  return write_figures(path, {&figure, 1}, figure_csv(figure));
}

bool write_figures(const std::string& path, std::span<const Figure> figures, const std::string& data) {
  check_figure_path(path);
  // A figure without anything to draw is refused before anything is written.
  for (const Figure& figure : figures) static_cast<void>(x_range(figure));
  mtf::io::write_text_file(figure_data_path(path), data);
  return draw(path, figures);
}

bool write_figures(const std::string& path, std::span<const Figure> figures) {
  return write_figures(path, figures, figures_csv(figures));
}

bool draw_figure(const std::string& path, const Figure& figure) { return draw(path, {&figure, 1}); }

std::optional<std::string> ascii_figure(const Figure& figure, int columns, int rows) {
  auto drawing = run_gnuplot(gnuplot_script({&figure, 1}, Medium::characters, columns, rows));
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
