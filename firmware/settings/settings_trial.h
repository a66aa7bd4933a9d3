#pragma once

#include <cstdint>
#include <optional>

#include "firmware/settings/saved_settings.h"
#include "hal/time.h"

namespace stof::settings {

// Settings that a start has begun with for the first time, or after a failed start. Once the sensor
// has published frames with them for kProof they are the last good ones. No heap; for one thread,
// which may have to wait for the medium.
class SettingsTrial {
 public:
  static constexpr hal::Duration kProof = std::chrono::seconds(10);

  // settings: of a start that is on trial; load_settings() has counted it.
  SettingsTrial(const SettingsStores& stores, const Settings& settings) noexcept
      : stores_(stores), settings_(settings) {}

  // published: frames since the start. changed: the sensor runs with other settings meanwhile:
  // nothing is proven any more.
  void tick(hal::Time now, std::uint64_t published, bool changed) noexcept;
  // The sensor ends as somebody asked: where it has published anything, that was no failed start.
  void end(std::uint64_t published) noexcept;

 private:
  SettingsStores stores_;
  Settings settings_;
  std::optional<hal::Time> since_;  // the first frame
  std::uint64_t first_ = 0;         // frames then
  bool over_ = false;
};

}  // namespace stof::settings
