// SPDX-License-Identifier: Apache-2.0
#include "mtf/work/usable_memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

namespace mtf {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/// The number that a file begins with; none for "max" and for a file that is not there.
double number_in(const std::string& file) {
  std::ifstream in(file);
  double number = 0.0;
  return in >> number && number >= 0.0 ? number : kNone;
}

/// Of a group and those around it, up to the root. In a container the names of its groups may be those outside of it,
/// and its own limit stands at the root.
double least_upwards(const std::string& root, std::string group, const std::string& file) {
  if (group.find("..") != std::string::npos) group.clear();
  double least = kNone;
  for (;;) {
    least = std::min(least, number_in(root + group + "/" + file));
    if (group.empty()) return least;
    group.erase(std::min(group.rfind('/'), group.size()));
  }
}

double page_bytes() { return static_cast<double>(::sysconf(_SC_PAGESIZE)); }

double left_of_address_space() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kNone;
  const double mapped = number_in("/proc/self/statm") * page_bytes();
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - (mapped < kNone ? mapped : 0.0));
}

}  // namespace

double group_limit_bytes(const std::string& groups, const std::string& root) {
  double least = kNone;
  std::istringstream lines(groups);
  for (std::string line; std::getline(lines, line);) {  // "4:memory,hugetlb:/jobs/7", "0::/jobs/7"
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    std::string group = line.substr(second + 1);
    if (group == "/") group.clear();
    if (controllers == ",,") least = std::min(least, least_upwards(root, group, "memory.max"));
    if (controllers.find(",memory,") != std::string::npos)
      least = std::min(least, least_upwards(root + "/memory", group, "memory.limit_in_bytes"));
  }
  return least;
}

UsableMemory usable_memory() {
  std::ifstream file("/proc/self/cgroup");
  const std::string groups{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const UsableMemory all[] = {{static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * page_bytes(), "the machine has"},
                              {left_of_address_space(), "ulimit -v leaves"},
                              {group_limit_bytes(groups, "/sys/fs/cgroup"), "the container has"}};
  return *std::min_element(std::begin(all), std::end(all),
                           [](const UsableMemory& a, const UsableMemory& b) { return a.bytes < b.bytes; });
}

double usable_bytes() { return usable_memory().bytes; }

}  // namespace mtf
