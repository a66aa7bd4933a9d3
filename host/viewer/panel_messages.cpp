#include "host/viewer/panel_messages.h"

#include <nlohmann/json.hpp>

namespace stof::viewer {
namespace {

// A sensor's and other programs' text may be no UTF-8.
std::string dump_panel(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

nlohmann::json begun_json(const BegunBy& by) {
  return by.page == 0 ? nlohmann::json(nullptr)
                      : nlohmann::json({{"page", by.page}, {"place", by.place}});
}

}  // namespace

std::string rights_message(const RightsState& state) {
  return dump_panel({{"type", "rights"},
                     {"may", state.why.empty()},
                     {"why", state.why},
                     {"why_not_pair", state.why_not_pair},
                     {"ticket", state.ticket},
                     {"page", state.page}});
}

std::string answer_message(std::uint32_t id, bool done, const std::string& text) {
  return dump_panel({{"type", "answer"}, {"id", id}, {"done", done}, {"text", text}});
}

std::string settings_message(const SettingsState& state) {
  return dump_panel({{"type", "settings"},
                     {"problem", state.problem},
                     {"schema", state.schema},
                     {"active", state.active},
                     {"saved", state.saved},
                     {"defaults", state.defaults},
                     {"role", state.role},
                     {"doubt", state.doubt}});
}

std::string faults_message(const std::vector<FaultState>& devices, const std::string& problem) {
  nlohmann::json all = nlohmann::json::array();
  for (const FaultState& one : devices) {
    all.push_back(
        {{"device", one.device}, {"now", one.now}, {"edges", one.edges}, {"kinds", one.kinds}});
  }
  return dump_panel({{"type", "faults"}, {"devices", all}, {"problem", problem}});
}

std::string recording_message(const RecordingState& state) {
  return dump_panel({{"type", "recording"},
                     {"possible", state.possible},
                     {"on", state.on},
                     {"writing", state.writing},
                     {"file", state.file},
                     {"bytes", state.bytes},
                     {"frames", state.frames},
                     {"dropped", state.dropped},
                     {"seconds", state.seconds},
                     {"problem", state.problem}});
}

std::string playback_message(const PlaybackState& state) {
  return dump_panel({{"type", "playback"},
                     {"playing", state.playing},
                     {"seekable", state.seekable},
                     {"at_ms", state.at_ms},
                     {"length_ms", state.length_ms},
                     {"began_ms", state.began_ms}});
}

std::string pairing_message(const PairingState& state) {
  return dump_panel({{"type", "pairing"},
                     {"offer", state.offer},
                     {"step", state.step},
                     {"by", begun_json(state.by)},
                     {"role", state.role},
                     {"given", state.given},
                     {"ours", state.ours},
                     {"text", state.text}});
}

std::string update_message(const UpdateState& state) {
  nlohmann::json files = nlohmann::json::array();
  for (const ReleaseFile& one : state.files) {
    files.push_back({{"name", one.name}, {"bytes", one.bytes}});
  }
  return dump_panel({{"type", "update"},
                     {"folder", state.folder},
                     {"files", files},
                     {"step", state.step},
                     {"by", begun_json(state.by)},
                     {"file", state.file},
                     {"sent", state.sent},
                     {"total", state.total},
                     {"text", state.text},
                     {"running", state.running},
                     {"other", state.other},
                     {"state", state.state},
                     {"problem", state.problem}});
}

std::string calibration_message(const CalibrationState& state) {
  const auto object = [](const std::string& text) {
    return text.empty() ? nlohmann::json(nullptr) : nlohmann::json::parse(text, nullptr, false);
  };
  return dump_panel({{"type", "calibration"},
                     {"step", state.step},
                     {"by", begun_json(state.by)},
                     {"text", state.text},
                     {"wrong", state.wrong},
                     {"folder", state.folder},
                     {"kept", state.kept},
                     {"look", object(state.look)},
                     {"result", object(state.result)},
                     {"problem", state.problem}});
}

}  // namespace stof::viewer
