#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/recording/mcap/bytes.h"

// Messages as ROS 2 serialises them: OMG CDR, version 1, little-endian, behind the four bytes of
// its encapsulation (00 01 00 00). A value is aligned to its size, counted from behind these.
namespace stof::recording {

using mcap::Buffer;
using mcap::Bytes;

inline constexpr std::size_t kEncapsulation = 4;

class CdrWriter {
 public:
  CdrWriter() { mcap::append(bytes_, std::uint32_t{0x0000'0100}); }

  template <typename T>
  void number(T value) {
    align(sizeof(T));
    if constexpr (std::is_floating_point_v<T>) {
      mcap::append_bytes(bytes_, std::as_bytes(std::span(&value, 1)));
    } else {
      mcap::append(bytes_, value);
    }
  }
  // Length with the closing 0, the text, the 0.
  void text(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size() + 1));
    mcap::append_bytes(bytes_, mcap::bytes_of(value));
    number(std::uint8_t{0});
  }
  // Of a sequence of bytes.
  void octets(Bytes value) {
    number(static_cast<std::uint32_t>(value.size()));
    mcap::append_bytes(bytes_, value);
  }
  // Room for more: what is written next into a buffer of this size is not moved.
  void reserve(std::size_t more) { bytes_.reserve(bytes_.size() + more); }
  void raw(Bytes value) { mcap::append_bytes(bytes_, value); }

  Buffer take() && { return std::move(bytes_); }

 private:
  void align(std::size_t size) {
    while ((bytes_.size() - kEncapsulation) % size != 0) {
      bytes_.push_back(std::byte{0});
    }
  }
  Buffer bytes_;
};

// Any bytes. What is not there makes it bad and reads as 0 or empty: look at ok() once, at the end.
class CdrReader {
 public:
  explicit CdrReader(Bytes message) noexcept : from_(message) {
    good_ = from_.number<std::uint32_t>() == 0x0000'0100;
  }

  template <typename T>
  T number() noexcept {
    while (from_.left() > 0 && (from_.position() - kEncapsulation) % sizeof(T) != 0) {
      from_.bytes(1);
    }
    return from_.number<T>();
  }
  std::string text() {
    const Bytes part = from_.bytes(number<std::uint32_t>());
    good_ = good_ && !part.empty() && part.back() == std::byte{0};
    return {reinterpret_cast<const char*>(part.data()), part.empty() ? 0 : part.size() - 1};
  }
  Bytes octets() noexcept { return from_.bytes(number<std::uint32_t>()); }

  bool ok() const noexcept { return good_ && from_.ok(); }

 private:
  mcap::Cursor from_;
  bool good_ = true;
};

}  // namespace stof::recording
