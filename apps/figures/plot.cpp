// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/plot.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <limits>
#include <string_view>
#include <system_error>

#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace apps {
namespace {

// What gnuplot is told to draw figures: data, axes, legends, colours and symbols.

enum class Medium { svg, pdf, png, characters };

/// More points of a series do not show; the CSV has all of them.
constexpr std::size_t kMaxPoints = 4000;

// Distinct for colour-blind readers too, dark enough on white (after Okabe and Ito).
constexpr std::array<std::string_view, 7> kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                   "#e69f00", "#56b4e9", "#7f6000"};

/// A literal: nothing is special in single quotes but the quote itself.
std::string gnuplot_string(std::string_view text) {
  std::string literal = "'";
  for (const char c : mtf::printable(text, 120)) literal += c == '\'' ? std::string("''") : std::string(1, c);
  return literal + "'";
}

std::string terminal(Medium medium, int columns, int rows, int panels, bool maps) {
  // Panels side by side are narrower than a figure alone, so that the type of all is readable on one screen. Those of
  // maps have colour bars to the right of them.
  const int percent = panels == 1 ? 100 : (maps ? 75 : 50) * panels;
  const auto wide = [&](int width) { return std::to_string(width * percent / 100); };
  switch (medium) {
    case Medium::svg:
      return "svg size " + wide(960) + ",560 noenhanced font 'DejaVu Sans,Arial,sans-serif,15' background '#ffffff'";
    case Medium::pdf:  // in a PDF gnuplot halves the size of type unless told otherwise
      return "pdfcairo size " + wide(20) +
             "cm,11.7cm noenhanced fontscale 0.8 font 'DejaVu Sans,11' background '#ffffff'";
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
              ", graph 1 offset 0," + (raised ? "1.9" : "0.7") + " center tc rgb '#505050'";
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
    // The symbols of gnuplot's SVG are larger than those of its other figures.
    const bool large = series.mark == Mark::large_points;
    const std::string size =
        std::string(" ps ") + (medium == Medium::svg ? (large ? "1.6" : "0.9") : (large ? "2.4" : "1.3"));
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

/// Ticks at 1, 2 and 5 times the powers of ten, where the range holds few of these.
std::string log_tics(std::array<double, 2> range) {
  const double decades = std::log10(range[1] / range[0]);
  if (!(decades < 3.0)) return "";
  std::string text;
  for (int power = static_cast<int>(std::floor(std::log10(range[0]))); std::pow(10.0, power) <= range[1]; ++power)
    for (const double multiple : {1.0, 2.0, 5.0}) {
      const double at = multiple * std::pow(10.0, power);
      if (at >= range[0] && at <= range[1]) text += (text.empty() ? "" : ", ") + mtf::format_double(at);
    }
  return text.empty() ? "" : "set xtics (" + text + ")\n";
}

/// Rows of two that the legends of panels need; 0 for a figure alone.
std::size_t legend_rows(std::span<const Figure> figures) {
  std::size_t most = 0;
  for (const Figure& figure : figures) most = std::max(most, figure.series.size());
  return figures.size() > 1 ? (most + 1) / 2 : 0;
}

/// The legend stands beside a figure alone and below a panel, where it never covers a curve. gnuplot leaves too little
/// room below the label of the x axis for the latter, so the margin is set.
std::string legend(Medium medium, std::size_t rows) {
  if (medium == Medium::characters) return "set key outside bottom center horizontal\n";
  if (rows == 0) return "set key outside right center Left reverse samplen 2 spacing 1.25\n";
  return "set key outside bottom center horizontal maxcols 2 Left reverse samplen 2 spacing 1.25\nset bmargin " +
         std::to_string(4 + 2 * rows) + "\n";
}

/// Of the figure's x axis. Throws UsageError where the figure has no point that can be drawn.
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

std::string plot_commands(const Figure& figure, std::size_t panel, Medium medium, std::size_t rows) {
  const std::array<double, 2> range = x_range(figure);
  const bool characters = medium == Medium::characters;
  std::string text = "unset arrow\nunset label\nunset logscale\nset xtics autofreq\nset format '% h'\nset bmargin\n";
  text += "set title " + gnuplot_string(figure.title) + (characters ? "\n" : " offset 0,2\n");
  text += "set xlabel " + gnuplot_string(figure.x_label) + "\nset ylabel " + gnuplot_string(figure.y_label) + "\n";
  text += "set xrange [" + mtf::format_double(range[0]) + ":" + mtf::format_double(range[1]) + "]\n";
  text += "set yrange [" + (figure.y_low ? mtf::format_double(*figure.y_low) : "*") + ":" +
          (figure.y_high ? mtf::format_double(*figure.y_high) : "*") + "]\n";
  if (figure.log_x) text += "set logscale x\n" + log_tics(range);
  if (figure.log_y) text += "set logscale y\nset format y '%.0e'\n";
  if (figure.equal_axes && !characters) return text + map_commands(figure, panel);
  text += vertical_lines(figure, range, medium);
  text += legend(medium, rows);
  if (!characters)
    text +=
        "set tmargin 5.5\nset border 3 lc rgb '#404040'\nset tics nomirror out scale 0.6\n"
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
             style(figure.series[i], figure.series[i].style.value_or(figure.series[i].emphasised ? 0 : thin++), medium);
  return text + plots + "\n";
}

/// Figures side by side. `columns` and `rows` are the size of a drawing in characters.
std::string gnuplot_script(std::span<const Figure> figures, Medium medium, int columns = 0, int rows = 0) {
  const int panels = static_cast<int>(figures.size());
  std::string text =
      "set encoding utf8\nset terminal " + terminal(medium, columns, rows, panels, figures.front().equal_axes) + "\n";
  for (std::size_t panel = 0; panel < figures.size(); ++panel)
    for (std::size_t i = 0; i < figures[panel].series.size(); ++i) text += data_block(figures[panel], panel, i);
  if (panels > 1) text += "set multiplot layout 1," + std::to_string(panels) + "\n";
  for (std::size_t panel = 0; panel < figures.size(); ++panel)
    text += plot_commands(figures[panel], panel, medium, legend_rows(figures));
  return text;
}

constexpr std::chrono::seconds kPatience{60};

class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    close();
    number_ = other.release();
    return *this;
  }
  int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int release() {
    const int number = number_;
    number_ = -1;
    return number;
  }
  int number_;
};

