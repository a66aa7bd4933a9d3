#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "firmware/update/boot_choice.h"
#include "firmware/update/boot_sector.h"
#include "firmware/update/release.h"
#include "firmware/update/shown.h"
#include "firmware/update/slot_writer.h"
#include "firmware/update/trial.h"
#include "firmware/upload/upload_target.h"
#include "hal/slots.h"

namespace stof::update {

// What a start knows of the disk that it came from.
struct UpdaterSetup {
  hal::Slots* slots = nullptr;  // nullptr: it came from none that can be updated
  Slot running = Slot::kA;
  bool can_try = false;     // this board and kernel can start the other slot once
  bool old_loader = false;  // the boot loader cannot, whatever the kernel
  std::string_view board{};
  std::span<const wire::PublicKey> keys{};  // of makers, any of which may have signed
};

// Which start the board shall make.
enum class Restart : std::uint8_t { kNone, kUsual, kTrial };

// What came of the newest trial.
struct TrialOutcome {
  enum class What : std::uint8_t { kNone, kRuns, kConfirmed, kLeft };

  What what = What::kNone;
  std::uint32_t release = 0;  // its fingerprint

  friend bool operator==(const TrialOutcome&, const TrialOutcome&) = default;
};

// Takes signed releases into the slot that does not run, and judges the running one while it is on
// trial. The head of a file is judged before anything is written, and each chunk before it is
// written. Nothing of the running slot is ever written. For the control thread alone; all memory
// is taken at construction, and blocks there for as long as the medium takes to read three sectors.
class Updater final : public upload::Target {
 public:
  // Largest slot, of chunks.
  static constexpr std::size_t kMostChunks = 4096;
  // Of one call of write().
  static constexpr std::size_t kMostAtOnce = 1024;
  // From the last answer to the restart.
  static constexpr hal::Duration kFarewell = std::chrono::seconds(1);

  explicit Updater(const UpdaterSetup& setup);

  wire::SettingsResult begin(std::uint32_t total, settings::PagedWriter& why) noexcept override;
  wire::SettingsResult write(std::span<const std::byte> bytes,
                             settings::PagedWriter& why) noexcept override;
  // kOk: the other slot is whole, and the sensor restarts with it on trial.
  wire::SettingsResult commit(const firmware::Requester& by,
                              settings::PagedWriter& why) noexcept override;
  // Tries the release in the other slot, where there is one.
  wire::SettingsResult revert(const firmware::Requester& by,
                              settings::PagedWriter& why) noexcept override;
  upload::Versions versions() const noexcept override;

  // Several times a second. period: from frame to frame, of the settings.
  void tick(hal::Time now, const Published& published, hal::Duration period) noexcept;
  // What the board shall do now; stays.
  Restart restart(hal::Time now) const noexcept;
  bool trial_runs() const noexcept { return trial_.has_value(); }
  // Of this start; of the one before where that left its release.
  const TrialOutcome& outcome() const noexcept { return outcome_; }
  // Of the running slot; empty: nobody knows.
  std::string_view version() const noexcept;

 private:
  using Result = wire::SettingsResult;
  // What bytes that come are part of.
  enum class Place : std::uint8_t { kHead, kHashes, kChunks, kEnd };

  Result may_begin(settings::PagedWriter& why) noexcept;
  std::span<std::byte> place() noexcept;
  Result finish_place(settings::PagedWriter& why) noexcept;
  Result judge_head(settings::PagedWriter& why) noexcept;
  Result judge_release(const Release& release, settings::PagedWriter& why) const noexcept;
  Result finish_chunk(settings::PagedWriter& why) noexcept;
  Result keep(const ReleaseBytes& release, settings::PagedWriter& why) noexcept;
  Status go_on_keeping() noexcept;
  void judge_trial(Trial::Verdict verdict) noexcept;
  std::size_t chunk_bytes() const noexcept;
  std::size_t room_of_slot() const noexcept;
  Record load_record(Slot slot) const noexcept;

  UpdaterSetup setup_;
  std::optional<SlotWriter> writer_;
  std::optional<BootSector> sector_;
  std::vector<std::byte> hashes_;
  Record running_;
  std::uint32_t other_ = 0;  // fingerprint of the release in the other slot
  std::optional<Trial> trial_;
  TrialOutcome outcome_;
  ShownLately lately_;
  Shown shown_ = 0;

  // The upload that is under way.
  Place place_ = Place::kEnd;
  ReleaseBytes head_{};
  std::optional<Release> release_;
  std::uint32_t total_ = 0;
  std::size_t filled_ = 0;  // of the place
  std::size_t chunk_ = 0;   // that comes

  RecordBytes record_{};  // while it is written
  enum class Keeping : std::uint8_t { kNot, kChoice, kRecord } keeping_ = Keeping::kNot;
  Restart wish_ = Restart::kNone;
  std::optional<hal::Time> wished_;  // first tick with the wish
};

}  // namespace stof::update
