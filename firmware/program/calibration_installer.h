#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/control/token_bucket.h"
#include "firmware/events/events.h"
#include "firmware/program/run_config.h"
#include "firmware/upload/upload_target.h"
#include "hal/store.h"

namespace stof::firmware {

// Puts another calibration in the place of the rig's while the sensor runs, and keeps it for the
// next start; or goes back to the factory's, which is never written. An uploaded file is held in
// memory until it was judged as at start: nothing is written before that, and then the whole at
// once, so that a power cut leaves the one or the other. For the control thread alone; all memory
// is taken at construction.
class CalibrationInstaller final : public upload::Target {
 public:
  // Runs with the rig.
  class Sink {
   public:
    virtual ~Sink() = default;
    // Frames are made with the rig's calibration: nobody uses the one before any more.
    virtual bool rig_in_force() noexcept = 0;
    // Whether the sensor can run with the rig as it is now. kInvalid: `why` says why not. kBusy.
    virtual wire::SettingsResult takes_rig(settings::PagedWriter& why) noexcept = 0;
    // Runs with the rig from now on; it has just been taken.
    virtual void use_rig() noexcept = 0;
  };
  struct Parts {
    RigInfo& rig;       // nobody else changes its calibration
    hal::Store* store;  // of what is installed; nullptr: nothing can be
    ChangeRing* changes;
    Sink& sink;
  };

  // Changes that a rest allows, and the time until one more may follow: each writes some tens of
  // kilobytes of flash.
  static constexpr std::uint32_t kMostChanges = 10;
  static constexpr hal::Duration kRefill = std::chrono::minutes(1);

  explicit CalibrationInstaller(const Parts& parts);

  wire::SettingsResult begin(std::uint32_t total, settings::PagedWriter& why) noexcept override;
  wire::SettingsResult write(std::span<const std::byte> bytes,
                             settings::PagedWriter& why) noexcept override;
  wire::SettingsResult commit(const Requester& by, settings::PagedWriter& why) noexcept override;
  wire::SettingsResult revert(const Requester& by, settings::PagedWriter& why) noexcept override;
  upload::Versions versions() const noexcept override {
    return {.in_force = parts_.rig.fingerprint, .former = former_};
  }

  std::span<const std::byte> file_in_force() const noexcept override;

  // The installed calibration of the start is not used, and still there.
  CalibrationDropped dropped() const noexcept { return parts_.rig.dropped; }

 private:
  // Puts the file's calibration in force once `keep` (whether it is kept as installed) is done.
  wire::SettingsResult change(std::span<const std::byte> file, bool keep, const Requester& by,
                              settings::PagedWriter& why) noexcept;
  Status store(std::span<const std::byte> file, bool keep) noexcept;
  void tell(const Requester& by) noexcept;

  Parts parts_;
  std::vector<std::byte> file_;  // what was uploaded
  std::size_t bytes_ = 0;        // of it
  std::vector<std::byte> installed_;
  std::size_t installed_bytes_ = 0;  // of it; 0: it is not known
  // Of the next calibration; the rig's belongs to the loop.
  std::vector<std::int16_t> next_pattern_;
  std::uint32_t former_ = 0;
  TokenBucket changes_{kMostChanges, kRefill};
};

}  // namespace stof::firmware
