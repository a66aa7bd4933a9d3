#pragma once

#include <cstdint>
#include <string>
#include <vector>

// What the page's panels are told, as JSON. docs: docs/VIEWER.md.
namespace stof::viewer {

// To one page, first of all.
struct RightsState {
  std::string why{};           // it may have nothing done; empty: it may, with this ticket
  std::string why_not_pair{};  // it may not pair; empty: it may
  std::string ticket{};
  std::uint64_t page = 0;  // number of its connection, see BegunBy
};
std::string rights_message(const RightsState& state);
std::string answer_message(std::uint32_t id, bool done, const std::string& text);

struct SettingsState {
  std::string problem{};  // one line: why they are not known; empty: they are
  // Documents as the sensor gave them: any bytes.
  std::string schema{};
  std::string active{};
  std::string saved{};
  std::string defaults{};
  // Who changes them: "admin", "tune", "view", by a key; "anybody": without, the harmless ones;
  // "none": the sensor is paired, and no key is there.
  std::string role = "none";
  std::string doubt{};  // one line: no key is used; empty: see role
};
std::string settings_message(const SettingsState& state);

struct FaultState {
  std::string device{};
  std::string now{};        // its fault; "none"
  std::uint64_t edges = 0;  // for how many more; 0: until it is ended, or none
  std::vector<std::string> kinds{};
};
// problem: one line; empty: there is none.
std::string faults_message(const std::vector<FaultState>& devices, const std::string& problem);

struct RecordingState {
  bool possible = false;  // of a sensor, not of a recording
  bool on = false;
  bool writing = false;  // it has ended, but not all of it is written: what came of it is not known
  std::string file{};    // of the last one, too
  std::uint64_t bytes = 0;
  std::uint64_t frames = 0;
  std::uint64_t dropped = 0;  // frames that the disk was too slow for
  double seconds = 0;
  // One line: why the last one ended, and whether a file is left; empty: it was asked to end.
  std::string problem{};
};
std::string recording_message(const RecordingState& state);

struct PlaybackState {
  bool playing = false;
  bool seekable = false;        // the file has an index
  std::uint64_t at_ms = 0;      // of the frame that was shown last, from the begin
  std::uint64_t length_ms = 0;  // 0: not known
  std::uint64_t began_ms = 0;   // Unix
};
std::string playback_message(const PlaybackState& state);

// The connection of a page that began something which takes a while.
struct BegunBy {
  std::uint64_t page = 0;  // 0: nobody has
  std::string place{};     // "this computer", or its address
};

struct PairingState {
  // Why a key can be made here: "unpaired", nobody has one; "no_key", others have, this user has
  // none; empty: he has one, or nobody knows.
  std::string offer{};
  std::string step = "none";  // then "begin", "digits" (are awaited), "accept", "paired", "failed"
  BegunBy by{};               // of this step, as role and what follows
  std::string role{};         // that the key gets: "view", "tune", "admin"
  std::string given{};        // the six digits that were given
  std::string ours{};         // and those of here; only once some were given
  std::string text{};         // one line of what came of it
};
std::string pairing_message(const PairingState& state);

struct ReleaseFile {
  std::string name{};
  std::uint64_t bytes = 0;
};
struct UpdateState {
  std::string folder{};  // of the releases; empty: none was named
  std::vector<ReleaseFile> files{};
  // "none", "sending", "restarting", "trial", "confirmed", "left" (the former one runs again),
  // "failed"
  std::string step = "none";
  BegunBy by{};            // of this step, as file and what follows
  std::string file{};      // empty: the release of the other slot
  std::uint64_t sent = 0;  // bytes that the sensor has
  std::uint64_t total = 0;
  std::string text{};     // one line of what came of it
  std::string running{};  // 8 hexadecimal digits; empty: not known
  std::string other{};    // in the other slot; empty: none
  std::string
      state{};  // of the running one: "settled", "trial", "restarting", "left"; empty: not known
  std::string problem{};  // one line: why that is not known
};
std::string update_message(const UpdateState& state);

struct CalibrationState {
  // "none", "begin", the states of `stof calib stereo --live --json`, "calibrated" (a file is
  // there), "ended" (as asked), "failed", "installing", "installed"
  std::string step = "none";
  BegunBy by{};            // of this step; nobody, too, once that page has gone and it has ended
  std::string text{};      // one line: what to do, or what came of it
  bool wrong = false;      // an install was refused: `text` says why
  std::string folder{};    // of its files
  std::uint64_t kept = 0;  // views of an unfinished one, which the next may go on with
  std::string look{};      // the newest exposure: a JSON object; empty: none
  std::string result{};    // likewise, of the calibration
  std::string problem{};   // one line: why there is no calibration here; empty: there is
};
std::string calibration_message(const CalibrationState& state);

}  // namespace stof::viewer
