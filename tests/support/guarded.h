#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <type_traits>

#include <sys/mman.h>
#include <unistd.h>

#include "dsp/base/image.h"

// Memory whose last byte is followed by an unreadable page: one element too far faults.
namespace stof::test {

template <typename T>
class GuardedBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit GuardedBuffer(std::size_t count, T fill = T{}) : count_(count) {
    const std::size_t page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t bytes = count * sizeof(T);
    const std::size_t readable = (bytes + page - 1) / page * page;
    mapped_ = readable + page;
    void* const memory =
        mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) {
      std::abort();
    }
    base_ = static_cast<std::byte*>(memory);
    if (mprotect(base_ + readable, page, PROT_NONE) != 0) {
      std::abort();
    }
    data_ = reinterpret_cast<T*>(base_ + readable - bytes);
    for (std::size_t i = 0; i < count; ++i) {
      data_[i] = fill;
    }
  }
  GuardedBuffer(GuardedBuffer&& other) noexcept
      : base_(other.base_), mapped_(other.mapped_), data_(other.data_), count_(other.count_) {
    other.base_ = nullptr;
  }
  GuardedBuffer(const GuardedBuffer&) = delete;
  GuardedBuffer& operator=(const GuardedBuffer&) = delete;
  GuardedBuffer& operator=(GuardedBuffer&&) = delete;
  ~GuardedBuffer() {
    if (base_ != nullptr) {
      munmap(base_, mapped_);
    }
  }

  std::span<T> span() noexcept { return {data_, count_}; }
  std::span<const T> span() const noexcept { return {data_, count_}; }
  T& operator[](std::size_t i) noexcept { return data_[i]; }
  std::size_t size() const noexcept { return count_; }

 private:
  std::byte* base_ = nullptr;
  std::size_t mapped_ = 0;
  T* data_ = nullptr;
  std::size_t count_ = 0;
};

// An image whose last row ends at an unreadable page; the gap between rows (stride - width) holds
// `fill`, so a kernel that writes there is found by padding_is().
template <typename T>
class GuardedImage {
 public:
  GuardedImage(int width, int height, int stride, T fill = T{})
      : buffer_(elements(width, height, stride), fill),
        width_(width),
        height_(height),
        stride_(stride) {}

  dsp::ImageView<T> view() noexcept { return {buffer_.span().data(), width_, height_, stride_}; }

  bool padding_is(T fill) {
    for (int y = 0; y + 1 < height_; ++y) {
      for (int x = width_; x < stride_; ++x) {
        if (buffer_[static_cast<std::size_t>(y) * static_cast<std::size_t>(stride_) +
                    static_cast<std::size_t>(x)] != fill) {
          return false;
        }
      }
    }
    return true;
  }

 private:
  static std::size_t elements(int width, int height, int stride) {
    return height == 0 ? 0
                       : static_cast<std::size_t>(height - 1) * static_cast<std::size_t>(stride) +
                             static_cast<std::size_t>(width);
  }

  GuardedBuffer<T> buffer_;
  int width_;
  int height_;
  int stride_;
};

}  // namespace stof::test
