// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/visibility/sides_in_sun.h"

#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include "mtf/math/simd.h"
#include "mtf/parallel.h"
#include "radiometry/scene/rays.h"

namespace radiometry::render {
namespace {

using scene::operator-, scene::operator*;
namespace simd = mtf::simd;
using Place = SunPicture::Place;
using Lines = SidesInSun::Lines;

constexpr std::size_t kMostLines = 512;     // with more of them a ray takes less time
constexpr std::size_t kMostEnds = 1 << 27;  // 512 MiB; sides that come after them are left to rays

double cross(const Place& a, const Place& b) { return a[0] * b[1] - a[1] * b[0]; }
Place operator-(const Place& a, const Place& b) { return {a[0] - b[0], a[1] - b[1]}; }

/// The part of the picture that a side takes up, or somewhat more: a box, cut along the edges of the side that have all
/// of it on one side.
class Target {
 public:
  Target(const scene::Facets& facets, const SunPicture& picture, std::uint32_t facet, double slack) : slack_(slack) {
    const std::uint64_t first = facets.first[facet], last = facets.first[facet + 1];
    for (std::uint64_t t = first; t < last; ++t)
      for (const std::uint32_t vertex : facets.triangles[t]) box_.take(picture.place(vertex)), own_.push_back(vertex);
    std::sort(own_.begin(), own_.end());
    for (std::size_t axis = 0; axis < 2; ++axis) {
      HalfPlane at_least{}, at_most{};
      at_least.normal[axis] = 1.0, at_least.rest = -box_.low[axis];
      at_most.normal[axis] = -1.0, at_most.rest = box_.high[axis];
      bound_.push_back(at_least);
      bound_.push_back(at_most);
    }
    constexpr std::uint64_t kFew = 4;
    for (std::uint64_t t = first; t < last && last - first <= kFew; ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& number = facets.triangles[t];
        const Place &p = picture.place(number[k]), &q = picture.place(number[(k + 1) % 3]);
        const Place along = q - p;
        const double length = std::hypot(along[0], along[1]);
        for (const double sign : {1.0, -1.0}) {
          HalfPlane inside{{-sign * along[1] / length, sign * along[0] / length}, 0.0};
          inside.rest = -(inside.normal[0] * p[0] + inside.normal[1] * p[1]);
          bool all = true;
          for (std::uint64_t other = first; other < last; ++other)
            for (const std::uint32_t vertex : facets.triangles[other])
              all = all && inside.depth(picture.place(vertex)) >= -slack;
          if (all) bound_.push_back(inside);
        }
      }
  }
  const SunPicture::Box& box() const { return box_; }
  bool has_corner(std::uint32_t vertex) const { return std::binary_search(own_.begin(), own_.end(), vertex); }
  /// Whether a line comes further into it than the slack.
  bool meets(const Place& a, const Place& b) const {
    double from = 0.0, to = 1.0;
    for (const HalfPlane& bound : bound_) {
      const double at_a = bound.depth(a) - slack_, at_b = bound.depth(b) - slack_;
      if (at_a <= 0.0 && at_b <= 0.0) return false;
      if (at_a <= 0.0) from = std::max(from, at_a / (at_a - at_b));
      if (at_b <= 0.0) to = std::min(to, at_a / (at_a - at_b));
    }
    return from < to;
  }

 private:
  struct HalfPlane {
    Place normal{};  ///< into it
    double rest = 0.0;
    double depth(const Place& p) const { return normal[0] * p[0] + normal[1] * p[1] + rest; }
  };
  double slack_;
  SunPicture::Box box_ = SunPicture::Box::none();
  std::vector<HalfPlane> bound_;
  std::vector<std::uint32_t> own_{};  ///< vertices, sorted
};

struct Line {
  Place from, to;
};

/// What a triangle is to a side: how high its corners are above the plane, and its lines.
class Above {
 public:
  Above(const scene::Facets& facets, const SunPicture& picture, std::uint32_t triangle, double lift_m)
      : number_(facets.triangles[triangle]), picture_(picture), triangle_(triangle), lift_m_(lift_m) {}

