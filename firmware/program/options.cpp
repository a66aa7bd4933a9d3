#include "firmware/program/options.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dsp/base/parse_number.h"
#include "dsp/depth/max_range.h"
#include "dsp/stereo/match_options.h"
#include "firmware/settings/depth_settings.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/fields/presets.h"
#include "firmware/settings/text/paged_writer.h"

namespace stof::firmware {
namespace {

// Flags that are settings by another name.
struct Alias {
  std::string_view flag;
  std::string_view path;
  std::string_view alone;  // its value; empty: one follows
};
constexpr std::array<Alias, 9> kAliases{{{"--preset", "preset", ""},
                                         {"--disparities", "depth.disparities", ""},
                                         {"--guided", "depth.guided", "true"},
                                         {"--temporal", "depth.temporal", "true"},
                                         {"--period-ms", "period_ms", ""},
                                         {"--threads", "compute.threads", ""},
                                         {"--name", "name", ""},
                                         {"--serial", "serial.device", ""},
                                         {"--baud", "serial.baud", ""}}};

// Stores the number, or says what the flag takes.
template <typename To, typename T>
std::string take_number(std::string_view flag, std::string_view text, T low, T high, To& to) {
  const std::optional<T> value = dsp::parse_number_in<T>(text, low, high);
  if (!value) {
    return std::string(flag) + " takes a whole number from " + std::to_string(low) + " to " +
           std::to_string(high) + ", not \"" + std::string(text) + "\"";
  }
  to = *value;
  return {};
}

std::string take_text(std::string_view flag, std::string_view text, std::string& to) {
  to = text;
  return text.empty() ? std::string(flag) + " takes a name" : std::string();
}

// --NAME VALUE, --NAME=VALUE, --NAME where that has a meaning, --no-NAME: an option of the matcher.
struct MatchFlag {
  const dsp::MatchOption* option = nullptr;
  std::optional<std::string_view> value;
};

MatchFlag find_match_flag(std::string_view flag) noexcept {
  if (!flag.starts_with("--")) {
    return {};
  }
  flag.remove_prefix(2);
  const std::size_t equals = flag.find('=');
  if (equals != std::string_view::npos) {
    return {dsp::find_match_option(flag.substr(0, equals)), flag.substr(equals + 1)};
  }
  const dsp::MatchOption* const option = dsp::find_match_option(flag);
  if (option != nullptr) {
    return {option, option->alone.empty() ? std::nullopt : std::optional(option->alone)};
  }
  if (flag.starts_with("no-")) {
    return {dsp::find_match_option(flag.substr(3)), "off"};
  }
  return {};
}

// Metres, into millimetres.
std::string take_max_range(std::string_view text, Options& options) {
  static_assert(dsp::kLeastMaxRangeMm == 500 && dsp::kMostMaxRangeMm == 16'380, "as the texts say");
  constexpr double kMmPerMetre = 1000;
  const std::optional<double> metres = dsp::parse_number_in<double>(
      text, dsp::kLeastMaxRangeMm / kMmPerMetre, dsp::kMostMaxRangeMm / kMmPerMetre);
  if (!metres) {
    return "--max-range takes metres from 0.5 to 16.38, not \"" + std::string(text) + "\"";
  }
  options.assignments.push_back({.path = "depth.max_range_mm",
                                 .value = std::to_string(std::lround(*metres * kMmPerMetre)),
                                 .flag = "--max-range"});
  return {};
}

// PATH=VALUE.
std::string take_setting(std::string_view text, Options& options) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    return "--set takes PATH=VALUE, such as streams.depth=raw, not \"" + std::string(text) + "\"";
  }
  options.assignments.push_back({.path = std::string(text.substr(0, equals)),
                                 .value = std::string(text.substr(equals + 1)),
                                 .flag = "--set"});
  return {};
}

bool take_switch(std::string_view flag, Options& options) {
  if (flag == "--help" || flag == "-h") {
    options.help = true;
  } else if (flag == "--schema") {
    options.schema = true;
  } else if (flag == "--settings-table") {
    options.settings_table = true;
  } else if (flag == "--no-trial") {
    options.no_trial = true;
  } else if (flag == "--old-boot-loader") {
    options.old_loader = true;
  } else {
    return false;
  }
  return true;
}

// One of two words.
std::string take_word(std::string_view flag, std::string_view text, std::string_view one,
                      std::string_view other, std::string& to) {
  to = text;
  return text == one || text == other ? std::string()
                                      : std::string(flag) + " takes " + std::string(one) + " or " +
                                            std::string(other) + ", not \"" + to + "\"";
}

// Of a board that is an appliance: updates and addresses. false: not one of them.
bool take_appliance_value(std::string_view flag, std::string_view value, Options& options,
                          std::string& wrong) {
  if (flag == "--slots") {
    wrong = take_text(flag, value, options.slots);
  } else if (flag == "--slot") {
    wrong = take_word(flag, value, "a", "b", options.slot);
  } else if (flag == "--which-slot") {
    wrong = take_word(flag, value, "usual", "trial", options.which_slot);
  } else if (flag == "--restart") {
    wrong = take_word(flag, value, "usual", "trial", options.restart);
  } else if (flag == "--update-keys") {
    wrong = take_text(flag, value, options.update_keys);
  } else if (flag == "--first-settings") {
    wrong = take_text(flag, value, options.first_settings);
  } else if (flag == "--network") {
    wrong = take_text(flag, value, options.network);
  } else if (flag == "--network-done") {
    wrong = take_text(flag, value, options.network_done);
  } else {
    return false;
  }
  return true;
}

// false: not one of ours.
bool take_value(std::string_view flag, std::string_view value, Options& options,
                std::string& wrong) {
  constexpr auto kMaxId = std::numeric_limits<std::uint32_t>::max();
  if (flag == "--frames") {
    wrong =
        take_number<std::uint64_t, std::uint64_t>(flag, value, 1, 1'000'000'000, options.frames);
  } else if (flag == "--calibration") {
    wrong = take_text(flag, value, options.calibration);
  } else if (flag == "--settings") {
    wrong = take_text(flag, value, options.settings);
  } else if (flag == "--keys") {
    wrong = take_text(flag, value, options.keys);
  } else if (flag == "--records") {
    wrong = take_text(flag, value, options.records);
  } else if (flag == "--label") {
    wrong = take_text(flag, value, options.label);
  } else if (flag == "--to") {
    wrong = options.to.empty() ? take_text(flag, value, options.to)
                               : "--to is given twice: others subscribe (stof view SENSOR)";
  } else if (flag == "--port-file") {
    wrong = take_text(flag, value, options.port_file);
  } else if (flag == "--device") {
    wrong = take_number<std::uint32_t, std::uint32_t>(flag, value, 1, kMaxId, options.device_id);
  } else if (flag == "--session") {
    wrong = take_number<std::optional<std::uint32_t>, std::uint32_t>(flag, value, 0, kMaxId,
                                                                     options.session_id);
  } else if (flag == "--port") {
    wrong = take_number<std::optional<std::uint16_t>, std::uint16_t>(flag, value, 0, 65'535,
                                                                     options.port);
  } else if (flag == "--max-range") {
    wrong = take_max_range(value, options);
  } else if (flag == "--set") {
    wrong = take_setting(value, options);
  } else {
    return take_appliance_value(flag, value, options, wrong);
  }
  return true;
}

// A flag that is a setting: what it assigns, the value perhaps still to follow.
struct Setting {
  std::string path;
  std::optional<std::string_view> value;
};

std::optional<Setting> find_setting(std::string_view flag) {
  if (const MatchFlag match = find_match_flag(flag); match.option != nullptr) {
    return Setting{.path = "depth.match." + std::string(match.option->name), .value = match.value};
  }
  const auto* const alias = std::ranges::find(kAliases, flag, &Alias::flag);
  if (alias == kAliases.end()) {
    return std::nullopt;
  }
  return Setting{.path = std::string(alias->path),
                 .value = alias->alone.empty() ? std::nullopt : std::optional(alias->alone)};
}

void add_note(const settings::PagedWriter& note, std::string& notes) {
  notes += notes.empty() || note.text().empty() ? "" : "; ";
  notes += note.text();
}

// A preset of the settings, or of the search alone.
bool assign(const Assignment& assignment, settings::Settings& settings,
            settings::PagedWriter& why) {
  if (assignment.path != "preset") {
    return settings::parse_field(assignment.path, assignment.value, settings, why);
  }
  if (const auto* const preset = settings::find_preset(assignment.value)) {
    return settings::parse(preset->json, settings, why);
  }
  if (assignment.value == "chapter") {
    return settings::parse_field("depth.preset", assignment.value, settings, why);
  }
  why << "takes ";
  settings::write_preset_names(why);
  why << ", or chapter, not \"" << std::string_view(assignment.value) << '"';
  return false;
}

}  // namespace

std::expected<Options, std::string> parse_options(std::span<const std::string_view> arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view flag = arguments[i];
    if (take_switch(flag, options)) {
      continue;
    }
    const bool last = i + 1 == arguments.size();
    const std::string_view next = last ? std::string_view() : arguments[i + 1];
    std::string wrong;
    bool with_next = true;
    if (const std::optional<Setting> setting = find_setting(flag)) {
      with_next = !setting->value;
      options.assignments.push_back({.path = setting->path,
                                     .value = std::string(setting->value.value_or(next)),
                                     .flag = std::string(flag.substr(0, flag.find('=')))});
    } else if (!take_value(flag, next, options, wrong)) {
      options.board.push_back(flag);
      continue;
    }
    if (with_next && last) {
      return std::unexpected(std::string(flag) +
                             " is the last argument, but takes a value; try --help");
    }
    if (!wrong.empty()) {
      return std::unexpected(wrong);
    }
    i += with_next ? 1 : 0;
  }
  return options;
}

