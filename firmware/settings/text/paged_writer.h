#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <span>
#include <string_view>

namespace stof::settings {

// Takes a text of any length, counts it, and keeps what falls into `space` from byte `offset` on: a
// document is written anew for each part of it that is asked for, and needs no memory of its own.
class PagedWriter {
 public:
  constexpr explicit PagedWriter(std::span<char> space, std::size_t offset = 0) noexcept
      : space_(space), offset_(offset) {}

  constexpr PagedWriter& operator<<(std::string_view text) noexcept {
    const std::size_t skipped = std::min(text.size(), offset_ - std::min(offset_, total_));
    const std::string_view kept = text.substr(skipped).substr(0, space_.size() - kept_);
    std::ranges::copy(kept, space_.begin() + static_cast<std::ptrdiff_t>(kept_));
    kept_ += kept.size();
    total_ += text.size();
    return *this;
  }
  constexpr PagedWriter& operator<<(const char* text) noexcept {
    return *this << std::string_view(text);
  }
  constexpr PagedWriter& operator<<(char letter) noexcept {
    return *this << std::string_view(&letter, 1);
  }
  template <std::integral T>
    requires(!std::same_as<T, bool>)
  PagedWriter& operator<<(T number) noexcept {
    std::array<char, 24> digits;
    const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    return *this << std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data()));
  }

  // Bytes of the whole text so far.
  constexpr std::size_t total() const noexcept { return total_; }
  // The text that was kept, a part of `space`.
  constexpr std::string_view text() const noexcept { return {space_.data(), kept_}; }
  constexpr bool complete() const noexcept { return offset_ == 0 && kept_ == total_; }

 private:
  std::span<char> space_;
  std::size_t offset_;
  std::size_t total_ = 0;
  std::size_t kept_ = 0;
};

// As it may stand in a message of one line: short, quotes and control characters replaced.
inline void write_clipped(std::string_view text, PagedWriter& out) noexcept {
  constexpr std::size_t kMost = 40;
  for (const char c : text.substr(0, kMost)) {
    out << (c < 0x20 || c == 0x7F || c == '"' ? '?' : c);
  }
  if (text.size() > kMost) {
    out << "...";
  }
}
inline void write_quoted(std::string_view text, PagedWriter& out) noexcept {
  out << '"';
  write_clipped(text, out);
  out << '"';
}

}  // namespace stof::settings
