#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Little-endian values at the end of a buffer, and out of bytes that may be anything.
namespace stof::mcap {

using Buffer = std::vector<std::byte>;
using Bytes = std::span<const std::byte>;

static_assert(std::endian::native == std::endian::little, "values are copied as they are");

inline void append_bytes(Buffer& to, Bytes bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}
template <typename T>
void append(Buffer& to, T value) {
  static_assert(std::is_integral_v<T>);
  append_bytes(to, std::as_bytes(std::span(&value, 1)));
}
inline Bytes bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }
// Length (u32), then the text.
inline void append_text(Buffer& to, std::string_view text) {
  append(to, static_cast<std::uint32_t>(text.size()));
  append_bytes(to, bytes_of(text));
}

// Reads one value after the other. What is not there makes it bad, and reads as 0 or empty: look at
// ok() once, at the end.
class Cursor {
 public:
  explicit Cursor(Bytes bytes) noexcept : bytes_(bytes) {}

  template <typename T>
  T number() noexcept {
    static_assert(std::is_integral_v<T>);
    T value = 0;
    const Bytes part = bytes(sizeof(T));
    if (part.size() == sizeof(T)) {
      std::memcpy(&value, part.data(), sizeof(T));
    }
    return value;
  }
  Bytes bytes(std::uint64_t count) noexcept {
    if (!ok_ || count > bytes_.size() - at_) {
      ok_ = false;
      return {};
    }
    const Bytes part = bytes_.subspan(at_, static_cast<std::size_t>(count));
    at_ += part.size();
    return part;
  }
  std::string text() {
    const Bytes part = bytes(number<std::uint32_t>());
    return {reinterpret_cast<const char*>(part.data()), part.size()};  // any bytes
  }
  Bytes rest() noexcept { return bytes(left()); }
  std::size_t left() const noexcept { return ok_ ? bytes_.size() - at_ : 0; }
  std::size_t position() const noexcept { return at_; }
  bool ok() const noexcept { return ok_; }
  // Nothing was missing, and nothing is left.
  bool at_end() const noexcept { return ok_ && at_ == bytes_.size(); }

 private:
  Bytes bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace stof::mcap
