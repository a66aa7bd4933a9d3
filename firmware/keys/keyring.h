#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/status.h"
#include "firmware/settings/text/paged_writer.h"
#include "firmware/wire/keys/key_table.h"
#include "hal/store.h"

namespace stof::keys {

inline constexpr std::size_t kMostKeys = wire::kMostSensorKeys;

// What the sensor knows of its clients.
enum class Pairing : std::uint8_t {
  kUnpaired,  // there is no key, and never was, or all were removed
  kPaired,
  kLost,  // there are keys that cannot be read: nobody's key is known, and nobody is let in instead
};

// Which secret of a renewed key somebody has shown, while it has two: kNewest also settles it.
enum class Shown : std::uint8_t { kNewest, kFormer };

// The sensor's keys, in memory and where they are kept. What was not saved is not in force. For one
// thread; allocates nothing; wipes what it read and wrote.
class Keyring {
 public:
  // store: nullptr: keys live until the program ends. aside: gets what is in the store where that
  // is damaged and comes to be replaced. Both outlive the ring.
  Keyring(hal::Store* store, hal::Store* aside) noexcept : store_(store), aside_(aside) {}

  // Reads what is kept. `line`: what is wrong with it and what to do, in one line that begins with
  // `place`; else nothing. What cannot be read stays where it is.
  void load(std::string_view place, settings::PagedWriter& line) noexcept;

  // Each also saves. Where keys were lost, the first that comes replaces them, once the old file
  // was copied aside. kInvalidArgument, kTooLarge: as KeyTable::add(), with
  // kMostKeys; kDeviceError, kUnsupported: as hal::Store::save(): nothing has changed.
  Status add(const wire::Key& key) noexcept;
  // kInvalidArgument: there is no such key. Without its last key the sensor is unpaired.
  Status remove(std::uint32_t id) noexcept;
  // The same key with another secret; the one that was shown for it holds too, until settle().
  Status replace(std::uint32_t id, const wire::Secret& secret, Shown shown) noexcept;

  // The new secret of a renewed key has signed: the one of before is none any more. Where that
  // cannot be saved, it is again at the next start.
  void settle(std::uint32_t id) noexcept;

  Pairing pairing() const noexcept;
  const wire::KeyTable& keys() const noexcept { return keys_; }

 private:
  Status become(const wire::KeyTable& next) noexcept;
  Status keep_damaged() noexcept;

  hal::Store* store_;
  hal::Store* aside_;
  wire::KeyTable keys_;
  bool lost_ = false;
  bool damaged_ = false;  // what is in the store is no key file, or not as it was written
};

}  // namespace stof::keys
