// SPDX-License-Identifier: Apache-2.0
// Devices: which there are, who is admitted, and what is said of the others.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "mtf/device/device_filter.h"
#include "mtf/device/device_parts.h"
#include "mtf/device/device_taps.h"
#include "radiometry/stages/noise/random.h"
#include "tests/expect_error.h"
#include "tests/mtf/device_support.h"

namespace mtf::test {
namespace {

// The kernels' text on the host: its random words are those of the noise, its functions near those of the C library.
TEST(DeviceText, HasTheWordsOfTheNoiseAndFunctionsToSevenDigits) {
  constexpr std::int64_t kCount = 4096;
  const std::vector<std::uint32_t> bits = bits_on_host(kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const std::uint32_t* of = bits.data() + std::size_t{i} * kBitsOfInput;
    const radiometry::Bits128 words = radiometry::philox({i, 17, 3, 2}, 0x9abcdef012345678U);
    for (std::size_t w = 0; w < 4; ++w) ASSERT_EQ(of[w], words[w]) << i;
    const radiometry::Uniform u = radiometry::uniform(words[0], words[1]);
    const double exact = u.u < 0.5 ? -std::log(u.u) : -std::log1p(-u.rest);
    // Errors of the polynomials and a few roundings of float.
    EXPECT_NEAR(std::bit_cast<float>(of[4]), exact, 3e-7 * exact) << i;
    const double turn = 2.0 * M_PI * (static_cast<double>(words[2]) + 0.5) / 4294967296.0;
    EXPECT_NEAR(std::bit_cast<float>(of[5]), std::cos(turn), 2e-7) << i;
    EXPECT_NEAR(std::bit_cast<float>(of[6]), std::sin(turn), 2e-7) << i;
  }
}

TEST(Device, IsAdmittedAndMeasured) {
  const auto device = open_tested_device();
  if (!device) GTEST_SKIP() << "no device";
  const DeviceTest& test = device->test();
  for (const double rms : test.rms) {
    EXPECT_GT(rms, 1e-8);  // of float: no error at all would be a broken measure
    EXPECT_LE(rms, 3e-7);
  }
  EXPECT_GE(test.rounding, 1.0);
  EXPECT_LT(test.rounding, 2.0);
  EXPECT_GT(test.filter_ms[0], 0.0);
  EXPECT_GT(test.filter_ms[1], test.filter_ms[0]);
  EXPECT_GT(test.upload_ns, 0.0);
  EXPECT_GT(device->parts().tap_ns, 0.0);
  EXPECT_GT(device->info().bytes, 1 << 20);
  EXPECT_FALSE(device->failure());
  EXPECT_EQ(open_device(device->info()), device) << "a device that is open is shared";
  std::printf("%s: rms %.2e %.2e, filter of 1024 x 1024 %.3f ms, up %.2f, down %.2f GB/s\n",
              device->info().name.c_str(), test.rms[0], test.rms[1], test.filter_ms[1], 1.0 / test.upload_ns,
              1.0 / test.download_ns);
}

TEST(Device, ThatComputesWrongIsRefusedByName) {
  const std::optional<DeviceInfo> info = tested_device();
  if (!info) GTEST_SKIP() << "no device";
  expect_refused<DeviceError>({info->name, info->id, "not admitted", "random words", "to the bit"},
                              [&] { open_device(*info, DeviceFault::words); });
  expect_refused<DeviceError>({info->name, "not admitted", "errs by", "3e-07 allowed"},
                              [&] { open_device(*info, DeviceFault::values); });
  DeviceInfo gone = *info;
  gone.index = 4711;
  gone.id = "gone";
  EXPECT_THROW(open_device(gone), DeviceError);
}

TEST(Device, IsChosenByWord) {
  std::string note;
  EXPECT_FALSE(choose_device("cpu", note).device);
  EXPECT_EQ(note, "");
  const std::optional<DeviceInfo> info = tested_device();
  const std::string message =
      expect_refused({"there is no device no such card"}, [&] { choose_device("no such card", note); });
  if (!info) return;
  expect_says(message, {info->id, info->name});
  const DeviceChoice chosen = choose_device(info->id, note);
  EXPECT_EQ(chosen.device, open_device(*info));
  EXPECT_TRUE(chosen.insisted);
  if (!info->cpu) return;
  // The processor by another way is no gain: by name alone.
  EXPECT_FALSE(choose_device("auto", note).device);
  expect_says(note, {"no device beside the processor"});
}

TEST(Device, WhoseModuleIsMissingIsNotThere) {
  const char* const before = std::getenv("MTFKIT_OPENCL");
  const std::string kept = before != nullptr ? before : "";
  ::setenv("MTFKIT_OPENCL", "/no/such/module.so", 1);
  const DeviceList list = devices();
  if (before == nullptr)
    ::unsetenv("MTFKIT_OPENCL");
  else
    ::setenv("MTFKIT_OPENCL", kept.c_str(), 1);
  for (const DeviceInfo& info : list.devices) EXPECT_NE(info.backend, "opencl");
  std::string notes;
  for (const std::string& note : list.notes) notes += note + "\n";
  expect_says(notes, {"opencl: not part of this installation"});
}

AxisTransform axis(std::int64_t length, std::int64_t out_length, Resampling resampling = Resampling::fold) {
  AxisTransform job;
  job.frequency = {Basis::fourier, length, 1.0};
  job.samples = length;
  job.outputs = job.out_length = out_length;
  job.pitch_um = static_cast<double>(length) / static_cast<double>(out_length);
  job.resampling = resampling;
  job.keep = job.frequency.half_count();
  return job;
}

TEST(Device, SaysWhatItCannotDo) {
  DeviceInfo info;
  info.bytes = std::int64_t{1} << 30;
  info.largest_bytes = info.bytes / 4;
  const AxisTransform good = axis(4096, 2048);
  EXPECT_EQ(device_obstacle(info, good, good, true), "");
  expect_says(device_obstacle(info, good, axis(22, 22), false), {"factors up to 7", "22"});
  expect_says(device_obstacle(info, axis(1, 1), good, false), {"lengths of 2 and more"});
  expect_says(device_obstacle(info, axis(100, 30, Resampling::chirp), good, false), {"canvases of whole pixels"});
  const AxisTransform large = axis(16384, 16384);
  expect_says(device_obstacle(info, large, large, false), {"bytes on the device"});
  info.largest_bytes = info.bytes = std::int64_t{16} << 30;
  EXPECT_EQ(device_obstacle(info, large, large, false), "");
  const TapAxis side{16384, 8192, 2, -3, 9};
  EXPECT_EQ(device_taps_obstacle(info, side, side), "");
  info.bytes = std::int64_t{2} << 30;
  expect_says(device_taps_obstacle(info, side, side), {"bytes on the device"});
}

}  // namespace
}  // namespace mtf::test
