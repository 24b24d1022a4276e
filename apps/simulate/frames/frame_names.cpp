// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/frame_names.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/config/schedule.h"

namespace apps {
namespace {

constexpr int kMaxWidth = 18;
constexpr std::int64_t kMaxFrames = 10'000'000;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Length of the conversion at the front of `text`, which starts with a percent sign; 0 when it is none.
std::size_t conversion_length(std::string_view text) {
  std::size_t at = 1;
  while (at < text.size() && is_digit(text[at])) ++at;
  return at < text.size() && text[at] == 'd' ? at + 1 : 0;
}

/// Position of the first conversion from `at` on; %% is skipped.
std::size_t find_conversion(std::string_view text, std::size_t at) {
  for (; (at = text.find('%', at)) != std::string_view::npos; ++at) {
    if (text.substr(at).starts_with("%%"))
      ++at;
    else if (conversion_length(text.substr(at)) > 0)
      return at;
  }
  return std::string_view::npos;
}

std::string with_percents(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    result += text[i];
    if (text.substr(i).starts_with("%%")) ++i;
  }
  return result;
}

[[noreturn]] void missing(const std::string& name, std::int64_t frame, const std::string& remedy) {
  throw mtf::RuntimeError("frame " + std::to_string(frame) + " is missing: there is no " + one_line(name) + "; " +
                          remedy);
}

}  // namespace

std::vector<std::int64_t> frames_of(const FrameRange& range) {
  if (range.first < 0 || range.last < range.first || range.last > mtf::io::kLastFrame || range.step < 1)
    throw mtf::UsageError("--frames: " + std::to_string(range.first) + " to " + std::to_string(range.last) +
                          " in steps of " + std::to_string(range.step) +
                          "; give a first frame of 0 or more, a last one from there to " +
                          std::to_string(mtf::io::kLastFrame) + ", and a step of 1 or more");
  const std::int64_t count = (range.last - range.first) / range.step + 1;
  if (count > kMaxFrames)
    throw mtf::UsageError("--frames: " + std::to_string(count) + " frames are more than " + std::to_string(kMaxFrames) +
                          "; run them in parts");
  std::vector<std::int64_t> frames;
  for (std::int64_t i = 0; i < count; ++i) frames.push_back(range.first + i * range.step);
  return frames;
}

std::optional<FrameNames> FrameNames::parse(const std::string& path) {
  const std::size_t at = find_conversion(path, 0);
  if (at == std::string::npos) return std::nullopt;
  const std::size_t length = conversion_length(std::string_view(path).substr(at));
  if (find_conversion(path, at + length) != std::string::npos)
    throw mtf::UsageError(one_line(path) + ": more than one frame number; leave one, write %% for a percent sign");
  const std::size_t slash = path.rfind('/');
  const std::size_t start = slash == std::string::npos ? 0 : slash + 1;
  if (at < start)
    throw mtf::UsageError(one_line(path) + ": the frame number has to be in the name of the file, not of a folder");
  FrameNames names;
  names.pattern_ = path;
  names.folder_ = with_percents(path.substr(0, start));
  names.before_ = with_percents(path.substr(start, at - start));
  names.after_ = with_percents(path.substr(at + length));
  const std::string_view digits = std::string_view(path).substr(at + 1, length - 2);
  if (digits.starts_with('0')) names.fill_ = '0';
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), names.width_);
  if (!digits.empty() && (status != std::errc{} || names.width_ > kMaxWidth))
    throw mtf::UsageError(one_line(path) + ": a frame number of more than " + std::to_string(kMaxWidth) +
                          " digits; write for example %04d");
  return names;
}

std::string FrameNames::name(std::int64_t frame) const {
  const std::string digits = std::to_string(frame);
  const auto width = static_cast<std::size_t>(width_);
  return folder_ + before_ + std::string(width > digits.size() ? width - digits.size() : 0, fill_) + digits + after_;
}

