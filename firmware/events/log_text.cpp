#include "firmware/events/log_text.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <string_view>
#include <utility>

#include "firmware/settings/text/paged_writer.h"
#include "firmware/wire/frame_info.h"
#include "firmware/wire/keys/key_text.h"
#include "hal/network_interfaces.h"

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

// In hexadecimal digits, `least` of them at least.
void write_hexadecimal(std::uint32_t value, int least, settings::PagedWriter& out) noexcept {
  constexpr std::string_view kDigits = "0123456789abcdef";
  for (int place = 7; place >= 0; --place) {
    if (place < least || value >> (4 * place) != 0) {
      out << kDigits[value >> (4 * place) & 15];
    }
  }
}

// 192.168.1.5, or the eight groups of an IPv6 address, fd00:0:0:0:0:0:c0a8:105.
void write_address(const std::array<std::uint8_t, 16>& address,
                   settings::PagedWriter& out) noexcept {
  constexpr std::array<std::uint8_t, 12> kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
  if (std::ranges::equal(std::span(address).first(kMapped.size()), kMapped)) {
    for (std::size_t i = kMapped.size(); i < address.size(); ++i) {
      out << (i > kMapped.size() ? "." : "") << int{address[i]};
    }
    return;
  }
  for (std::size_t i = 0; i < address.size(); i += 2) {
    out << (i > 0 ? ":" : "");
    write_hexadecimal(address[i] * 256U + address[i + 1], 1, out);
  }
}

void write_requester(const Event& event, settings::PagedWriter& out) noexcept {
  if (event.address == std::array<std::uint8_t, 16>{}) {
    out << "over the serial line";
    return;
  }
  // Over a link nobody proves an address.
  out << (event.address == hal::kAllOfLink ? "by broadcast" : "by ");
  if (event.address != hal::kAllOfLink) {
    write_address(event.address, out);
  }
}

const char* sending_text(EventKind kind) noexcept {
  return kind == EventKind::kSending
             ? "packets leave again"
             : "nobody can be reached at the destination, packets are dropped; sending goes on";
}

// Of one device, behind its name.
const char* device_text(EventKind kind) noexcept {
  switch (kind) {
    case EventKind::kLost:
      return " lost, trying to get it back";
    case EventKind::kBack:
      return " is back";
    case EventKind::kSilent:
      return " silent: it is there, but sends nothing that belongs to an edge";
    case EventKind::kDark:
      return " dark: its samples hold no light of its lamp";
    default:
      return ": frames are used again";
  }
}

const char* key_text(EventKind kind) noexcept {
  switch (kind) {
    case EventKind::kKeyMade:
      return ", made ";
    case EventKind::kKeyRenewed:
      return ", renewed ";
    default:
      return ", ended ";
  }
}

void write_key(const Event& event, settings::PagedWriter& out) noexcept {
  out << "key ";
  write_hexadecimal(event.value, 8, out);
  out << ", role " << wire::role_text(event.role) << key_text(event.kind);
  write_requester(event, out);
  if (event.kind == EventKind::kLastKeyEnded) {
    out << ". It was the last: anybody on the network may change what is harmless";
  }
}

// Of settings, of the calibration.
void write_change(const Event& event, settings::PagedWriter& out) noexcept {
  if (event.kind == EventKind::kCalibrationChanged) {
    out << "calibration ";
    write_hexadecimal(event.value, 8, out);
    out << " in place of ";
    write_hexadecimal(event.former, 8, out);
    out << ", put there ";
  } else {
    if (event.former == kNetworkTakenBack) {
      out << "settings changed: network is as before, because nobody saved its change in time";
      return;
    }
    out << "settings changed ";
  }
  write_requester(event, out);
  if (event.kind == EventKind::kSettingsChanged && event.former == kNetworkOnTrial) {
    out << "; network is on trial";
  }
}

