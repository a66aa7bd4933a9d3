#include "hal/linux/libcamera/libcamera_stream.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <thread>
#include <utility>

#include <sys/sysmacros.h>
#include <unistd.h>

#include "hal/linux/system/heap_watch.h"

namespace stof::hal::linux {
namespace {

using libcamera::StreamRole;

struct Format {
  const char* name;
  StreamRole role;
  int shift;  // as LibcameraPixels::Layout
};
// Grey bytes first, then their plane, then what has to be made bytes.
constexpr std::array kFormats{
    Format{"R8", StreamRole::Viewfinder, -1},
    Format{"R8", StreamRole::Raw, -1},
    Format{"YUV420", StreamRole::Viewfinder, -1},
    Format{"NV12", StreamRole::Viewfinder, -1},
    Format{"R10", StreamRole::Raw, 2},
    Format{"R12", StreamRole::Raw, 4},
    Format{"R16", StreamRole::Raw, 8},
};
constexpr int kLeastBuffers = 4;

Duration clock_now(clockid_t clock) noexcept {
  timespec now{};
  clock_gettime(clock, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

std::int64_t microseconds(Duration time) noexcept {
  return std::chrono::duration_cast<std::chrono::microseconds>(time).count();
}

// What the camera has of that which is asked for. Some pipelines take controls with the start,
// others with a request.
void set_controls(const libcamera::ControlInfoMap& known, const LibcameraOptions& options,
                  libcamera::ControlList& list) {
  namespace controls = libcamera::controls;
  // By pointer: by number every control of libcamera counts, at some cameras.
  const auto has = [&known](const libcamera::ControlId& id) { return known.count(&id) != 0; };
  if (has(controls::AeEnable) && (options.exposure > Duration{0} || options.gain > 0)) {
    list.set(controls::AeEnable, false);
  }
  if (has(controls::ExposureTime) && options.exposure > Duration{0}) {
    list.set(controls::ExposureTime, static_cast<std::int32_t>(microseconds(options.exposure)));
  }
  if (has(controls::AnalogueGain) && options.gain > 0) {
    list.set(controls::AnalogueGain, options.gain);
  }
  if (has(controls::FrameDurationLimits) && options.period > Duration{0}) {
    const std::array<std::int64_t, 2> limits{microseconds(options.period),
                                             microseconds(options.period)};
    list.set(controls::FrameDurationLimits, libcamera::Span<const std::int64_t, 2>(limits));
  }
}

OpenError refusal(const libcamera::Camera& camera, const std::string& what) {
  return {"cannot use camera '" + camera.id() + "' of libcamera: " + what};
}

}  // namespace

std::optional<OpenError> LibcameraStream::open(std::shared_ptr<libcamera::Camera> camera,
                                               const LibcameraOptions& options) {
  close();
  lost_ = false;
  if (camera->acquire() != 0) {
    return refusal(*camera, "another program has it: end that first");
  }
  camera_ = std::move(camera);
  std::optional<OpenError> error = configure(options);
  if (!error) {
    error = make_requests(options);
  }
  if (!error) {
    error = start(options);
  }
  if (error) {
    close();
  }
  return error;
}

std::optional<OpenError> LibcameraStream::configure(const LibcameraOptions& options) {
  const libcamera::Size size(static_cast<unsigned>(options.width),
                             static_cast<unsigned>(options.height));
  for (const Format& format : kFormats) {
    if (!options.format.empty() && options.format != format.name) {
      continue;
    }
    configuration_ = camera_->generateConfiguration({format.role});
    if (configuration_ == nullptr || configuration_->empty()) {
      continue;
    }
    libcamera::StreamConfiguration& stream = configuration_->at(0);
    const libcamera::PixelFormat wanted = libcamera::PixelFormat::fromString(format.name);
    stream.pixelFormat = wanted;
    stream.size = size;
    stream.bufferCount = static_cast<unsigned>(options.buffers);
    if (configuration_->validate() == libcamera::CameraConfiguration::Invalid ||
        stream.pixelFormat != wanted || stream.size != size) {
      continue;
    }
    if (camera_->configure(configuration_.get()) != 0) {
      return refusal(*camera_, "it does not take " + stream.toString() + "; unplug and plug it");
    }
    layout_ = {.width = options.width,
               .height = options.height,
               .stride = stream.stride,
               .shift = format.shift};
    return std::nullopt;
  }
  return refusal(*camera_, "it has no " + size.toString() + " in " +
                               (options.format.empty() ? "a grey format" : options.format) +
                               "; see `cam -I` for what it has");
}

std::optional<OpenError> LibcameraStream::make_requests(const LibcameraOptions& options) {
  libcamera::Stream* const stream = configuration_->at(0).stream();
  allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
  const int got = allocator_->allocate(stream);
  if (got < kLeastBuffers) {
    return refusal(*camera_, "it gives fewer than 4 buffers; give more memory to cma=");
  }
  pixels_ = std::make_shared<LibcameraPixels>(layout_);
  const int count = std::min(got, LibcameraBufferQueue::kMostSlots);
  for (int slot = 0; slot < count; ++slot) {
    libcamera::FrameBuffer& buffer = *allocator_->buffers(stream)[static_cast<std::size_t>(slot)];
    std::unique_ptr<libcamera::Request> request =
        camera_->createRequest(static_cast<std::uint64_t>(slot));
    if (request == nullptr || request->addBuffer(stream, &buffer) != 0 || !pixels_->add(buffer)) {
      return refusal(*camera_, "its buffers cannot be mapped; use another kernel");
    }
    set_controls(camera_->controls(), options, request->controls());
    requests_.push_back(std::move(request));
  }
  // Two buffers keep any pipeline busy; of only four one has to do, or two that are lent would
  // starve it.
  queue_.reset(count, count > kLeastBuffers ? 2 : 1);
  return std::nullopt;
}

std::optional<OpenError> LibcameraStream::start(const LibcameraOptions& options) {
  nodes_.clear();
  const std::optional<libcamera::Span<const std::int64_t>> devices =
      camera_->properties().get(libcamera::properties::SystemDevices);
  if (devices) {
    for (const std::int64_t device : *devices) {
      const dev_t number = static_cast<dev_t>(device);
      nodes_.push_back("/sys/dev/char/" + std::to_string(major(number)) + ":" +
                       std::to_string(minor(number)));
    }
  }
  libcamera::ControlList list(camera_->controls());
  set_controls(camera_->controls(), options, list);
  camera_->requestCompleted.connect(this, &LibcameraStream::on_completed);
  camera_->disconnected.connect(this, &LibcameraStream::on_disconnected);
  running_ = true;
  if (camera_->start(&list) != 0) {
    return refusal(*camera_, "it does not start; use a port with more bandwidth or another size");
  }
  for (const std::unique_ptr<libcamera::Request>& request : requests_) {
    if (camera_->queueRequest(request.get()) != 0) {
      return refusal(*camera_, "it takes no buffers; unplug and plug it");
    }
  }
  return std::nullopt;
}

void LibcameraStream::close() noexcept {
  if (camera_ == nullptr) {
    return;
  }
  running_ = false;
  if (node_gone()) {
    // stop() aborts where buffers do not come back, and a driver without a device keeps them. What
    // the loop's thread has sent has to arrive while there are requests.
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  } else {
    camera_->stop();
  }
  camera_->requestCompleted.disconnect(this);
  camera_->disconnected.disconnect(this);
  requests_.clear();
  allocator_.reset();
  configuration_.reset();
  camera_->release();
  camera_.reset();
}

bool LibcameraStream::node_gone() const noexcept {
  return std::ranges::any_of(
      nodes_, [](const std::string& node) { return access(node.c_str(), F_OK) != 0; });
}

void LibcameraStream::mark_lost() noexcept {
  lost_.store(true, std::memory_order_release);
  wake_.wake();
}

void LibcameraStream::on_disconnected() noexcept { mark_lost(); }

// On libcamera's thread.
void LibcameraStream::on_completed(libcamera::Request* request) noexcept {
  if (!running_.load(std::memory_order_acquire)) {
    return;
  }
  if (request->status() == libcamera::Request::RequestCancelled) {
    mark_lost();
    return;
  }
  const libcamera::FrameMetadata& frame = request->buffers().begin()->second->metadata();
  const std::optional<std::int64_t> sensor =
      request->metadata().get(libcamera::controls::SensorTimestamp);
  const Duration stamp(sensor ? *sensor : static_cast<std::int64_t>(frame.timestamp));
  const std::size_t needed = layout_.stride * static_cast<std::size_t>(layout_.height - 1) +
                             static_cast<std::size_t>(layout_.width);
  const bool whole = frame.planes().empty() || frame.planes()[0].bytesused >= needed;
  const LibcameraArrival arrival{
      .stamp = from_libcamera(stamp, clock_now(CLOCK_MONOTONIC), clock_now(CLOCK_BOOTTIME)),
      .sequence = frame.sequence,
      .damaged = frame.status != libcamera::FrameMetadata::FrameSuccess || !whole};
  const std::optional<int> back = queue_.deliver(static_cast<int>(request->cookie()), arrival);
  if (back) {
    requeue(*back);
  }
  wake_.wake();
}

void LibcameraStream::requeue(int slot) noexcept {
  if (!running_.load(std::memory_order_acquire) || lost()) {
    return;
  }
  pixels_->end_reading(slot);
  libcamera::Request* const request = requests_[static_cast<std::size_t>(slot)].get();
  const MarkedHeap marked;
  request->reuse(libcamera::Request::ReuseBuffers);
  if (camera_->queueRequest(request) != 0) {
    mark_lost();
  }
}

}  // namespace stof::hal::linux
