#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/control/settings_service.h"
#include "firmware/settings/text/paged_writer.h"
#include "firmware/wire/messages/enums.h"

namespace stof::upload {

// What the sensor runs with of one kind; 0: not told.
struct Versions {
  std::uint32_t in_force = 0;
  std::uint32_t former = 0;  // before the last commit or revert of this start
  wire::UploadState state = wire::UploadState::kSettled;
};

// Takes uploads of one kind. For the control thread alone; no heap. Refusals say in one line of
// `why` what is wrong and what to do; nothing has changed then.
class Target {
 public:
  virtual ~Target() = default;

  // An upload of so many bytes, 1 or more, begins; what came of one before is forgotten. kInvalid:
  // too many; kNotSaved: this sensor can keep none.
  virtual wire::SettingsResult begin(std::uint32_t total, settings::PagedWriter& why) noexcept = 0;
  // The bytes behind those of before, never more than `total` in all. kNotSaved. kInvalid: they are
  // no good, which ends it. kBusy: not now, nothing was taken, repeat it.
  virtual wire::SettingsResult write(std::span<const std::byte> bytes,
                                     settings::PagedWriter& why) noexcept = 0;
  // All of them came, with the hash that was told: judges, keeps and uses them. kInvalid: they are
  // no good. kNotSaved. kBusy: not now, repeat it. May block for as long as saving a file takes.
  virtual wire::SettingsResult commit(const firmware::Requester& by,
                                      settings::PagedWriter& why) noexcept = 0;
  // Back to what was there before the first upload. As commit().
  virtual wire::SettingsResult revert(const firmware::Requester& by,
                                      settings::PagedWriter& why) noexcept = 0;
  virtual Versions versions() const noexcept = 0;
  // The bytes of what is in force, valid until the next call of another function here; empty: they
  // cannot be given, as those of most kinds.
  virtual std::span<const std::byte> file_in_force() const noexcept { return {}; }
};

}  // namespace stof::upload
