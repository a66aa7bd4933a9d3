#include "firmware/settings/depth_settings.h"

#include <cstddef>
#include <span>

#include "dsp/base/check.h"
#include "dsp/stereo/match_options.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/fields/field.h"

namespace stof::settings {
namespace {

constexpr std::string_view preset_name(DepthPreset preset) noexcept {
  switch (preset) {
    case DepthPreset::kQuality:
      return "quality";
    case DepthPreset::kChapter:
      return "chapter";
    case DepthPreset::kFast:
      break;
  }
  return "fast";
}

dsp::MatchParams match_params(const DepthSettings& depth) noexcept {
  const dsp::Preset* const preset = dsp::find_preset(preset_name(depth.preset));
  STOF_CHECK(preset != nullptr);
  dsp::MatchParams match = dsp::for_depth(*preset);
  const std::span<const dsp::MatchOption> options = dsp::match_options();
  STOF_CHECK(options.size() <= depth.match.size());
  for (std::size_t slot = 0; slot < options.size(); ++slot) {
    if (const std::string_view text = depth.match[slot].view(); !text.empty()) {
      const bool known = options[slot].set(text, match);
      STOF_CHECK(known);
    }
  }
  return match;
}

}  // namespace

dsp::DepthParams depth_params(const Settings& settings, int rig_disparities) noexcept {
  const DepthSettings& depth = settings.depth;
  dsp::DepthParams params{.match = match_params(depth),
                          .fusion = {},
                          .guided = depth.guided,
                          .temporal = depth.temporal};
  params.fusion.max_range =
      static_cast<dsp::QuarterMm>(depth.max_range_mm * (dsp::kQuarterMmPerMetre / 1000));
  params.fusion.trust = dsp::trust_of(params.match);
  params.match.disparities = depth.disparities > 0 ? depth.disparities : rig_disparities;
  return params;
}

void fit_blocks(Settings& settings, PagedWriter& note) noexcept {
  // Blocks of grey values, and sums that do not fit 16 bits.
  for (const std::string_view name : {"prefilter", "block"}) {
    const dsp::MatchParams match = match_params(settings.depth);
    if (match.search != dsp::Search::kBlocks || dsp::blocks_fit(match) ||
        (match.min_texture && !match.prefilter_cap)) {
      return;
    }
    const auto slot =
        static_cast<std::size_t>(dsp::find_match_option(name) - dsp::match_options().data());
    if (!settings.depth.match[slot].view().empty()) {
      settings.depth.match[slot] = {};
      note_fallback(name == "block" ? "depth.match.block" : "depth.match.prefilter",
                    "sums of such blocks do not fit 16 bits", note);
    }
  }
}

const char* problem(const Settings& settings) noexcept {
  return dsp::problem(match_params(settings.depth));
}

}  // namespace stof::settings