std::string apply(const std::vector<Assignment>& assignments, settings::Settings& settings,
                  std::string& notes) {
  settings::Settings changed = settings;
  for (const Assignment& assignment : assignments) {
    std::array<char, settings::kWhyBytes> space{};
    settings::PagedWriter why(space);
    if (!assign(assignment, changed, why)) {
      return assignment.flag + ": " + std::string(why.text());
    }
    add_note(why, notes);
  }
  std::array<char, settings::kWhyBytes> space{};
  settings::PagedWriter note(space);
  settings::fit_blocks(changed, note);
  add_note(note, notes);
  settings = changed;
  return {};
}

std::string options_usage() {
  std::string text =
      "  --frames N           publish N frames, then stop (default: run until stopped)\n"
      "  --calibration FILE   calibration of the rig (default: what the board knows), until stof "
      "calib\n"
      "                       install puts another one there\n"
      "  --settings FILE      settings to start with, and where changed ones are saved; beside it "
      "keys,\n"
      "                       and the installed calibration (FILE.calibration)\n"
      "  --keys FILE          keys of clients (default: the settings' name with .keys behind it)\n"
      "  --records DISK       partition that keeps settings, keys and the installed calibration in "
      "place of\n"
      "                       files: its last 12 MiB; not with --settings or --keys\n"
      "  --label FILE         32 hexadecimal digits of the label, with which clients may pair\n"
      "  --slots PREFIX       disk that this start came from: its partitions are PREFIX1, 2 and 3, "
      "or files\n"
      "                       of these names; stof update writes the slot that does not run\n"
      "  --slot a|b           that runs (default a)\n"
      "  --update-keys FILE   makers' public keys, 64 hexadecimal digits a line\n"
      "  --no-trial           this kernel cannot start the other slot once: no updates\n"
      "  --old-boot-loader    that in this board's EEPROM cannot: no updates\n"
      "  --which-slot WHICH   print the slot of --slots that a start takes, usual or trial, and "
      "end\n"
      "  --restart WHICH      restart the board, usual, or trial: once with the other slot\n"
      "  --first-settings FILE  are saved where none ever were\n"
      "  --network FILE       gets the settings network.*, for a program that may set addresses\n"
      "  --network-done FILE  where that program leaves what it has carried out\n"
      "  --set PATH=VALUE     any setting, such as streams.depth=raw; docs/SETTINGS.md has them "
      "all\n"
      "  --schema             print the JSON Schema of the settings\n"
      "  --port N             UDP port for requests, 0: any free one (default 7560)\n"
      "  --port-file FILE     gets the number of that port\n"
      "  --to HOST:PORT       gets every packet without having subscribed\n"
      "  --serial DEVICE      serial line, with --baud N and --set serial.mode=stof or mavlink\n"
      "  --name TEXT          shown by stof discover\n"
      "  --period-ms N        time from one trigger edge to the next (default: the board's)\n"
      "  --disparities N      candidates of the search, 1..256; 0 (default): what the rig asks "
      "for\n"
      "  --preset NAME        indoor, outdoor or near: where the sensor is; fast (default) or "
      "quality: "
      "how much\n"
      "                       is computed; chapter: as the book chapter matches\n"
      "  --max-range METRES   nothing is further away, 0.5 to 16.38 (default 10)\n"
      "  --guided             PMD intervals narrow the search where they can be trusted\n"
      "  --temporal           frames before count where nothing moves: depth is steadier, and "
      "averaged\n"
      "  --threads N          that compute depth, 1..8; 0 (default): the board's processors, at "
      "most 4\n"
      "  --device N           device number in every packet (default 1)\n"
      "  --session N          session number in every packet (default: random)\n"
      "  --help               this text\n";
  text +=
      "What changes the preset; where the name alone has a meaning a value follows \"=\", such as\n"
      "--lr=2, and --no-NAME is NAME=off:\n";
  for (const dsp::MatchOption& option : dsp::match_options()) {
    std::string name = "  --" + std::string(option.name);
    name.resize(std::max<std::size_t>(name.size() + 1, 23), ' ');
    text += name + std::string(option.meaning) + ": " + std::string(option.values) + "\n";
  }
  return text;
}

}  // namespace stof::firmware
