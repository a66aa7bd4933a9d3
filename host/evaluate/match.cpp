#include "host/evaluate/match.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <string_view>

#include "host/evaluate/median.h"

namespace stof::host {
namespace {

using dataset::Problem;
using Judged = std::expected<void, Problem>;

std::unexpected<Problem> refuse(std::string message) {
  return std::unexpected(Problem{std::move(message)});
}

// An option whose first value is the one there is; the others are known and still to come.
Judged judge_choice(std::string_view option, const std::string& value,
                    std::initializer_list<std::string_view> known) {
  if (value == *known.begin()) {
    return {};
  }
  const std::string name(option);
  if (std::ranges::find(known, value) != known.end()) {
    return refuse(name + " " + value + ": not in this version: use " + name + " " +
                  std::string(*known.begin()));
  }
  std::string list;
  for (const std::string_view each : known) {
    list += (list.empty() ? "" : ", ") + std::string(each);
  }
  return refuse(name + " " + value + ": unknown: use one of " + list);
}

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const char* const end = text.data() + text.size();
  const std::from_chars_result result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc{} && result.ptr == end ? std::optional(value) : std::nullopt;
}

Judged read_block(const std::string& text, dsp::MatchParams& params) {
  const std::size_t by = std::min(text.find('x'), text.size());
  const std::optional<int> width = whole_number(std::string_view(text).substr(0, by));
  const std::optional<int> height =
      whole_number(std::string_view(text).substr(std::min(by + 1, text.size())));
  if (!width || !height || *width < 1 || *width > dsp::kMaxBlock || *height < 1 ||
      *height > dsp::kMaxBlock) {
    return refuse("--block " + text + ": not a block size: use WxH from 1x1 to 64x64");
  }
  params.block_width = *width;
  params.block_height = *height;
  return {};
}

Judged judge_options(const MatchOptions& options) {
  if (Judged method = judge_choice("--method", options.method, {"wta", "dp", "so", "sgm", "sa"});
      !method) {
    return method;
  }
  if (Judged cost = judge_choice("--cost", options.cost, {"sad", "ssd", "census5", "census9x7"});
      !cost) {
    return cost;
  }
  if (!options.preset.empty()) {
    return refuse("--preset " + options.preset +
                  ": not in this version: name --method, --cost and --block");
  }
  if (options.fill) {
    return refuse("--fill: not in this version: leave it out");
  }
  if (options.runs < 1) {
    return refuse("--runs " + std::to_string(options.runs) + ": too few: use 1 or more");
  }
  return {};
}

}  // namespace

std::expected<dsp::MatchParams, Problem> match_params(const MatchOptions& options,
                                                      int disparities) {
  if (Judged judged = judge_options(options); !judged) {
    return std::unexpected(std::move(judged.error()));
  }
  dsp::MatchParams params{.disparities = disparities, .subpixel = options.subpixel ? dsp::Subpixel::kEquiangular : dsp::Subpixel::kWhole};
  if (Judged block = read_block(options.block, params); !block) {
    return std::unexpected(std::move(block.error()));
  }
  if (options.left_right) {
    params.left_right_tolerance = kLeftRightTolerancePx;
  }
  return params;
}

std::string describe(const MatchOptions& options) {
  return options.method + ", " + options.cost + " " + options.block +
         (options.left_right ? ", left-right check" : "") + (options.subpixel ? ", subpixel" : "");
}

dataset::Loaded<MatchResult> match_scene(const dataset::StereoScene& scene,
                                         const dsp::MatchParams& params, int runs) {
  const int width = scene.left.width;
  const int height = scene.left.height;
  if (dsp::check(params, width, height) != Status::kOk) {
    return refuse(
        scene.name + ": " + std::to_string(width) + "x" + std::to_string(height) + " pixels with " +
        std::to_string(params.disparities) +
        " disparities are more than this version matches: use a smaller picture or ndisp");
  }
  Workspace workspace(dsp::Matcher::bytes_needed(params, width, height));
  dsp::Arena arena = workspace.arena();
  dsp::Matcher matcher(params, width, height, arena);
  MatchResult result{.disparity = {width, height}};
  result.median_ms = median_time_ms(
      runs, [&] { matcher.match(scene.left.view(), scene.right.view(), result.disparity.view()); });
  return result;
}

double median_time_ms(int runs, const std::function<void()>& work) {
  std::vector<double> times;
  for (int i = 0; i < std::max(runs, 1); ++i) {
    const std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - begin;
    times.push_back(taken.count());
  }
  return median(std::move(times)).value_or(0);
}

Workspace::Workspace(std::size_t bytes) : lines_((bytes + sizeof(Line) - 1) / sizeof(Line)) {}

dsp::Arena Workspace::arena() noexcept {
  return dsp::Arena(std::as_writable_bytes(std::span(lines_)));
}

}  // namespace stof::host
