#pragma once

#include <expected>
#include <memory>
#include <string>

#include "firmware/program/options.h"
#include "firmware/program/run_config.h"
#include "firmware/settings/settings.h"
#include "hal/store.h"

namespace stof::firmware {

// The settings at start: the saved ones, and on top of them those of the command line.
struct InitialSettings {
  std::unique_ptr<hal::Store> store;  // may be empty
  settings::Settings saved;
  settings::Settings active;
  bool fell_back = false;  // of load_settings()
};

// Opens the store where one is named. Error: one line, which flag takes what.
std::expected<InitialSettings, std::string> read_settings(const Options& options);

// Settings that were saved for another rig must not keep a sensor out of reach: they are set aside
// and the defaults hold. Empty, or what is wrong with the command line.
std::string drop_unusable(const RigInfo& rig, const Options& options, InitialSettings& initial);

}  // namespace stof::firmware
