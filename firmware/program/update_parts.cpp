#include "firmware/program/update_parts.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "board/board.h"
#include "dsp/base/parse_number.h"
#include "firmware/settings/text/as_text.h"
#include "firmware/update/boot_sector.h"

namespace stof::firmware {
namespace {

constexpr std::size_t kMostKeyFile = 4096;

std::optional<std::byte> hexadecimal(std::string_view two) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  const std::size_t high = kDigits.find(two[0]);
  const std::size_t low = kDigits.find(two[1]);
  return high == std::string_view::npos || low == std::string_view::npos
             ? std::nullopt
             : std::optional(static_cast<std::byte>(high << 4U | low));
}

std::optional<wire::PublicKey> key_of(std::string_view line) {
  wire::PublicKey key{};
  if (line.size() != 2 * key.size()) {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < key.size(); ++i) {
    const std::optional<std::byte> byte = hexadecimal(line.substr(2 * i, 2));
    if (!byte) {
      return std::nullopt;
    }
    key[i] = *byte;
  }
  return key;
}

std::expected<std::vector<wire::PublicKey>, std::string> read_update_keys(const std::string& file) {
  std::array<std::byte, kMostKeyFile> bytes{};
  const Result<std::optional<std::size_t>> read = board::make_store(file)->load(bytes);
  std::vector<wire::PublicKey> keys;
  std::string_view rest =
      read && *read ? settings::as_text(bytes).substr(0, **read) : std::string_view();
  bool good = !rest.empty();
  while (good && !rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    if (line.empty() || line.starts_with('#')) {
      continue;
    }
    const std::optional<wire::PublicKey> key = key_of(line);
    good = key.has_value();
    keys.push_back(key.value_or(wire::PublicKey{}));
  }
  if (!good) {
    return std::unexpected(file +
                           ": --update-keys takes a file with 64 hexadecimal digits a line, the "
                           "public keys of makers");
  }
  return keys;
}

}  // namespace

update::UpdaterSetup UpdateParts::setup() const {
  return {.slots = slots.get(),
          .running = running,
          .can_try = can_try,
          .old_loader = old_loader,
          .board = board::kConfig.name,
          .keys = keys};
}

std::expected<UpdateParts, std::string> open_update_parts(const Options& options) {
  UpdateParts parts;
  parts.running = options.slot == "b" ? update::Slot::kB : update::Slot::kA;
  parts.can_try = !options.no_trial;
  parts.old_loader = options.old_loader;
  if (!options.update_keys.empty()) {
    auto keys = read_update_keys(options.update_keys);
    if (!keys) {
      return std::unexpected(keys.error());
    }
    parts.keys = std::move(*keys);
  }
  if (!options.slots.empty()) {
    Result<std::unique_ptr<hal::Slots>> slots = board::make_slots(options.slots);
    if (slots) {
      parts.slots = std::move(*slots);
    } else {
      parts.note = options.slots + "1 to 3 cannot be opened as slots: no updates";
    }
  }
  return parts;
}

std::expected<std::string, std::string> slot_of_start(const Options& options) {
  Result<std::unique_ptr<hal::Slots>> slots = board::make_slots(options.slots);
  if (!slots) {
    return std::unexpected(options.slots + "1 to 3 cannot be opened: name a disk with --slots");
  }
  const std::optional<update::BootSector> sector = update::BootSector::find(**slots);
  if (!sector) {
    return std::unexpected(options.slots + "1 has no autoboot.txt: write the card again");
  }
  return std::string(
      1, update::letter(update::started(sector->choice(), options.which_slot == "trial")));
}

}  // namespace stof::firmware