struct Pipe {
  Descriptor read, write;
};

Pipe make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    throw mtf::RuntimeError("cannot start gnuplot: " + std::generic_category().message(errno));
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

/// The process id, or 0 when there is no gnuplot.
pid_t spawn(const Pipe& in, const Pipe& out, const Pipe& err) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in.read.number(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out.write.number(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.write.number(), STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);

  std::array<std::string, 3> words{"gnuplot", "--default-settings", "-"};
  std::array<char*, 4> arguments{words[0].data(), words[1].data(), words[2].data(), nullptr};
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, "gnuplot", &actions, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error == ENOENT || error == EACCES || error == ENOTDIR) return 0;
  if (error != 0) throw mtf::RuntimeError("cannot start gnuplot: " + std::generic_category().message(error));
  return child;
}

/// Reads what is there; closes at the end of the stream.
void drain(Descriptor& from, std::string& to) {
  std::array<char, 65536> bytes{};
  const ssize_t count = ::read(from.number(), bytes.data(), bytes.size());
  if (count > 0)
    to.append(bytes.data(), static_cast<std::size_t>(count));
  else if (count == 0 || errno != EINTR)
    from.close();
}

/// Feeds and empties the pipes at once, so that neither side waits for the other. False when time is up.
bool exchange(std::string_view script, Descriptor& in, Descriptor& out, Descriptor& err, std::string& figure,
              std::string& messages) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  ::fcntl(in.number(), F_SETFL, O_NONBLOCK);
  while (out.number() >= 0 || err.number() >= 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    std::array<pollfd, 3> ends{{{in.number(), POLLOUT, 0}, {out.number(), POLLIN, 0}, {err.number(), POLLIN, 0}}};
    if (::poll(ends.data(), ends.size(), static_cast<int>(left.count())) < 0 && errno != EINTR) return false;
    if (ends[0].revents != 0) {
      const ssize_t count = ::write(in.number(), script.data(), script.size());
      if (count > 0) script.remove_prefix(static_cast<std::size_t>(count));
      if (script.empty() || (count < 0 && errno != EAGAIN && errno != EINTR)) in.close();
    }
    if (ends[1].revents != 0) drain(out, figure);
    if (ends[2].revents != 0) drain(err, messages);
  }
  return true;
}

std::string last_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return mtf::printable(text.substr(text.rfind('\n') + 1));
}

/// Runs gnuplot on `script` (without the user's settings) and returns what it writes to its standard output: the
/// figure, when the script sets no output. Nothing when gnuplot is not installed. Throws RuntimeError with gnuplot's
/// last words when it fails or takes longer than a minute.
std::optional<std::string> run_gnuplot(const std::string& script) {
  Pipe in = make_pipe(), out = make_pipe(), err = make_pipe();
  const pid_t child = spawn(in, out, err);
  if (child == 0) return std::nullopt;
  in.read.close();
  out.write.close();
  err.write.close();
  std::string figure, messages;
  const bool in_time = exchange(script, in.write, out.read, err.read, figure, messages);
  if (!in_time) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!in_time) throw mtf::RuntimeError("gnuplot did not finish within a minute; the data are in the CSV file");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || figure.empty())
    throw mtf::RuntimeError("gnuplot failed: " + (messages.empty() ? "it drew nothing" : last_line(messages)) +
                            "; the data are in the CSV file");
  return figure;
}

std::string extension(const std::string& path) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos || path.find('/', dot) != std::string::npos) return "";
  return mtf::lower_case(path.substr(dot));
}

Medium medium_of(const std::string& path) {
  const std::string ending = extension(path);
  if (ending == ".svg") return Medium::svg;
  if (ending == ".pdf") return Medium::pdf;
  if (ending == ".png") return Medium::png;
  throw mtf::UsageError(path + ": a figure is a .svg, .pdf or .png file");
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

/// "plot.svg" -> "plot.svg.csv": not "plot.csv", which may be a file of the user's.
std::string figure_data_path(const std::string& path) { return path + ".csv"; }

}  // namespace

std::vector<std::string> figure_files(const std::string& path) {
  if (path.empty()) return {};
  static_cast<void>(medium_of(path));
  return {path, figure_data_path(path)};
}

bool write_figure(const std::string& path, const Figure& figure) {
  return write_figures(path, {&figure, 1}, figure_csv(figure));
}

bool write_figures(const std::string& path, std::span<const Figure> figures, const std::string& data) {
  static_cast<void>(medium_of(path));
  // A figure without anything to draw is refused before anything is written.
  for (const Figure& figure : figures) static_cast<void>(x_range(figure));
  mtf::io::write_text_file(figure_data_path(path), data);
  return draw(path, figures);
}

bool write_figures(const std::string& path, std::span<const Figure> figures) {
  return write_figures(path, figures, figures_csv(figures));
}

std::string figure_note(const std::string& path, bool drawn) {
  const std::string data = one_line(figure_data_path(path));
  return drawn ? "wrote " + one_line(path) + " and its data " + data
               : "mtf: note: gnuplot is not installed (Debian package gnuplot-nox): wrote only the data, " + data;
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
