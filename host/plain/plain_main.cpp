// stof_plain SCENE_DIR RUNS [OPTION VALUE]...: the appliance's matcher without its vector kernels.
// Options are those of dsp/stereo/match_options.h. Prints {"ms": median, "map": fingerprint}.
#include <charconv>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "host/evaluate/stereo/match.h"
#include "host/plain/fingerprint.h"

namespace stof::host {
namespace {

using dataset::Problem;

std::expected<MatchOptions, Problem> options_of(std::span<char* const> words) {
  MatchOptions options;
  const std::string_view runs = words.size() < 2 ? "" : words[1];
  const auto parsed = std::from_chars(runs.data(), runs.data() + runs.size(), options.runs);
  if (runs.empty() || words.size() % 2 != 0 || parsed.ec != std::errc() ||
      parsed.ptr != runs.data() + runs.size()) {
    return std::unexpected(Problem{"use: stof_plain SCENE_DIR RUNS [OPTION VALUE]..."});
  }
  for (std::size_t i = 2; i < words.size(); i += 2) {
    options.settings.emplace_back(words[i], words[i + 1]);
  }
  return options;
}

std::expected<std::string, Problem> run(std::span<char* const> words) {
  const std::expected<MatchOptions, Problem> options = options_of(words);
  if (!options) {
    return std::unexpected(options.error());
  }
  const dataset::Loaded<dataset::StereoScene> scene = dataset::read_stereo_scene(words[0]);
  if (!scene) {
    return std::unexpected(scene.error());
  }
  const std::expected<MatchPlan, Problem> plan = match_plan(*options, scene->ndisp);
  if (!plan) {
    return std::unexpected(plan.error());
  }
  const dataset::Loaded<MatchResult> result = match_scene(*scene, *plan);
  if (!result) {
    return std::unexpected(result.error());
  }
  return nlohmann::json{{"ms", result->median_ms}, {"map", fingerprint(result->disparity)}}.dump();
}

}  // namespace
}  // namespace stof::host

int main(int argc, char** argv) {
  const std::span<char* const> words(argv, static_cast<std::size_t>(argc));
  const auto line = stof::host::run(words.subspan(words.empty() ? 0 : 1));
  if (!line) {
    std::fprintf(stderr, "stof_plain: %s\n", line.error().message.c_str());
    return 2;
  }
  std::printf("%s\n", line->c_str());
  return 0;
}
