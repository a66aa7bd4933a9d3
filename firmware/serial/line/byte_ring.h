#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

// Records of bytes from one thread to another one.
namespace stof::firmware {

// One thread puts, one other takes; nobody waits. A group of records becomes visible as a whole.
// Records have lengths of their own, and memory of the caller's; what has one size goes through an
// SpscRing.
class ByteRing {
 public:
  static constexpr std::size_t kMaxRecord = 65'535;

  // The part of room() that a record takes.
  static constexpr std::size_t cost(std::size_t bytes) noexcept { return bytes + 2; }

  // memory.size() is a power of two, which records may fill to the last byte.
  explicit ByteRing(std::span<std::byte> memory) noexcept;

  // For the thread that puts. Bytes for records with their cost(); it only grows meanwhile.
  std::size_t room() const noexcept;
  // Within room(), 1 to kMaxRecord bytes; seen by the other thread after publish().
  void put(std::span<const std::byte> record) noexcept;
  void publish() noexcept { written_.store(writing_, std::memory_order_release); }

  // For the thread that takes. Length of the oldest record, 0: there is none.
  std::size_t next() const noexcept;
  // Takes it out, up to its first out.size() bytes; returns how many, 0: there was none.
  std::size_t take(std::span<std::byte> out) noexcept;
  // Bytes that wait, with their cost().
  std::size_t waiting() const noexcept;

 private:
  void copy_in(std::size_t at, std::span<const std::byte> bytes) noexcept;
  void copy_out(std::size_t at, std::span<std::byte> bytes) const noexcept;

  std::span<std::byte> memory_;
  std::size_t writing_ = 0;  // counts on for ever, as the next two
  std::atomic<std::size_t> written_ = 0;
  std::atomic<std::size_t> read_ = 0;
};

}  // namespace stof::firmware
