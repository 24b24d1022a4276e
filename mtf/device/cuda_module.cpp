// SPDX-License-Identifier: Apache-2.0

// The module of NVIDIA's devices: CUDA's driver API, kernels compiled by NVRTC.

#include <algorithm>
#include <map>
#include <utility>

#include "mtf/device/backend.h"
#include "mtf/device/vkfft.h"
#include "mtf/version.h"

namespace mtf {
namespace {

void require(CUresult code, const char* what) {
  if (code == CUDA_SUCCESS) return;
  const char* reason = nullptr;
  cuGetErrorString(code, &reason);
  const std::string text = std::string("cannot ") + what + " (CUDA error " + std::to_string(code) +
                           (reason != nullptr ? std::string(", ") + reason : "") + ")";
  if (code == CUDA_ERROR_OUT_OF_MEMORY) throw DeviceMemoryError(text);
  throw DeviceError(text);
}

std::vector<DeviceInfo> list() {
  require(cuInit(0), "start CUDA");
  int count = 0, version_number = 0;
  require(cuDeviceGetCount(&count), "count devices");
  if (count == 0) throw DeviceError("its driver knows no device");
  require(cuDriverGetVersion(&version_number), "ask for the driver's version");
  std::vector<DeviceInfo> infos;
  for (int i = 0; i < count; ++i) {
    CUdevice device = 0;
    std::array<char, 256> name{};
    std::size_t bytes = 0;
    require(cuDeviceGet(&device, i), "find a device");
    require(cuDeviceGetName(name.data(), static_cast<int>(name.size()) - 1, device), "ask a device for its name");
    require(cuDeviceTotalMem(&bytes, device), "ask a device for its memory");
    DeviceInfo info;
    info.name = name.data();
    info.vendor = "NVIDIA";
    info.driver = "CUDA " + std::to_string(version_number / 1000) + "." + std::to_string(version_number % 1000 / 10);
    info.bytes = info.largest_bytes = static_cast<std::int64_t>(bytes);
    info.doubles = true;
    info.index = i;
    infos.push_back(std::move(info));
  }
  return infos;
}

/// The machine code of a text for one device.
std::string compiled(const std::string& kernels, CUdevice device) {
  const auto check = [](nvrtcResult code) {
    if (code != NVRTC_SUCCESS)
      throw DeviceError(std::string("cannot compile kernels (") + nvrtcGetErrorString(code) + ")");
  };
  int major = 0, minor = 0;
  require(cuDeviceGetAttribute(&major, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR, device), "ask for its kind");
  require(cuDeviceGetAttribute(&minor, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR, device), "ask for its kind");
  const std::string target = "--gpu-architecture=sm_" + std::to_string(10 * major + minor);
  const std::array options{target.c_str(), "--fmad=false", "--std=c++17"};
  nvrtcProgram made = nullptr;
  check(nvrtcCreateProgram(&made, kernels.c_str(), "kernels.cl", 0, nullptr, nullptr));
  const auto destroy = [](nvrtcProgram* program) { nvrtcDestroyProgram(program); };
  const std::unique_ptr<nvrtcProgram, decltype(destroy)> program(&made, destroy);
  if (const nvrtcResult code = nvrtcCompileProgram(made, static_cast<int>(options.size()), options.data());
      code != NVRTC_SUCCESS) {
    std::size_t size = 0;
    nvrtcGetProgramLogSize(made, &size);
    std::string log(size, '\0');
    nvrtcGetProgramLog(made, log.data());
    throw DeviceError(std::string("cannot compile kernels (") + nvrtcGetErrorString(code) + "): " + log.substr(0, 400));
  }
  std::size_t size = 0;
  check(nvrtcGetCUBINSize(made, &size));
  std::string code(size, '\0');
  check(nvrtcGetCUBIN(made, code.data()));
  return code;
}

class CudaFft final : public DeviceFft {
 public:
  CudaFft(CUdevice device, CUstream stream, const FftShape& shape)
      : device_(device),
        stream_(stream),
        bytes_(vkfft_bytes(shape)),
        forward_(shape.forward),
        plan_(configured(vkfft_planes(shape))) {
    cuCtxGetCurrent(&context_);
  }
  ~CudaFft() override { cuCtxSetCurrent(context_); }  // the plan is given up in it, by whatever thread
  CudaFft(const CudaFft&) = delete;
  CudaFft& operator=(const CudaFft&) = delete;

  void run(const DeviceMemory& planes) override {
    auto* memory = reinterpret_cast<void*>(planes.handle);
    VkFFTLaunchParams launch{};
    launch.buffer = &memory;
    plan_.run(launch, forward_);
  }

 private:
  VkFFTConfiguration configured(VkFFTConfiguration plan) {
    plan.device = &device_;
    plan.stream = &stream_;
    plan.num_streams = 1;
    plan.bufferSize = &bytes_;
    return plan;
  }
  CUcontext context_ = nullptr;
  CUdevice device_;
  cudaStream_t stream_;
  std::uint64_t bytes_;
  bool forward_;
  VkFftPlan plan_;
};

/// The device's own context, which CUDA's runtime in VkFFT takes too.
class CudaContext {
 public:
  explicit CudaContext(CUdevice device) : device_(device) {
    require(cuDevicePrimaryCtxRetain(&context_, device), "open it");
  }
  ~CudaContext() { cuDevicePrimaryCtxRelease(device_); }
  CudaContext(const CudaContext&) = delete;
  CudaContext& operator=(const CudaContext&) = delete;
  /// Every thread chooses the context by itself.
  void use() const { require(enter(), "use it"); }
  CUresult enter() const { return cuCtxSetCurrent(context_); }

