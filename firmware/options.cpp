#include "firmware/options.h"

#include <charconv>
#include <limits>

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

std::string take_block(std::string_view text, dsp::MatchParams& match) {
  const std::size_t x = text.find('x');
  const auto width = number<int>(text.substr(0, x), 1, dsp::kMaxBlock);
  const auto height = x == std::string_view::npos
                          ? std::nullopt
                          : number<int>(text.substr(x + 1), 1, dsp::kMaxBlock);
  if (!width || !height) {
    return "--block takes WxH with both from 1 to " + std::to_string(dsp::kMaxBlock) +
           ", such as 16x16, not \"" + std::string(text) + "\"";
  }
  match.block_width = *width;
  match.block_height = *height;
  return {};
}

enum class Taken { kNot, kAlone, kWithValue };

Taken take_switch(std::string_view flag, Options& options) {
  if (flag == "--help" || flag == "-h") {
    options.help = true;
  } else if (flag == "--no-lr") {
    options.match.left_right_tolerance.reset();
  } else if (flag == "--no-subpixel") {
    options.match.subpixel = dsp::Subpixel::kWhole;
  } else if (flag == "--no-prefilter") {
    options.match.prefilter_cap.reset();
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
  } else if (flag == "--min-disparity") {
    wrong = take_number(flag, value, -1024, 1024, options.match.min_disparity);
  } else if (flag == "--block") {
    wrong = take_block(value, options.match);
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
    std::string wrong;
    if (take_value(flag, last ? std::string_view() : arguments[i + 1], options, wrong) ==
        Taken::kNot) {
      options.board.push_back(flag);
      continue;
    }
    if (last) {
      return std::unexpected(std::string(flag) +
                             " is the last argument, but takes a value; try --help");
    }
    if (!wrong.empty()) {
      return std::unexpected(wrong);
    }
    ++i;
  }
  return options;
}

std::string_view options_usage() noexcept {
  return "  --frames N           publish N frames, then stop (default: run until stopped)\n"
         "  --period-ms N        time from one trigger edge to the next (default: the board's)\n"
         "  --calibration FILE   calibration of the rig (default: what the board knows)\n"
         "  --disparities N      candidates of the search, 1..256 (default: what the rig asks "
         "for)\n"
         "  --min-disparity N    the first candidate (default 0)\n"
         "  --block WxH          block of the matcher, 1x1..64x64 (default 16x16)\n"
         "  --no-lr              without the left-right check\n"
         "  --no-subpixel        whole disparities\n"
         "  --no-prefilter       match grey values instead of their derivative\n"
         "  --device N           device number in every packet (default 1)\n"
         "  --session N          session number in every packet (default: random)\n"
         "  --help               this text\n";
}

}  // namespace stof::firmware
