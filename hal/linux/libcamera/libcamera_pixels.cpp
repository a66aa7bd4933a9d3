#include "hal/linux/libcamera/libcamera_pixels.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <linux/dma-buf.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace stof::hal::linux {

LibcameraPixels::~LibcameraPixels() {
  for (const Buffer& buffer : buffers_) {
    munmap(buffer.map, buffer.bytes);
    ::close(buffer.fd);
  }
}

bool LibcameraPixels::add(const libcamera::FrameBuffer& buffer) {
  // The grey values are the first plane of every format that is asked for.
  const libcamera::FrameBuffer::Plane& plane = buffer.planes().front();
  const std::size_t offset =
      plane.offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;
  const std::size_t bytes = offset + plane.length;
  if (plane.length < layout_.stride * static_cast<std::size_t>(layout_.height)) {
    return false;
  }
  const int fd = fcntl(plane.fd.get(), F_DUPFD_CLOEXEC, 0);
  if (fd < 0) {
    return false;
  }
  void* const map = mmap(nullptr, bytes, PROT_READ, MAP_SHARED, fd, 0);
  if (map == MAP_FAILED) {
    ::close(fd);
    return false;
  }
  buffers_.push_back(
      {.fd = fd, .map = map, .bytes = bytes, .offset = offset, .reading = false, .grey = {}});
  if (layout_.shift >= 0) {
    buffers_.back().grey.resize(static_cast<std::size_t>(layout_.width) *
                                static_cast<std::size_t>(layout_.height));
  }
  return true;
}

// Buffers that libcamera hands from driver to driver are not made coherent by the drivers; those
// of drivers that need nothing answer with an error or do nothing.
dsp::ImageView<const std::uint8_t> LibcameraPixels::read(int slot) noexcept {
  Buffer& buffer = buffers_[static_cast<std::size_t>(slot)];
  buffer.reading = true;
  const dma_buf_sync begin{.flags = DMA_BUF_SYNC_START | DMA_BUF_SYNC_READ};
  static_cast<void>(ioctl(buffer.fd, DMA_BUF_IOCTL_SYNC, &begin));
  const std::uint8_t* const bytes = static_cast<const std::uint8_t*>(buffer.map) + buffer.offset;
  if (layout_.shift < 0) {
    return {bytes, layout_.width, layout_.height, static_cast<std::ptrdiff_t>(layout_.stride)};
  }
  const std::size_t width = static_cast<std::size_t>(layout_.width);
  for (int y = 0; y < layout_.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(y);
    const std::uint8_t* const from = bytes + row * layout_.stride;
    std::uint8_t* const to = buffer.grey.data() + row * width;
    for (std::size_t x = 0; x < width; ++x) {
      // Little endian, as V4L2's Y10, Y12 and Y16 are.
      const unsigned value = from[2 * x] + (unsigned{from[2 * x + 1]} << 8);
      to[x] = static_cast<std::uint8_t>(std::min(value >> layout_.shift, 255U));
    }
  }
  return {buffer.grey.data(), layout_.width, layout_.height};
}

void LibcameraPixels::end_reading(int slot) noexcept {
  Buffer& buffer = buffers_[static_cast<std::size_t>(slot)];
  if (buffer.reading) {
    buffer.reading = false;
    const dma_buf_sync end{.flags = DMA_BUF_SYNC_END | DMA_BUF_SYNC_READ};
    static_cast<void>(ioctl(buffer.fd, DMA_BUF_IOCTL_SYNC, &end));
  }
}

}  // namespace stof::hal::linux
