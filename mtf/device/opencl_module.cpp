// SPDX-License-Identifier: Apache-2.0

// The module of devices by OpenCL 1.2. Its loader (ocl-icd) finds drivers by the files in /etc/OpenCL/vendors, or in
// the folder that OCL_ICD_VENDORS names.

#define CL_TARGET_OPENCL_VERSION 120
#include <dlfcn.h>

#include <algorithm>
#include <map>
#include <utility>

#include "mtf/device/backend.h"
#include "mtf/device/vkfft.h"
#include "mtf/version.h"

namespace mtf {
namespace {

bool is_memory(cl_int code) {
  return code == CL_MEM_OBJECT_ALLOCATION_FAILURE || code == CL_OUT_OF_HOST_MEMORY || code == CL_INVALID_BUFFER_SIZE;
}

std::string reason_of(cl_int code) {
  std::string reason;
  if (is_memory(code)) reason = "no memory left, ";
  if (code == CL_OUT_OF_RESOURCES) reason = "out of resources, ";
  if (code == CL_DEVICE_NOT_AVAILABLE) reason = "the device is not available, ";
  return reason + "OpenCL error " + std::to_string(code);
}

void require(cl_int code, const char* what) {
  if (code == CL_SUCCESS) return;
  const std::string text = std::string("cannot ") + what + " (" + reason_of(code) + ")";
  if (is_memory(code)) throw DeviceMemoryError(text);
  throw DeviceError(text);
}

template <class Query>
std::string text_of(const Query& query) {
  std::size_t bytes = 0;
  if (query(0, nullptr, &bytes) != CL_SUCCESS || bytes == 0) return "";
  std::string text(bytes, '\0');
  if (query(bytes, text.data(), nullptr) != CL_SUCCESS) return "";
  return text.substr(0, text.find('\0'));
}

std::string device_text(cl_device_id device, cl_device_info what) {
  return text_of([&](auto... to) { return clGetDeviceInfo(device, what, to...); });
}

template <class T>
T device_value(cl_device_id device, cl_device_info what) {
  T value{};
  require(clGetDeviceInfo(device, what, sizeof value, &value, nullptr), "ask a device for its properties");
  return value;
}

// In a fixed order: by platform.
std::vector<cl_device_id> all_devices() {
  cl_uint count = 0;
  const cl_int code = clGetPlatformIDs(0, nullptr, &count);
  if (code != CL_SUCCESS || count == 0) {
    const bool nvidia = ::dlopen("libnvidia-opencl.so.1", RTLD_LAZY | RTLD_LOCAL) != nullptr;
    throw DeviceError(
        std::string("no driver: no file NAME.icd in /etc/OpenCL/vendors, or in the folder that OCL_ICD_VENDORS names, "
                    "holds the name of a library that can be loaded") +
        (nvidia ? "; libnvidia-opencl.so.1 is here: write that name to such a file" : ""));
  }
  std::vector<cl_platform_id> platforms(count);
  require(clGetPlatformIDs(count, platforms.data(), nullptr), "list platforms");
  std::vector<cl_device_id> devices;
  for (const cl_platform_id platform : platforms) {
    cl_uint more = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &more) != CL_SUCCESS || more == 0) continue;
    devices.resize(devices.size() + more);
    require(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, more, &*devices.end() - more, nullptr), "list devices");
  }
  if (devices.empty()) throw DeviceError("its drivers know no device");
  return devices;
}

