#include "firmware/program/replay_driver.h"

#include <array>
#include <utility>

#include "firmware/settings/fields/document.h"
#include "firmware/settings/text/paged_writer.h"

namespace stof::firmware {
namespace {

// Fields that an earlier version took are as the preset has them: then frames may differ.
std::expected<settings::Settings, std::string> read_recorded(const std::string& document) {
  settings::Settings recorded;
  std::array<char, settings::kWhyBytes> space{};
  settings::PagedWriter why(space);
  if (!settings::parse(document, recorded, why)) {
    return std::unexpected("the recording's settings: " + std::string(why.text()));
  }
  return recorded;
}

// Of the recording what makes frames; who talks to this program, and where, is its own matter.
std::expected<settings::Settings, std::string> together(const settings::Settings& recorded,
                                                        const settings::Settings& own,
                                                        const Options& options) {
  settings::Settings all = own;
  all.depth = recorded.depth;
  all.period_ms = recorded.period_ms;
  all.streams = recorded.streams;
  std::string notes;
  if (std::string why = apply(options.assignments, all, notes); !why.empty()) {
    return std::unexpected(std::move(why));
  }
  return all;
}

}  // namespace

std::expected<settings::Settings, std::string> ReplayDriver::first_settings(
    const board::Replay& replay, const settings::Settings& own, const Options& options) {
  const auto recorded = read_recorded(replay.settings());
  return recorded ? together(*recorded, own, options) : recorded;
}

board::Config ReplayDriver::config(const board::Board& board) {
  board::Config config = board::kConfig;
  if (board.replay != nullptr) {
    config.timing = board.replay->timing(config.timing);
  }
  return config;
}

ReplayDriver::ReplayDriver(board::Replay& replay, const RigInfo& rig, const board::Config& config,
                           const settings::Settings& own, const Options& options)
    : replay_(replay), rig_(rig), config_(config), own_(own), options_(options) {
  if (const auto recorded = read_recorded(replay.settings())) {
    note_streams(*recorded);
  }
}

void ReplayDriver::note_streams(const settings::Settings& recorded) {
  const auto rounded = [&](wire::Stream stream) {
    return recorded.streams.of(stream) == wire::Coding::kQuantised;
  };
  replay_.note_streams({.depth_rounded = rounded(wire::Stream::kDepth),
                        .width_rounded = rounded(wire::Stream::kWidth)});
}

bool ReplayDriver::prepare(Appliance& appliance) {
  if (!replay_.next_edge()) {
    return false;
  }
  const board::Replay::Change change = replay_.take_change();
  if (change.settings) {
    const auto recorded = read_recorded(*change.settings);
    const auto all = recorded ? together(*recorded, own_, options_) : recorded;
    auto run_config = all ? make_run_config(rig_, config_, *all)
                          : std::expected<RunConfig, std::string>(std::unexpected(all.error()));
    if (!run_config) {
      problem_ = run_config.error();
      return false;
    }
    run_config->publisher.revision = ++revision_;
    note_streams(*recorded);
    appliance.apply(*run_config);
  }
  if (change.begins_anew) {
    appliance.begin_anew();
  }
  return true;
}

}  // namespace stof::firmware