 private:
  CUdevice device_;
  CUcontext context_ = nullptr;
};

class CudaBackend final : public DeviceBackend {
 public:
  CudaBackend(CUdevice device, const std::string& kernels)
      : device_(device), context_(std::make_shared<const CudaContext>(device)) {
    context_->use();
    require(cuModuleLoadData(&module_, compiled(kernels, device).data()), "load kernels");
  }
  CudaBackend(const CudaBackend&) = delete;
  CudaBackend& operator=(const CudaBackend&) = delete;
  ~CudaBackend() override {
    if (context_->enter() != CUDA_SUCCESS) return;
    cuCtxSynchronize();
    for (CUevent event : events_)
      if (event != nullptr) cuEventDestroy(event);
    for (CUstream stream : streams_) cuStreamDestroy(stream);
    cuModuleUnload(module_);
  }

  Queue make_queue() override {
    context_->use();
    CUstream stream = nullptr;
    require(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), "make a queue");
    streams_.push_back(stream);
    return static_cast<Queue>(streams_.size()) - 1;
  }

  std::shared_ptr<const DeviceMemory> allocate(std::size_t bytes) override {
    context_->use();
    CUdeviceptr memory = 0;
    require(cuMemAlloc(&memory, bytes), "take memory of the device");
    return {new DeviceMemory{static_cast<std::uint64_t>(memory), bytes},
            [context = context_](const DeviceMemory* given) {
              if (context->enter() == CUDA_SUCCESS) cuMemFree(static_cast<CUdeviceptr>(given->handle));
              delete given;
            }};
  }
  std::shared_ptr<const PinnedMemory> allocate_pinned(std::size_t bytes) override {
    context_->use();
    void* memory = nullptr;
    require(cuMemAllocHost(&memory, bytes), "take memory of the host");
    return {new PinnedMemory{memory, bytes}, [context = context_](const PinnedMemory* given) {
              if (context->enter() == CUDA_SUCCESS) cuMemFreeHost(given->data);
              delete given;
            }};
  }

  void upload(Queue queue, const void* from, const DeviceMemory& to, std::size_t bytes) override {
    context_->use();
    require(cuMemcpyHtoDAsync(static_cast<CUdeviceptr>(to.handle), from, bytes, of(queue)), "upload");
  }
  void download(Queue queue, const DeviceMemory& from, void* to, std::size_t bytes) override {
    context_->use();
    require(cuMemcpyDtoHAsync(to, static_cast<CUdeviceptr>(from.handle), bytes, of(queue)), "download");
  }

  void launch(Queue queue, const std::string& name, std::array<std::int64_t, 3> threads,
              std::span<const KernelArgument> arguments) override {
    context_->use();
    CUfunction& kernel = kernels_[name];
    if (kernel == nullptr) require(cuModuleGetFunction(&kernel, module_, name.c_str()), "find a kernel");
    std::vector<void*> values;
    for (const KernelArgument& argument : arguments) values.push_back(const_cast<void*>(argument.data()));
    const bool plane = threads[1] > 1;
    const unsigned across = plane ? 32 : 256, down = plane ? 8 : 1;
    const auto groups = [](std::int64_t n, unsigned group) {
      return static_cast<unsigned>((n + static_cast<std::int64_t>(group) - 1) / static_cast<std::int64_t>(group));
    };
    require(cuLaunchKernel(kernel, groups(threads[0], across), groups(threads[1], down), groups(threads[2], 1), across,
                           down, 1, 0, of(queue), values.data(), nullptr),
            "run a kernel");
  }

  std::shared_ptr<DeviceFft> fft(Queue queue, const FftShape& shape) override {
    context_->use();
    return std::make_shared<CudaFft>(device_, of(queue), shape);
  }

  void finish(Queue queue) override {
    context_->use();
    require(cuStreamSynchronize(of(queue)), "finish");
  }

  Event mark(Queue queue) override {
    context_->use();
    CUevent event = nullptr;
    require(cuEventCreate(&event, CU_EVENT_DEFAULT), "mark a time");
    events_.push_back(event);
    require(cuEventRecord(event, of(queue)), "mark a time");
    return static_cast<Event>(events_.size()) - 1;
  }
  double ms_between(Event from, Event to) override {
    context_->use();
    CUevent &start = events_.at(static_cast<std::size_t>(from)), &end = events_.at(static_cast<std::size_t>(to));
    float ms = 0.0F;
    require(cuEventElapsedTime(&ms, start, end), "read a time");
    for (CUevent* event : {&start, &end}) cuEventDestroy(std::exchange(*event, nullptr));
    if (std::all_of(events_.begin(), events_.end(), [](CUevent event) { return event == nullptr; })) events_.clear();
    return static_cast<double>(ms);
  }

 private:
  CUstream of(Queue queue) const { return streams_.at(static_cast<std::size_t>(queue)); }

  CUdevice device_;
  std::shared_ptr<const CudaContext> context_;
  CUmodule module_ = nullptr;
  std::map<std::string, CUfunction> kernels_;
  std::vector<CUstream> streams_;
  std::vector<CUevent> events_;
};

std::unique_ptr<DeviceBackend> open(int index, const std::string& kernels) {
  require(cuInit(0), "start CUDA");
  CUdevice device = 0;
  require(cuDeviceGet(&device, index), "find it");
  return std::make_unique<CudaBackend>(device, kernels);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const void* mtfkit_cuda_table() {
  static const DeviceModule table{{version, git_commit}, list, open};
  return &table;
}

}  // namespace mtf
