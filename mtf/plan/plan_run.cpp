// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "mtf/engines/kept_plane.h"
#include "mtf/error.h"
#include "mtf/plan/plan_impl.h"

namespace mtf {
namespace {

void check_size(std::int64_t width, std::int64_t height, const SampleGrid& grid, const char* name) {
  if (width == grid.width && height == grid.height) return;
  throw UsageError(std::string(name) + " image is " + std::to_string(width) + "x" + std::to_string(height) +
                   ", the plan was made for " + std::to_string(grid.width) + "x" + std::to_string(grid.height));
}

void fill(ImageView<float> out, float value) {
  for (std::int64_t y = 0; y < out.height; ++y) std::fill_n(out.row(y), out.width, value);
}

bool share_memory(ImageView<const float> a, ImageView<const float> b) {
  const std::less<const float*> before;
  return before(a.data, b.row(b.height)) && before(b.data, a.row(a.height));
}

Image copy_of(ImageView<const float> plane) {
  Image copy(plane.width, plane.height);
  for (std::int64_t y = 0; y < plane.height; ++y) std::copy_n(plane.row(y), plane.width, copy.view().row(y));
  return copy;
}

}  // namespace

const PlanReport& Plan::report() const { return impl_->report; }
double Plan::dc() const { return impl_->dc; }

void Plan::run(ImageView<const float> in, ImageView<float> out, double border_value, int threads) const {
  run(std::span(&in, 1), std::span(&out, 1), border_value, threads);
}

void Plan::run(std::span<const ImageView<const float>> in, std::span<const ImageView<float>> out, double border_value,
               int threads) const {
  run_planes(in, out, border_value, threads, {});
}

void Plan::run(KeptScene& scene, std::span<const ImageView<float>> out, double border_value, int threads) const {
  std::vector<ImageView<const float>> in;
  for (const Image& plane : scene.planes()) in.push_back(plane.view());
  run_planes(in, out, border_value, threads, scene.kept());
}

void Plan::run_planes(std::span<const ImageView<const float>> in, std::span<const ImageView<float>> out,
                      double border_value, int threads, std::span<KeptPlane> kept) const {
  if (in.size() != out.size()) throw UsageError("as many output as input planes are needed");
  const bool constant = impl_->options.border == Border::constant;
  if (constant && !(std::abs(border_value) <= std::numeric_limits<float>::max()))
    throw UsageError("the border value has to be a finite float");
  std::vector<Channel> channels;
  std::vector<Image> copies;
  std::vector<KeptPlane> own(kept.empty() ? in.size() : 0);  // for this run alone
  // FFT engines read all of an input before they write, and check by themselves that it is finite.
  const bool transforms = impl_->report.method.starts_with("fft");
  for (std::size_t c = 0; c < in.size(); ++c) {
    check_size(in[c].width, in[c].height, impl_->report.in, "input");
    check_size(out[c].width, out[c].height, impl_->report.out, "output");
    const std::optional<MeanAndDeviation> sampled = transforms ? sampled_mean_and_deviation(in[c]) : std::nullopt;
    KeptPlane& plane = kept.empty() ? own[c] : kept[c];
    if (!sampled && !plane.all) plane.all = mean_and_deviation(in[c], threads, plane.flat);
    const MeanAndDeviation about = sampled ? *sampled : *plane.all;
    const double deviation = canvas_deviation(about, impl_->options.border, border_value);
    if (deviation == 0.0) {
      fill(out[c], static_cast<float>(impl_->dc * about.mean));
    } else if (!impl_->engine) {
      for (std::int64_t y = 0; y < out[c].height; ++y)
        std::memmove(out[c].row(y), in[c].row(y), static_cast<std::size_t>(out[c].width) * sizeof(float));
    } else {
      ImageView<const float> from = in[c];
      if (!transforms && share_memory(in[c], out[c])) from = copies.emplace_back(copy_of(in[c])).view();
      channels.push_back({from, out[c], about.mean, scale_for(deviation), sampled.has_value(), impl_->dc, border_value,
                          &plane.flat, impl_->report.predicted.flat, kept.empty() ? nullptr : &plane});
    }
  }
  if (!channels.empty()) impl_->engine->run(channels, threads);
}

}  // namespace mtf
