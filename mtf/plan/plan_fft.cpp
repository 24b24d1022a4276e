// SPDX-License-Identifier: Apache-2.0

// The FFT methods of a plan: the frequencies in use, predicted error and cost.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "mtf/device/device_filter.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/engines/fft/spectral.h"
#include "mtf/plan/padding.h"
#include "mtf/plan/plan_parts.h"

namespace mtf {
namespace {

constexpr double kCutShare = 0.25;
constexpr double kDoubleCost = 2.2;  // half the samples a vector, twice the memory
constexpr double kCutCost = 1.06;    // frequencies that end anywhere
constexpr double kFlatShare = 0.25, kFewFlatLines = 0.1;
constexpr double kLinesCost = 0.5;  // share of the whole cost that transforms of the lines are (measured)

// Leaves out the frequencies from the far end that no component lets through. Returns the largest |H| among them. They
// go in steps of 3 % of the axis, at most a block of the engine: so plans whose OTFs differ little share their
// transforms (Plan::with), and with them what is kept of a scene (KeptScene).
double cut_frequencies(const FactoredOtf& sampler, Axis axis, double allowed, AxisTransform& job) {
  const std::int64_t step = std::clamp<std::int64_t>(job.frequency.half_count() / kRow, 1, kRow);
  double largest = 0.0;
  while (job.keep > step) {
    const std::int64_t first = (job.keep - 1) / step * step;
    double bound = 0.0;
    for (std::int64_t k = first; k < job.keep && bound <= allowed; ++k)
      bound = std::max(bound, sampler.axis_bound(axis, job.frequency.cy_mm(k)));
    if (bound > allowed) break;
    largest = std::max(largest, bound);
    job.keep = first;
  }
  return largest;
}

// Largest |H| about each corner of the scene's spectrum: there, and at the axis' own frequencies in both cells beside
// it.
std::vector<double> bounds_about_corners(const FactoredOtf& sampler, Axis axis, const AxisTransform& job) {
  constexpr int kCells = SceneSpectrum::kCells;
  std::vector<double> bounds;
  for (int i = 0; i <= kCells; ++i)
    bounds.push_back(sampler.axis_bound(axis, SceneSpectrum::corner_cy_mm(i, job.frequency.nyquist_cy_mm())));
  for (std::int64_t k = 0; k < job.frequency.half_count(); ++k) {
    const double f = job.frequency.cy_mm(k), bound = sampler.axis_bound(axis, f);
    // A frequency on a corner belongs to both of its cells, whatever rounding says.
    const double place = f / job.frequency.nyquist_cy_mm() * kCells;
    const int first = std::clamp(static_cast<int>(std::floor(place - 1e-6)), 0, kCells);
    const int last = std::clamp(static_cast<int>(std::floor(place + 1e-6)) + 1, 0, kCells);
    for (int corner = first; corner <= last; ++corner) {
      double& largest = bounds[static_cast<std::size_t>(corner)];
      largest = std::max(largest, bound);
    }
  }
  return bounds;
}

// Leaves out those that cost this scene no more than `budget`, each axis half of it. Returns what they cost.
double cut_by_spectrum(const PlanTask& task, double budget, double spectrum_gain, AxisTransform& x, AxisTransform& y) {
  constexpr int kCells = SceneSpectrum::kCells, kColumns = SceneSpectrum::kColumns;
  const SampleGrid &in = task.in, &out = task.out;
  const std::vector<double> bound_x = bounds_about_corners(task.sampler, Axis::x, x),
                            bound_y = bounds_about_corners(task.sampler, Axis::y, y);
  const auto cost = [&](int from_x, int from_y) {
    std::vector<double> error(static_cast<std::size_t>(SceneSpectrum::kRows * kColumns), 0.0);
    for (int j = -kCells; j <= kCells; ++j)
      for (int i = 0; i <= kCells; ++i)
        if (i >= from_x || std::abs(j) >= from_y)
          error[static_cast<std::size_t>((j + kCells) * kColumns + i)] =
              std::min(bound_x[static_cast<std::size_t>(i)], bound_y[static_cast<std::size_t>(std::abs(j))]);
    return spectrum_gain *
           task.options.spectrum->rms_error(error, out.step_x_um / in.step_x_um, out.step_y_um / in.step_y_um);
  };
  const auto first = [&](const auto& cost_from) {
    int low = 1, high = kCells + 1;  // high: nothing is cut
    while (low < high) {
      const int middle = (low + high) / 2;
      if (cost_from(middle) <= 0.5 * budget)
        high = middle;
      else
        low = middle + 1;
    }
    return high;
  };
  const int from_x = first([&](int i) { return cost(i, kCells + 1); });
  const int from_y = first([&](int j) { return cost(kCells + 1, j); });
  // A cell more than the corner: errors are counted from the corner on.
  const auto keep = [](int from, AxisTransform& job) {
    const double share = static_cast<double>(from) / kCells;
    const auto count =
        static_cast<std::int64_t>(std::ceil(share * static_cast<double>(job.frequency.half_count()))) + 1;
    job.keep = std::min(job.keep, count);
  };
  if (from_x > kCells && from_y > kCells) return 0.0;
  if (from_x <= kCells) keep(from_x, x);
  if (from_y <= kCells) keep(from_y, y);
  return cost(from_x, from_y);
}

// Leaves out the frequencies that cost at most `budget`: those that no component lets through, or those that this scene
// does not miss, whichever are more. Returns what they cost.
double cut(const PlanTask& task, double budget, double rms_per_otf, bool full_canvas, bool symmetric, AxisTransform& x,
           AxisTransform& y) {
  AxisTransform worst_x = x, worst_y = y, scene_x = x, scene_y = y;
  const double spread = rms_per_otf * std::sqrt(aliases(x) * aliases(y));
  const double largest = std::max(cut_frequencies(task.sampler, Axis::x, budget / spread, worst_x),
                                  cut_frequencies(task.sampler, Axis::y, budget / spread, worst_y));
  // The spectrum is that of the defined canvas.
  double cost = 0.0;
  if (task.options.spectrum && full_canvas)
    cost = cut_by_spectrum(task, budget, task.spectrum_gain / (symmetric ? 2.0 : 1.0), scene_x, scene_y);
  const bool by_scene = cost > 0.0 && scene_x.keep * scene_y.keep < worst_x.keep * worst_y.keep;
  x = by_scene ? scene_x : worst_x;
  y = by_scene ? scene_y : worst_y;
  return by_scene ? cost : largest * spread;
}

/// A layout as the prediction of errors sees it.
struct Judged {
  explicit Judged(const PlanTask& task, const Layout& l) : layout(l) {
    double mirrors = 1.0;
    const auto canvas = [&](const AxisTransform& job) {
      const bool cosine = job.frequency.basis == Basis::cosine;
      defined = defined && (cosine || job.frequency.length == canvas_length(job.border, job.samples));
      // What one part of an OTF makes of cosines has a modulus of the same mirror symmetry as the canvas: nothing of
      // the canvas's energy can concentrate in the image.
      if (cosine && (!job.odd || task.sampler.parities().is_one())) mirrors *= 2.0;
      return static_cast<double>(job.frequency.length) * (cosine ? 2.0 : 1.0);
    };
    const double samples = canvas(l.x) * canvas(l.y);
    const double image_area = static_cast<double>(task.in.width) * static_cast<double>(task.in.height);
    canvas_rms = task.canvas_norm * std::sqrt(image_area / samples);
    symmetric = std::sqrt(mirrors);
    rms_per_otf = task.norm / symmetric;
    spread = rms_per_otf * std::sqrt(aliases(l.x) * aliases(l.y));
  }
  Layout layout;
  bool defined = true;     ///< the canvas is the defined one
  double symmetric = 1.0;  ///< norm of the canvas over that of the part in which an error may concentrate
  double canvas_rms = 0.0;
  double rms_per_otf =
      0.0;              ///< rms error over the scene's std that an OTF error of 1 may become in a single alias zone
  double spread = 0.0;  ///< and in all of them
};

double rounding(const PlanTask& task, Method method, const Judged& judged, double canvas_rms) {
  const double gain = task.sampler.gain();
  if (method == Method::fft_double) return gain * storage_error(task.options) * (1.0 + 1e-6);
  const double units = arithmetic_error(judged.layout.x, judged.layout.y, canvas_rms, gain, task.options);
  return method == Method::fft_device ? task.options.device.device->test().rounding * units : units;
}

/// An order of the axes: the lines, and what lies across them.
struct Order {
  Lines lines = Lines::rows;
  const AxisTransform &along, &across;
  double flat = 0.0;     ///< share of the lines that are uniform and take no transform
  double cost_ms = 0.0;  ///< where all lines are transformed
};

Order order_of(Lines lines, const AxisTransform& x, const AxisTransform& y, const Parities& parities,
               const PlanOptions& options) {
  const bool rows = lines == Lines::rows;
  Order order{lines, rows ? x : y, rows ? y : x};
  order.cost_ms = fft_cost_ms(order.along, order.across, rows ? parities : parities.swapped());
  if (!options.scene || order.along.resampling != Resampling::fold) return order;
  const double flat = rows ? options.scene->flat_rows : options.scene->flat_columns;
  // Lines are left out in whole groups.
  if (flat >= kFewFlatLines && flat * static_cast<double>(order.across.outputs) >= 2.0 * kRow) order.flat = flat;
  return order;
}

// Columns come first where leaving out uniform ones makes up for it: an OTF with phase may then take more series.
Order cheaper_order(const AxisTransform& x, const AxisTransform& y, const Parities& parities,
                    const PlanOptions& options) {
  const auto cost_ms = [](const Order& order) { return (1.0 - kLinesCost * order.flat) * order.cost_ms; };
  const Order rows = order_of(Lines::rows, x, y, parities, options);
  if (x.frequency.basis != y.frequency.basis) return rows;
  const Order columns = order_of(Lines::columns, x, y, parities, options);
  return columns.flat > 0.0 && cost_ms(columns) < cost_ms(rows) ? columns : rows;
}

// Detail, cost and engine of a filter on the device.
void describe_on_device(const PlanTask& task, const AxisTransform& x, const AxisTransform& y, MethodCandidate& d) {
  const std::shared_ptr<const Device>& device = task.options.device.device;
  const bool complex = !task.sampler.is_real();
  d.axes = {x, y};
  d.report.on_device = true;
  d.report.detail = "x " + axis_text(x) + "; y " + axis_text(y) + "; on " + device->info().name;
  d.report.reason = device_obstacle(device->info(), x, y, complex);
  d.report.bytes = device_bytes(x, y, complex);
  d.report.cost_ms = device_cost_ms(*device, x, y);
  d.make = [&sampler = task.sampler, x, y, device, threads = task.options.threads](const Engine*) {
    return make_device_spectral_filter(sampler, x, y, device, threads);
  };
}

MethodCandidate make_candidate(const PlanTask& task, Method method, const Judged& judged) {
  const FactoredOtf& sampler = task.sampler;
  const PlanOptions& options = task.options;
  const bool in_double = method == Method::fft_double;
  const double dropped = dropped_error(sampler);
  AxisTransform x = judged.layout.x, y = judged.layout.y;
  MethodCandidate d;
  d.report.method = method;
  PredictedError& predicted = d.report.predicted;
  predicted.dropped = dropped * (sampler.dropped_is_even() ? judged.rms_per_otf : task.norm) * task.alias;
  predicted.table = sampler.table_error() * judged.spread;
  predicted.band = sampler.quadrature_error() * judged.spread;
  predicted.wrap = judged.layout.wrap;
  predicted.arithmetic = rounding(task, method, judged, judged.canvas_rms);
  if (method == Method::fft_cut) {
    // Of what the other parts leave of the tolerance: a bound that is looser than the others.
    const double budget = std::min(kCutShare * options.tolerance, 0.9 * (options.tolerance - predicted.total()));
    if (budget > 0.0)
      predicted.cut = cut(task, budget, judged.rms_per_otf, judged.defined, judged.symmetric > 1.5, x, y);
  }
  if (method == Method::fft_device) {
    describe_on_device(task, x, y, d);
    d.error_per_otf = judged.rms_per_otf * task.alias;
    return d;
  }
  const std::size_t parts = otf_parts(x, y, sampler.parities()).size();
  const Order order = cheaper_order(x, y, sampler.parities(), options);
  d.lines = order.lines;
  // Contrast that the filter brings to uniform lines is left out, up to a share of the tolerance.
  if (order.flat > 0.0)
    predicted.flat =
        std::max(0.0, std::min(kFlatShare * options.tolerance, 0.9 * (options.tolerance - predicted.total())));
  d.report.detail = "x " + axis_text(x) + "; y " + axis_text(y);
  if (parts > 1) d.report.detail += "; " + std::to_string(parts) + " parities";
  const double dearer = in_double ? kDoubleCost : method == Method::fft_cut ? kCutCost : 1.0;
  d.report.cost_ms = dearer * order.cost_ms;
  if (predicted.flat > 0.0) d.lines_saved_ms = kLinesCost * order.flat * d.report.cost_ms;
  d.report.cost_ms -= d.lines_saved_ms;
  d.report.bytes = static_cast<std::int64_t>((in_double ? 2.0 : 1.0) *
                                             spectral_bytes(order.along, order.across, sampler.parities()));
  d.axes = {x, y};
  d.error_per_otf = judged.rms_per_otf * task.alias;
  const Precision precision = in_double ? Precision::double_precision : Precision::single_precision;
  d.make = [&sampler, work = SpectralWork{x, y, precision, d.lines}, bytes = static_cast<double>(d.report.bytes),
            rigor = options.rigor, threads = options.threads, out = task.out](const Engine* earlier) {
    require_memory(bytes, out);
    return make_spectral_filter(sampler, work, rigor, threads, earlier);
  };
  return d;
}

// Basis and length of both axes of an FFT method.

/// How an axis is expanded: `odd` as in AxisTransform.
struct Expansion {
  Basis basis = Basis::fourier;
  bool odd = false;
};

AxisTransform axis_job(const CanvasRequest& request, Expansion expansion, std::int64_t length, std::int64_t outputs) {
  AxisTransform job;
  job.frequency = {expansion.basis, length, request.step_um};
  job.border = request.border;
  job.samples = request.samples;
  job.outputs = outputs;
  job.pitch_um = request.pitch_um;
  const double pitches = static_cast<double>(length) * request.step_um / request.pitch_um;
  job.resampling = is_whole(pitches) ? Resampling::fold : Resampling::chirp;
  if (job.resampling == Resampling::fold) job.out_length = std::llround(pitches);
  job.keep = job.frequency.half_count();
  job.odd = expansion.odd;
  return job;
}

// The least that an axis costs, whatever canvas it may need.
AxisTransform least_job(const CanvasRequest& request, Expansion expansion, std::int64_t outputs) {
  if (expansion.basis == Basis::cosine) return axis_job(request, expansion, request.samples, outputs);
  AxisTransform job = axis_job(request, expansion, next_smooth(request.samples), outputs);
  job.resampling = Resampling::fold;
  job.out_length = next_smooth(outputs);
  return job;
}

/// Layouts as alternatives to one that costs `below_ms`.
class Layouts {
 public:
  explicit Layouts(const PlanTask& task) : task_(task) {
    const SampleGrid &in = task.in, &out = task.out;
    const double density = std::sqrt(std::max(1.0, out.step_x_um / in.step_x_um * (out.step_y_um / in.step_y_um)));
    const double norm = task.norm * density, budget = 0.5 * kWrapShare * task.options.tolerance;
    const Border border = task.options.border;
    x_ = {Axis::x, border, in.width, in.step_x_um, 500.0 / in.step_y_um, out.step_x_um, norm, budget};
    y_ = {Axis::y, border, in.height, in.step_y_um, 500.0 / in.step_x_um, out.step_y_um, norm, budget};
  }

