#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host/viewer/frame_message.h"

// What a page says, as docs/VIEWER.md has it.
namespace stof::viewer {

// What it looks at, and how many frames more it takes.
struct Look {
  static constexpr int kMostFrames = 2;
  Planes planes = 0;
  int frames = 0;
  bool quiet = false;
};

// What it wants done.
struct ReadSettings {};
struct ChangeSettings {
  std::vector<std::string> assignments{};  // "depth.max_range_mm=4000", the value in JSON
};
struct SaveSettings {};
struct GiveFault {
  std::string order{};  // "pmd:vanish:30" (board/emu/fault_orders.h); "list"
};
struct SetRecording {
  bool on = false;
};
struct SetPlaying {
  bool on = false;
};
struct SeekTo {
  std::uint64_t ms = 0;  // from the begin of the recording
};
struct BeginPairing {
  std::string code{};  // of the label; empty: digits are compared
  std::string role{};  // "view", "tune" or "admin"
};
struct GiveDigits {
  std::string digits{};  // that the sensor tells
};
struct EndPairing {};
struct ReadRelease {};
struct PutRelease {
  std::string file{};  // a name in the folder of releases, and no path
};
using Wish =
    std::variant<ReadSettings, ChangeSettings, SaveSettings, GiveFault, SetRecording, SetPlaying,
                 SeekTo, BeginPairing, GiveDigits, EndPairing, ReadRelease, PutRelease>;

struct Request {
  std::uint32_t id = 0;  // of the page's choice: its answer has it, too
  std::string ticket{};  // that this page was given
  Wish wish{};
};

using PageMessage = std::variant<Look, Request>;

// Any bytes. None: it means nothing, or names a member of an object twice.
std::optional<PageMessage> parse_page_message(std::string_view text);

}  // namespace stof::viewer
