#include "tests/bench/bench_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>

#include <benchmark/benchmark.h>
#include <nlohmann/json.hpp>

#include "dsp/base/target.h"

namespace stof::bench {
namespace {

using Times = std::vector<double>;

constexpr double kShortestMs = 2.0;  // of one measurement: more runs of what is over sooner

double at(Times times, double share) {
  std::ranges::sort(times);
  const double place = share * static_cast<double>(times.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, times.size() - 1);
  const double part = place - static_cast<double>(below);
  return times[below] * (1 - part) + times[above] * part;
}

// Keeps the times of every repetition in ms; prints nothing.
class Collector : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type == Run::RT_Iteration) {
        const double count = static_cast<double>(run.iterations) / 1e3;
        real[run.run_name.function_name].push_back(run.real_accumulated_time / count);
        cpu[run.run_name.function_name].push_back(run.cpu_accumulated_time / count);
      }
    }
  }

  std::map<std::string, Times> real;
  std::map<std::string, Times> cpu;
};

// Also warms everything up.
std::int64_t runs_for(const Work& work) {
  using Clock = std::chrono::steady_clock;
  work();
  const Clock::time_point begin = Clock::now();
  work();
  const std::chrono::duration<double, std::milli> taken = Clock::now() - begin;
  return std::clamp<std::int64_t>(std::lround(kShortestMs / std::max(taken.count(), 1e-4)), 1,
                                  100'000);
}

Outcome outcome_of(const Group& group, const Contender& contender, Collector& times) {
  const Times& real = times.real[contender.name];
  Outcome out{.group = group.name,
              .name = contender.name,
              .peer = contender.peer,
              .threads = group.threads,
              .least_ms = at(real, 0),
              .median_ms = at(real, 0.5),
              .cpu_ms = at(times.cpu[contender.name], 0)};
  out.spread = (at(real, 0.75) - at(real, 0.25)) / out.median_ms;
  if (!contender.peer.empty()) {
    out.ratio = out.least_ms / at(times.real[contender.peer], 0);
    out.cpu_ratio = out.cpu_ms / at(times.cpu[contender.peer], 0);
  }
  return out;
}

// As the kernel calls it.
std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "unknown processor";
}

void print(const Outcome& out) {
  std::printf("  %-26s %9.3f %9.3f %7.0f %% %9.3f", out.name.c_str(), out.least_ms, out.median_ms,
              100 * out.spread, out.cpu_ms);
  if (!out.peer.empty()) {
    std::printf("   %5.2f  %5.2f  of %s", out.ratio, out.cpu_ratio, out.peer.c_str());
  }
  std::printf("\n");
}

}  // namespace

std::vector<Outcome> measure(const Group& group, int rounds) {
  benchmark::ClearRegisteredBenchmarks();
  for (const Contender& contender : group.contenders) {
    auto* const one = benchmark::RegisterBenchmark(
        contender.name.c_str(), [&work = contender.work](benchmark::State& state) {
          for ([[maybe_unused]] const auto turn : state) {
            work();
          }
        });
    one->UseRealTime()->Repetitions(rounds)->Iterations(runs_for(contender.work));
    if (group.threads > 1) {
      one->MeasureProcessCPUTime();
    }
  }
  Collector times;
  benchmark::RunSpecifiedBenchmarks(&times, ".*");
  std::printf("%s, %d thread%s\n  %-26s %9s %9s %9s %9s   %5s  %5s\n", group.name.c_str(),
              group.threads, group.threads > 1 ? "s" : "", "", "least ms", "median", "spread",
              "CPU ms", "ratio", "CPU");
  std::vector<Outcome> outcomes;
  for (const Contender& contender : group.contenders) {
    print(outcomes.emplace_back(outcome_of(group, contender, times)));
  }
  std::fflush(stdout);
  return outcomes;
}

Outcome difference(const std::string& name, const Outcome& with, const Outcome& without,
                   const Outcome& peer) {
  Outcome out{.group = with.group,
              .name = name,
              .peer = peer.name,
              .threads = with.threads,
              .least_ms = with.least_ms - without.least_ms,
              .median_ms = with.median_ms - without.median_ms,
              .cpu_ms = with.cpu_ms - without.cpu_ms};
  out.ratio = out.least_ms / peer.least_ms;
  out.cpu_ratio = out.cpu_ms / peer.cpu_ms;
  print(out);
  return out;
}

const char* name_of(dsp::Vectors vectors) {
  switch (vectors) {
    case dsp::Vectors::kAvx512:
      return "AVX-512";
    case dsp::Vectors::kAvx2:
      return "AVX2";
    case dsp::Vectors::kNeon:
      return "NEON source";
    case dsp::Vectors::kRef:
      break;
  }
  return "reference";
}

std::string json(const std::vector<Outcome>& outcomes, int rounds, const std::string& peer) {
  nlohmann::ordered_json root;
  root["machine"] = processor();
  root["rounds"] = rounds;
  root["peer"] = peer;
  root["vectors"] = name_of(dsp::widest_vectors());
  nlohmann::ordered_json& list = root["results"] = nlohmann::ordered_json::array();
  for (const Outcome& out : outcomes) {
    nlohmann::ordered_json entry{{"group", out.group},         {"name", out.name},
                                 {"threads", out.threads},     {"least_ms", out.least_ms},
                                 {"median_ms", out.median_ms}, {"spread", out.spread},
                                 {"cpu_ms", out.cpu_ms}};
    if (!out.peer.empty()) {
      entry["peer"] = out.peer;
      entry["ratio"] = out.ratio;
      entry["cpu_ratio"] = out.cpu_ratio;
    }
    list.push_back(entry);
  }
  return root.dump(1) + "\n";
}

}  // namespace stof::bench
