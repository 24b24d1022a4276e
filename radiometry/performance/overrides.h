// SPDX-License-Identifier: Apache-2.0
#pragma once

// A number of the tables of a sensor file may be overridden by its path ("detector.read_noise"); that is how a design
// of a study differs from its sensor file.

#include <algorithm>
#include <span>
#include <string_view>

namespace radiometry {

template <class S>
struct Override {
  std::string_view path;  ///< "table.key"
  S value{};
};

template <class S>
class Overrides {
 public:
  Overrides() = default;
  explicit Overrides(std::span<const Override<S>> list) : list_(list) {}

  const S* find(std::string_view path) const {
    for (const Override<S>& one : list_)
      if (one.path == path) return &one.value;
    return nullptr;
  }
  S operator()(std::string_view path, double given) const {
    const S* value = find(path);
    return value != nullptr ? *value : S(given);
  }
  bool empty() const { return list_.empty(); }
  /// True where one of the paths is such.
  template <class Is>
  bool any(const Is& is) const {
    return std::any_of(list_.begin(), list_.end(), [&](const Override<S>& one) { return is(one.path); });
  }

 private:
  std::span<const Override<S>> list_;
};

}  // namespace radiometry
