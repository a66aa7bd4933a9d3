#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

#include "dsp/base/check.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// Hands out parts of one block of memory, in order, once: this is how a Matcher, a PmdConverter and
// a Fuser get their buffers from the caller's static workspace. Nothing is freed one by one.
// Contents are not initialised. Running out is our own bug (sizes are measured first): CHECK.
//
// A part takes its memory in its constructor, and no other code says how much that is:
// bytes_taken() runs the same constructor with an arena that only measures.
//
// take() lasts: its contents stay from frame to frame. take_passing() is for contents that nobody
// needs once a phase of the frame is over (arena_phase.h): the next phase writes over them. What
// lasts grows from the beginning of the block, what passes from its end.
class Arena {
 public:
  static constexpr std::size_t kAlign = 64;  // a cache line, and any vector register

  constexpr explicit Arena(std::span<std::byte> memory) noexcept
      : memory_(memory.first(memory.size() / kAlign * kAlign)), end_(memory_.size()) {}

  // An arena that never runs out, over addresses at which no process has memory: whoever touches
  // what it hands out faults. A constructor that also fills what it takes asks is_measuring().
  static Arena measuring() noexcept {
    return Arena({reinterpret_cast<std::byte*>(kNobodys), kNobodys});  // NOLINT: never touched
  }
  bool is_measuring() const noexcept {
    return reinterpret_cast<std::uintptr_t>(memory_.data()) >= kNobodys;  // NOLINT: compared only
  }
  // Bytes that were taken of an arena that measures.
  std::size_t taken() const noexcept {
    STOF_CHECK(is_measuring());
    return kNobodys - memory_.size();
  }

  // The bytes that take<T>(count) uses.
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
    end_ -= bytes;
    return {reinterpret_cast<T*>(at), count};  // NOLINT: bytes become elements
  }

  // The same, shared with the phases that follow this one. Never filled at start: each frame writes
  // what it reads.
  template <typename T>
  std::span<T> take_passing(std::size_t count) noexcept {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kAlign);
    const std::size_t bytes = bytes_for<T>(count);
    STOF_CHECK(bytes <= end_);
    end_ -= bytes;
    std::byte* const at = memory_.data() + end_;
    STOF_CHECK(reinterpret_cast<std::uintptr_t>(at) % kAlign == 0);  // NOLINT: address arithmetic
    memory_ = memory_.first(std::min(memory_.size(), end_));
    return {reinterpret_cast<T*>(at), count};  // NOLINT: bytes become elements
  }

  // The same, each element `value`.
  template <typename T>
  std::span<T> take_filled(std::size_t count, T value) noexcept {
    const std::span<T> all = take<T>(count);
    if (!is_measuring()) {
      std::ranges::fill(all, value);
    }
    return all;
  }

  // A copy of `value`; nullptr in an arena that measures.
  template <typename T>
  T* put(const T& value) noexcept {
    T* const at = take<T>(1).data();
    return is_measuring() ? nullptr : std::construct_at(at, value);
  }

  // A part that is made where it lives, with this arena for its last argument, and never destroyed.
  // nullptr in an arena that measures: then the part has laid itself out and is gone.
  template <typename T, typename... Arguments>
  T* make(Arguments&&... arguments) noexcept {
    static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= kAlign);
    std::byte* const at = take<std::byte>(sizeof(T)).data();
    if (is_measuring()) {
      T(std::forward<Arguments>(arguments)..., *this);
      return nullptr;
    }
    return std::construct_at(reinterpret_cast<T*>(at),  // NOLINT: bytes become the part
                             std::forward<Arguments>(arguments)..., *this);
  }

  template <typename T>
  ImageView<T> take_image(int width, int height) noexcept {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    return ImageView<T>(take<T>(count).data(), width, height);
  }
  template <typename T>
  ImageView<T> take_passing_image(int width, int height) noexcept {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    return ImageView<T>(take_passing<T>(count).data(), width, height);
  }
  // The same, each pixel `value`.
  template <typename T>
  ImageView<T> take_filled_image(int width, int height, T value) noexcept {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    return ImageView<T>(take_filled(count, value).data(), width, height);
  }

 private:
  // Above what x86-64 and AArch64 give a program, and not where tags of pointers are ignored.
  static constexpr std::uintptr_t kNobodys = std::uintptr_t{1} << 55;

  friend class ArenaPhase;

  std::span<std::byte> memory_;  // that nobody has, in any phase
  std::size_t end_;              // where this phase's memory begins, from memory_.data()
};

// Bytes of an Arena that lay_out(Arena&) takes: construct a part there, or several.
//   bytes_taken([&](Arena& arena) noexcept { Fuser(calibration, params, arena); })
template <typename LayOut>
std::size_t bytes_taken(LayOut&& lay_out) noexcept {
  Arena arena = Arena::measuring();
  lay_out(arena);
  return arena.taken();
}

}  // namespace stof::dsp