  /// False where all of it is below. Corners of the side itself are on its plane, though the facet is flat to rounding
  /// of its coordinates only: no line stands for the edges that triangles share with it.
  bool rises(const scene::Facets& facets, const Vector& up, const Point& on, const Target& side) {
    bool any = false;
    for (std::size_t k = 0; k < 3; ++k) {
      height_[k] = side.has_corner(number_[k]) ? 0.0 : scene::dot(up, facets.vertices[number_[k]] - on);
      any = any || above(k);
    }
    if (!any) return false;
    faces_ = picture_.faces(triangle_);
    return true;
  }

  bool covers(const Place& p) const {
    std::array<double, 3> weight{};  // of the corner across from each edge
    for (std::size_t k = 0; k < 3; ++k) {
      // From the lower number to the higher, so that of two triangles at an edge exactly one has the place.
      const std::uint32_t a = number_[k], b = number_[(k + 1) % 3];
      const Place &from = picture_.place(std::min(a, b)), &to = picture_.place(std::max(a, b));
      const double left = cross(to - from, p - from);
      if ((left >= 0.0) != ((a < b) == faces_)) return false;
      weight[(k + 2) % 3] = std::abs(left);
    }
    if (above(0) && above(1) && above(2)) return true;
    const double sum = weight[0] + weight[1] + weight[2];
    return weight[0] * height_[0] + weight[1] * height_[1] + weight[2] * height_[2] > sum * lift_m_;
  }

  /// Gives `take` the outlines above the plane, and the line along which the triangle goes through it.
  template <class Take>
  void lines(const Take& take) const {
    const auto give = [&](const Place& from, const Place& to) {
      if (faces_)
        take(Line{from, to});
      else
        take(Line{to, from});
    };
    Place leaves{}, enters{};
    bool through = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const bool begins = above(k), ends = above(next), outline = picture_.outline(triangle_, k);
      if (begins != ends) {
        through = true;
        const Place cut = crossing(k, next);
        (begins ? leaves : enters) = cut;
        if (outline) give(begins ? place(k) : cut, ends ? place(next) : cut);
      } else if (begins && outline) {
        give(place(k), place(next));
      }
    }
    if (through) give(leaves, enters);
  }

 private:
  bool above(std::size_t k) const { return height_[k] > lift_m_; }
  const Place& place(std::size_t k) const { return picture_.place(number_[k]); }
  /// The same for both triangles at an edge.
  Place crossing(std::size_t a, std::size_t b) const {
    if (number_[a] > number_[b]) std::swap(a, b);
    const double at = (lift_m_ - height_[a]) / (height_[b] - height_[a]);
    return {std::lerp(place(a)[0], place(b)[0], at), std::lerp(place(a)[1], place(b)[1], at)};
  }

  const std::array<std::uint32_t, 3>& number_;
  const SunPicture& picture_;
  std::uint32_t triangle_;
  double lift_m_;
  std::array<double, 3> height_{};
  bool faces_ = false;
};

/// A place inside a triangle, of no symmetry, so that lines of a scene do not pass through it.
Place inside(const scene::Facets& facets, const SunPicture& picture, std::uint64_t triangle, int which) {
  constexpr std::array<std::array<double, 3>, 3> kWeights{
      {{0.3119, 0.3594, 0.3287}, {0.5213, 0.2471, 0.2316}, {0.1938, 0.2874, 0.5188}}};
  Place p{};
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t axis = 0; axis < 2; ++axis)
      p[axis] += kWeights[static_cast<std::size_t>(which)][k] * picture.place(facets.triangles[triangle][k])[axis];
  return p;
}

double area(const scene::Facets& facets, const SunPicture& picture, std::uint64_t triangle) {
  const auto& [a, b, c] = facets.triangles[triangle];
  return std::abs(cross(picture.place(b) - picture.place(a), picture.place(c) - picture.place(a)));
}

