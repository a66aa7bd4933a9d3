#include "firmware/settings/fields/presets.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace stof::settings {
namespace {

constexpr std::array<SettingsPreset, 5> kPresets{{
    {"indoor",
     "rooms and halls: 10 m; what stands still is averaged, because walls and furniture do",
     R"({"depth": {"max_range_mm": 10000, "guided": false, "temporal": true}})"},
    {"outdoor",
     "as far as depth can be told; nothing is averaged, because leaves, grass and light move",
     R"({"depth": {"max_range_mm": 16380, "guided": false, "temporal": false}})"},
    {"near",
     "docking and handling: 2 m, so that nothing behind can be mistaken for it; the PMD camera, "
     "surest there, narrows the search, which repeating patterns need",
     R"({"depth": {"max_range_mm": 2000, "guided": true, "temporal": true}})"},
    {"fast", "least computation: the highest rate", R"({"depth": {"preset": "fast"}})"},
    {"quality", "densest depth: the search takes several times as long",
     R"({"depth": {"preset": "quality"}})"},
}};

}  // namespace

std::span<const SettingsPreset> presets() noexcept { return kPresets; }

const SettingsPreset* find_preset(std::string_view name) noexcept {
  const auto* const found = std::ranges::find(kPresets, name, &SettingsPreset::name);
  return found == kPresets.end() ? nullptr : found;
}

void write_preset_names(PagedWriter& out) noexcept {
  for (std::size_t k = 0; k < kPresets.size(); ++k) {
    if (k > 0) {
      out << (k + 1 == kPresets.size() ? " or " : ", ");
    }
    out << kPresets[k].name;
  }
}

void write_preset_table(PagedWriter& out) noexcept {
  out << "| preset | sets | for |\n| --- | --- | --- |\n";
  for (const SettingsPreset& preset : kPresets) {
    out << "| `" << preset.name << "` | `" << preset.json << "` | " << preset.meaning << " |\n";
  }
}

}  // namespace stof::settings
