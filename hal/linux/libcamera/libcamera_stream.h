#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <libcamera/libcamera.h>

#include "hal/linux/libcamera/libcamera_buffer_queue.h"
#include "hal/linux/libcamera/libcamera_pixels.h"
#include "hal/linux/libcamera/libcamera_stereo.h"
#include "posix/wake_event.h"

namespace stof::hal::linux {

// One camera of libcamera that streams into a queue.
class LibcameraStream {
 public:
  LibcameraStream(const posix::WakeEvent& wake, LibcameraBufferQueue& queue) noexcept
      : wake_(wake), queue_(queue) {}
  ~LibcameraStream() { close(); }
  LibcameraStream(const LibcameraStream&) = delete;
  LibcameraStream& operator=(const LibcameraStream&) = delete;

  // None: it streams.
  std::optional<OpenError> open(std::shared_ptr<libcamera::Camera> camera,
                                const LibcameraOptions& options);
  // Stops; pixels are still readable.
  void close() noexcept;

  // Gone for good, or its node is.
  bool lost() const noexcept { return lost_.load(std::memory_order_acquire); }
  bool node_gone() const noexcept;
  // Allocates within libcamera, as this is how libcamera takes buffers: Request::reuse and
  // Camera::queueRequest.
  void requeue(int slot) noexcept;
  // Outlives close() and the camera.
  const std::shared_ptr<LibcameraPixels>& pixels() const noexcept { return pixels_; }

 private:
  std::optional<OpenError> configure(const LibcameraOptions& options);
  std::optional<OpenError> make_requests(const LibcameraOptions& options);
  std::optional<OpenError> start(const LibcameraOptions& options);
  void on_completed(libcamera::Request* request) noexcept;
  void on_disconnected() noexcept;
  void mark_lost() noexcept;

  const posix::WakeEvent& wake_;
  LibcameraBufferQueue& queue_;
  std::shared_ptr<libcamera::Camera> camera_;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::vector<std::unique_ptr<libcamera::Request>> requests_;  // by slot, which is the cookie
  std::shared_ptr<LibcameraPixels> pixels_;
  std::vector<std::string> nodes_;  // in sysfs
  LibcameraPixels::Layout layout_;
  std::atomic<bool> running_{false};
  std::atomic<bool> lost_{false};
};

}  // namespace stof::hal::linux
