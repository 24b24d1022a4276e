// SPDX-License-Identifier: Apache-2.0
#include "mtf/work/usable_memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace {

namespace fs = std::filesystem;

/// Control groups as files, in a folder that goes away.
class Groups {
 public:
  Groups() {
    std::string name = (fs::temp_directory_path() / "mtfkit_groups_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    root_ = name;
  }
  ~Groups() {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  Groups(const Groups&) = delete;
  Groups& operator=(const Groups&) = delete;

  void set(const std::string& file, const std::string& limit) const {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << limit << "\n";
  }
  double of(const std::string& groups) const { return mtf::group_limit_bytes(groups, root_.string()); }

 private:
  fs::path root_;
};

TEST(UsableMemory, TheLeastLimitOfNestedGroupsCounts) {
  const Groups two;
  two.set("memory.max", "max");
  two.set("jobs/memory.max", "536870912");
  two.set("jobs/7/memory.max", "1073741824");
  two.set("jobs/8/memory.max", "max");
  EXPECT_EQ(two.of("0::/jobs/7\n"), 536870912.0);
  EXPECT_EQ(two.of("0::/jobs/8\n"), 536870912.0);
  EXPECT_TRUE(std::isinf(two.of("0::/\n")));
  EXPECT_TRUE(std::isinf(two.of("0::/other\n")));
}

TEST(UsableMemory, TheFirstVersionOfGroupsCountsToo) {
  const Groups one;
  one.set("memory/memory.limit_in_bytes", "9223372036854771712");  // how it says none
  one.set("memory/docker/abc/memory.limit_in_bytes", "1048576");
  one.set("cpu/docker/abc/memory.limit_in_bytes", "1");  // of another controller
  EXPECT_EQ(one.of("5:cpu,cpuacct:/docker/abc\n4:hugetlb,memory:/docker/abc\n0::/\n"), 1048576.0);
  EXPECT_GT(one.of("4:memory:/\n"), 9e18);
}

// In a container the group has the name that it has outside, and its limit stands at the root of what is mounted.
TEST(UsableMemory, AContainerSeesItsOwnGroupAtTheRoot) {
  const Groups here;
  here.set("memory.max", "536870912");
  EXPECT_EQ(here.of("0::/docker/abc\n"), 536870912.0);
  EXPECT_EQ(here.of("0::/../../abc\n"), 536870912.0);
  EXPECT_EQ(here.of("0::/\n"), 536870912.0);
  EXPECT_TRUE(std::isinf(here.of("")));
  EXPECT_TRUE(std::isinf(here.of("no groups\n:\n")));
}

TEST(UsableMemory, WhatUlimitLeavesCounts) {
  const double machine = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  EXPECT_GT(mtf::usable_bytes(), 0.0);
  EXPECT_LE(mtf::usable_bytes(), machine);
  const pid_t child = ::fork();
  if (child == 0) {
    std::ifstream statm("/proc/self/statm");
    rlim_t mapped = 0;
    statm >> mapped;
    constexpr rlim_t kLeft = rlim_t{4} << 30U;
    const rlim_t all = mapped * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + kLeft;
    const rlimit limit{all, all};
    if (::setrlimit(RLIMIT_AS, &limit) != 0) ::_exit(1);
    const mtf::UsableMemory left = mtf::usable_memory();
    // What is mapped already is not left.
    const bool right =
        std::abs(left.bytes - static_cast<double>(kLeft)) < 1e8 && std::string(left.whose) == "ulimit -v leaves";
    ::_exit(right || machine < static_cast<double>(kLeft) ? 0 : 2);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

}  // namespace
