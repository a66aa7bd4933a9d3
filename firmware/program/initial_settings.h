#pragma once

#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/keys/keyring.h"
#include "firmware/keys/pairing_server.h"
#include "firmware/program/options.h"
#include "firmware/program/run_config.h"
#include "firmware/records/record_disk.h"
#include "firmware/settings/network_trial.h"
#include "firmware/settings/saved_settings.h"
#include "firmware/settings/settings.h"
#include "hal/disk.h"
#include "hal/store.h"

namespace stof::firmware {

// The settings at start: the saved ones, and on top of them those of the command line.
struct InitialSettings {
  // --records: what the stores below are in then.
  std::unique_ptr<hal::Disk> disk;
  std::unique_ptr<records::RecordDisk> records;
  // Of a file, and beside it NAME.good, NAME.trial and NAME.limits; empty: nothing is kept.
  std::unique_ptr<hal::Store> store;
  std::unique_ptr<hal::Store> good;
  std::unique_ptr<hal::Store> trial;
  std::unique_ptr<hal::Store> fixed;
  // Of --keys, and beside it NAME.bad; empty: keys are not kept.
  std::unique_ptr<hal::Store> keys;
  std::unique_ptr<hal::Store> damaged_keys;
  // Beside the settings, NAME.calibration: the one that was put on the sensor.
  std::unique_ptr<hal::Store> calibration;
  // Of --network and --network-done; empty: the network is not ours.
  std::unique_ptr<hal::Store> network_wanted;
  std::unique_ptr<hal::Store> network_done;
  std::optional<settings::NetworkTrial> network;
  std::optional<keys::LabelCode> label;
  settings::StartSettings saved;
  settings::Settings active;
  bool serial_dropped = false;  // the saved line is none of the board's

  settings::SettingsStores stores() const { return {*store, *good, *trial, fixed.get()}; }
};

struct StartRefusal {
  std::string message;  // one line
  bool in_use = false;  // another program keeps something there; else which flag takes what
};

// Opens the store where one is named.
std::expected<InitialSettings, StartRefusal> read_settings(const Options& options);

// The keys that are kept there; says in a line what is wrong with them.
void read_keys(const Options& options, keys::Keyring& ring);

// A command line that is refused says nothing of the saved settings: this start has not failed
// because of them.
void forget_start(const InitialSettings& initial) noexcept;

// The calibration that was put on the sensor.
InstalledCalibration read_installed(const Options& options, const InitialSettings& initial);

// Settings that were saved for another rig must not keep a sensor out of reach, not even together
// with a command line: others hold. What is wrong then is the command line.
void drop_unusable(const RigInfo& rig, const Options& options, InitialSettings& initial);

// Hands network.* to whoever sets the addresses, where there is somebody.
void begin_network(const Options& options, InitialSettings& initial);

// The command line names this setting: it is not what was saved.
bool names(const Options& options, std::string_view path);

}  // namespace stof::firmware