// To who holds the button.
const char* vain_hold_text(std::uint32_t state) noexcept {
  switch (state) {
    case kPairingOpen:
      return "no digits are told yet. Let go, wait for the digits, read them, hold again";
    case kPairingClosed:
    case kPairingDone:
      return "there are no digits to accept. A short press opens pairing";
    default:
      return "it began before the digits were told. Let go, read the digits, hold again";
  }
}

void write_pairing(const Event& event, settings::PagedWriter& out) noexcept {
  const std::uint32_t state = event.value;
  if (event.former == kPairingHeldInVain) {
    out << "pairing: the hold of the button counts for nothing: " << vain_hold_text(state);
    return;
  }
  if (state == kPairingClosed) {
    out << "pairing has ended without a key";
    if (event.former == kPairingPressed) {
      out << ": the button was pressed, or held for less than three seconds. Press it again to "
             "begin anew";
    }
    return;
  }
  if (state == kPairingDone) {
    out << "pairing has ended: there is a new key";
    return;
  }
  if (state == kPairingOpen) {
    out << "pairing is open for two minutes: stof pair";
    return;
  }
  out << "pairing: the digits are ";
  std::uint32_t unit = 100'000;
  for (int place = 0; place < 6; ++place, unit /= 10) {
    out << (place == 3 ? " " : "") << static_cast<char>('0' + state / unit % 10);
  }
  out << ", role " << wire::role_text(event.role) << ", asked for ";
  write_requester(event, out);
  out << ". Type them into stof pair; only if it accepts them hold the button for three seconds";
}

void write_release(const Event& event, settings::PagedWriter& out) noexcept {
  out << "release ";
  write_hexadecimal(event.former, 8, out);
  if (event.value == kReleaseOnTrial) {
    out << " is on trial";
  } else if (event.value == kReleaseConfirmed) {
    out << " is confirmed: each start takes it";
  } else {
    out << " was not confirmed: each start takes the former one";
  }
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

void describe(const Event& event, settings::PagedWriter& out) noexcept {
  const char* const part = name(event.component);
  switch (event.kind) {
    case EventKind::kPublishing:
      out << "publishing";
      if (event.value != 0) {
        out << ", after " << event.value << " edges without a frame";
      }
      return;
    case EventKind::kUnpaired:
      out << "no frame since " << event.value << " edges: " << part << ", "
          << to_string(event.status);
      return;
    case EventKind::kLost:
    case EventKind::kBack:
    case EventKind::kSilent:
    case EventKind::kDark:
    case EventKind::kSupplying:
      out << part << device_text(event.kind);
      return;
    case EventKind::kSendFailed:
    case EventKind::kSending:
      out << sending_text(event.kind);
      return;
    case EventKind::kLate:
      out << "late: " << event.value
          << " period(s) skipped, this machine is too slow or too busy for the period";
      return;
    case EventKind::kInTime:
      out << "in time again";
      return;
    case EventKind::kFrozen:
      out << part << " frozen: " << frozen_text(event) << " comes again and again";
      return;
    case EventKind::kStandsOn:
      out << standing_text(event.value);
      return;
    case EventKind::kSettingsChanged:
    case EventKind::kCalibrationChanged:
      write_change(event, out);
      return;
    case EventKind::kStandby:
      out << (event.value != 0 ? "standby: nobody receives; whoever subscribes ends it"
                               : "standby has ended");
      return;
    case EventKind::kRelease:
      write_release(event, out);
      return;
    case EventKind::kPairing:
      write_pairing(event, out);
      return;
    case EventKind::kKeyMade:
    case EventKind::kKeyRenewed:
    case EventKind::kKeyEnded:
    case EventKind::kLastKeyEnded:
      write_key(event, out);
      return;
  }
  out << "unknown event";
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
    const StageTime& stage = counters.stages[i];
    text += std::string(i == 0 ? " " : ", ") + kNames[i] + " ";
    // A recording's clock stands still meanwhile.
    text += stage.longest == hal::Duration::zero()
                ? "not measured"
                : microseconds(stage.total / frames) + " (" + microseconds(stage.longest) + ")";
  }
  return text;
}

}  // namespace stof::firmware
