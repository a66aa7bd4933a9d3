#include "firmware/events/log_text.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <span>
#include <utility>

#include "firmware/wire/frame_info.h"
#include "firmware/wire/keys/key_text.h"

namespace stof::firmware {
namespace {

const char* name(Component component) noexcept {
  switch (component) {
    case Component::kTrigger:
      return "trigger";
    case Component::kStereo:
      return "stereo camera";
    case Component::kPmd:
      return "PMD camera";
    case Component::kLink:
      return "link";
    case Component::kLoop:
      return "loop";
  }
  return "unknown part";
}

constexpr std::array<const char*, kDrops> kDropNames{"used",       "left over",       "too early",
                                                     "torn",       "bad stamp",       "repeated",
                                                     "wrong size", "without partner", "dark"};

// What comes again.
const char* frozen_text(const Event& event) {
  if (event.component == Component::kPmd) {
    return "the same set of samples";
  }
  switch (event.value) {
    case 1:
      return "the same left picture";
    case 2:
      return "the same right picture";
    default:
      return "the same pair";
  }
}

const char* standing_text(std::uint32_t sensors) {
  switch (sensors) {
    case wire::kStereoSensor:
      return "frames stand on the stereo pair alone";
    case wire::kPmdSensor:
      return "frames stand on the PMD camera alone";
    default:
      return "frames stand on both sensors";
  }
}

// 192.168.1.5, or the eight groups of an IPv6 address, fd00:0:0:0:0:0:c0a8:105.
std::string address_text(const std::array<std::uint8_t, 16>& address) {
  constexpr std::array<std::uint8_t, 12> kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
  const bool mapped = std::ranges::equal(std::span(address).first(kMapped.size()), kMapped);
  std::string text;
  for (std::size_t i = mapped ? kMapped.size() : 0; i < address.size(); i += mapped ? 1 : 2) {
    std::array<char, 8> group{};
    if (mapped) {
      std::snprintf(group.data(), group.size(), "%d", int{address[i]});
    } else {
      std::snprintf(group.data(), group.size(), "%x", address[i] * 256U + address[i + 1]);
    }
    if (!text.empty()) {
      text += mapped ? '.' : ':';
    }
    text += group.data();
  }
  return text;
}

std::string requester_text(const Event& event) {
  return event.address == std::array<std::uint8_t, 16>{} ? "over the serial line"
                                                         : "by " + address_text(event.address);
}

std::string key_text(const Event& event, const char* what) {
  std::array<char, 16> id{};
  std::snprintf(id.data(), id.size(), "%08x", event.value);
  return std::string("key ") + id.data() + ", role " + std::string(wire::role_text(event.role)) +
         ", " + what + " " + requester_text(event);
}

std::string pairing_text(std::uint32_t state) {
  if (state == kPairingClosed) {
    return "pairing has ended without a key";
  }
  if (state == kPairingDone) {
    return "pairing has ended: there is a new key";
  }
  if (state == kPairingOpen) {
    return "pairing is open for two minutes: stof pair";
  }
  std::string digits = std::to_string(state).substr(1);
  digits.insert(digits.size() / 2, " ");
  return "pairing: the digits are " + digits +
         ". Type them into stof pair; only if it accepts them hold the button for three seconds";
}

// " (3 repeated, 1 torn)", or nothing.
std::string causes(const std::array<std::uint64_t, kDrops>& dropped) {
  std::string text;
  for (std::size_t cause = 1; cause < kDrops; ++cause) {
    if (dropped[cause] != 0) {
      text += (text.empty() ? "" : ", ") + std::to_string(dropped[cause]) + " " + kDropNames[cause];
    }
  }
  return text;
}

// ", 3 what" when there are any.
std::string also(std::uint64_t count, const char* what) {
  return count == 0 ? std::string() : ", " + std::to_string(count) + " " + what;
}

}  // namespace

std::string describe(const Event& event) {
  switch (event.kind) {
    case EventKind::kPublishing:
      return "publishing" + (event.value == 0 ? std::string()
                                              : ", after " + std::to_string(event.value) +
                                                    " edges without a frame");
    case EventKind::kUnpaired:
      return std::string("no frame since ") + std::to_string(event.value) +
             " edges: " + name(event.component) + ", " + to_string(event.status);
    case EventKind::kLost:
      return std::string(name(event.component)) + " lost, trying to get it back";
    case EventKind::kBack:
      return std::string(name(event.component)) + " is back";
    case EventKind::kSendFailed:
      return "nobody can be reached at the destination, packets are dropped; sending goes on";
    case EventKind::kSending:
      return "packets leave again";
    case EventKind::kLate:
      return "late: " + std::to_string(event.value) +
             " period(s) skipped, this machine is too slow or too busy for the period";
    case EventKind::kInTime:
      return "in time again";
    case EventKind::kSilent:
      return std::string(name(event.component)) +
             " silent: it is there, but sends nothing that belongs to an edge";
    case EventKind::kFrozen:
      return std::string(name(event.component)) + " frozen: " + frozen_text(event) +
             " comes again and again";
    case EventKind::kDark:
      return std::string(name(event.component)) + " dark: its samples hold no light of its lamp";
    case EventKind::kStandsOn:
      return standing_text(event.value);
    case EventKind::kSettingsChanged:
      return "settings changed " + requester_text(event);
    case EventKind::kPairing:
      return pairing_text(event.value);
    case EventKind::kKeyMade:
      return key_text(event, "made");
    case EventKind::kKeyRenewed:
      return key_text(event, "renewed");
    case EventKind::kKeyEnded:
      return key_text(event, "ended");
    case EventKind::kLastKeyEnded:
      return key_text(event, "ended") +
             ". It was the last: anybody on the network may change what is harmless";
    case EventKind::kSupplying:
      return std::string(name(event.component)) + ": frames are used again";
  }
  return "unknown event";
}

std::string threads_text(int threads, int there) {
  return std::to_string(threads) + (threads == 1 ? " thread" : " threads") +
         (threads == there
              ? std::string()
              : " (of " + std::to_string(there) + ": there is no memory for more searches)");
}

std::string heap_text(std::uint64_t own, std::uint64_t libraries, std::uint64_t edges) {
  return "heap calls in the loop: " + std::to_string(own) + " of our own, " +
         std::to_string(libraries) + " of device libraries in " + std::to_string(edges) + " edges";
}

std::string summary(const Counters& counters) {
  std::string text = std::to_string(counters.published) + " frames published of " +
                     std::to_string(counters.edges) + " edges, " +
                     std::to_string(counters.packets_sent) + " packets sent, " +
                     std::to_string(counters.packets_dropped) + " dropped";
  text += also(counters.unpaired_edges, "edges without a frame");
  text += also(counters.skipped_periods, "periods skipped");
  text += also(counters.expired, "frames expired");
  text += also(counters.lost_events, "events not told");
  const std::pair<const char*, const std::array<std::uint64_t, kDrops>&> cameras[] = {
      {"stereo", counters.stereo_dropped}, {"PMD", counters.pmd_dropped}};
  for (const auto& [camera, dropped] : cameras) {
    const std::string why = causes(dropped);
    text += why.empty() ? "" : std::string("; ") + camera + " frames dropped: " + why;
  }
  for (std::size_t component = 0; component < kComponents; ++component) {
    const char* const what = name(static_cast<Component>(component));
    text += also(counters.timeouts[component], "timeouts of the ") +
            (counters.timeouts[component] == 0 ? "" : what);
    text += also(counters.errors[component], "errors of the ") +
            (counters.errors[component] == 0 ? "" : what);
    text += also(counters.losses[component], "losses of the ") +
            (counters.losses[component] == 0 ? "" : what);
  }
  return text;
}

std::string stage_times(const Counters& counters) {
  constexpr std::array<const char*, kStages> kNames{"match", "convert", "fuse", "publish"};
  const auto microseconds = [](hal::Duration time) {
    return std::to_string(std::chrono::duration_cast<std::chrono::microseconds>(time).count());
  };
  std::string text = "time of a frame, mean (longest) in us:";
  for (std::size_t i = 0; i < kStages; ++i) {
    const auto frames = static_cast<std::int64_t>(counters.published == 0 ? 1 : counters.published);
    text += std::string(i == 0 ? " " : ", ") + kNames[i] + " " +
            microseconds(counters.stages[i].total / frames) + " (" +
            microseconds(counters.stages[i].longest) + ")";
  }
  return text;
}

}  // namespace stof::firmware
