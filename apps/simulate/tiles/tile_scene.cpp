// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/tiles/tile_scene.h"

#include <sys/stat.h>

#include <algorithm>
#include <cstdio>

#include "apps/sensor/sensor_chain.h"
#include "apps/simulate/sensor_run.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/version.h"

namespace apps {
namespace {

constexpr std::int64_t kSurveyShare = 8;      // of the memory that rows may take while the scene is surveyed
constexpr std::size_t kChannelsTogether = 4;  // in one pass: each has running sums of its coarse image
constexpr std::size_t kHeaderBytes = 65536;   // of a scene file, for telling it from another

}  // namespace

std::string refusal_of_windows(const SimulateOptions& options, const SceneSource& file) {
  if (file.image)
    return "--memory: " + one_line(file.file) +
           " is in memory already; name a file of the scene, or leave out the limit";
  if (mtf::io::detect_format(file.file) != mtf::io::Format::exr)
    return "--memory: " + one_line(file.file) +
           " is no OpenEXR file, which is the format that can be read in pieces; convert it";
  if (!options.out.empty() && mtf::io::format_from_extension(options.out) != mtf::io::Format::exr)
    return "--memory: tiles are written as OpenEXR; end the name of the output in .exr";
  if (options.nan != NanPolicy::refuse)
    return "--nan: fill and propagate need the whole image; leave out --memory, or replace such pixels before";
  return "";
}

void open_windows(const SimulateOptions& options, const mtf::io::SensorConfig& config, const SceneSource& file,
                  TileScene& source) {
  if (const std::string refusal = refusal_of_windows(options, file); !refusal.empty()) throw mtf::UsageError(refusal);
  source.file.emplace(file.file, file.read);
  source.scene = mtf::io::describe_scene(config, file.file, source.file->file());
  source.read = [&source](std::size_t channel, std::int64_t x, std::int64_t y, mtf::ImageView<float> out) {
    source.file->read(channel, x, y, out);
    mtf::io::make_physical(source.scene, out);
  };
}

std::vector<mtf::Survey> survey_all(TileScene& source, const SceneSurvey& asked, RunWatch& watch) {
  mtf::SurveyOptions survey_options{
      .border = asked.border, .border_value = asked.border_value, .every = asked.every, .threads = asked.threads};
  if (source.file) {
    if (asked.memory > 0)
      survey_options.band_rows =
          std::clamp<std::int64_t>(asked.memory / kSurveyShare / source.file->row_bytes(), 1, survey_options.band_rows);
    source.file->keep_rows(survey_options.band_rows);
  }
  const std::size_t channels = source.scene.names.size();
  std::vector<mtf::Survey> surveys;
  for (std::size_t first = 0; first < channels; first += kChannelsTogether) {
    const std::size_t count = std::min(kChannelsTogether, channels - first);
    survey_options.progress = [&](std::int64_t row) {
      const double share = static_cast<double>(row) / static_cast<double>(source.scene.grid.height);
      watch.share(asked.step,
                  (static_cast<double>(first) + share * static_cast<double>(count)) / static_cast<double>(channels));
    };
    for (mtf::Survey& survey : mtf::survey_channels(source.read, first, count, source.scene.grid, survey_options))
      surveys.push_back(std::move(survey));
  }
  for (std::size_t c = 0; c < channels; ++c) {
    const mtf::Statistics& s = surveys[c].statistics;
    if (s.not_finite > 0 && asked.computed) refuse_overflow(source.scene.names[c]);
    if (s.not_finite > 0)
      throw mtf::RuntimeError("channel " + one_line(source.scene.names[c]) + ": " + std::to_string(s.not_finite) +
                              " pixels are NaN or infinite, the first at column " + std::to_string(s.first_x) +
                              ", row " + std::to_string(s.first_y) +
                              "; replace them before, or run without --memory "
                              "and with --nan fill|propagate");
  }
  return surveys;
}

std::string key_of(const SimulateOptions& options, const mtf::io::SensorConfig& config, const std::string& file,
                   const TileScene& source, const std::vector<mtf::Survey>& surveys, const mtf::TiledSensorPlan& plan,
                   const std::string& stage) {
  struct stat status {};
  static_cast<void>(::stat(file.c_str(), &status));
  std::string header(kHeaderBytes, '\0');
  if (std::FILE* handle = std::fopen(file.c_str(), "rb")) {
    header.resize(std::fread(header.data(), 1, header.size(), handle));
    std::fclose(handle);
  }
  const mtf::TileReport& r = plan.report();
  std::string key = std::string(mtf::version) + " " + mtf::git_commit + " " + config.sha256 + " " +
                    std::to_string(status.st_size) + " " + std::to_string(status.st_mtim.tv_sec) + "." +
                    std::to_string(status.st_mtim.tv_nsec) + " " + mtf::format_double(r.tolerance) + " " +
                    (options.measure ? "measure" : "estimate") + " " + stage;
  for (const std::string& curve : files_of(config)) {  // that the sensor file names
    struct stat part {};
    static_cast<void>(::stat(curve.c_str(), &part));
    key += " " + std::to_string(part.st_size) + " " + std::to_string(part.st_mtim.tv_sec) + "." +
           std::to_string(part.st_mtim.tv_nsec);
  }
  if (options.region)
    for (const std::int64_t number : *options.region) key += " " + std::to_string(number);
  for (const std::string& name : source.scene.names) key += " [" + name + "]";
  for (const mtf::Survey& survey : surveys) key += " " + std::to_string(survey.fingerprint);
  return key + " " + std::to_string(r.every) + " " + header;
}

}  // namespace apps
