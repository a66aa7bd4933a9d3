#pragma once

#include <span>
#include <string_view>

#include "dsp/stereo/match_options.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"

// MatchParams by name: the options of the appliance (dsp/stereo/match_options.h) and more.
namespace stof::lab {

struct MatchOption {
  std::string_view name;     // "band"
  std::string_view values;   // "0..256 or off", for a message
  std::string_view meaning;  // one line with the unit
  // The value that the name alone stands for; empty where a value must follow.
  std::string_view alone;
  bool (*own)(std::string_view value, MatchParams& params) = nullptr;
  const dsp::MatchOption* common = nullptr;  // where it is the appliance's

  // false: not one of its values, nothing changed.
  bool set(std::string_view value, MatchParams& params) const noexcept;
};

// In the order of a help text.
std::span<const MatchOption> match_options() noexcept;

// nullptr: no option of that name.
const MatchOption* find_match_option(std::string_view name) noexcept;

}  // namespace stof::lab
