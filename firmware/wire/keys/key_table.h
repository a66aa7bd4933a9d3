#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "dsp/base/status.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/messages/enums.h"

namespace stof::wire {

inline constexpr std::size_t kKeyNameBytes = 32;
inline constexpr std::size_t kMostSensorKeys = 16;  // that a sensor keeps; a user more: KeyTable

// What one client and one sensor know, and nobody else.
struct Key {
  std::uint32_t id = 0;                    // random, never 0
  std::uint32_t device = 0;                // of the sensor
  Role role = Role::kNone;                 // never kNone in a table
  std::array<char, kKeyNameBytes> name{};  // whose it is, filled up with 0; see key_name()
  Secret secret{};
  // Of a sensor, where the key was renewed: holds too, until the new one has signed once.
  std::optional<Secret> former{};

  std::string_view name_text() const noexcept;
  friend bool operator==(const Key&, const Key&) = default;  // in tests alone: it takes its time
};

// A name as keys have it: letters, digits, `.`, `_`, `@` and `-`, which stands for everything else;
// never empty, cut off where it is too long.
std::array<char, kKeyNameBytes> key_name(std::string_view text) noexcept;

// Keys, of fixed capacity, in the order they came. Wipes what it drops.
class KeyTable {
 public:
  static constexpr std::size_t kMost = 32;

  KeyTable() = default;
  ~KeyTable() { clear(); }
  KeyTable(const KeyTable&) = default;
  KeyTable& operator=(const KeyTable&) = default;

  // kInvalidArgument: an id that is 0 or here already, or none of the roles; kTooLarge: it is full.
  Status add(const Key& key) noexcept;
  // false: there is none.
  bool remove(std::uint32_t id) noexcept;
  void clear() noexcept;

  // nullptr: there is none.
  const Key* find(std::uint32_t id) const noexcept;
  std::span<const Key> all() const noexcept { return std::span(keys_).first(count_); }
  std::size_t count() const noexcept { return count_; }

 private:
  std::array<Key, kMost> keys_{};
  std::size_t count_ = 0;
};

}  // namespace stof::wire
