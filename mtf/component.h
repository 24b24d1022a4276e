// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a component of a sensor is. A component is a value type `template <class S>` in mtf/components/ with
//   kind, doc, stages      static: its name in the config, one sentence, the lists it may stand in
//   part                   the part of a sensor that it stands for
//   fields()               the one table that drives config reading and writing, validation, fits and tests
//   traits(ctx)            symmetry of its OTF for the present values
//   otf(f, ctx)            OTF(f) = integral of psf(x) exp(-2 pi i f.x) dx at f in cycles/mm
//   deviation(fx, fy, ctx) a bound of |otf - 1| over |f.x| <= fx, |f.y| <= fy
// and may add:
//   cutoff_cy_mm(ctx)      |f| from which the OTF is zero. Without it: infinity
//   check(ctx)             what the field bounds cannot say: values that exclude each other, validity of the formula
// and, mostly for speed:
//   displacement_mm(ctx)   a vector d such that the OTF depends on f through d.f alone (motion in one direction)
//   kinks_cy_mm(ctx)       the |f| in rising order at which the OTF is not smooth, the last being its cutoff where it
//                          has one; where they depend on the wavelength they go with 1/wavelength. Without it: the
//                          cutoff
//   is_slow                an OTF that costs microseconds, in two dimensions: plans tabulate it between its kinks
//   is_footprint           it is the light-sensitive area of a pixel
//   is_reconstruction      it turns samples into a continuous image (display, eye, interpolation), which digital
//                          filters do not: their OTF is periodic in the sampling frequency
//   rows(fx, ctx)          see Component::rows, for sums of products of functions of fx and of fy
//   evaluator(ctx)         otf as a function of f alone, where work that does not depend on f is worth doing once
//   variant_doc()          the sentence for the present values, where the kind holds several models
// Whoever builds a system in code includes the headers of its components and adds their values:
//   system.add(Stage::presample, Jitter<double>{.rms = 20_urad});
// The system keeps each as a type-erased handle `Component<S>`; the list of types is mtf/components/all.h.

#include <array>
#include <concepts>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <typeinfo>
#include <variant>
#include <vector>

#include "mtf/frame.h"

