// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a component keeps what grids, plans and fits rely on: the list of properties.h, for the draws of its field
// table, in double and in float; with a type for automatic differentiation also its derivatives. For a component that
// is being written, from any test framework; it need not be in the list of mtf/components/all.h.
//
//   const std::vector<Outcome> outcomes = mtf::conformance::check<MyBlur>();
//   if (!mtf::conformance::all_ok(outcomes)) std::puts(mtf::conformance::describe_failures(outcomes).c_str());
//
// With derivatives: check<MyBlur, ceres::Jet<double, 4>>().
// That values survive the sensor file: mtf/io/config/round_trip.h. Values against published ones remain for the author.

#include "mtf/components/conformance/properties.h"
#include "mtf/components/conformance/slope_checks.h"

namespace mtf::conformance {

/// The draws of a component type that its check accepts.
template <template <class> class C>
std::vector<Draw> draws_of() {
  C<double> blank{};
  const auto accepted = [](const Draw& draw) {
    C<double> component{};
    const Context<double> ctx = give_values(draw, fields_of<double>(component));
    return is_accepted<double>(component, ctx);
  };
  return draws_of(C<double>::kind, fields_of<double>(blank), accepted);
}

namespace detail {

/// The properties that a subject has by itself.
template <class S, class C>
struct Property {
  const char* name;
  void (*check)(const Subject<S, C>&, Outcome&);
};

template <class S, class C>
constexpr std::array<Property<S, C>, 8> kProperties{
    {{"unity at zero frequency", &unity_at_zero_frequency<S, C>},
     {"passive ones do not amplify", &passive_ones_do_not_amplify<S, C>},
     {"hermitian", &hermitian<S, C>},
     {"declared symmetry is true", &declared_symmetry_is_true<S, C>},
     {"cutoff is true and tight", &cutoff_is_true_and_tight<S, C>},
     {"finite everywhere", &finite_everywhere<S, C>},
     {"deviation bounds the distance from one", &deviation_bounds_the_distance_from_one<S, C>},
     {"chromatic flag is true", &chromatic_flag_is_true<S, C>}}};

template <class C>
constexpr std::array<Property<double, C>, 3> kPropertiesInDouble{
    {{"rows and evaluator equal the otf", &rows_equal_the_otf<C>},
     {"only the projection on a motion counts", &only_the_projection_counts<C>},
     {"values outside their range are refused by name", &values_outside_their_range_are_refused_by_name<C>}}};

template <class S, class C>
void add_outcomes(const std::vector<Subject<S, C>>& subjects, std::span<const Property<S, C>> properties,
                  std::vector<Outcome>& outcomes) {
  for (const Property<S, C>& property : properties) {
    Outcome& outcome = outcomes.emplace_back(Outcome{.property = property.name});
    if constexpr (std::is_same_v<S, float>) outcome.property += ", in float";
    for (const Subject<S, C>& subject : subjects) property.check(subject, outcome);
  }
}

template <class Jet, class Double, class Jets>
void add_derivatives(const std::vector<Pair<Jet, Double, Jets>>& pairs, std::vector<Outcome>& outcomes) {
  const auto add = [&](const char* name, const auto& check) {
    Outcome& outcome = outcomes.emplace_back(Outcome{.property = name});
    for (const auto& pair : pairs) check(pair, outcome);
  };
  add("gradient equals difference", [](const auto& pair, Outcome& out) { gradient_equals_difference(pair, out); });
  add("gradient at bounds", [](const auto& pair, Outcome& out) {
    if (pair.plain.name.ends_with("#0")) gradient_at_bounds(pair, out);
  });
  add("gradient at zero frequency", [](const auto& pair, Outcome& out) { gradient_at_zero_frequency(pair, out); });
  add("gradient at and beyond the cutoff",
      [](const auto& pair, Outcome& out) { gradient_at_and_beyond_the_cutoff(pair, out); });
  add("gradient is never NaN", [](const auto& pair, Outcome& out) { gradient_is_never_nan(pair, out); });
  add("gradient is finite at and near zero frequency",
      [](const auto& pair, Outcome& out) { gradient_is_finite_at_and_near_zero(pair, out); });
}

}  // namespace detail

/// Checks all properties and gives an outcome for each; the names of those over float say so. With Jet =
/// ceres::Jet<double, N> the derivatives are checked too. The first outcome says whether every field is part of a draw:
/// without draws nothing else is compared. Throws UsageError for examples in the field table that cannot be read.
template <template <class> class C, class Jet = void>
std::vector<Outcome> check() {
  const std::vector<Draw> draws = draws_of<C>();
  std::vector<Outcome> outcomes{{.property = "the examples of the field table are accepted"}};
  const auto accepted_with = [&](std::uint64_t fields, const std::string& which) {
    const auto gives_them = [&](const Draw& draw) { return (draw.given & fields) == fields; };
    outcomes.front().holds(std::any_of(draws.begin(), draws.end(), gives_them), [&] {
      return std::string(C<double>::kind) + ": check() refuses every combination of fields " + which;
    });
  };
  accepted_with(0, "with the examples of the table");
  C<double> blank{};
  std::uint64_t bit = 1;
  for (const FieldRef<double>& field : fields_of<double>(blank)) {
    accepted_with(bit, "that has \"" + std::string(field.info->name) + "\"");
    bit <<= 1;
  }

  std::vector<Subject<double, C<double>>> in_double, rounded;
  std::vector<Subject<float, C<float>>> in_float, rounded_in_float;
  for (const Draw& draw : draws) {
    in_double.push_back(subject_of(draw, C<double>{}));
    in_float.push_back(cast_subject<float, C<float>>(in_double.back()));
    rounded.push_back(rounded_to_float(in_double.back()));
    rounded_in_float.push_back(cast_subject<float, C<float>>(rounded.back()));
  }
  detail::add_outcomes<double, C<double>>(in_double, detail::kProperties<double, C<double>>, outcomes);
  detail::add_outcomes<double, C<double>>(in_double, detail::kPropertiesInDouble<C<double>>, outcomes);
  detail::add_outcomes<float, C<float>>(in_float, detail::kProperties<float, C<float>>, outcomes);
  Outcome& equal = outcomes.emplace_back(Outcome{.property = "float equals double"});
  for (std::size_t i = 0; i < rounded.size(); ++i) float_equals_double(rounded[i], rounded_in_float[i], equal);
  if constexpr (!std::is_void_v<Jet>) {
    std::vector<Pair<Jet, C<double>, C<Jet>>> pairs;
    for (const auto& subject : in_double) pairs.push_back({subject, cast_subject<Jet, C<Jet>>(subject)});
    detail::add_derivatives(pairs, outcomes);
  }
  return outcomes;
}

}  // namespace mtf::conformance
