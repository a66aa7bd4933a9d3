#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <libcamera/libcamera.h>

#include "dsp/base/image.h"

namespace stof::hal::linux {

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
  // slot: it goes to the camera, whether it was read or not.
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

}  // namespace stof::hal::linux
