// campaign_emulated [--seeds N] [--first-seed N] [--kind GROUP:NAME]... [--minutes M] [--verbose]
// The campaign's kinds of faults in emulated time; a JSON object a kind and place.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/base/parse_number.h"
#include "tests/campaign/soak.h"
#include "tests/campaign/trial.h"

namespace {

using namespace stof::campaign;

constexpr std::array kPlaceNames{"start", "steady", "mid-frame"};

struct Options {
  int seeds = 10;
  int first_seed = 1;
  double minutes = 0;  // 0: as long as it takes
  double soak_hours = 0;
  bool verbose = false;
  std::vector<std::string> only;
};

struct Row {
  int runs = 0;
  int effect = 0;
  int in_time = 0;
  int told = 0;
  int healed = 0;
  std::uint64_t false_frames = 0;
  std::uint64_t delivered = 0;
  double worst_detected_ms = 0;
  double worst_told_ms = 0;
  double worst_healed_ms = 0;
  double oldest_ms = 0;

  void add(const Verdict& verdict) {
    ++runs;
    effect += verdict.effect ? 1 : 0;
    in_time += verdict.in_time() ? 1 : 0;
    told += verdict.was_told() ? 1 : 0;
    healed += verdict.healed() ? 1 : 0;
    false_frames += verdict.false_frames();
    delivered += verdict.delivered;
    if (verdict.effect) {
      worst_detected_ms = std::max(worst_detected_ms, verdict.detected_ms.value_or(1e6));
      worst_told_ms = std::max(worst_told_ms, verdict.told_ms.value_or(0));
    }
    worst_healed_ms = std::max(worst_healed_ms, verdict.healed_ms);
    oldest_ms = std::max(oldest_ms, verdict.oldest_ms);
  }
};

void print(const Kind& kind, std::size_t place, const Row& row) {
  std::printf(
      "{\"kind\": \"%s %s\", \"place\": \"%s\", \"runs\": %d, \"effect\": %d, \"in_time\": %d, "
      "\"told\": %d, \"healed\": %d, \"false\": %llu, \"frames\": %llu, \"detected_ms\": %.1f, "
      "\"told_ms\": %.1f, \"healed_ms\": %.1f, \"oldest_ms\": %.1f}\n",
      kind.group, kind.name, kPlaceNames[place], row.runs, row.effect, row.in_time, row.told,
      row.healed, static_cast<unsigned long long>(row.false_frames),
      static_cast<unsigned long long>(row.delivered), row.worst_detected_ms, row.worst_told_ms,
      row.worst_healed_ms, row.oldest_ms);
  std::fflush(stdout);
}

void print_run(const Kind& kind, std::size_t place, std::uint64_t seed, const Verdict& verdict) {
  const bool good =
      verdict.in_time() && verdict.was_told() && verdict.healed() && verdict.false_frames() == 0;
  std::fprintf(stderr,
               "%s %s %s, %s, seed %llu: effect %d, detected %.1f, told %.1f, outage %.1f, healed "
               "%.1f, oldest %.1f ms, false",
               good ? "ok" : "NO", kind.group, kind.name, kPlaceNames[place],
               static_cast<unsigned long long>(seed), verdict.effect ? 1 : 0,
               verdict.detected_ms.value_or(-1), verdict.told_ms.value_or(-1), verdict.outage_ms,
               verdict.healed_ms, verdict.oldest_ms);
  for (std::size_t i = 1; i < kFalsehoods; ++i) {
    std::fprintf(stderr, " %llu", static_cast<unsigned long long>(verdict.falsehoods[i]));
  }
  std::fprintf(stderr, " of %llu\n", static_cast<unsigned long long>(verdict.delivered));
}

bool parse(std::span<char*> arguments, Options& options) {
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::string_view flag = arguments[i];
    if (flag == "--verbose") {
      options.verbose = true;
      continue;
    }
    if (i + 1 == arguments.size()) {
      return false;
    }
    const std::string_view value = arguments[++i];
    const auto number = stof::dsp::parse_number<std::uint32_t>(value);
    if (flag == "--kind") {
      options.only.emplace_back(value);
    } else if (flag == "--seeds" && number) {
      options.seeds = static_cast<int>(*number);
    } else if (flag == "--first-seed" && number) {
      options.first_seed = static_cast<int>(*number);
    } else if (flag == "--minutes" && number) {
      options.minutes = *number;
    } else if (flag == "--soak-minutes" && number) {
      options.soak_hours = *number / 60.0;
    } else {
      return false;
    }
  }
  return true;
}

bool wanted(const Kind& kind, const Options& options) {
  return options.only.empty() ||
         std::ranges::find(options.only, std::string(kind.group) + ":" + kind.name) !=
             options.only.end();
}

void run_kinds(const Options& options) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begun = Clock::now();
  for (const Kind& kind : kinds()) {
    if (!wanted(kind, options)) {
      continue;
    }
    for (std::size_t place = 0; place < kPlaces; ++place) {
      Row row;
      for (int seed = 0; seed < options.seeds; ++seed) {
        const std::chrono::duration<double> spent = Clock::now() - begun;
        if (options.minutes > 0 && spent.count() > 60 * options.minutes) {
          break;
        }
        const auto number = static_cast<std::uint64_t>(options.first_seed + seed);
        const Verdict verdict = run(kind, static_cast<Place>(place), number);
        row.add(verdict);
        if (options.verbose) {
          print_run(kind, place, number, verdict);
        }
      }
      print(kind, place, row);
    }
  }
}

}  // namespace

int main(int count, char** values) {
  Options options;
  if (!parse(std::span(values, static_cast<std::size_t>(count)), options)) {
    std::fputs(
        "campaign_emulated [--seeds N] [--first-seed N] [--minutes N] [--kind GROUP:NAME]... "
        "[--verbose] [--soak-minutes N]\n",
        stderr);
    return 2;
  }
  if (options.soak_hours > 0) {
    return soak(options.soak_hours, static_cast<std::uint64_t>(options.first_seed)) ? 0 : 1;
  }
  if (!check_the_judge()) {
    std::fputs(
        "campaign_emulated: the judge does not see what is planted: its verdicts say nothing\n",
        stderr);
    return 3;
  }
  run_kinds(options);
  return 0;
}
