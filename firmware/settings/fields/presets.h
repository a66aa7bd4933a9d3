#pragma once

#include <span>
#include <string_view>

#include "firmware/settings/text/paged_writer.h"

// Names for settings that belong together. A preset is a JSON text like any other that changes
// settings; what it does not name stays as it is. `indoor`, `outdoor` and `near` say where the
// sensor is and name the same fields, so that each undoes the others; `fast` and `quality` choose
// the matching preset (depth.preset, dsp::Preset) of that name.
namespace stof::settings {

struct SettingsPreset {
  std::string_view name;
  std::string_view meaning;  // one line, with the reason
  std::string_view json;
};

std::span<const SettingsPreset> presets() noexcept;
// nullptr: no preset of that name.
const SettingsPreset* find_preset(std::string_view name) noexcept;
// "indoor, outdoor, near, fast or quality".
void write_preset_names(PagedWriter& out) noexcept;
// The second table of docs/SETTINGS.md (Markdown).
void write_preset_table(PagedWriter& out) noexcept;

}  // namespace stof::settings
