#include "firmware/start_settings.h"

#include <array>
#include <utility>

#include "firmware/settings/fields/assignment.h"
#include "firmware/settings/saved.h"
#include "firmware/teller.h"

namespace stof::firmware {

std::expected<StartSettings, std::string> read_settings(const Options& options) {
  StartSettings start;
  if (!options.settings.empty()) {
    start.store = board::make_store(options.settings);
    std::array<char, 512> space{};
    settings::PagedWriter line(space);
    start.saved = settings::load_settings(*start.store, options.settings, nullptr, line);
    if (!line.text().empty()) {
      say(std::string(line.text()));
    }
  }
  start.active = start.saved;
  if (std::string why = apply(options.assignments, start.active); !why.empty()) {
    return std::unexpected(std::move(why));
  }
  return start;
}

std::string drop_unusable(const RigInFront& rig, const Options& options, StartSettings& start) {
  if (start.store == nullptr) {
    return {};
  }
  const auto plan = make_plan(rig, board::kConfig, start.saved);
  if (plan) {
    return {};
  }
  say(options.settings + ": not for this sensor, set aside, the defaults hold: " + plan.error());
  static_cast<void>(start.store->set_aside());  // the next save replaces it in any case
  start.saved = {};
  start.active = {};
  return apply(options.assignments, start.active);
}

}  // namespace stof::firmware
