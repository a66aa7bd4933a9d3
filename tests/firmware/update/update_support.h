#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <sodium.h>

#include "firmware/update/updater.h"
#include "firmware/wire/bytes.h"
#include "hal/emu/devices/slots.h"

// Makers, their update files, and a sensor on a disk in memory.
namespace stof::test {

using Bytes = std::vector<std::byte>;
using update::Slot;

inline constexpr std::size_t kRoom = 3 * update::kChunkBytes;  // of a slot, beside its record

// A maker whose keys are made of a number: no key of a test is anybody's.
struct Maker {
  explicit Maker(unsigned char number) {
    EXPECT_TRUE(wire::start_crypto());
    std::array<unsigned char, crypto_sign_ed25519_SEEDBYTES> seed{number};
    std::array<unsigned char, crypto_sign_ed25519_PUBLICKEYBYTES> known{};
    crypto_sign_ed25519_seed_keypair(known.data(), secret.data(), seed.data());
    std::ranges::copy(std::as_bytes(std::span(known)), key.begin());
  }
  void sign(Bytes& file) const {
    crypto_sign_ed25519_detached(reinterpret_cast<unsigned char*>(file.data()) + 128, nullptr,
                                 reinterpret_cast<const unsigned char*>(file.data()), 128,
                                 secret.data());
  }