/// Across the longest edge.
double width_of(const scene::Facets& facets, const SunPicture& picture, std::uint64_t triangle) {
  double longest = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& number = facets.triangles[triangle];
    const Place edge = picture.place(number[(k + 1) % 3]) - picture.place(number[k]);
    longest = std::max(longest, std::hypot(edge[0], edge[1]));
  }
  return area(facets, picture, triangle) / longest;
}

/// The signs of three cross products tell whether the way from c to the place crosses a line, and in which direction.
struct CountCovers {
  template <int Bytes>
  static MTFKIT_INLINE void run(const float* ends, std::size_t blocks, float x, float y, std::int32_t* covers) {
    using Floats = simd::Vector<float, Bytes>;
    using Ints = simd::Vector<std::int32_t, Bytes>;
    constexpr std::size_t kLanes = Bytes / sizeof(float);
    Ints sum{};
    for (std::size_t block = 0; block < blocks; ++block, ends += 4 * Lines::kBlock)
      for (std::size_t k = 0; k < Lines::kBlock; k += kLanes) {
        const Floats ax = simd::load<Floats>(ends + k), ay = simd::load<Floats>(ends + Lines::kBlock + k),
                     bx = simd::load<Floats>(ends + 2 * Lines::kBlock + k),
                     by = simd::load<Floats>(ends + 3 * Lines::kBlock + k);
        const Floats a = x * ay - y * ax, b = x * by - y * bx;  // on which side of the way the ends are
        const Floats along_x = bx - ax, along_y = by - ay;
        // Not ax by - ay bx: far from c that would cancel.
        const Floats at_c = ax * along_y - ay * along_x, at_p = at_c + y * along_x - x * along_y;
        const Ints across = (a < 0.0F) ^ (b < 0.0F);
        sum += across & ((at_p < 0.0F) - (at_c < 0.0F));  // true is -1
      }
    for (std::size_t k = 0; k < kLanes; ++k) *covers += sum[k];
  }
};

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

SunPicture::Box SunPicture::Box::none() {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  return {{kFar, kFar}, {-kFar, -kFar}};
}

void SunPicture::Box::take(const Place& p) { take(Box{p, p}); }

void SunPicture::Box::take(const Box& other) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    low[axis] = std::min(low[axis], other.low[axis]);
    high[axis] = std::max(high[axis], other.high[axis]);
  }
}

SunPicture::SunPicture(const scene::Facets& facets, const Vector& to_sun, int threads)
    : facets_(&facets), to_sun_(to_sun), place_(facets.vertices.size()) {
  // Any two axes will do: what faces the sun runs counter-clockwise.
  const auto steep = [](double a, double b) { return std::abs(a) < std::abs(b); };
  Vector level{};
  level[static_cast<std::size_t>(std::min_element(to_sun.begin(), to_sun.end(), steep) - to_sun.begin())] = 1.0;
  axes_[0] = scene::unit(scene::cross(level, to_sun));
  axes_[1] = scene::unit(scene::cross(to_sun, axes_[0]));
  for (std::size_t i = 0; i < place_.size(); ++i) {
    const Vector from_middle = facets.vertices[i] - facets.middle;
    place_[i] = {scene::dot(axes_[0], from_middle), scene::dot(axes_[1], from_middle)};
  }
  find_outlines();
  build_tree(threads);
}

