#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <mutex>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

#include "dsp/base/image.h"

// Memory whose last byte is followed by an unreadable page: one element too far faults.
namespace stof::test {

// Whole pages with an unreadable one behind them. The system takes long to make and to end them,
// above all under emulation, and comparisons of kernels want millions: they are used again.
class GuardedPages {
 public:
  explicit GuardedPages(std::size_t bytes) {
    const std::size_t page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    readable_ = (bytes + page - 1) / page * page;
    base_ = take_unused();
    if (base_ != nullptr) {
      return;
    }
    void* const memory =
        mmap(nullptr, readable_ + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) {
      std::abort();
    }
    base_ = static_cast<std::byte*>(memory);
    if (mprotect(base_ + readable_, page, PROT_NONE) != 0) {
      std::abort();
    }
  }
  GuardedPages(GuardedPages&& other) noexcept
      : base_(std::exchange(other.base_, nullptr)), readable_(other.readable_) {}
  GuardedPages(const GuardedPages&) = delete;
  GuardedPages& operator=(const GuardedPages&) = delete;
  GuardedPages& operator=(GuardedPages&&) = delete;
  ~GuardedPages() {
    if (base_ != nullptr) {
      const std::scoped_lock lock(unused().mutex);
      unused().pages[readable_].push_back(base_);
    }
  }

  std::byte* end() const noexcept { return base_ + readable_; }

 private:
  // By their size. They outlive everything that gives pages back.
  struct Unused {
    std::mutex mutex;
    std::map<std::size_t, std::vector<std::byte*>> pages;
  };
  static Unused& unused() {
    static Unused& all = *new Unused;
    return all;
  }
  std::byte* take_unused() const {
    const std::scoped_lock lock(unused().mutex);
    std::vector<std::byte*>& pages = unused().pages[readable_];
    if (pages.empty()) {
      return nullptr;
    }
    std::byte* const taken = pages.back();
    pages.pop_back();
    return taken;
  }

  std::byte* base_ = nullptr;
  std::size_t readable_ = 0;
};

template <typename T>
class GuardedBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit GuardedBuffer(std::size_t count, T fill = T{})
      : pages_(count * sizeof(T)),
        data_(reinterpret_cast<T*>(pages_.end() - count * sizeof(T))),
        count_(count) {
    std::ranges::fill(span(), fill);
  }

  std::span<T> span() noexcept { return {data_, count_}; }
  std::span<const T> span() const noexcept { return {data_, count_}; }
  T& operator[](std::size_t i) noexcept { return data_[i]; }
  std::size_t size() const noexcept { return count_; }

 private:
  GuardedPages pages_;
  T* data_;
  std::size_t count_;
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
