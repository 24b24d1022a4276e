// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>

#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/raw/envi.h"
#include "mtf/words.h"
#include "mtf/work/stop.h"

namespace mtf::io {
namespace {

/// As a value in braces, or as an item of a list of them.
std::string braced(std::string text, bool item) {
  for (char& c : text) {
    if (c == '{') c = '(';
    if (c == '}') c = ')';
    if (item && (c == ',' || c == '\n')) c = ';';
  }
  return item ? text : "{" + text + "}";
}

std::string envi_header(const std::string& path, const std::vector<std::string>& names, std::int64_t width,
                        std::int64_t height, const Metadata& metadata) {
  const auto whole = [](std::int64_t number) { return std::to_string(number); };
  std::string text = "ENVI\nsamples = " + whole(width) + "\nlines = " + whole(height) +
                     "\nbands = " + whole(std::ssize(names)) +
                     "\nheader offset = 0\nfile type = ENVI Standard\ndata type = 4\ninterleave = " +
                     (names.size() == 1 ? "bsq" : "bil") + "\nbyte order = 0\nband names = {" +
                     joined(names, [](const std::string& name) { return braced(name, true); }) + "}\n";
  const auto wavelengths = metadata.lists.find("mtf:wavelength");
  const bool spectral = wavelengths != metadata.lists.end() && wavelengths->second.size() == names.size();
  if (spectral)
    text += "wavelength units = Micrometers\nwavelength = {" + joined(wavelengths->second, number_text<float>) + "}\n";
  for (const auto& [name, words] : words_of(metadata)) {
    if (spectral && name == "mtf:wavelength") continue;
    if (name.empty() || name.find_first_of("=\n;") != std::string::npos ||
        text.find("\n" + lower_case(name) + " = ") != std::string::npos)
      throw UsageError(path + ": attribute '" + printable(name, 40) +
                       "' is a key of ENVI, or cannot be one; rename it");
    text += name + " = " + braced(words, false) + "\n";
  }
  return text;
}

}  // namespace

std::vector<std::string> envi_files(const std::string& path) {
  const bool header = lower_case(path).ends_with(".hdr");
  const std::string other = std::filesystem::path(path).replace_extension(header ? ".img" : ".hdr").string();
  return header ? std::vector{path, other} : std::vector{other, path};
}

void write_envi(const std::string& path, const std::vector<std::string>& names, std::int64_t width, std::int64_t height,
                const ReadRows& rows, const Metadata& metadata) {
  check_plane_pixels(path, width, height);
  const std::vector<std::string> files = envi_files(path);
  AtomicFile header(files[0]), numbers(files[1]);
  const std::string text = envi_header(path, names, width, height, metadata);
  header.write(text.data(), text.size());
  constexpr std::int64_t kTogether = 256;
  std::vector<Image> planes;
  for (std::size_t c = 0; c < names.size(); ++c) planes.emplace_back(width, std::min(kTogether, height));
  for (std::int64_t first = 0; first < height; first += kTogether) {
    require_going_on();
    std::vector<ImageView<float>> views;
    for (Image& plane : planes) views.push_back({plane.data(), width, std::min(kTogether, height - first), width});
    rows(first, views);
    for (std::int64_t y = 0; y < views.front().height; ++y)
      for (const ImageView<float>& view : views)
        numbers.write(view.row(y), static_cast<std::size_t>(width) * sizeof(float));
  }
  numbers.commit();
  header.commit();
}

}  // namespace mtf::io
