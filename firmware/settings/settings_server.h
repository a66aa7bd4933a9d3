#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/control/settings_service.h"
#include "firmware/control/token_bucket.h"
#include "firmware/events/events.h"
#include "firmware/settings/fields/field.h"
#include "firmware/settings/key_ids.h"
#include "firmware/settings/network_trial.h"
#include "firmware/settings/permission.h"
#include "firmware/settings/settings.h"
#include "firmware/settings/text/paged_writer.h"
#include "hal/network_interfaces.h"
#include "hal/store.h"

namespace stof::settings {

// The limits of this board and rig beyond those in the table of fields: workspace, disparities.
class Limits {
 public:
  virtual ~Limits() = default;
  // Whether the sensor can run with them. false: `why` says in a line what is too much, what to do.
  virtual bool accepts(const Settings& settings, PagedWriter& why) noexcept = 0;
};

// Runs with the settings.
class SettingsSink {
 public:
  virtual ~SettingsSink() = default;
  // From now on, or soon. false: not taken, it has not got to the last ones yet.
  virtual bool apply(const Settings& settings, std::uint32_t revision) noexcept = 0;
};

// Whether the fields suit each other, and the limits accept them (nullptr: are not asked).
bool usable(const Settings& settings, Limits* limits, PagedWriter& why) noexcept;

// Keeps the documents active, staged and saved, and answers requests about them. Staged are
// fields and their values: fields that were not staged stay as they are active at the commit. They
// belong to one key (or to the cable): nobody adds to them with another one or commits them.
// Whoever may stage may revert: then whose they were stages and commits nothing until he has
// reverted himself. No heap; for the control thread alone.
class SettingsServer final : public firmware::SettingsService {
 public:
  struct Parts {
    Limits& limits;
    SettingsSink& sink;
    hal::Store* store = nullptr;                   // nullptr: nothing can be saved
    hal::Store* fixed = nullptr;                   // SettingsStores::fixed
    firmware::ChangeRing* changes = nullptr;       // gets each
    NetworkTrial* network = nullptr;               // begun with `active`; nullptr: not the sensor's
    hal::NetworkInterfaces* interfaces = nullptr;  // nullptr: has no addresses to tell
    bool fell_back = false;                        // of load_settings()
    bool dropped = false;  // what is in the store is not `saved`, and of no use
  };

  // Saves that a rest allows, and the time until one more may follow: each writes some tens of
  // kilobytes of flash.
  static constexpr std::uint32_t kMostSaves = 10;
  static constexpr hal::Duration kSaveRefill = std::chrono::minutes(1);

  // active: what the sensor was started with, already applied, as revision 1. saved: what is in the
  // store (load_settings()), which a command line may have changed into active: such a field is not
  // saved before a request has named it.
  SettingsServer(const Settings& active, const Settings& saved, const Parts& parts) noexcept;

  // kDenied: by.access does not do. To stage, commit, revert and save takes kTune, a field what
  // permitted() says. A text longer than `answer_text` is cut off. request_id, cookie: the
  // caller's.
  wire::SettingsAnswer serve(const wire::SettingsRequest& request, std::span<const std::byte> text,
                             const firmware::Requester& by, std::span<std::byte> answer_text,
                             std::size_t& answer_bytes) noexcept override;

  // Takes a change of network.* back that nobody has saved in time. Call some times a second.
  void tick(hal::Time now) noexcept;

  const Settings& active() const noexcept { return active_; }
  std::uint32_t revision() const noexcept { return revision_; }
  // Some of the active settings wait for the next start.
  bool restart_needed() const noexcept;
  // What is in the store, where the sensor runs with it and, but for a command line, nothing else.
  const Settings* saved_in_force() const noexcept;
  // The last attempt to save failed. Never where there is no store: nothing was ever promised.
  bool unsaved() const noexcept { return unsaved_; }
  // Since the last save, or in what was saved, fields were named that are as the preset has them
  // now. Without a file to save to: in the last change.
  bool fell_back() const noexcept { return fell_back_; }
  // What the start found in the store is still there, and of no use.
  bool dropped() const noexcept { return dropped_; }

 private:
  using Result = wire::SettingsResult;

  Result serve(const wire::SettingsRequest& request, std::string_view text,
               const firmware::Requester& by, PagedWriter& out) noexcept;
  Result get(wire::SettingsDocument document, Access access, PagedWriter& out) const noexcept;
  Result stage(std::string_view text, const firmware::Requester& by, PagedWriter& why) noexcept;
  // Whether what is staged is the requester's, or nothing is; says why not.
  bool staged_by(const firmware::Requester& by, std::string_view operation,
                 PagedWriter& why) noexcept;
  void revert(const firmware::Requester& by) noexcept;
  void forget_staged() noexcept;
  // The active ones with these of the staged fields.
  Settings with_staged(const FieldSet& fields) const noexcept;
  // The active ones, without what the command line alone set.
  Settings to_save() const noexcept;
  Status write(const Settings& settings) const noexcept;
  Result commit(const firmware::Requester& by, PagedWriter& why) noexcept;
  Result preset(std::string_view name, const firmware::Requester& by, PagedWriter& why) noexcept;
  Result save(const firmware::Requester& by, PagedWriter& why) noexcept;
  // Whether a change of the network may be saved with `next`; without it, where another asks who
  // may not change it.
  bool confirm_network(const firmware::Requester& by, Settings& next,
                       PagedWriter& why) const noexcept;
  Result change(std::string_view json, const firmware::Requester& by, PagedWriter& why) noexcept;
  Result reset(const firmware::Requester& by, PagedWriter& why) noexcept;
  // Refuses also what falls back and its sender may not set. notes: what falls back.
  static Result read(std::string_view json, const firmware::Requester& by, Settings& next,
                     FieldSet& named, PagedWriter& notes, PagedWriter& why) noexcept;
  // fell_back: something of `next` did, which alone is a change. notes: told where all is well.
  Result become(Settings next, const firmware::Requester& by, bool fell_back, PagedWriter& notes,
                PagedWriter& why) noexcept;
  // Of these, what the requester may set is saved from now on, though a command line set it.
  void name_fields(const FieldSet& fields, const firmware::Requester& by) noexcept;
  bool network_runs() const noexcept { return parts_.network != nullptr && parts_.network->runs(); }
  Settings staged() const noexcept { return with_staged(staged_fields_); }

  Parts parts_;
  Settings started_;  // with which the fields that take a restart are in force
  Settings active_;
  Settings saved_;
  Settings staged_values_{};
  FieldSet staged_fields_{};
  FieldSet staged_by_tune_{};     // of these: not by an admin, and within the limits of then
  std::uint32_t staged_key_ = 0;  // that staged them; 0: none, the cable
  KeyIds losers_;                 // whose staged fields somebody else reverted
  FieldSet overridden_{};         // by the command line, and named by no request since
  std::uint32_t revision_ = 1;
  bool unsaved_ = false;
  bool fell_back_;
  bool staged_fell_back_ = false;
  bool dropped_;
  firmware::TokenBucket saves_{kMostSaves, kSaveRefill};
};

}  // namespace stof::settings
