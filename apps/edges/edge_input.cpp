// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/edge_input.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/terminal/output.h"
#include "calib/find/find_edges.h"
#include "calib/find/no_data.h"
#include "calib/find/roi_file.h"
#include "mtf/error.h"
#include "mtf/io/codecs/encoding.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/plane_checks.h"
#include "mtf/io/scene.h"

namespace apps {
namespace {

using mtf::Image;

/// Luminance of linear R, G, B with the primaries of ITU-R BT.709.
constexpr std::array kLuminance{0.2126F, 0.7152F, 0.0722F};

/// Of a file of regions.
constexpr std::size_t kMostRegionBytes = std::size_t{16} << 20;

struct NamedImage {
  std::string name;
  Image plane;
};

/// Takes the planes out of the file. `clipped_from`: linear value at the end of the scale.
std::vector<NamedImage> chosen_planes(mtf::io::ImageFile& file, double clipped_from, const std::string& image,
                                      const EdgeInput& input) {
  std::vector<NamedImage> planes;
  if (file.planes.size() == 1) {
    planes.push_back({"", std::move(file.planes.front())});
    return planes;
  }
  const bool all = input.read.channel == "all", luminance = input.read.channel == "luminance";
  if (mtf::io::is_grey(file.planes) && !all) {
    planes.push_back({"", std::move(file.planes.front())});
  } else if (all) {
    for (std::size_t i = 0; i < file.planes.size(); ++i) planes.push_back({file.names[i], std::move(file.planes[i])});
  } else if (luminance && file.planes.size() == 3) {
    Image sum(file.planes[0].width(), file.planes[0].height());
    const float clipped = file.integer ? static_cast<float>(clipped_from) : std::numeric_limits<float>::infinity();
    for (std::int64_t i = 0; i < sum.size(); ++i)
      // A pixel with one clipped colour has no luminance.
      sum.data()[i] =
          std::max({file.planes[0].data()[i], file.planes[1].data()[i], file.planes[2].data()[i]}) >= clipped
              ? std::numeric_limits<float>::quiet_NaN()
              : kLuminance[0] * file.planes[0].data()[i] + kLuminance[1] * file.planes[1].data()[i] +
                    kLuminance[2] * file.planes[2].data()[i];
    planes.push_back({"luminance", std::move(sum)});
  } else {
    throw mtf::UsageError(one_line(image) + ": has the channels " + joined(file.names, one_line) +
                          "; an edge is measured in one: --channel NAME, or luminance, or all for each separately");
  }
  return planes;
}

std::vector<NamedImage> mosaic_planes(std::vector<NamedImage>&& planes, const std::string& image,
                                      const EdgeInput& input) {
  if (input.bayer.empty() && !input.pattern.empty())
    throw mtf::UsageError("--cfa-pattern: choose with --bayer which colours of the mosaic to measure");
  if (input.bayer.empty()) return std::move(planes);
  if (planes.size() != 1 || planes.front().name == "luminance")
    throw mtf::UsageError(one_line(image) + ": a mosaic has one channel, this image " + std::to_string(planes.size()) +
                          "; choose one with --channel, or leave out --bayer");
  static const std::vector<std::string> kAll{"r", "gr", "gb", "b"};
  std::vector<NamedImage> colours;
  for (const std::string& colour : input.bayer == "all" ? kAll : std::vector{input.bayer})
    colours.push_back({colour, calib::bayer_plane(planes.front().plane.view(),
                                                  input.pattern.empty() ? "rggb" : input.pattern, colour)});
  return colours;
}

/// Pixels of the display window that an OpenEXR does not hold are no data: zeros would make a perfect edge.
void hide_missing(mtf::io::ImageFile& file) {
  if (file.missing_pixels == 0) return;
  const auto [left, top, right, bottom] = file.info.data_window;
  for (Image& plane : file.planes)
    for (std::int64_t y = 0; y < plane.height(); ++y)
      for (std::int64_t x = 0; x < plane.width(); ++x)
        if (const std::int64_t u = x + file.info.display_window[0], v = y + file.info.display_window[1];
            u < left || u > right || v < top || v > bottom)
          plane.at(x, y) = std::numeric_limits<float>::quiet_NaN();
  file.info.notes.push_back(std::to_string(file.missing_pixels) +
                            " pixels lie outside the data window and are taken as no data");
}

/// Adds to `notes` what the file of the mask holds beside it.
void hide_masked(const std::string& file, const std::string& image, std::vector<NamedImage>& planes,
                 std::vector<std::string>& notes) {
  if (file.empty()) return;
  const mtf::io::ImageFile mask = mtf::io::read_image(file);
  for (const std::string& note : mask.info.notes) notes.push_back(one_line(file) + ": " + one_line(note));
  for (NamedImage& plane : planes) {
    try {
      calib::apply_mask(plane.plane.view(), mask.planes.front().view());
    } catch (const mtf::UsageError& error) {
      throw mtf::UsageError("mask " + one_line(file) + " for " + one_line(image) + ": " + error.what());
    }
  }
}

/// Least and largest linear value of the file's scale; a table may fall, and then its end is the least.
std::array<double, 2> linear_scale(const mtf::io::ImageFile& file, const mtf::io::Encoding& encoding) {
  const double full = mtf::io::full_scale(file.info);
  const double start = mtf::io::decode(encoding, mtf::io::least_stored(file.info), full),
               end = mtf::io::decode(encoding, full, full);
  return {std::min(start, end), std::max(start, end)};
}

/// The step between stored values in the middle of their scale, in linear units, and the ends of that scale.
calib::MeasureOptions options_of(const mtf::io::ImageFile& file, const mtf::io::Encoding& encoding,
                                 const std::array<double, 2>& scale, const EdgeInput& input, const Image& plane) {
  calib::MeasureOptions options;
  options.noise_sd = input.noise_sd;
  const double full = mtf::io::full_scale(file.info);
  if (input.saturation) {
    options.saturation = mtf::io::decode(encoding, *input.saturation, full);
    if (!std::isfinite(*options.saturation))
      throw mtf::UsageError(
          "--saturation: the encoding has no linear value for it; give a stored value inside the table");
  }
  if (!file.integer) return options;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (std::int64_t i = 0; i < plane.size(); ++i) {
    low = std::fmin(low, plane.data()[i]);  // passes over NaN
    high = std::fmax(high, plane.data()[i]);
  }
  options.quantum = mtf::io::quantum_at(encoding, 0.5 * (static_cast<double>(low) + high), full);
  if (encoding.kind != mtf::io::Encoding::Kind::linear)
    options.quantum_at = [encoding, full](double value) { return mtf::io::quantum_at(encoding, value, full); };
  if (!options.saturation && std::isfinite(scale[1])) options.saturation = scale[1];
  if (std::isfinite(scale[0])) options.floor = scale[0];
  return options;
}

/// The user's word, else the file's, else linear.
mtf::io::ChosenEncoding encoding_of(const mtf::io::FileInfo& info, const EdgeInput& input) {
  if (!input.encoding.empty()) return {mtf::io::parse_encoding(input.encoding), "--encoding"};
  if (!info.encoding.word.empty()) return {mtf::io::parse_encoding(info.encoding.word), info.encoding.source};
  return {{}, "assumed"};
}

/// A note about a curve that the file states and the user did not ask for, or that is not known here.
std::string curve_note(const std::string& image, const mtf::io::FileInfo& info, const EdgeInput& input) {
  const auto& [word, source] = info.encoding;
  if (!input.encoding.empty() || source.empty() || word == "linear") return "";
  const std::string says = one_line(image) + ": " + one_line(source);
  if (word.empty())
    return says + " is not applied: the values are taken as linear; give their curve, or linear, with --encoding";
  return says + ": the curve " + word + " is undone; --encoding linear takes the values as they are";
}

/// What the rounding of a JPEG does to the values.
std::string jpeg_note(const std::string& image, const mtf::io::FileInfo& info) {
  if (info.dct_steps.empty()) return "";
  const auto [least, most] = std::minmax_element(info.dct_steps.begin(), info.dct_steps.end());
  return one_line(image) + ": JPEG: rounding of the cosine coefficients of its blocks, in steps of " +
         std::to_string(*least) + " to " + std::to_string(*most) + " counts, changes pixels by up to " +
         significant(mtf::io::dct_rounding_sd(info.dct_steps), 2) +
         " counts rms; what the camera did before it, such as sharpening, is part of the MTF";
}

/// Which of the edges found are not among the regions.
std::string left_out_note(const EdgePlane& plane, const EdgeInput& input) {
  std::string text;
  if (plane.left_out > 0)
    text = "the best " + std::to_string(input.most) + " of " + std::to_string(input.most + plane.left_out) +
           " usable edges are taken; --edges N takes more";
  if (plane.not_tried > 0)
    text +=
        (text.empty() ? "" : "; ") + std::to_string(plane.not_tried) +
        " pieces of edges, the least promising ones, were not tried for want of memory; give regions with --roi, or "
        "a larger --min-length";
  if (text.empty()) return text;
  return one_line(plane.image) + (plane.channel.empty() ? "" : " " + one_line(plane.channel)) + ": " + text;
}

Linearisation linearisation_of(const mtf::io::ImageFile& file, const mtf::io::ChosenEncoding& chosen,
                               const calib::MeasureOptions& options, const EdgeInput& input) {
  return {.encoding = chosen.encoding.name,
          .encoding_source = chosen.source,
          .stated = file.info.encoding,
          .storage = file.info.storage,
          .integer = file.integer,
          .full_scale = mtf::io::full_scale(file.info),
          .dark_end = options.floor,
          .light_end = options.saturation,
          .dct_rounding_sd = mtf::io::dct_rounding_sd(file.info.dct_steps),
          .mosaic = input.bayer.empty()     ? ""
                    : input.pattern.empty() ? "rggb"
                                            : input.pattern,
          .mask = input.mask};
}

std::vector<EdgeRegion> given_regions(const EdgeInput& input) {
  std::vector<EdgeRegion> regions;
  for (const auto& [x, y, width, height] : input.regions) regions.push_back({{x, y, width, height}, ""});
  if (!input.region_file.empty())
    for (const calib::NamedRoi& named :
         calib::parse_roi_file(mtf::io::read_text_file(input.region_file, kMostRegionBytes), input.region_file))
      regions.push_back({named.roi, named.name});
  return regions;
}

}  // namespace

std::vector<EdgePlane> load_edge_planes(const std::string& image, const EdgeInput& input, Regions regions) {
  mtf::io::ReadOptions read = input.read;
  if (read.channel == "all" || read.channel == "luminance") read.channel.reset();
  return edge_planes_of(mtf::io::read_image(image, read), image, input, regions);
}

std::vector<EdgePlane> edge_planes_of(mtf::io::ImageFile file, const std::string& image, const EdgeInput& input,
                                      Regions regions) {
  const mtf::io::ChosenEncoding chosen = encoding_of(file.info, input);
  const mtf::io::Encoding& encoding = chosen.encoding;
  hide_missing(file);
  std::int64_t outside = 0;
  for (Image& plane : file.planes) outside += mtf::io::decode(encoding, plane.view(), mtf::io::full_scale(file.info));

  const std::array<double, 2> scale = linear_scale(file, encoding);
  std::vector<NamedImage> planes = mosaic_planes(chosen_planes(file, scale[1], image, input), image, input);
  std::vector<std::string> notes{curve_note(image, file.info, input), jpeg_note(image, file.info)};
  for (const std::string& note : file.info.notes) notes.push_back(one_line(image) + ": " + one_line(note));
  if (const std::string aspect = mtf::io::aspect_note(file.info); !aspect.empty())
    notes.push_back(one_line(image) + ": " + aspect + ": frequencies and angles are those of a grid of squares");
  hide_masked(input.mask, image, planes, notes);
  std::erase(notes, "");
  std::vector<EdgePlane> result;
  for (NamedImage& named : planes) {
    EdgePlane& plane = result.emplace_back();
    plane.image = image;
    if (outside > 0)
      plane.warning = one_line(image) + ": " + std::to_string(outside) + " samples lie outside the table " +
                      one_line(encoding.name) + " (" + mtf::format_double(encoding.stored.front()) + " to " +
                      mtf::format_double(encoding.stored.back()) + ") and are taken as no data";
    plane.channel = named.name;
    plane.stated_pitch_um = mtf::io::stated_pitch_um(file.info);
    if (regions == Regions::wanted) plane.regions = given_regions(input);
    plane.options = options_of(file, encoding, scale, input, named.plane);
    plane.options.sparse = !input.bayer.empty() || !input.mask.empty();
    plane.linearisation = linearisation_of(file, chosen, plane.options, input);
    if (result.size() == 1) plane.notes = notes;
    if (regions == Regions::wanted && plane.regions.empty()) {
      const calib::FindOptions find{
          .most = static_cast<std::size_t>(input.most), .min_length_px = input.min_length_px, .min_cnr = input.min_cnr};
      calib::FoundEdges found = calib::find_edges(named.plane.view(), find);
      for (const calib::FoundEdge& edge : found.edges) plane.regions.push_back({edge.roi, ""});
      plane.left_out = found.left_out;
      plane.not_tried = found.not_tried;
      if (std::string note = left_out_note(plane, input); !note.empty()) plane.notes.push_back(std::move(note));
      plane.reason = std::move(found.reason);
    }
    plane.plane = std::move(named.plane);
  }
  return result;
}

std::vector<std::string> files_of(const EdgeInput& input) {
  std::vector<std::string> files = input.images;
  for (const std::string& file : {input.mask, input.region_file, input.encoding})
    if (!file.empty()) files.push_back(file);
  return files;
}

}  // namespace apps
