#include "firmware/program/initial_settings.h"

#include <array>
#include <utility>

#include "firmware/events/event_printer.h"
#include "firmware/settings/saved_settings.h"

namespace stof::firmware {

std::expected<InitialSettings, std::string> read_settings(const Options& options) {
  InitialSettings initial;
  if (!options.settings.empty()) {
    initial.store = board::make_store(options.settings);
    std::array<char, 512> space{};
    settings::PagedWriter line(space);
    initial.saved = settings::load_settings(*initial.store, options.settings, nullptr, line,
                                            &initial.fell_back);
    if (!line.text().empty()) {
      print_line(std::string(line.text()));
    }
  }
  initial.active = initial.saved;
  std::string notes;
  if (std::string why = apply(options.assignments, initial.active, notes); !why.empty()) {
    return std::unexpected(std::move(why));
  }
  if (!notes.empty()) {
    print_line(notes);
  }
  return initial;
}

std::string drop_unusable(const RigInfo& rig, const Options& options, InitialSettings& initial) {
  if (initial.store == nullptr) {
    return {};
  }
  const auto run_config = make_run_config(rig, board::kConfig, initial.saved);
  if (run_config) {
    return {};
  }
  print_line(options.settings +
             ": not for this sensor, set aside, the defaults hold: " + run_config.error());
  static_cast<void>(initial.store->set_aside());  // the next save replaces it in any case
  initial.saved = {};
  initial.active = {};
  initial.fell_back = false;
  std::string told_at_first;
  return apply(options.assignments, initial.active, told_at_first);
}

}  // namespace stof::firmware
