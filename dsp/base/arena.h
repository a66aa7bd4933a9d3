#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "dsp/base/check.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// Hands out parts of one block of memory, in order, once: this is how a Matcher, a Converter and a
// Fuser get their buffers from the caller's static workspace. Nothing is freed one by one.
// Contents are not initialised. Running out is our own bug (sizes are asked for first): CHECK.
class Arena {
 public:
  static constexpr std::size_t kAlign = 64;  // a cache line, and any vector register

  constexpr explicit Arena(std::span<std::byte> memory) noexcept : memory_(memory) {}

  // What take<T>(count) uses up at most, for bytes_needed() functions.
  template <typename T>
  static constexpr std::size_t bytes_for(std::size_t count) noexcept {
    return (count * sizeof(T) + kAlign - 1) / kAlign * kAlign;
  }

  template <typename T>
  std::span<T> take(std::size_t count) noexcept {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kAlign);
    const std::size_t bytes = bytes_for<T>(count);
    STOF_CHECK(bytes <= memory_.size());
    std::byte* const at = memory_.data();
    STOF_CHECK(reinterpret_cast<std::uintptr_t>(at) % kAlign == 0);  // NOLINT: address arithmetic
    memory_ = memory_.subspan(bytes);
    return {reinterpret_cast<T*>(at), count};  // NOLINT: the one place where bytes become elements
  }

  template <typename T>
  ImageView<T> take_image(int width, int height) noexcept {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    return ImageView<T>(take<T>(count).data(), width, height);
  }

 private:
  std::span<std::byte> memory_;
};

}  // namespace stof::dsp