  /// Nothing where it would cost `below_ms` or more.
  std::optional<Layout> make(Expansion x, Expansion y,
                             double below_ms = std::numeric_limits<double>::infinity()) const {
    const std::int64_t width = task_.out.width, height = task_.out.height;
    const AxisTransform least_x = least_job(x_, x, width), least_y = least_job(y_, y, height);
    const double room = below_ms / cost_ms(least_x, least_y);
    if (!(room > 1.0)) return std::nullopt;
    Layout layout;
    const auto place = [&](const CanvasRequest& request, Expansion expansion, std::int64_t outputs,
                           AxisTransform& job) {
      CanvasLength canvas{request.samples, 0.0};
      if (expansion.basis == Basis::fourier) canvas = choose_canvas(task_.sampler, longest(request, room));
      layout.wrap += canvas.bound;
      job = axis_job(request, expansion, canvas.length, outputs);
    };
    place(x_, x, width, layout.x);
    if (!(cost_ms(layout.x, least_y) < below_ms)) return std::nullopt;
    place(y_, y, height, layout.y);
    if (!(cost_ms(layout.x, layout.y) < below_ms)) return std::nullopt;
    return layout;
  }
  double cost_ms(const AxisTransform& x, const AxisTransform& y) const {
    return fft_cost_ms(x, y, task_.sampler.parities());
  }

