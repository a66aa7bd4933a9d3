#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/settings/settings.h"

// stofd's command line. Used once, before the loop.
namespace stof::firmware {

// A setting by its path, and the flag that gave it.
struct Assignment {
  std::string path;
  std::string value;
  std::string flag;
};

struct Options {
  bool help = false;
  bool schema = false;          // print the JSON Schema of the settings
  bool settings_table = false;  // print the tables of docs/SETTINGS.md
  std::uint64_t frames = 0;     // stop after so many; 0: never
  std::string calibration;      // file; empty: the board's own
  std::string settings;         // file; empty: nothing is kept
  std::string first_settings;   // file, for a sensor that never saved any; empty: none
  std::string keys;             // file; empty: SETTINGS.keys, or without settings nothing is kept
  std::string records;          // partition with records in place of those files; empty: none
  std::string label;            // file with the label's code; empty: there is none
  std::string network;          // file that gets network.*; empty: the network is not ours
  std::string network_done;     // and gets the same when they are carried out
  std::string to;               // HOST:PORT that gets packets without asking; empty: none
  std::string slots;            // common name of the disk's partitions; empty: no updates
  std::string slot = "a";       // that this start came from
  std::string update_keys;      // file of makers' public keys; empty: none
  bool no_trial = false;        // this board's kernel cannot start the other slot once
  bool old_loader = false;      // nor can the boot loader of this board
  std::string restart;          // the board, usual or trial, and nothing else; empty: run
  std::string which_slot;       // print the slot that a start takes, usual or trial; empty: run
  std::string port_file;        // gets the number of the UDP port; empty: none
  std::uint32_t device_id = 1;
  std::optional<std::uint32_t> session_id;
  std::optional<std::uint16_t> port;    // UDP, 0: any free one; none: as the settings say
  std::vector<Assignment> assignments;  // in order
  std::vector<std::string_view> board;  // everything that is not ours, in order
};

// Error: one line, what, where and what to do. Views refer to `arguments`.
std::expected<Options, std::string> parse_options(std::span<const std::string_view> arguments);

// Applies the command line's settings. Empty, or which flag takes what; nothing is changed then.
// `notes` names in one line the fields that are as the preset has them, although they are named.
std::string apply(const std::vector<Assignment>& assignments, settings::Settings& settings,
                  std::string& notes);

// One flag per line.
std::string options_usage();

}  // namespace stof::firmware
