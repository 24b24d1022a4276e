// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/plot.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "apps/figures/gnuplot_script.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace apps {
namespace {

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