 private:
  // Costs grow with the length of a canvas.
  static CanvasRequest longest(CanvasRequest request, double room) {
    const double length = room * static_cast<double>(next_smooth(request.samples));
    if (length < static_cast<double>(request.longest)) request.longest = static_cast<std::int64_t>(length);
    return request;
  }

  const PlanTask& task_;
  CanvasRequest x_, y_;
};

}  // namespace

std::string axis_text(const AxisTransform& job) {
  const bool cosine = job.frequency.basis == Basis::cosine;
  std::string text =
      (cosine ? job.odd ? "cosine-sine " : "cosine " : "fourier ") + std::to_string(job.frequency.length);
  if (job.keep < job.frequency.half_count()) text += ", " + std::to_string(job.keep) + " kept";
  if (job.resampling == Resampling::chirp) return text + ", chirp to " + std::to_string(job.outputs);
  if (job.out_length == job.frequency.length) return text;
  return text + ", fold to " + std::to_string(job.out_length);
}

std::vector<MethodCandidate> fft_candidates(const PlanTask& task) {
  std::vector<Judged> layouts;
  for (const Layout& layout : fft_layouts(task)) layouts.emplace_back(task, layout);
  // The last one keeps what any of them can. With cosines alone its canvas is the same at any tolerance.
  const Judged& last = layouts.back();
  const bool cosines = last.layout.x.frequency.basis == Basis::cosine && last.layout.y.frequency.basis == Basis::cosine;
  const auto candidate = [&](Method method) {
    MethodCandidate d = make_candidate(task, method, layouts.front());
    for (std::size_t i = 1; i < layouts.size() && !keeps_tolerance(d, task.options); ++i)
      d = make_candidate(task, method, layouts[i]);
    const double least = rounding(task, method, last, cosines ? last.canvas_rms : task.canvas_norm / last.symmetric);
    const double band = task.sampler.quadrature_error() * last.spread;
    d.reachable = reachable_tolerance(least, band, cosines ? 0.0 : kWrapShare);
    return d;
  };
  std::vector<MethodCandidate> candidates{candidate(Method::fft_float)};
  MethodCandidate cut = candidate(Method::fft_cut);
  const auto cuts = [](const AxisTransform& job) { return job.keep < job.frequency.half_count(); };
  if (cuts((*cut.axes)[0]) || cuts((*cut.axes)[1])) candidates.push_back(std::move(cut));
  candidates.push_back(candidate(Method::fft_double));
  if (task.options.device.device) {
    const Judged judged(task, fourier_layout(task));
    MethodCandidate d = make_candidate(task, Method::fft_device, judged);
    if (d.report.reason.empty())
      d.reachable = reachable_tolerance(rounding(task, Method::fft_device, judged, task.canvas_norm / judged.symmetric),
                                        task.sampler.quadrature_error() * judged.spread, kWrapShare);
    candidates.push_back(std::move(d));
  }
  return candidates;
}

Layout fourier_layout(const PlanTask& task) {
  return *Layouts(task).make({Basis::fourier, false}, {Basis::fourier, false});
}

// Cosines are exact without padding. Where they are many series (an OTF that is not even) or of an awkward length (a
// large prime, not a whole number of pitches) a padded canvas may be cheaper all the same.
std::vector<Layout> fft_layouts(const PlanTask& task) {
  const FactoredOtf& sampler = task.sampler;
  constexpr Expansion fourier{Basis::fourier, false}, cosine{Basis::cosine, false};
  const Layouts layouts(task);
  if (task.options.border != Border::reflect) return {*layouts.make(fourier, fourier)};
  const bool odd_x = !sampler.all_parities().is_even_x(), odd_y = !sampler.all_parities().is_even_y();
  std::vector<Layout> list{*layouts.make({Basis::cosine, odd_x}, {Basis::cosine, odd_y})};
  const auto dear = [](const AxisTransform& job) {
    return job.odd || job.resampling == Resampling::chirp || !is_smooth(job.frequency.length);
  };
  const bool try_x = dear(list[0].x), try_y = dear(list[0].y);
  const auto consider = [&](Expansion x, Expansion y) {
    const std::optional<Layout> other = layouts.make(x, y, layouts.cost_ms(list[0].x, list[0].y));
    if (!other) return;
    if (list.size() > 1) list.erase(list.begin());
    list.insert(list.begin(), *other);
  };
  if (try_x && !odd_y) consider(fourier, cosine);
  if (try_y) consider(fourier, fourier);
  return list;
}

}  // namespace mtf
