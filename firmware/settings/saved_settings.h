#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/settings/settings.h"
#include "firmware/settings/settings_server.h"
#include "firmware/settings/text/paged_writer.h"
#include "hal/store.h"

// What a start begins with. Nothing that was saved keeps a sensor from starting.
namespace stof::settings {

// Where settings are kept.
struct SettingsStores {
  hal::Store& current;  // of the next start; the only one that requests write
  hal::Store& good;     // that proved good last (SettingsTrial)
  hal::Store& trial;    // how many starts with the current ones have not proven them
  // What an installer fixed last, limits.*, network.* and serial.remote: it outlives settings that
  // cannot be used. nullptr: nothing is kept of it.
  hal::Store* fixed = nullptr;
};

// Why a start does not begin with the current settings; the value of condition `settings_dropped`.
enum class Dropped : std::uint8_t {
  kNot,
  kMissing,       // there are good ones, but no current ones any more
  kNoFile,        // a folder, a device or a link has their name: nothing can be saved
  kUnreadable,    // they stay where they are: nothing can be saved
  kEmpty,         // set aside, as the next
  kUnusable,      // damaged, of a later version, or not for this sensor
  kFailedStarts,  // as many starts as may be have not proven them; they stay until the next save
};

struct StartSettings {
  Settings settings{};
  Dropped dropped = Dropped::kNot;
  bool good = false;       // they are the last good ones; with `dropped` else the defaults
  bool fell_back = false;  // fields that this version does not take any more are as the preset
  bool on_trial = false;   // these starts are counted until they have proven good
  bool strictest = false;  // with `dropped`: nobody knows any more what an installer fixed
};

// A start that ended, or was reset, before it proved new settings good is a failed one.
inline constexpr int kMaxFailedStarts = 2;

// The current settings, fields that they do not name at their defaults; the defaults where nothing
// was ever saved; the last good ones, else the defaults, where the current ones cannot be used.
// `line` says so in one line that begins with `place`, such as the file's name; it names fields
// that fell back, too, and what keeps the start from being counted. limits: nullptr: are not asked.
// Counts the start where it is on trial, and writes nothing where the current settings are the last
// good ones.
StartSettings load_settings(const SettingsStores& stores, std::string_view place, Limits* limits,
                            PagedWriter& line) noexcept;
// The same for current settings that load_settings() took before the limits were known.
StartSettings reload_settings(const SettingsStores& stores, std::string_view place, Limits& limits,
                              PagedWriter& line) noexcept;

// A document that somebody put beside a sensor before its first start: where nothing was ever saved
// it is saved now, as if he had done so. Any text, of some or all fields. `line`: that it was
// taken, or why not; empty: something was saved before.
void save_first(const SettingsStores& stores, std::string_view text, std::string_view place,
                PagedWriter& line) noexcept;

// What an installer fixed (limits.*, network.*, serial.remote), as it was saved last, into settings
// that hold in place of the saved ones. false: that is not known: the line counts as remote, for
// all but an admin the range, the period and the streams stay as they are, and the network is as
// it is in `settings`.
bool keep_fixed(const SettingsStores& stores, Settings& settings) noexcept;
// Writes nothing where the record says so already.
Status save_fixed(hal::Store& fixed, const Settings& settings) noexcept;

// How many starts with these settings have failed.
int failed_starts(hal::Store& trial, const Settings& settings) noexcept;
Status count_failed_starts(hal::Store& trial, const Settings& settings, int count) noexcept;
// One whole document.
Status save_document(hal::Store& store, const Settings& settings) noexcept;

}  // namespace stof::settings
