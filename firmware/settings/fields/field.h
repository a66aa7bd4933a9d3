#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "dsp/stereo/match_options.h"
#include "firmware/control/access.h"
#include "firmware/settings/settings.h"

// The one table of all settings. Parser, writer, schema, help text and docs/SETTINGS.md are made of
// it.
namespace stof::settings {

enum class Kind : std::uint8_t {
  kInteger,  // low .. high
  kBoolean,
  kChoice,     // one of `values`
  kText,       // UTF-8 of low .. high bytes, without quotes, backslashes and control characters
  kDevice,     // the name of a device below /dev/ of at most `high` bytes, or nothing
  kInterface,  // A.B.C.D/BITS, or nothing
  kIpv4,       // A.B.C.D, or nothing
  kHostname,   // a label of RFC 1123
  kMatch,      // what dsp::MatchOption takes, as string, number or boolean; "preset": as the preset
};

enum class Applies : std::uint8_t { kNow, kRestart };

using firmware::Access;

struct Field {
  std::string_view group = {};  // "depth.match"; empty: of the document itself
  std::string_view name = {};   // "lr"
  Kind kind = Kind::kInteger;
  Applies applies = Applies::kNow;
  Access access = Access::kTune;  // the least that may change it
  int low = 0;
  int high = 0;
  std::span<const std::string_view> values = {};
  std::string_view unit = {};
  std::string_view meaning = {};  // one line
  // kMatch.
  const dsp::MatchOption* option = nullptr;
  std::size_t slot = 0;
  // For the other kinds: the value as a number (of a choice its place in `values`), or as text.
  int (*number)(const Settings&) = nullptr;
  void (*set_number)(int, Settings&) = nullptr;
  std::string_view (*text)(const Settings&) = nullptr;
  void (*set_text)(std::string_view, Settings&) = nullptr;
};

// Which fields; bit: place in the table.
inline constexpr std::size_t kMostFields = 96;
using FieldSet = std::bitset<kMostFields>;

// All fields, those of a group together, of a group before its groups. A field lives as long as the
// program.
std::size_t field_count() noexcept;
Field field(std::size_t place) noexcept;
// field_count(): there is none. "depth.match.lr".
std::size_t find_field(std::string_view path) noexcept;
bool is_group(std::string_view path) noexcept;

}  // namespace stof::settings