/// Edges are gathered by their lower vertex.
void SunPicture::find_outlines() {
  struct Use {
    std::uint32_t other, triangle;  ///< the higher vertex
    std::uint8_t edge;
    bool left;  ///< of the edge from its lower vertex to the higher one
  };
  const auto ends = [&](std::size_t t, std::size_t k) {
    return std::minmax(facets_->triangles[t][k], facets_->triangles[t][(k + 1) % 3]);
  };
  const std::size_t triangles = facets_->triangles.size();
  std::vector<std::size_t> first(facets_->vertices.size() + 1, 0);
  for (std::size_t t = 0; t < triangles; ++t)
    for (std::size_t k = 0; k < 3; ++k) ++first[ends(t, k).first + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Use> use(3 * triangles);
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  outline_.assign(triangles, 0);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::array<std::uint32_t, 3>& number = facets_->triangles[t];
    const auto &a = place_[number[0]], &b = place_[number[1]], &c = place_[number[2]];
    const bool faces = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
    if (faces) outline_[t] = kFaces;
    for (std::uint8_t k = 0; k < 3; ++k) {
      const auto [low, high] = ends(t, k);
      use[next[low]++] = {high, t, k, faces == (number[k] == low)};
    }
  }
  const auto by_other = [](const Use& a, const Use& b) { return a.other < b.other; };
  for (std::size_t v = 0; v + 1 < first.size(); ++v) {
    const std::span<Use> here = std::span(use).subspan(first[v], first[v + 1] - first[v]);
    std::sort(here.begin(), here.end(), by_other);
    for (auto from = here.begin(), to = from; from != here.end(); from = to) {
      to = std::upper_bound(from, here.end(), *from, by_other);
      if (to - from == 2 && from[0].left != from[1].left) continue;
      for (auto one = from; one != to; ++one) outline_[one->triangle] |= static_cast<std::uint8_t>(1U << one->edge);
    }
  }
}

/// Each node halves its triangles by their middles, along x and y in turn.
void SunPicture::build_tree(int threads) {
  const std::size_t triangles = facets_->triangles.size();
  std::vector<std::array<double, 2>> middle(triangles);
  for (std::size_t t = 0; t < triangles; ++t)
    for (const std::uint32_t vertex : facets_->triangles[t])
      for (std::size_t axis = 0; axis < 2; ++axis) middle[t][axis] += place_[vertex][axis];
  std::size_t leaves = 1;
  while (triangles > leaves * kLeaf) leaves *= 2;  // as halving goes on while a node has more than kLeaf
  box_.assign(2 * leaves - 1, Box::none());
  order_.resize(triangles);
  std::iota(order_.begin(), order_.end(), 0U);
  const auto place = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  const auto halve = [&](std::size_t first, std::size_t last, std::size_t axis) {
    const std::size_t half = std::midpoint(first, last);
    std::nth_element(place(first), place(half), place(last),
                     [&](std::uint32_t a, std::uint32_t b) { return middle[a][axis] < middle[b][axis]; });
    return half;
  };
  const std::function<void(std::size_t, std::size_t, std::size_t, std::size_t)> build = [&](std::size_t node,
                                                                                            std::size_t first,
                                                                                            std::size_t last,
                                                                                            std::size_t axis) {
    if (last - first <= kLeaf) {
      for (std::size_t i = first; i < last; ++i)
        for (const std::uint32_t vertex : facets_->triangles[order_[i]]) box_[node].take(place_[vertex]);
      return;
    }
    const std::size_t half = halve(first, last, axis);
    const std::array<std::array<std::size_t, 3>, 2> parts{{{2 * node + 1, first, half}, {2 * node + 2, half, last}}};
    constexpr std::size_t kAlone = 1 << 14;  // triangles
    mtf::parallel_for_each(2, 1, last - first > kAlone ? threads : 1,
                           [&](std::size_t k) { build(parts[k][0], parts[k][1], parts[k][2], 1 - axis); });
    box_[node].take(box_[2 * node + 1]);
    box_[node].take(box_[2 * node + 2]);
  };
  build(0, 0, triangles, 0);
}

SidesInSun::SidesInSun(const scene::Facets& facets, const Vector& to_sun, double lift_m, int threads)
    : facets_(&facets), lift_m_(lift_m), picture_(std::make_shared<const SunPicture>(facets, to_sun, threads)) {}