namespace mtf {

/// The three lists of a system, in the order of the physics (presample acts on the scene, readout on collected
/// charge before the ADC, postsample on digital images; the last two are on the detector grid).
enum class Stage { presample, readout, postsample };
inline constexpr std::array kStages{Stage::presample, Stage::readout, Stage::postsample};
std::string_view stage_name(Stage stage);

struct Stages {
  bool presample = false, readout = false, postsample = false;
  constexpr bool allows(Stage stage) const {
    return stage == Stage::presample ? presample : stage == Stage::readout ? readout : postsample;
  }
};

/// The part of a sensor that a component stands for, along the path of the light and the signal. `unspecified`: blur
/// known by its size or a measured curve, of which nobody has said where it comes from.
enum class SensorPart { unspecified, optics, path, detector, motion, electronics, display };

/// Properties of an OTF that the grid and the plan rely on; each is tested for every component.
struct Traits {
  bool radial = false;     ///< depends on |f| only
  bool separable = false;  ///< otf(fx, fy) = otf(fx, 0) x otf(0, fy), where otf(0, 0) = 1
  bool even_x = false;     ///< otf(-fx, fy) = otf(fx, fy)
  bool even_y = false;     ///< otf(fx, -fy) = otf(fx, fy)
  bool square = false;     ///< otf(fy, 0) = otf(0, fy); radial ones are so without saying it
  bool flat_x = false;     ///< otf(fx, 0) = 1
  bool flat_y = false;     ///< otf(0, fy) = 1
  bool real = true;
  bool chromatic = false;  ///< depends on the wavelength of the band node
  bool placed = false;     ///< depends on the place in the image (Context::place)
  bool gain = false;       ///< |otf| may exceed 1, or otf(0) differs from 1
  double dc = 1.0;         ///< otf(0)
};

enum class Presence {
  required,
  optional,
  shared  ///< falls back to the field of the same name in [optics]
};

/// How a value stands in a file.
enum class FieldType {
  number,          ///< in a unit
  size,            ///< in the image: a length, an angle or pixels, for both axes or as NAME_x and NAME_y
  frequency,       ///< cycles/mm, cycles/mrad, cycles/pixel; where `unit` names Hz, also in time
  whole,           ///< a whole number
  flag,            ///< true or false
  word,            ///< one of `words`
  numbers,         ///< a list of numbers
  rows,            ///< a list of lists of numbers, as of filter taps
  text,            ///< free text: a name
  file,            ///< the name of a file
  number_or_file,  ///< one number, or the file of a curve
  pair,            ///< a list of two numbers, whole ones without `unit`
  date             ///< a date and time
};

/// One row of a field table: all that a reader, a writer, a schema, a form or a fit has to know of a key of a file.
/// Tables of types state rows beside the members that hold the values, and the type of a member is that of its row.
struct FieldInfo {
  std::string_view name;
  Dimension dimension = Dimension::none;
  std::string_view unit{};    ///< unit the raw double is held in ("um", "" for plain numbers and Extents)
  double lo = 0.0, hi = 0.0;  ///< allowed range, in that unit (Extents: in um, urad or px as written)
  bool lo_open = false;       ///< lo itself is not allowed
  bool hi_open = false;
  Presence presence = Presence::required;
  std::string_view example{};  ///< a typical value as written in a config
  std::string_view doc{};
  FieldType type = FieldType::number;
  std::span<const std::string_view> words{};  ///< of a number: may stand in its place, and leave it to other keys
  std::string_view excludes{};  ///< keys of the same table that it takes the place of, with blanks between them
  std::string_view kinds{};     ///< words of the table's key `kind` with which it counts; "" with any
};

template <class Row>
concept TableRow = std::derived_from<Row, FieldInfo>;

// The same row, but for one thing; also as a Field (mtf/components/field.h).
template <TableRow Row, class Cell>
constexpr Row with(Row row, Cell FieldInfo::*cell, Cell value) {
  row.*cell = value;
  return row;
}
constexpr auto required(TableRow auto row) { return with(row, &FieldInfo::presence, Presence::required); }
constexpr auto optional(TableRow auto row) { return with(row, &FieldInfo::presence, Presence::optional); }
constexpr auto shared(TableRow auto row) { return with(row, &FieldInfo::presence, Presence::shared); }
/// `lo` itself is not allowed; `hi`.
constexpr auto above(TableRow auto row) { return with(row, &FieldInfo::lo_open, true); }
constexpr auto below(TableRow auto row) { return with(row, &FieldInfo::hi_open, true); }
constexpr auto excluding(std::string_view keys, TableRow auto row) { return with(row, &FieldInfo::excludes, keys); }
constexpr auto of_kinds(std::string_view kinds, TableRow auto row) { return with(row, &FieldInfo::kinds, kinds); }
constexpr auto of_type(FieldType type, TableRow auto row, std::span<const std::string_view> words = {}) {
  return with(with(row, &FieldInfo::type, type), &FieldInfo::words, words);
}

/// A row of a number from lo to hi in a unit of that dimension.
constexpr FieldInfo required_row(std::string_view name, Dimension dimension, std::string_view unit, double lo,
                                 double hi, std::string_view example, std::string_view doc) {
  return {.name = name, .dimension = dimension, .unit = unit, .lo = lo, .hi = hi, .example = example, .doc = doc};
}
/// The same with the dimension of the unit; of a plain number; of what has no range, such as a word or a file.
constexpr FieldInfo required_row(std::string_view name, std::string_view unit, double lo, double hi,
                                 std::string_view example, std::string_view doc) {
  return required_row(name, dimension_of(unit), unit, lo, hi, example, doc);
}
constexpr FieldInfo required_row(std::string_view name, double lo, double hi, std::string_view example,
                                 std::string_view doc) {
  return required_row(name, Dimension::none, "", lo, hi, example, doc);
}
constexpr FieldInfo required_row(std::string_view name, std::string_view example, std::string_view doc) {
  return required_row(name, 0.0, 0.0, example, doc);
}

/// The same as required_row, of what need not be given.
template <class... Cells>
constexpr FieldInfo optional_row(std::string_view name, const Cells&... cells) {
  return optional(required_row(name, cells...));
}

/// The words of FieldInfo::excludes or FieldInfo::kinds.
std::vector<std::string_view> words_in(std::string_view text);
/// Whether a value is finite and within the bounds.
bool in_range(const FieldInfo& info, double value);
/// The bounds of a value in this unit: "[0, 1) um".
std::string range_text(const FieldInfo& info, std::string_view unit);
/// "2 um is outside [0, 1) um".
std::string outside_text(const FieldInfo& info, double value, std::string_view unit);

/// An enumerated field: `names` are the words of the config.
struct Choice {
  int index = 0;
  std::span<const std::string_view> names;
};

/// `.axis = choice_of(kAxisNames, "y")`. Throws UsageError, with the words there are, for another word.
Choice choice_of(std::span<const std::string_view> names, std::string_view word);

/// A measured curve of one frequency axis. Values are interpolated by monotone cubics (value and slope continuous).
/// Before the first sample it starts from 1 at f = 0; beyond the last it goes to 0 along the last slope, or the mean
/// fall 1/(last frequency) if steeper, and stays there.
struct Curve {
  std::string source;             ///< file it came from, for messages and provenance; empty: lines of the sensor file
  const Unit* unit = nullptr;     ///< cy/mm, cy/mrad or cy/px
  std::vector<double> frequency;  ///< strictly increasing, first > 0 or (0, value)
  std::vector<double> value;
  std::vector<double> slope;  ///< filled by make_curve
};

/// A curve ready for use. Throws UsageError (with `source`) for fewer than two samples, unsorted, negative or
/// non-finite entries, sizes that differ, or |value| > 1.05.
Curve make_curve(std::string source, const Unit& unit, std::vector<double> frequency, std::vector<double> value);

struct ValueSlope {
  double value = 0.0;
  double slope = 0.0;
};

/// Value at |f| and slope at f, in the curve's own unit; the slope at 0 is 0, the mean of both sides.
ValueSlope evaluate(const Curve& curve, double f);
/// From where on it is 0, in the curve's own unit.
double end_of(const Curve& curve);

/// A curve, or the curves at positions of the field, of one unit, and the weights by which they are summed.
template <class S>
struct CurveSum {
  std::vector<std::shared_ptr<const Curve>> curves{};
  std::vector<S> weight{};  ///< none: one curve as it is

