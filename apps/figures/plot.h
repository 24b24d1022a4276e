// SPDX-License-Identifier: Apache-2.0
#pragma once

// Line figures through gnuplot: SVG, PDF, PNG and characters. The data of every figure file are written to a CSV file
// too, so that any program can draw it again. Labels are taken literally, whatever they contain.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace apps {

/// How a series is drawn. A single point of a line is drawn as a point.
enum class Mark { line, points, large_points };

struct Series {
  std::string name;
  std::vector<double> x{}, y{};  ///< of one length; what is not finite (or not positive on a log axis) leaves a gap
  bool emphasised = false;       ///< a thick black line or ring instead of a thin coloured one
  Mark mark = Mark::line;
  std::vector<double> low{}, high{};  ///< a band around the line, shaded; empty or of the same length
  std::vector<double> value{};        ///< colours of points, in Figure::colour_range; empty or of the same length
  std::vector<std::string> words{};   ///< next to points that have colours; empty or of the same length
  /// Number of colour and shape, for what has to have the same ones in every figure; else the place among the series.
  std::optional<std::size_t> style{};
};

struct VerticalLine {
  double x = 0.0;
  std::string label;
};

struct Figure {
  std::string title;
  std::string x_label, y_label;  ///< with units
  std::vector<Series> series;
  std::vector<VerticalLine> vertical_lines;  ///< drawn where they lie inside the x range
  bool log_x = false, log_y = false;
  std::optional<std::array<double, 2>> x_range;  ///< else from the data
  std::optional<double> y_low, y_high;           ///< limits of the y axis, else from the data; it may fall
  bool equal_axes = false;                       ///< a unit of x is as long as one of y
  std::array<double, 2> colour_range{0.0, 1.0};
  std::string colour_label;  ///< of the colours, with unit
};

/// The files that write_figure makes, of which a command says so before it begins: figure and data; none for "". Throws
/// UsageError unless the extension is .svg, .pdf or .png (any case).
std::vector<std::string> figure_files(const std::string& path);

/// Writes the data as CSV (17 digits) beside `path`, then the figure, both or neither. False when there is no gnuplot:
/// the CSV is there, the figure is not. Throws UsageError (extension) and RuntimeError.
bool write_figure(const std::string& path, const Figure& figure);

/// Several figures side by side in one file, one to four; the data have a column for the figure, or are `data`.
bool write_figures(const std::string& path, std::span<const Figure> figures);
bool write_figures(const std::string& path, std::span<const Figure> figures, const std::string& data);

/// What a command says of a figure that it was asked for: what was written, or that gnuplot is missing.
std::string figure_note(const std::string& path, bool drawn);

/// The figure alone, for data that have a file of their own. False when there is no gnuplot.
bool draw_figure(const std::string& path, const Figure& figure);

/// The figure in characters, or nothing when there is no gnuplot. Throws RuntimeError.
std::optional<std::string> ascii_figure(const Figure& figure, int columns, int rows);

/// The data: x and one column a series when all share their x, else series,x,y.
std::string figure_csv(const Figure& figure);

}  // namespace apps
