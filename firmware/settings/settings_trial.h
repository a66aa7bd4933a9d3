#pragma once

#include <cstdint>
#include <optional>

#include "firmware/settings/saved_settings.h"
#include "hal/time.h"

namespace stof::settings {

// Saved settings that have not proven good yet: those of a start, and those that are saved later.
// Once the sensor has published frames with them for kProof they are the last good ones. No heap;
// for one thread, which may have to wait for the medium.
class SettingsTrial {
 public:
  static constexpr hal::Duration kProof = std::chrono::seconds(10);

  // settings: what load_settings() gave. proven: they are not on trial; else it has counted the
  // start.
  SettingsTrial(const SettingsStores& stores, const Settings& settings, bool proven) noexcept
      : stores_(stores), settings_(settings), proven_(proven) {}

  // published: frames since the start. in_force: the saved settings, which the sensor runs with;
  // nullptr: it runs with others, or some of them wait for the next start: nothing is proven
  // meanwhile.
  void tick(hal::Time now, std::uint64_t published, const Settings* in_force) noexcept;
  bool proven() const noexcept { return proven_; }
  // The sensor ends as somebody asked: where it has published anything, that was no failed start.
  void end(std::uint64_t published) noexcept;

 private:
  SettingsStores stores_;
  Settings settings_;
  bool proven_;
  std::optional<hal::Time> since_;  // the first frame with them
  std::uint64_t first_ = 0;         // frames then
};

}  // namespace stof::settings
