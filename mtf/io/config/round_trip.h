// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether the values of a component survive a sensor file: written as its TOML table and read again they are the same,
// bit for bit. For the components of the list and for a type C<S> that is being written, beside the properties of
// mtf/components/conformance/conformance.h. Fields that name a file are left out: the draws have curves, but no files.

#include <span>
#include <string>

#include "mtf/components/conformance/conformance.h"

namespace mtf::io {

/// Writes a component's table with the fields `written` and reads it into `read`, the fields of a component of the same
/// kind with default values. Empty; or the first field that differs or the reader's message, with the text.
std::string round_trip(std::string_view kind, std::span<const FieldRef<double>> written,
                       std::span<const FieldRef<double>> read);

/// For every draw of the component type.
template <template <class> class C>
conformance::Outcome check_round_trip() {
  conformance::Outcome outcome{.property = "values survive the sensor file"};
  for (const conformance::Draw& draw : conformance::draws_of<C>()) {
    C<double> written{}, read{};
    const auto fields = conformance::fields_of<double>(written);
    conformance::give_values(draw, fields);
    const std::string problem = round_trip(C<double>::kind, fields, conformance::fields_of<double>(read));
    outcome.holds(problem.empty(), [&] { return draw.name + ": " + problem; });
  }
  return outcome;
}

}  // namespace mtf::io
