// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/visibility/shadows.h"

#include <array>
#include <atomic>
#include <cmath>
#include <optional>

#include "mtf/parallel.h"
#include "radiometry/scene/beam.h"

namespace radiometry::render {
namespace {

using scene::kBeamRays;
using scene::operator+, scene::operator*;

/// Gathers shadow rays into packets; `take(of, lit)` is told the answers.
template <class Take>
class ShadowRays {
 public:
  ShadowRays(const RenderScene& scene, const Camera& camera, const scene::Beam& beam, int n, Take take)
      : scene_(scene), camera_(camera), beam_(beam), n_(n), take_(take) {}

  void add(const SamplePart& part, std::size_t of) {
    const PlaceInScene place = place_of(scene_, camera_, part, n_);
    from_[count_] = place.point + beam_.lift_m() * place.normal;
    of_[count_++] = of;
    if (count_ == kBeamRays) trace();
  }
  void trace() {
    if (count_ == 0) return;
    const std::uint32_t blocked = beam_.blocked(std::span<const Point>(from_).first(count_));
    for (std::size_t k = 0; k < count_; ++k) take_(of_[k], (blocked >> k & 1U) == 0U);
    rays_ += count_;
    count_ = 0;
  }
  std::size_t rays() const { return rays_; }

 private:
  const RenderScene& scene_;
  const Camera& camera_;
  const scene::Beam& beam_;
  int n_;
  Take take_;
  std::array<Point, kBeamRays> from_;
  std::array<std::size_t, kBeamRays> of_{};
  std::size_t count_ = 0, rays_ = 0;
};

/// Where what a camera sees is in the picture of the sun.
class SightInPicture {
 public:
  SightInPicture(const scene::Facets& facets, const SunPicture& picture, const Camera& camera, int n)
      : camera_(camera), n_(n) {
    using scene::operator-;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const Vector& along = picture.axes()[axis];
      eye_[axis] = scene::dot(along, camera.position - facets.middle);
      ahead_[axis] = scene::dot(along, camera.ahead);
      right_[axis] = scene::dot(along, camera.right);
      down_[axis] = scene::dot(along, camera.down);
    }
  }
  SunPicture::Place of(const SamplePart& part) const {
    const PlaceInImage at = place_of(part, n_);
    const double x = camera_.tangent_x(at.x), y = camera_.tangent_y(at.y);
    const double depth = static_cast<double>(part.range_m) / std::sqrt(1.0 + x * x + y * y);
    SunPicture::Place place;
    for (std::size_t axis = 0; axis < 2; ++axis)
      place[axis] = eye_[axis] + depth * (ahead_[axis] + x * right_[axis] + y * down_[axis]);
    return place;
  }

 private:
  const Camera& camera_;
  int n_;
  SunPicture::Place eye_{}, ahead_{}, right_{}, down_{};
};

/// Adds the pieces of a run that are in the sun, and those that are not.
void split(const SampleRun& run, const std::uint8_t* lit, std::vector<SampleRun>& out) {
  for (std::uint32_t begin = 0, end = 0; begin < run.samples; begin = end) {
    while (end < run.samples && lit[end] == lit[begin]) ++end;
    SampleRun& piece = out.emplace_back(run);
    piece.column += begin;
    piece.nearness += static_cast<float>(begin) * run.step;
    piece.samples = end - begin;
    piece.lit = lit[begin] != 0;
  }
}

}  // namespace

std::size_t find_shadows(const RenderScene& scene, const VisibleSides& sides, const SidesInSun* in_sun,
                         VisibleParts& parts, int threads) {
  const Camera& camera = parts.camera;
  const scene::Beam beam(*scene.rays, scene.sun->to_sun);
  std::optional<SightInPicture> sight;
  if (in_sun != nullptr) sight.emplace(scene.facets(), in_sun->picture(), camera, parts.n);
  const auto known = [&](std::uint32_t side) {
    if (side == scene::kNone) return InSun::nowhere;
    const std::uint32_t number = sides.number(side);
    if (in_sun != nullptr) return in_sun->of(number);
    return sides.sun_cosine(number) > 0.0F ? InSun::unknown : InSun::nowhere;
  };
  std::atomic<std::size_t> rays = 0;
  const auto work = [&](std::vector<SamplePart>& band, std::vector<SampleRun>& runs) {
    std::vector<SunQuestion> question;
    const auto ask = [&](const SamplePart& part) { question.push_back({sides.number(part.side), sight->of(part)}); };
    std::vector<SampleRun> whole, asked;
    for (SampleRun& run : runs) {
      const InSun how = known(run.side);
      run.lit = how == InSun::wholly;
      for (std::uint32_t k = 0; how == InSun::partly && k < run.samples; ++k) ask(sample_of(run, k, camera, parts.n));
      for (std::uint32_t k = 0; how == InSun::unknown && k < run.samples; ++k)
        band.push_back(sample_of(run, k, camera, parts.n));
      if (how != InSun::unknown) (how == InSun::partly ? asked : whole).push_back(run);
    }
    const std::size_t of_runs = question.size();
    ShadowRays shadow(scene, camera, beam, parts.n, [&](std::size_t part, bool lit) { band[part].lit = lit; });
    for (std::size_t i = 0; i < band.size(); ++i) {
      const InSun how = known(band[i].side);
      band[i].lit = how == InSun::wholly;
      if (how == InSun::unknown) shadow.add(band[i], i);
      if (how == InSun::partly) ask(band[i]);
    }
    shadow.trace();
    rays += shadow.rays();
    if (in_sun == nullptr) return;
    std::vector<std::uint8_t> lit(question.size());
    in_sun->reaches(question, lit);
    auto answer = lit.begin() + static_cast<std::ptrdiff_t>(of_runs);
    for (SamplePart& part : band)
      if (known(part.side) == InSun::partly) part.lit = *answer++ != 0;
    runs = std::move(whole);
    answer = lit.begin();
    for (const SampleRun& run : asked) {
      split(run, &*answer, runs);
      answer += run.samples;
    }
  };
  mtf::parallel_for(static_cast<std::int64_t>(parts.band.size()), 1, threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b)
                        work(parts.band[b], parts.runs[b]);
                    });
  return rays;
}

}  // namespace radiometry::render