  std::array<unsigned char, crypto_sign_ed25519_SECRETKEYBYTES> secret{};
  wire::PublicKey key{};
};

inline const Maker& maker() {
  static const Maker made(1);
  return made;
}

struct Words {
  std::string_view board = "virt";
  std::string_view camera = "usb";
  std::string_view version = "2.0";
  std::uint32_t counter = 5;
  std::uint32_t letter_at = update::kNoLetter;
};

inline void put_text(Bytes& file, std::size_t at, std::string_view text) {
  std::ranges::copy(std::as_bytes(std::span(text)), file.begin() + static_cast<std::ptrdiff_t>(at));
}

inline std::size_t hashes_of(std::size_t content) {
  return (content + update::kChunkBytes - 1) / update::kChunkBytes * update::kHashBytes;
}

// An update file of that content.
inline Bytes update_file(const Bytes& content, const Words& words = {}, const Maker& by = maker()) {
  Bytes file(update::kReleaseBytes);
  Bytes hashes;
  for (std::size_t at = 0; at < content.size(); at += update::kChunkBytes) {
    const auto chunk = std::span(content).subspan(at);
    const wire::Digest hash =
        wire::digest_of({}, {chunk.first(std::min(chunk.size(), update::kChunkBytes))});
    hashes.insert(hashes.end(), hash.begin(), hash.end());
  }
  const std::span<std::byte> head(file);
  put_text(file, 0, "STOFUPD");
  wire::put_u16(head.subspan<8, 2>(), 1);
  wire::put_u32(head.subspan<12, 4>(), update::kChunkBytes);
  put_text(file, 16, words.board);
  put_text(file, 32, words.camera);
  put_text(file, 48, words.version);
  wire::put_u32(head.subspan<80, 4>(), words.counter);
  wire::put_u32(head.subspan<84, 4>(), static_cast<std::uint32_t>(content.size()));
  wire::put_u32(head.subspan<88, 4>(), words.letter_at);
  std::ranges::copy(wire::digest_of({}, {hashes}), head.subspan(96).begin());
  by.sign(file);
  file.insert(file.end(), hashes.begin(), hashes.end());
  file.insert(file.end(), content.begin(), content.end());
  return file;
}

inline Bytes content_of(std::size_t bytes, unsigned seed) {
  Bytes content(bytes);
  std::uint32_t state = seed * 2'654'435'761U + 1;
  for (std::byte& byte : content) {
    state = state * 1'664'525U + 1'013'904'223U;
    byte = static_cast<std::byte>(state >> 24U);
  }
  return content;
}

// Puts a release into a slot, as scripts/image does.
inline void install(hal::emu::Slots::Disk& disk, Slot slot, const Bytes& content,
                    const Words& words) {
  const Bytes file = update_file(content, words);
  Bytes& to = disk[static_cast<std::size_t>(update::part_of(slot))];
  to.assign(kRoom + update::kRecordBytes, std::byte{0});
  std::ranges::copy(content, to.begin());
  std::copy_n(file.begin(), update::kReleaseBytes,
              to.end() - static_cast<std::ptrdiff_t>(update::kRecordBytes));
}

inline constexpr std::size_t kChoiceAt = 5 * update::kSectorBytes;

// Slot A runs release 1.0 (counter 5); slot B holds 0.9 (counter 5).
inline hal::emu::Slots::Disk disk_of(const Bytes& a, const Bytes& b) {
  hal::emu::Slots::Disk disk;
  disk[0].assign(8 * update::kSectorBytes, std::byte{0x55});
  update::write_choice(update::settled(Slot::kA),
                       std::span(disk[0]).subspan<kChoiceAt, update::kSectorBytes>());
  install(disk, Slot::kA, a, {.version = "1.0"});
  install(disk, Slot::kB, b, {.version = "0.9"});
  return disk;
}

inline std::optional<update::BootChoice> choice_on(const hal::emu::Slots::Disk& disk) {
  return update::read_choice(std::span(disk[0]).subspan<kChoiceAt, update::kSectorBytes>());
}

inline update::UpdaterSetup setup_of(hal::Slots& slots, Slot running) {
  return {.slots = &slots,
          .running = running,
          .can_try = true,
          .board = "virt",
          .keys = std::span(&maker().key, 1)};
}

// One upload, as the server of uploads asks for it: `file` in requests of 960 bytes, each repeated
// while the sensor is busy; `repeats` counts that.
inline wire::SettingsResult send(update::Updater& updater, const Bytes& file, std::string& said,
                                 int* repeats = nullptr) {
  const auto ask = [&](auto&& request) {
    for (int i = 0; i < 1000; ++i) {
      std::array<char, 320> space{};
      settings::PagedWriter why(space);
      const wire::SettingsResult result = request(why);
      said = why.text();
      if (result != wire::SettingsResult::kBusy) {
        return result;
      }
      if (repeats != nullptr) {
        ++*repeats;
      }
    }
    ADD_FAILURE() << "busy for ever";
    return wire::SettingsResult::kBusy;
  };
  wire::SettingsResult result = ask([&](settings::PagedWriter& why) {
    return updater.begin(static_cast<std::uint32_t>(file.size()), why);
  });
  for (std::size_t at = 0; at < file.size() && result == wire::SettingsResult::kOk; at += 960) {
    const auto rest = std::span(file).subspan(at);
    result = ask([&](settings::PagedWriter& why) {
      return updater.write(rest.first(std::min<std::size_t>(rest.size(), 960)), why);
    });
  }
  if (result == wire::SettingsResult::kOk) {
    result = ask([&](settings::PagedWriter& why) { return updater.commit({}, why); });
  }
  return result;
}

// The same where nobody is busy, without a word.
inline wire::SettingsResult send_quietly(update::Updater& updater,
                                         std::span<const std::byte> file) {
  std::array<char, 320> space{};
  settings::PagedWriter why(space);
  wire::SettingsResult result = updater.begin(static_cast<std::uint32_t>(file.size()), why);
  while (!file.empty() && result == wire::SettingsResult::kOk) {
    const std::size_t count = std::min<std::size_t>(file.size(), 960);
    result = updater.write(file.first(count), why);
    file = file.subspan(count);
  }
  for (int i = 0; i < 10 && result == wire::SettingsResult::kOk; ++i) {
    result = updater.commit({}, why);
    if (result != wire::SettingsResult::kBusy) {
      return result;
    }
    result = wire::SettingsResult::kOk;
  }
  return result;
}

inline wire::SettingsResult revert(update::Updater& updater, std::string& said) {
  for (int i = 0; i < 1000; ++i) {
    std::array<char, 320> space{};
    settings::PagedWriter why(space);
    const wire::SettingsResult result = updater.revert({}, why);
    said = why.text();
    if (result != wire::SettingsResult::kBusy) {
      return result;
    }
  }
  ADD_FAILURE() << "busy for ever";
  return wire::SettingsResult::kBusy;
}

}  // namespace stof::test
