#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "dsp/base/check.h"

namespace stof::dsp {

// Half-open range of image rows [begin, end): how threads and tests split a kernel call.
struct Rows {
  int begin = 0;
  int end = 0;
  constexpr int count() const noexcept { return end - begin; }
};

// A borrowed image: width x height elements of T, `stride` elements from one row to the next
// (stride >= width). Copies refer to the same pixels. An empty image has width or height 0.
template <typename T>
class ImageView {
 public:
  constexpr ImageView() noexcept = default;
  constexpr ImageView(T* data, int width, int height, std::ptrdiff_t stride) noexcept
      : data_(data), width_(width), height_(height), stride_(stride) {
    STOF_CHECK(width >= 0 && height >= 0 && stride >= width);
  }
  constexpr ImageView(T* data, int width, int height) noexcept
      : ImageView(data, width, height, width) {}
  // A mutable view is also a read-only one.
  template <typename U>
    requires(std::is_same_v<const U, T>)
  constexpr ImageView(ImageView<U> other) noexcept  // NOLINT(google-explicit-constructor): a view
                                                    // of the same pixels
      : ImageView(other.data(), other.width(), other.height(), other.stride()) {}

  constexpr T* data() const noexcept { return data_; }
  constexpr int width() const noexcept { return width_; }
  constexpr int height() const noexcept { return height_; }
  constexpr std::ptrdiff_t stride() const noexcept { return stride_; }
  constexpr bool empty() const noexcept { return width_ == 0 || height_ == 0; }
  constexpr Rows rows() const noexcept { return {0, height_}; }

  constexpr std::span<T> row(int y) const noexcept {
    STOF_CHECK(y >= 0 && y < height_);
    return {data_ + y * stride_, static_cast<std::size_t>(width_)};
  }
  // The row nearest to y: borders replicate. For images that are not empty.
  constexpr std::span<T> row_clamped(int y) const noexcept {
    return row(std::clamp(y, 0, height_ - 1));
  }
  constexpr T& at(int x, int y) const noexcept {
    STOF_CHECK(x >= 0 && x < width_);
    return row(y)[static_cast<std::size_t>(x)];
  }

 private:
  T* data_ = nullptr;
  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
};

template <typename A, typename B>
constexpr bool same_size(const ImageView<A>& a, const ImageView<B>& b) noexcept {
  return a.width() == b.width() && a.height() == b.height();
}

// The upper left width x height pixels of a buffer that is at least as large; of an empty one
// nothing.
template <typename T>
constexpr ImageView<T> cut(const ImageView<T>& buffer, int width, int height) noexcept {
  return buffer.empty() ? buffer : ImageView<T>(buffer.data(), width, height, buffer.stride());
}

}  // namespace stof::dsp
