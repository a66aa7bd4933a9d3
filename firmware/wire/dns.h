#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string_view>

#include "dsp/base/status.h"

// Messages of the domain name system, as far as service discovery needs them: RFC 1035 section 4,
// RFC 6762, RFC 6763. Numbers are big-endian. Any bytes may be read; nothing allocates.
namespace stof::wire::dns {

enum class Type : std::uint16_t {
  kNone = 0,
  kA = 1,
  kPtr = 12,
  kTxt = 16,
  kAaaa = 28,
  kSrv = 33,
  kNsec = 47,
  kAny = 255
};

inline constexpr std::size_t kHeaderBytes = 12;
inline constexpr std::uint16_t kResponse = 0x8000;  // of Header::flags
inline constexpr std::uint16_t kAuthoritative = 0x0400;
inline constexpr std::uint16_t kTruncated = 0x0200;  // more known answers follow
inline constexpr std::uint16_t kOpcode = 0x7800;
inline constexpr std::uint16_t kInternet = 1;    // class
inline constexpr std::uint16_t kAnyClass = 255;  // of a question
// The top bit of a class: of a question "answer me alone", of a record "forget your others".
inline constexpr std::uint16_t kTopBit = 0x8000;

// A domain name, uncompressed: labels of 1 to 63 bytes, each behind its length, and a 0.
class Name {
 public:
  static constexpr std::size_t kMost = 255;  // bytes, with the 0

  Name() noexcept = default;
  // Labels that do not fit are left out.
  Name(std::initializer_list<std::string_view> labels) noexcept;

  // kTooLarge: the label is empty or too long, or the name would be; it stays as it was.
  Status append(std::string_view label) noexcept;
  std::span<const std::byte> bytes() const noexcept { return std::span(bytes_).first(size_); }
  // Without its first label; the root's is the root.
  Name parent() const noexcept;
  // Empty: the root.
  std::string_view first_label() const noexcept;
  bool is_root() const noexcept { return size_ == 1; }

  // As names compare: capitals of ASCII are small letters.
  friend bool operator==(const Name& a, const Name& b) noexcept;

 private:
  std::array<std::byte, kMost> bytes_{};
  std::size_t size_ = 1;
};

struct Header {
  std::uint16_t id = 0;
  std::uint16_t flags = 0;
  std::uint16_t questions = 0;
  std::uint16_t answers = 0;
  std::uint16_t authorities = 0;
  std::uint16_t additionals = 0;
};

struct Question {
  Name name;
  Type type = Type::kAny;
  std::uint16_t klass = kInternet;  // with the top bit
};

struct Record {
  Name name;
  Type type = Type::kNone;
  std::uint16_t klass = kInternet;  // with the top bit
  std::uint32_t ttl_s = 0;
  std::size_t data_offset = 0;  // in the message
  std::span<const std::byte> data;
};

// Reads a message part by part, each as often as the header says. Every function returns kCorrupt
// where the bytes end or contradict themselves; nothing after that can be read.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> message) noexcept : message_(message) {}

  Result<Header> header() noexcept;
  Result<Question> question() noexcept;
  Result<Record> record() noexcept;
  // A name inside of a record's data, which may be compressed.
  Result<Name> name_at(std::size_t offset) const noexcept;

 private:
  Result<Name> name() noexcept;
  std::optional<std::uint16_t> number() noexcept;

  std::span<const std::byte> message_;
  std::size_t at_ = 0;
};

// Writes a message into `space`, kHeaderBytes at least. What does not fit is left out whole.
class Writer {
 public:
  Writer(std::span<std::byte> space, std::uint16_t id, std::uint16_t flags) noexcept;

  // These return false when it did not fit.
  bool question(const Name& name, Type type, std::uint16_t klass) noexcept;
  // A record is its head, its data and finish(), which says whether it fits.
  void begin_record(const Name& name, Type type, std::uint16_t klass, std::uint32_t ttl_s) noexcept;
  void data_u16(std::uint16_t value) noexcept;
  void data(std::span<const std::byte> bytes) noexcept;
  void data_text(std::string_view key, std::string_view value) noexcept;  // "key=value" of a TXT
  void data_name(const Name& name, bool compressed = true) noexcept;

  enum class Section : std::uint8_t { kAnswer = 1, kAuthority, kAdditional };  // in this order
  bool finish(Section section) noexcept;

  // The message up to the last thing that fitted.
  std::span<const std::byte> message() noexcept;
  bool empty() const noexcept;                          // neither questions nor records
  bool complete() const noexcept { return complete_; }  // nothing was left out

 private:
  static constexpr std::size_t kPlaces = 48;

  void put(std::byte value) noexcept;
  void put_u16(std::uint16_t value) noexcept;
  void put_name(const Name& name, bool compressed) noexcept;
  std::optional<std::size_t> place_of(const Name& name) const noexcept;

  std::span<std::byte> space_;
  std::size_t size_ = kHeaderBytes;
  std::size_t kept_ = kHeaderBytes;
  std::size_t length_at_ = 0;  // of the open record
  bool full_ = false;
  bool complete_ = true;
  std::array<std::uint16_t, 4> counts_{};        // of the sections, questions first
  std::array<std::uint16_t, kPlaces> places_{};  // where labels begin that names may end with
  std::size_t places_count_ = 0;
  std::size_t places_kept_ = 0;
};

}  // namespace stof::wire::dns
