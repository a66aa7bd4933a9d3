#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <sodium.h>

#include "firmware/update/updater.h"
#include "hal/emu/devices/slots.h"
#include "tests/fuzz/fuzz_input.h"

// An update file. The first byte says what of it is set right before it is sent, and how it is
// sent: behind a signature lies what only a maker's bytes reach.
namespace stof {
namespace {

using update::Slot;
using wire::SettingsResult;
using Bytes = std::vector<std::byte>;

constexpr unsigned kSign = 1;
constexpr unsigned kHashes = 2;
constexpr unsigned kSlow = 32;
constexpr unsigned kRevert = 64;
constexpr std::size_t kRoom = 2 * update::kChunkBytes;
constexpr std::size_t kChoice = update::kSectorBytes;
constexpr int kMostRepeats = 100;

struct Maker {
  Maker() {
    fuzz::require(wire::start_crypto());
    const std::array<unsigned char, crypto_sign_ed25519_SEEDBYTES> seed{7};
    std::array<unsigned char, crypto_sign_ed25519_PUBLICKEYBYTES> known{};
    crypto_sign_ed25519_seed_keypair(known.data(), secret.data(), seed.data());
    std::ranges::copy(std::as_bytes(std::span(known)), key.begin());
  }
  std::array<unsigned char, crypto_sign_ed25519_SECRETKEYBYTES> secret{};
  wire::PublicKey key{};
};

void set_right(Bytes& file, unsigned flags, const Maker& maker) {
  if (file.size() < update::kReleaseBytes) {
    return;
  }
  const std::span<std::byte> head = std::span(file).first(update::kReleaseBytes);
  const std::size_t content = wire::get_u32(head.subspan<84, 4>());
  const std::size_t chunks = (content + update::kChunkBytes - 1) / update::kChunkBytes;
  const std::size_t hashes = chunks * update::kHashBytes;
  if ((flags & kHashes) != 0 && file.size() == update::kReleaseBytes + hashes + content) {
    const std::span<std::byte> rest = std::span(file).subspan(update::kReleaseBytes);
    for (std::size_t i = 0; i < chunks; ++i) {
      const auto from = rest.subspan(hashes + i * update::kChunkBytes);
      const wire::Digest hash =
          wire::digest_of({}, {from.first(std::min(from.size(), update::kChunkBytes))});
      std::ranges::copy(hash, rest.subspan(i * update::kHashBytes).begin());
    }
    std::ranges::copy(wire::digest_of({}, {rest.first(hashes)}), head.subspan(96).begin());
  }
  if ((flags & kSign) != 0) {
    crypto_sign_ed25519_detached(reinterpret_cast<unsigned char*>(file.data()) + 128, nullptr,
                                 reinterpret_cast<const unsigned char*>(file.data()), 128,
                                 maker.secret.data());
  }
}

template <typename Ask>
SettingsResult repeated(Ask&& ask) {
  for (int i = 0; i < kMostRepeats; ++i) {
    std::array<char, 320> space{};
    settings::PagedWriter why(space);
    const SettingsResult result = ask(why);
    fuzz::require(why.text().find('\n') == std::string_view::npos);
    if (result != SettingsResult::kBusy) {
      fuzz::require(result == SettingsResult::kOk || !why.text().empty());
      return result;
    }
  }
  std::abort();
}

SettingsResult send(update::Updater& updater, const Bytes& file, std::size_t at_once) {
  SettingsResult result = repeated([&](settings::PagedWriter& why) {
    return updater.begin(static_cast<std::uint32_t>(file.size()), why);
  });
  for (std::size_t at = 0; at < file.size() && result == SettingsResult::kOk; at += at_once) {
    const auto rest = std::span(file).subspan(at);
    result = repeated([&](settings::PagedWriter& why) {
      return updater.write(rest.first(std::min(rest.size(), at_once)), why);
    });
  }
  return result == SettingsResult::kOk
             ? repeated([&](settings::PagedWriter& why) { return updater.commit({}, why); })
             : result;
}

}  // namespace

void fuzz::run(std::span<const std::byte> input) {
  if (input.empty()) {
    return;
  }
  static const Maker maker;
  const auto flags = wire::get_u8(input.first<1>());
  Bytes file(input.begin() + 1, input.end());
  set_right(file, flags, maker);
  hal::emu::Slots::Disk disk{Bytes(3 * kChoice), Bytes(kRoom + update::kRecordBytes),
                             Bytes(kRoom + update::kRecordBytes)};
  update::write_choice(update::settled(Slot::kA),
                       std::span(disk[0]).subspan<kChoice, update::kSectorBytes>());
  hal::emu::Slots slots(disk);
  slots.delay = (flags & kSlow) != 0 ? 3 : 0;
  update::Updater updater({.slots = &slots,
                           .running = Slot::kA,
                           .can_try = true,
                           .board = "virt",
                           .keys = std::span(&maker.key, 1)});
  const SettingsResult result = send(updater, file, 1 + (flags >> 2U & 7U) * 130U);
  require(slots.disk()[0] == disk[0] && slots.disk()[1] == disk[1]);
  update::RecordBytes record{};
  require(slots.read(hal::DiskPart::kSlotB, kRoom, record) == Status::kOk);
  const update::Record found = update::read_record(record);
  const bool signed_by_maker =
      found.release && update::is_signed(found.bytes, std::span(&maker.key, 1));
  require((result == SettingsResult::kOk) == signed_by_maker);
  if ((flags & kRevert) != 0 && result != SettingsResult::kOk) {
    require(repeated([&](settings::PagedWriter& why) { return updater.revert({}, why); }) ==
            SettingsResult::kNotSaved);
  }
}

}  // namespace stof
