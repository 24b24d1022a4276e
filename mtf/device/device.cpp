// SPDX-License-Identifier: Apache-2.0
#include "mtf/device/device.h"

#include <dlfcn.h>

#include <algorithm>
#include <map>

#include "mtf/device/device_parts.h"
#include "mtf/words.h"

namespace mtf {
namespace {

struct BackendModule {
  const char* name;
  Module module;
  const char* driver;  ///< without which the module need not be opened; null: it says so itself
};

constexpr std::array kBackends{
    BackendModule{"cuda", {.name = "mtfkit_cuda", .what = "devices by CUDA", .in_all = true}, "libcuda.so.1"},
    BackendModule{"opencl", {.name = "mtfkit_opencl", .what = "devices by OpenCL", .in_all = true}, nullptr}};

const DeviceModule& module_of(const BackendModule& backend) { return open_module<DeviceModule>(backend.module); }

/// Why the module need not be opened, or "".
std::string absence(const BackendModule& backend) {
  if (!has_module(backend.module)) return "not part of this installation";
  if (backend.driver == nullptr) return "";
  void* const driver = ::dlopen(backend.driver, RTLD_LAZY | RTLD_LOCAL);
  return driver != nullptr ? "" : std::string("no driver on this machine (") + backend.driver + ")";
}

}  // namespace

DeviceList devices() {
  DeviceList list;
  for (const BackendModule& backend : kBackends) {
    const auto tell = [&](const std::string& why) { list.notes.push_back(std::string(backend.name) + ": " + why); };
    if (const std::string why = absence(backend); !why.empty()) {
      tell(why);
      continue;
    }
    try {
      for (DeviceInfo info : module_of(backend).list()) {
        info.backend = backend.name;
        info.id = backend.name + std::to_string(info.index);
        list.devices.push_back(std::move(info));
      }
    } catch (const RuntimeError& error) {
      tell(error.what());
    }
  }
  return list;
}

Device::Device(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Device::~Device() = default;
const DeviceInfo& Device::info() const { return parts_->info; }
const DeviceTest& Device::test() const { return parts_->test; }

std::optional<std::string> Device::failure() const {
  const std::scoped_lock lock(parts_->lock);
  return parts_->failure;
}

const DeviceMemory& Device::Parts::memory(Place place, std::size_t bytes) {
  std::shared_ptr<const DeviceMemory>& held = places_[static_cast<std::size_t>(place)];
  if (held && held->bytes >= bytes) return *held;
  held = nullptr;  // given back before more is taken
  held = backend->allocate(bytes);
  return *held;
}

const PinnedMemory& Device::Parts::pinned(std::size_t number, std::size_t bytes) {
  if (pinned_.size() <= number) pinned_.resize(number + 1);
  std::shared_ptr<const PinnedMemory>& held = pinned_[number];
  if (held && held->bytes >= bytes) return *held;
  held = nullptr;
  held = backend->allocate_pinned(bytes);
  return *held;
}

void Device::Parts::give_back() {
  places_ = {};
  pinned_.clear();
  ffts_.clear();
  maps_.clear();
}

void Device::Parts::fail(const DeviceError& error) {
  failure = error.what();
  try {
    backend->finish(queue);  // before memory goes that is in use
  } catch (const DeviceError&) {
    lost = true;
  }
  if (!lost && dynamic_cast<const DeviceMemoryError*>(&error) != nullptr) {
    give_back();
    throw DeviceMemoryError(info.name + ": " + error.what());
  }
  lost = true;
  throw DeviceError(info.name + ": " + error.what());
}

const DeviceMemory& Device::Parts::map(const std::shared_ptr<const Image>& image) {
  std::erase_if(maps_, [](const auto& entry) { return entry.first.expired(); });
  for (const auto& [known, memory] : maps_)
    if (known.lock() == image) return *memory;
  const auto memory = backend->allocate(static_cast<std::size_t>(image->size()) * sizeof(float));
  backend->upload(queue, image->data(), *memory, memory->bytes);
  backend->finish(queue);
  return *maps_.emplace_back(image, memory).second;
}

DeviceFft& Device::Parts::fft(const FftShape& shape) {
  auto found = std::find_if(ffts_.begin(), ffts_.end(), [&](const auto& entry) { return entry.first == shape; });
  if (found != ffts_.end()) {
    std::rotate(found, found + 1, ffts_.end());
  } else {
    if (ffts_.size() == kMostFfts) ffts_.erase(ffts_.begin());
    ffts_.emplace_back(shape, backend->fft(queue, shape));
  }
  return *ffts_.back().second;
}

std::shared_ptr<const Device> open_device(const DeviceInfo& info, DeviceFault fault) {
  static std::mutex lock;
  static std::map<std::string, std::weak_ptr<const Device>> open;
  const std::scoped_lock guard(lock);
  if (fault == DeviceFault::none)
    if (std::shared_ptr<const Device> known = open[info.id].lock()) return known;
  const auto backend =
      std::find_if(kBackends.begin(), kBackends.end(), [&](const auto& b) { return info.backend == b.name; });
  if (backend == kBackends.end()) throw UsageError("no backend of devices is called " + info.backend);
  auto parts = std::make_unique<Device::Parts>();
  parts->info = info;
  parts->fault = fault;
  std::shared_ptr<const Device> device;
  try {
    parts->backend = module_of(*backend).open(info.index, kKernelText);
    parts->queue = parts->backend->make_queue();
    device = std::make_shared<const Device>(std::move(parts));
    admit(device);
  } catch (const DeviceError& error) {
    throw DeviceError(info.name + " (" + info.id + ") is not admitted: " + error.what());
  }
  if (fault == DeviceFault::none) open[info.id] = device;
  return device;
}

DeviceChoice choose_device(std::string_view word, std::string& note) {
  if (word == "cpu") return {};
  const DeviceList list = devices();
  std::vector<std::string> reasons = list.notes, names;
  for (const DeviceInfo& info : list.devices) {
    names.push_back(info.id + " (" + info.name + ")");
    if (word != "auto") {
      if (word == info.id || lower_case(info.name).find(lower_case(word)) != std::string::npos)
        return {open_device(info), true};
      continue;
    }
    if (info.cpu) continue;
    try {
      return {open_device(info), false};
    } catch (const DeviceError& error) {
      reasons.push_back(error.what());
    }
  }
  if (word == "auto") {
    note = "no device beside the processor, which does the work; " + joined(reasons, "; ");
    return {};
  }
  throw UsageError("there is no device " + printable(std::string(word), 60) + "; " +
                   (names.empty() ? "none is here: " + joined(reasons, "; ") : "there are " + joined(names)));
}

}  // namespace mtf