SidesInSun::Lines SidesInSun::find(scene::Side side) const {
  const scene::Facet& facet = facets_->facet[side.facet];
  const SunPicture& picture = *picture_;
  const Vector up = (side.back ? -1.0 : 1.0) * facet.normal;
  const double slack = 0x1p-10 * lift_m_;  // edges that are shared are worked out alike but for rounding
  const Target target(*facets_, picture, side.facet, slack);
  Lines found;
  std::uint64_t largest = facets_->first[side.facet];
  for (std::uint64_t t = largest; t < facets_->first[side.facet + 1]; ++t)
    if (area(*facets_, picture, t) > area(*facets_, picture, largest)) largest = t;
  const double width = width_of(*facets_, picture, largest);
  if (!(width > 4.0 * lift_m_)) return found;
  for (int which = 0; which < 3; ++which) {
    found.c = inside(*facets_, picture, largest, which);
    found.covers = 0;
    std::vector<Line> lines;
    double margin = std::numeric_limits<double>::infinity();  // from c to the lines
    picture.visit(target.box(), [&](std::uint32_t triangle) {
      if (facets_->facet_of[triangle] == side.facet) return true;
      Above above(*facets_, picture, triangle, lift_m_);
      if (!above.rises(*facets_, up, facet.centre, target)) return true;
      found.covers += above.covers(found.c) ? 1 : 0;
      above.lines([&](const Line& line) {
        if (!target.meets(line.from, line.to)) return;
        const Line from_c{line.from - found.c, line.to - found.c};
        const Place along = line.to - line.from;
        margin = std::min(margin, std::abs(cross(from_c.from, from_c.to)) / std::hypot(along[0], along[1]));
        lines.push_back(from_c);
      });
      return lines.size() <= kMostLines;
    });
    if (lines.size() > kMostLines) return found;
    if (lines.empty()) {
      found.in_sun = found.covers > 0 ? InSun::nowhere : InSun::wholly;
      return found;
    }
    if (!(margin > 1e-5 * width)) continue;
    found.in_sun = InSun::partly;
    found.ends.assign((lines.size() + Lines::kBlock - 1) / Lines::kBlock * 4 * Lines::kBlock, 0.0F);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      float* const of = found.ends.data() + i / Lines::kBlock * 4 * Lines::kBlock + i % Lines::kBlock;
      of[0] = static_cast<float>(lines[i].from[0]), of[Lines::kBlock] = static_cast<float>(lines[i].from[1]);
      of[2 * Lines::kBlock] = static_cast<float>(lines[i].to[0]);
      of[3 * Lines::kBlock] = static_cast<float>(lines[i].to[1]);
    }
    return found;
  }
  return found;
}

void SidesInSun::add(const VisibleSides& sides, int threads) {
  const std::size_t begin_at = known_.size();
  std::vector<Lines> fresh(sides.size() - begin_at, Lines{.in_sun = InSun::nowhere});
  mtf::parallel_for_each(static_cast<std::int64_t>(fresh.size()), 64, threads, [&](std::size_t i) {
    if (const std::uint32_t side = sides.side(begin_at + i); sides.sun_cosine(begin_at + i) > 0.0F)
      fresh[i] = find({side / 2, side % 2 == 1});
  });
  known_.reserve(sides.size());
  for (const Lines& one : fresh) {
    const bool room = ends_.size() + one.ends.size() <= kMostEnds;
    known_.push_back({room || one.ends.empty() ? one.in_sun : InSun::unknown, one.covers, one.c, ends_.size(),
                      one.ends.size() / (4 * Lines::kBlock)});
    if (room) ends_.insert(ends_.end(), one.ends.begin(), one.ends.end());
  }
}

void SidesInSun::reaches(std::span<const SunQuestion> places, std::span<std::uint8_t> lit) const {
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Known& known = known_[places[i].number];
    std::int32_t covers = known.covers;
    simd::run<CountCovers>(static_cast<const float*>(ends_.data() + known.first), known.blocks,
                           static_cast<float>(places[i].place[0] - known.c[0]),
                           static_cast<float>(places[i].place[1] - known.c[1]), &covers);
    lit[i] = covers <= 0 ? 1 : 0;
  }
}

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
  mtf::parallel_for_each(static_cast<std::int64_t>(parts.band.size()), 1, threads,
                         [&](std::size_t b) { work(parts.band[b], parts.runs[b]); });
  return rays;
}

}  // namespace radiometry::render
