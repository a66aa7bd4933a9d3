#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <optional>

namespace stof::firmware {

// A queue from one thread to one other, kCapacity items at most, kCapacity a power of two. Neither
// end blocks, waits or allocates. T: copyable without exceptions; items are copied in and out.
template <typename T, std::size_t kCapacity>
class SpscRing {
  static_assert(kCapacity > 0 && (kCapacity & (kCapacity - 1)) == 0);
  static_assert(std::atomic<std::size_t>::is_always_lock_free);

 public:
  // For the writing thread. False: full, the item was not taken.
  bool push(const T& item) noexcept {
    const std::size_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) == kCapacity) {
      return false;
    }
    items_[written % kCapacity] = item;
    written_.store(written + 1, std::memory_order_release);
    return true;
  }

  // For the writing thread: false: the next push() takes its item.
  bool full() const noexcept { return size() == kCapacity; }

  // For the reading thread: the oldest item, none when empty.
  std::optional<T> pop() noexcept {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (read == written_.load(std::memory_order_acquire)) {
      return std::nullopt;
    }
    std::optional<T> item(items_[read % kCapacity]);
    read_.store(read + 1, std::memory_order_release);
    return item;
  }

  // For either thread: items in the queue, which the other end may change at once.
  std::size_t size() const noexcept {
    // In this order the difference cannot be negative.
    const std::size_t read = read_.load(std::memory_order_acquire);
    const std::size_t count = written_.load(std::memory_order_acquire) - read;
    return count < kCapacity ? count : kCapacity;
  }

 private:
  static constexpr std::size_t kLine = 64;  // bytes of a cache line: the ends do not share one

  std::array<T, kCapacity> items_{};
  alignas(kLine) std::atomic<std::size_t> written_{0};
  alignas(kLine) std::atomic<std::size_t> read_{0};
};

}  // namespace stof::firmware
