#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <libcamera/libcamera.h>

#include "dsp/base/image.h"
#include "hal/linux/libcamera/libcamera_mailbox.h"
#include "hal/linux/libcamera/libcamera_stereo.h"

namespace stof::hal::linux {

// Wakes the loop from libcamera's thread (eventfd).
class LibcameraBell {
 public:
  LibcameraBell() noexcept;
  ~LibcameraBell();
  LibcameraBell(const LibcameraBell&) = delete;
  LibcameraBell& operator=(const LibcameraBell&) = delete;

  bool works() const noexcept { return fd_ >= 0; }
  void ring() const noexcept;
  // Until it was rung since the last time, or the deadline: false.
  bool wait(Time deadline) const noexcept;

 private:
  int fd_;
};

// The pixels of one camera's buffers, readable for as long as this lives, whatever becomes of the
// camera: a mapping keeps its dmabuf.
class LibcameraPixels {
 public:
  struct Layout {
    int width = 0;
    int height = 0;
    std::size_t stride = 0;  // bytes
    int shift = -1;          // 16-bit pixels lose so many bits; -1: they are bytes
  };

  explicit LibcameraPixels(const Layout& layout) noexcept : layout_(layout) {}
  ~LibcameraPixels();
  LibcameraPixels(const LibcameraPixels&) = delete;
  LibcameraPixels& operator=(const LibcameraPixels&) = delete;

  // False: it cannot be mapped.
  bool add(const libcamera::FrameBuffer& buffer);
  // Fetches what the camera wrote (cache, 16 to 8 bits).
  dsp::ImageView<const std::uint8_t> read(int slot) noexcept;
  // Of a slot that goes to the camera, whether it was read or not.
  void end_reading(int slot) noexcept;

 private:
  struct Buffer {
    int fd = -1;  // a duplicate: libcamera may close its own
    void* map = nullptr;
    std::size_t bytes = 0;
    std::size_t offset = 0;
    bool reading = false;
    std::vector<std::uint8_t> grey;
  };

  Layout layout_;
  std::vector<Buffer> buffers_;
};

// One camera of libcamera that streams into a mailbox.
class LibcameraEye {
 public:
  LibcameraEye(const LibcameraBell& bell, LibcameraMailbox& mailbox) noexcept
      : bell_(bell), mailbox_(mailbox) {}
  ~LibcameraEye() { close(); }
  LibcameraEye(const LibcameraEye&) = delete;
  LibcameraEye& operator=(const LibcameraEye&) = delete;

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

  const LibcameraBell& bell_;
  LibcameraMailbox& mailbox_;
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