std::optional<std::int64_t> FrameNames::frame_of(const std::string& path) const {
  const std::size_t slash = path.rfind('/');
  const std::string file = slash == std::string::npos ? path : path.substr(slash + 1);
  const std::string folder = slash == std::string::npos ? "" : path.substr(0, slash + 1);
  std::error_code ignored;
  if (folder != folder_ &&
      !std::filesystem::equivalent(folder.empty() ? "." : folder, folder_.empty() ? "." : folder_, ignored))
    return std::nullopt;
  if (!file.starts_with(before_) || !file.ends_with(after_) || file.size() < before_.size() + after_.size())
    return std::nullopt;
  std::string_view number = file;
  number.remove_prefix(before_.size());
  number.remove_suffix(after_.size());
  number.remove_prefix(std::min(number.find_first_not_of(' '), number.size()));
  std::int64_t frame = 0;
  const auto [end, status] = std::from_chars(number.data(), number.data() + number.size(), frame);
  if (status != std::errc{} || end != number.data() + number.size() || frame < 0 || frame > mtf::io::kLastFrame)
    return std::nullopt;
  return name(frame) == folder_ + file ? std::optional(frame) : std::nullopt;  // frame.1.exr is not frame.%04d.exr
}

bool FrameNames::is_among(const std::vector<std::int64_t>& frames, const std::string& path) const {
  const auto frame = frame_of(path);
  return frame && std::binary_search(frames.begin(), frames.end(), *frame);
}

std::vector<std::int64_t> FrameNames::numbers_in_folder(std::error_code& error) const {
  std::vector<std::int64_t> frames;
  const std::string folder = folder_.empty() ? "." : folder_;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (const auto frame = frame_of(folder_ + it->path().filename().string())) frames.push_back(*frame);
  return frames;
}

std::vector<std::string> FrameNames::links(const std::vector<std::int64_t>& frames) const {
  std::error_code ignored;  // a folder that nobody may list has no names that anybody can write
  std::vector<std::int64_t> there = numbers_in_folder(ignored);
  std::sort(there.begin(), there.end());
  std::vector<std::string> found;
  for (const std::int64_t frame : there)
    if (is_among(frames, name(frame)) &&
        std::filesystem::is_symlink(std::filesystem::symlink_status(name(frame), ignored)))
      found.push_back(name(frame));
  return found;
}

std::vector<std::int64_t> FrameNames::in_folder() const {
  std::error_code error;
  std::vector<std::int64_t> frames = numbers_in_folder(error);
  if (error)
    throw mtf::RuntimeError("cannot list " + one_line(folder_.empty() ? "." : folder_) + ": " + error.message() +
                            "; check the folder of " + one_line(pattern_));
  if (frames.empty())
    throw mtf::RuntimeError("there is no file " + one_line(pattern_) + " (" + one_line(name(1)) +
                            ", ...); check folder and digits");
  std::sort(frames.begin(), frames.end());
  return frames;
}

std::vector<std::int64_t> FrameNames::find(const std::optional<FrameRange>& range) const {
  if (range) {
    const std::vector<std::int64_t> frames = frames_of(*range);
    std::error_code error;
    for (const std::int64_t frame : frames)
      if (!std::filesystem::exists(name(frame), error))
        missing(name(frame), frame, "bring it, or choose others by --frames START:STOP[:STEP]");
    return frames;
  }
  const std::vector<std::int64_t> frames = in_folder();
  std::int64_t step = frames.size() > 1 ? frames[1] - frames[0] : 1;
  for (std::size_t i = 1; i < frames.size(); ++i) step = std::min(step, frames[i] - frames[i - 1]);
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (frames[i] - frames[i - 1] != step)
      missing(name(frames[i - 1] + step), frames[i - 1] + step,
              "bring it, or choose what is there: --frames " + std::to_string(frames.front()) + ":" +
                  std::to_string(frames[i - 1]) + " or " + std::to_string(frames[i]) + ":" +
                  std::to_string(frames.back()) + " (step " + std::to_string(step) + ")");
  return frames;
}

}  // namespace apps
