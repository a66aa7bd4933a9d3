#include "firmware/wire/keys/key_text.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>

#include "dsp/base/check.h"
#include "firmware/wire/crc32c.h"

namespace stof::wire {
namespace {

constexpr std::string_view kFirstLine = "stof keys 1\n";
constexpr std::string_view kAnyVersion = "stof keys ";
constexpr std::string_view kLastLine = "crc32c ";
constexpr std::string_view kHexDigits = "0123456789abcdef";
constexpr std::size_t kWordDigits = 8;

// Text into a space that is known to be large enough.
class KeyWriter {
 public:
  explicit KeyWriter(std::span<char> space) : space_(space) {}
  KeyWriter& text(std::string_view text) {
    STOF_CHECK(size_ + text.size() <= space_.size());
    std::ranges::copy(text, space_.subspan(size_).begin());
    size_ += text.size();
    return *this;
  }
  KeyWriter& hex(std::uint8_t byte) {
    const std::array<char, 2> digits{kHexDigits[byte >> 4U], kHexDigits[byte & 15U]};
    return text({digits.data(), digits.size()});
  }
  KeyWriter& hex(std::uint32_t number) {
    for (int shift = 24; shift >= 0; shift -= 8) {
      hex(static_cast<std::uint8_t>(number >> shift));
    }
    return *this;
  }
  KeyWriter& hex(const Secret& secret) {
    for (const std::byte byte : secret) {
      hex(std::to_integer<std::uint8_t>(byte));
    }
    return *this;
  }
  std::span<char> written() const { return space_.first(size_); }

 private:
  std::span<char> space_;
  std::size_t size_ = 0;
};

std::uint32_t check_sum(std::span<const char> text) noexcept { return crc32c(std::as_bytes(text)); }

// Text up to `end`, which is taken off with it; none: it does not come.
std::optional<std::string_view> take_until(char end, std::string_view& rest) noexcept {
  const std::size_t at = rest.find(end);
  if (at == std::string_view::npos) {
    return std::nullopt;
  }
  const std::string_view taken = rest.substr(0, at);
  rest.remove_prefix(at + 1);
  return taken;
}

// Small digits alone: a file has one form.
std::optional<std::uint8_t> digit_of(char c) noexcept {
  const std::size_t at = kHexDigits.find(c);
  return at == std::string_view::npos ? std::nullopt : std::optional(static_cast<std::uint8_t>(at));
}

std::optional<std::uint32_t> read_word(std::optional<std::string_view> text) noexcept {
  if (!text || text->size() != kWordDigits ||
      !std::ranges::all_of(*text, [](char c) { return digit_of(c).has_value(); })) {
    return std::nullopt;
  }
  std::uint32_t word = 0;
  std::from_chars(text->data(), text->data() + text->size(), word, 16);
  return word;
}

bool read_secret(std::optional<std::string_view> text, Secret& secret) noexcept {
  if (!text || text->size() != 2 * secret.size()) {
    return false;
  }
  for (std::size_t i = 0; i < secret.size(); ++i) {
    const auto high = digit_of((*text)[2 * i]);
    const auto low = digit_of((*text)[2 * i + 1]);
    if (!high || !low) {
      return false;
    }
    secret[i] = static_cast<std::byte>(*high << 4U | *low);
  }
  return true;
}

bool read_key(std::string_view line, KeyTable& keys) noexcept {
  Key key;
  const auto id = read_word(take_until(' ', line));
  const auto device = read_word(take_until(' ', line));
  const auto role = take_until(' ', line);
  if (!id || !device || !role || !read_secret(take_until(' ', line), key.secret)) {
    return false;
  }
  key.id = *id;
  key.device = *device;
  key.role = role_of(*role);
  const std::size_t name_ends = line.find(' ');
  const std::string_view name = line.substr(0, name_ends);
  bool good = true;
  if (name_ends != std::string_view::npos) {
    good = read_secret(line.substr(name_ends + 1), key.former.emplace());
  }
  key.name = key_name(name);
  const bool added = good && key.name_text() == name && keys.add(key) == Status::kOk;
  wipe(key.secret);
  if (key.former) {
    wipe(*key.former);
  }
  return added;
}

bool read_lines(std::string_view text, KeyTable& keys) noexcept {
  while (!text.starts_with(kLastLine)) {
    const auto line = take_until('\n', text);
    if (!line || !read_key(*line, keys)) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::string_view role_text(Role role) noexcept {
  switch (role) {
    case Role::kView:
      return "view";
    case Role::kTune:
      return "tune";
    case Role::kAdmin:
      return "admin";
    case Role::kNone:
      break;
  }
  return "none";
}

Role role_of(std::string_view text) noexcept {
  for (const Role role : {Role::kView, Role::kTune, Role::kAdmin}) {
    if (text == role_text(role)) {
      return role;
    }
  }
  return Role::kNone;
}

std::optional<std::array<std::byte, 16>> code_of(std::string_view text) noexcept {
  std::array<std::byte, 16> code{};
  std::size_t digits = 0;
  for (const char c : text) {
    if (c == '-' || c == ' ' || c == '\n' || c == '\r') {
      continue;
    }
    const auto digit = digit_of(c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c);
    if (!digit || digits == 2 * code.size()) {
      return std::nullopt;
    }
    std::byte& byte = code[digits++ / 2];
    byte = byte << 4 | static_cast<std::byte>(*digit);
  }
  return digits == 2 * code.size() ? std::optional(code) : std::nullopt;
}

std::span<char> write_keys(const KeyTable& keys, std::span<char> space) noexcept {
  KeyWriter out(space);
  out.text(kFirstLine);
  for (const Key& key : keys.all()) {
    out.hex(key.id).text(" ").hex(key.device).text(" ").text(role_text(key.role)).text(" ");
    out.hex(key.secret).text(" ").text(key.name_text());
    if (key.former) {
      out.text(" ").hex(*key.former);
    }
    out.text("\n");
  }
  const std::uint32_t sum = check_sum(out.written());
  out.text(kLastLine).hex(sum).text("\n");
  return out.written();
}

Status read_keys(std::string_view text, KeyTable& keys) noexcept {
  constexpr std::size_t kLastBytes = kLastLine.size() + kWordDigits + 1;
  keys.clear();
  if (text.size() < kFirstLine.size() + kLastBytes) {
    return Status::kCorrupt;
  }
  const std::string_view checked = text.substr(0, text.size() - kLastBytes);
  const std::string_view last = text.substr(checked.size());
  if (!last.starts_with(kLastLine) || !last.ends_with('\n') ||
      read_word(last.substr(kLastLine.size(), kWordDigits)) != check_sum(checked)) {
    return Status::kCorrupt;
  }
  if (!checked.starts_with(kFirstLine)) {
    return checked.starts_with(kAnyVersion) ? Status::kUnsupported : Status::kCorrupt;
  }
  if (!read_lines(text.substr(kFirstLine.size()), keys)) {
    keys.clear();
    return Status::kCorrupt;
  }
  return Status::kOk;
}

}  // namespace stof::wire
