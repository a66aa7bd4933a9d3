#include "firmware/options.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "dsp/stereo/match_options.h"

namespace stof::firmware {
namespace {

// Nothing but one decimal number in [low, high].
template <typename T>
std::optional<T> number(std::string_view text, T low, T high) noexcept {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < low || value > high) {
    return std::nullopt;
  }
  return value;
}

// Stores the number, or says what the flag takes.
template <typename To, typename T>
std::string take_number(std::string_view flag, std::string_view text, T low, T high, To& to) {
  const std::optional<T> value = number<T>(text, low, high);
  if (!value) {
    return std::string(flag) + " takes a whole number from " + std::to_string(low) + " to " +
           std::to_string(high) + ", not \"" + std::string(text) + "\"";
  }
  to = *value;
  return {};
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

std::string set_match_option(const dsp::MatchOption& option, std::string_view value,
                             dsp::MatchParams& match) {
  return option.set(value, match)
             ? std::string()
             : "--" + std::string(option.name) + " takes " + std::string(option.values) +
                   ", not \"" + std::string(value) + "\"";
}

// Metres, into quarter millimetres.
std::string take_max_range(std::string_view text, dsp::FusionParams& fusion) {
  constexpr int kMostMm = dsp::kMaxQuarterMm / 4;
  double metres = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), metres);
  if (error != std::errc{} || end != text.data() + text.size() || !(metres >= 0.5) ||
      !(metres * 1000 <= kMostMm)) {
    return "--max-range takes metres from 0.5 to 16.38, not \"" + std::string(text) + "\"";
  }
  fusion.max_range = static_cast<dsp::QuarterMm>(metres * dsp::kQuarterMmPerMetre);
  return {};
}

std::string take_preset(std::string_view name, Options& options) {
  const dsp::Preset* const preset = dsp::find_preset(name);
  if (preset == nullptr) {
    return "--preset takes " + std::string(dsp::preset_names()) + ", not \"" + std::string(name) +
           "\"";
  }
  options.depth.match = dsp::for_depth(*preset);
  return {};
}

enum class Taken { kNot, kAlone, kWithValue };

Taken take_switch(std::string_view flag, Options& options) {
  if (flag == "--help" || flag == "-h") {
    options.help = true;
  } else if (flag == "--guided") {
    options.depth.guided = true;
  } else if (flag == "--temporal") {
    options.depth.temporal = true;
  } else {
    return Taken::kNot;
  }
  return Taken::kAlone;
}

Taken take_value(std::string_view flag, std::string_view value, Options& options,
                 std::string& wrong) {
  constexpr auto kMaxId = std::numeric_limits<std::uint32_t>::max();
  if (flag == "--frames") {
    wrong =
        take_number<std::uint64_t, std::uint64_t>(flag, value, 1, 1'000'000'000, options.frames);
  } else if (flag == "--period-ms") {
    wrong = take_number(flag, value, 1, 60'000, options.period_ms);
  } else if (flag == "--calibration") {
    options.calibration = value;
    wrong = value.empty() ? "--calibration takes a file name" : "";
  } else if (flag == "--device") {
    wrong = take_number<std::uint32_t, std::uint32_t>(flag, value, 0, kMaxId, options.device_id);
  } else if (flag == "--session") {
    wrong = take_number<std::optional<std::uint32_t>, std::uint32_t>(flag, value, 0, kMaxId,
                                                                     options.session_id);
  } else if (flag == "--disparities") {
    wrong = take_number(flag, value, 1, dsp::kMaxDisparities, options.disparities);
  } else if (flag == "--preset") {
    wrong = take_preset(value, options);
  } else if (flag == "--max-range") {
    wrong = take_max_range(value, options.depth.fusion);
  } else {
    return Taken::kNot;
  }
  return Taken::kWithValue;
}

}  // namespace

std::expected<Options, std::string> parse_options(std::span<const std::string_view> arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view flag = arguments[i];
    if (take_switch(flag, options) != Taken::kNot) {
      continue;
    }
    const bool last = i + 1 == arguments.size();
    const std::string_view next = last ? std::string_view() : arguments[i + 1];
    std::string wrong;
    bool with_next = false;
    if (const MatchFlag match = find_match_flag(flag); match.option != nullptr) {
      with_next = !match.value;
      wrong = set_match_option(*match.option, match.value.value_or(next), options.depth.match);
    } else if (take_value(flag, next, options, wrong) == Taken::kWithValue) {
      with_next = true;
    } else {
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
  if (options.depth.match.fill) {
    return std::unexpected("--fill: what is made up is not published: leave it out");
  }
  if (const char* const why = dsp::problem(options.depth.match); *why != '\0') {
    return std::unexpected(std::string(why));
  }
  return options;
}

std::string options_usage() {
  std::string text =
      "  --frames N           publish N frames, then stop (default: run until stopped)\n"
      "  --period-ms N        time from one trigger edge to the next (default: the board's)\n"
      "  --calibration FILE   calibration of the rig (default: what the board knows)\n"
      "  --disparities N      candidates of the search, 1..256 (default: what the rig asks "
      "for)\n"
      "  --preset NAME        how to match: fast (default), quality or chapter, to 1/16 px;\n"
      "                       what follows changes it\n"
      "  --max-range METRES   nothing is further away, 0.5 to 16.38 (default 10)\n"
      "  --guided             PMD intervals narrow the search where they can be trusted\n"
      "  --temporal           depth is averaged over frames where nothing moves\n"
      "  --device N           device number in every packet (default 1)\n"
      "  --session N          session number in every packet (default: random)\n"
      "  --help               this text\n";
  text +=
      "What changes the preset; where the name alone has a meaning a value follows \"=\", such as\n"
      "--lr=2, and --no-NAME is NAME=off:\n";
  for (const dsp::MatchOption& option : dsp::match_options()) {
    if (option.name == "fill") {
      continue;  // refused
    }
    std::string name = "  --" + std::string(option.name);
    name.resize(std::max<std::size_t>(name.size() + 1, 23), ' ');
    text += name + std::string(option.meaning) + ": " + std::string(option.values) + "\n";
  }
  return text;
}

}  // namespace stof::firmware