std::vector<DeviceInfo> list() {
  std::vector<DeviceInfo> infos;
  for (const cl_device_id device : all_devices()) {
    DeviceInfo info;
    info.name = device_text(device, CL_DEVICE_NAME);
    info.vendor = device_text(device, CL_DEVICE_VENDOR);
    info.driver = device_text(device, CL_DRIVER_VERSION);
    info.bytes = static_cast<std::int64_t>(device_value<cl_ulong>(device, CL_DEVICE_GLOBAL_MEM_SIZE));
    info.largest_bytes = static_cast<std::int64_t>(device_value<cl_ulong>(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE));
    info.cpu = (device_value<cl_device_type>(device, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_CPU) != 0;
    cl_device_fp_config doubles = 0;  // which drivers before OpenCL 1.2 do not know
    clGetDeviceInfo(device, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof doubles, &doubles, nullptr);
    info.doubles = doubles != 0;
    info.index = static_cast<int>(infos.size());
    infos.push_back(std::move(info));
  }
  return infos;
}

class OpenClFft final : public DeviceFft {
 public:
  OpenClFft(cl_context context, cl_device_id device, cl_command_queue queue, const FftShape& shape)
      : context_(context),
        device_(device),
        queue_(queue),
        bytes_(vkfft_bytes(shape)),
        forward_(shape.forward),
        plan_(configured(vkfft_planes(shape))) {}

  void run(const DeviceMemory& planes) override {
    auto memory = reinterpret_cast<cl_mem>(planes.handle);
    VkFFTLaunchParams launch{};
    launch.commandQueue = &queue_;
    launch.buffer = &memory;
    plan_.run(launch, forward_);
  }

 private:
  VkFFTConfiguration configured(VkFFTConfiguration plan) {
    plan.device = &device_;
    plan.context = &context_;
    plan.bufferSize = &bytes_;
    return plan;
  }

  cl_context context_;
  cl_device_id device_;
  cl_command_queue queue_;
  std::uint64_t bytes_;
  bool forward_;
  VkFftPlan plan_;
};

/// What is released when the last owner is gone.
using Context = std::shared_ptr<std::remove_pointer_t<cl_context>>;
using Program = std::shared_ptr<std::remove_pointer_t<cl_program>>;
using Kernel = std::shared_ptr<std::remove_pointer_t<cl_kernel>>;
using CommandQueue = std::shared_ptr<std::remove_pointer_t<cl_command_queue>>;

class OpenClBackend final : public DeviceBackend {
 public:
  OpenClBackend(cl_device_id device, const std::string& kernels) : device_(device) {
    cl_int code = 0;
    context_ = Context(clCreateContext(nullptr, 1, &device_, nullptr, nullptr, &code), clReleaseContext);
    require(code, "open it");
    const char* text = kernels.c_str();
    program_ = Program(clCreateProgramWithSource(context_.get(), 1, &text, nullptr, &code), clReleaseProgram);
    require(code, "take kernels");
    code = clBuildProgram(program_.get(), 1, &device_, "-cl-std=CL1.2", nullptr, nullptr);
    if (code != CL_SUCCESS) {
      const std::string log = text_of(
          [&](auto... to) { return clGetProgramBuildInfo(program_.get(), device_, CL_PROGRAM_BUILD_LOG, to...); });
      throw DeviceError("cannot compile kernels (" + reason_of(code) + "): " + log.substr(0, 400));
    }
  }
  OpenClBackend(const OpenClBackend&) = delete;
  OpenClBackend& operator=(const OpenClBackend&) = delete;
  ~OpenClBackend() override {
    for (const CommandQueue& queue : queues_) clFinish(queue.get());
    for (const cl_event event : events_)
      if (event != nullptr) clReleaseEvent(event);
  }

  Queue make_queue() override {
    cl_int code = 0;
    queues_.emplace_back(clCreateCommandQueue(context_.get(), device_, CL_QUEUE_PROFILING_ENABLE, &code),
                         [](cl_command_queue queue) {
                           if (queue != nullptr) clReleaseCommandQueue(queue);
                         });
    require(code, "make a queue");
    return static_cast<Queue>(queues_.size()) - 1;
  }

  std::shared_ptr<const DeviceMemory> allocate(std::size_t bytes) override {
    const cl_mem memory = buffer(bytes, CL_MEM_READ_WRITE);
    return {new DeviceMemory{reinterpret_cast<std::uint64_t>(memory), bytes}, [memory](const DeviceMemory* given) {
              clReleaseMemObject(memory);
              delete given;
            }};
  }

  std::shared_ptr<const PinnedMemory> allocate_pinned(std::size_t bytes) override {
    if (queues_.empty()) make_queue();
    const cl_mem memory = buffer(bytes, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR);
    const CommandQueue queue = queues_.front();
    cl_int code = 0;
    void* const data = clEnqueueMapBuffer(queue.get(), memory, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, bytes, 0,
                                          nullptr, nullptr, &code);
    if (code != CL_SUCCESS) clReleaseMemObject(memory);
    require(code, "take memory of the host");
    return {new PinnedMemory{data, bytes}, [memory, queue](const PinnedMemory* given) {
              clEnqueueUnmapMemObject(queue.get(), memory, given->data, 0, nullptr, nullptr);
              clFinish(queue.get());
              clReleaseMemObject(memory);
              delete given;
            }};
  }

  void upload(Queue queue, const void* from, const DeviceMemory& to, std::size_t bytes) override {
    require(clEnqueueWriteBuffer(of(queue), reinterpret_cast<cl_mem>(to.handle), CL_FALSE, 0, bytes, from, 0, nullptr,
                                 nullptr),
            "upload");
  }
  void download(Queue queue, const DeviceMemory& from, void* to, std::size_t bytes) override {
    require(clEnqueueReadBuffer(of(queue), reinterpret_cast<cl_mem>(from.handle), CL_FALSE, 0, bytes, to, 0, nullptr,
                                nullptr),
            "download");
  }

  void launch(Queue queue, const std::string& name, std::array<std::int64_t, 3> threads,
              std::span<const KernelArgument> arguments) override {
    Kernel& kernel = kernels_[name];
    if (!kernel) {
      cl_int code = 0;
      kernel = Kernel(clCreateKernel(program_.get(), name.c_str(), &code), [](cl_kernel made) {
        if (made != nullptr) clReleaseKernel(made);
      });
      require(code, "find a kernel");
    }
    for (cl_uint i = 0; i < arguments.size(); ++i)
      require(clSetKernelArg(kernel.get(), i, arguments[i].bytes(), arguments[i].data()),
              "give a kernel its arguments");
    const std::array<std::size_t, 3> group =
        threads[1] > 1 ? std::array<std::size_t, 3>{32, 8, 1} : std::array<std::size_t, 3>{256, 1, 1};
    std::array<std::size_t, 3> grid{};
    for (std::size_t d = 0; d < 3; ++d)
      grid[d] = (static_cast<std::size_t>(threads[d]) + group[d] - 1) / group[d] * group[d];
    require(clEnqueueNDRangeKernel(of(queue), kernel.get(), 3, nullptr, grid.data(), group.data(), 0, nullptr, nullptr),
            "run a kernel");
  }

  std::shared_ptr<DeviceFft> fft(Queue queue, const FftShape& shape) override {
    return std::make_shared<OpenClFft>(context_.get(), device_, of(queue), shape);
  }

  void finish(Queue queue) override { require(clFinish(of(queue)), "finish"); }

  Event mark(Queue queue) override {
    cl_event event = nullptr;
    require(clEnqueueMarkerWithWaitList(of(queue), 0, nullptr, &event), "mark a time");
    events_.push_back(event);
    return static_cast<Event>(events_.size()) - 1;
  }
  double ms_between(Event from, Event to) override {
    const auto end_of = [&](Event number) {
      cl_event& event = events_.at(static_cast<std::size_t>(number));
      cl_ulong ns = 0;
      require(clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof ns, &ns, nullptr), "read a time");
      clReleaseEvent(std::exchange(event, nullptr));
      return static_cast<double>(ns);
    };
    const double start = end_of(from), ms = 1e-6 * (end_of(to) - start);
    if (std::all_of(events_.begin(), events_.end(), [](cl_event event) { return event == nullptr; })) events_.clear();
    return ms;
  }

 private:
  cl_mem buffer(std::size_t bytes, cl_mem_flags flags) {
    cl_int code = 0;
    const cl_mem memory = clCreateBuffer(context_.get(), flags, bytes, nullptr, &code);
    require(code, "take memory of the device");
    return memory;
  }
  cl_command_queue of(Queue queue) const { return queues_.at(static_cast<std::size_t>(queue)).get(); }

  cl_device_id device_;
  Context context_;
  Program program_;
  std::map<std::string, Kernel> kernels_;
  std::vector<CommandQueue> queues_;
  std::vector<cl_event> events_;
};

std::unique_ptr<DeviceBackend> open(int index, const std::string& kernels) {
  const std::vector<cl_device_id> devices = all_devices();
  if (index < 0 || static_cast<std::size_t>(index) >= devices.size()) throw DeviceError("it is gone");
  return std::make_unique<OpenClBackend>(devices[static_cast<std::size_t>(index)], kernels);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const void* mtfkit_opencl_table() {
  static const DeviceModule table{{version, git_commit}, list, open};
  return &table;
}

}  // namespace mtf
