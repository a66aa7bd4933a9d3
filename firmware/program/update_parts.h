#pragma once

#include <expected>
#include <memory>
#include <string>
#include <vector>

#include "firmware/program/options.h"
#include "firmware/update/updater.h"
#include "hal/slots.h"

namespace stof::firmware {

// What updates need, as the command line names it.
struct UpdateParts {
  std::unique_ptr<hal::Slots> slots;  // empty: there are none
  std::vector<wire::PublicKey> keys;
  update::Slot running = update::Slot::kA;
  bool can_try = false;
  bool old_loader = false;
  std::string note;  // a line for whoever started it: what is missing; empty: nothing

  // Of this object, which outlives it.
  update::UpdaterSetup setup() const;
};

// Opens them where they are named. A disk that cannot be opened is a note: depth does not need it.
// Error: one line, which flag takes what.
std::expected<UpdateParts, std::string> open_update_parts(const Options& options);

// --which-slot: "a" or "b". Error: one line.
std::expected<std::string, std::string> slot_of_start(const Options& options);

}  // namespace stof::firmware