  CurveSum() = default;
  CurveSum(std::shared_ptr<const Curve> one) : curves{std::move(one)} {}
};

template <class S>
using Taps = std::vector<std::vector<S>>;  ///< rows of equal length, taps[row][column]

/// A list of plain numbers; each element has the bounds of the field and is fitted as name[i], i from 0.
template <class S>
using Coefficients = std::vector<S>;

/// A field of a live component, type-erased: what config, fits and tests work on.
template <class S>
struct FieldRef {
  const FieldInfo* info;
  std::variant<S*, std::optional<S>*, AxisPair<S>*, SpatialFrequency<S>*, int*, Choice*, Coefficients<S>*, Taps<S>*,
               CurveSum<S>*>
      value;
};

/// Something `check` found: an error stops compilation of the system, a warning is shown and reported.
struct Problem {
  bool error = true;
  std::string field{};  ///< "" when it concerns the component as a whole
  std::string text{};
};

template <class S>
struct ComponentVariant;  // std::variant of all types, in mtf/components/all.h

/// What the header of a component declares; see above.
template <class C>
concept ComponentType = requires {
  { C::kind } -> std::convertible_to<std::string_view>;
  C::fields();
};

/// What no value of a component changes.
struct KindFacts {
  std::string_view kind, doc;
  Stages stages;
  bool is_pupil, is_footprint, is_reconstruction, is_slow;
};

/// Value handle of one component: copies share, edits through fields() copy first. Plans, checks and texts are made of
/// systems of doubles, so the functions that only they call exist for doubles alone.
template <class S>
class Component {
 public:
  /// The component of a known type: `Component<double> c = Jitter<double>{.rms = 20_urad}`, where only the header of
  /// that component is needed. Throws UsageError for a type that is not in the list of mtf/components/all.h.
  template <template <class> class C>
  requires ComponentType<C<S>> Component(const C<S>& component) : Component(copy_of(&component, typeid(C<S>))) {}
  /// The component as the type that it has, null for another type: `c.get_if<Jitter<double>>()->rms`.
  template <ComponentType C>
  const C* get_if() const {
    return static_cast<const C*>(address_if(typeid(C)));
  }
  /// A component of that kind with default values. Throws UsageError naming the nearest kind.
  static Component make(std::string_view kind);

  std::string_view kind() const { return facts().kind; }
  std::string_view doc() const { return facts().doc; }
  /// doc(), or for a kind that holds several models the one in use.
  std::string_view description() const requires std::same_as<S, double>;
  Stages stages() const { return facts().stages; }
  SensorPart part() const;
  /// True for a complete pupil OTF (diffraction): at most one in a list.
  bool is_pupil() const { return facts().is_pupil; }
  /// The light-sensitive area of a pixel.
  bool is_footprint() const { return facts().is_footprint; }
  /// Turns samples into a continuous image.
  bool is_reconstruction() const { return facts().is_reconstruction; }
  Traits traits(const Context<S>& ctx) const;
  double cutoff_cy_mm(const Context<S>& ctx) const;
  double deviation(double fx_cy_mm, double fy_cy_mm, const Context<S>& ctx) const;
  /// Bounds of every field, shared fields that nobody gives, and the component's own check.
  std::vector<Problem> check(const Context<S>& ctx) const requires std::same_as<S, double>;

  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const;
  /// h[i] *= otf(f[i]): one dispatch for the whole span.
  void multiply(std::span<const Freq<S>> f, const Context<S>& ctx, std::span<Complex<S>> h) const;
  /// h[i] *= otf({fx[i], fy}) for any fy, what fx alone decides worked out once. Keeps fx; `h` may be shorter.
  using Rows = std::function<void(const S& fy, std::span<Complex<S>> h)>;
  Rows rows(std::span<const S> fx, const Context<S>& ctx) const requires std::same_as<S, double>;
  /// Where the OTF is not smooth, see above.
  std::vector<double> kinks_cy_mm(const Context<S>& ctx) const;
  /// It costs microseconds a frequency.
  bool is_slow() const { return facts().is_slow; }
  /// Unit vector u with otf(f) = otf((f.u) u), where the component knows one.
  std::optional<Freq<double>> line(const Context<S>& ctx) const requires std::same_as<S, double>;

  std::vector<FieldRef<S>> fields();
  /// The same for reading only; the pointers stay valid as long as the component.
  std::vector<FieldRef<S>> fields() const;

 private:
  explicit Component(std::shared_ptr<ComponentVariant<S>> value) : value_(std::move(value)) {}
  static Component copy_of(const void* component, const std::type_info& type);
  const void* address_if(const std::type_info& type) const;
  const KindFacts& facts() const;

  std::shared_ptr<ComponentVariant<S>> value_;
};

/// Every kind that exists, in the order of mtf/components/all.h.
std::vector<std::string_view> component_kinds();

}  // namespace mtf
