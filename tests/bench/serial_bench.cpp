// stof_serial_bench [PRESET]: the corridor's frame on a serial line. Bytes of each profile, the
// rate that a line carries, and what the sectors take.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <vector>

#include "firmware/serial/serial_sender.h"
#include "tests/firmware/serial/line.h"
#include "tests/firmware/wire/frame/corridor_frame.h"
#include "tests/support/guarded_part.h"

namespace stof::firmware::test {
namespace {

using settings::SerialMode;
using settings::SerialProfile;

constexpr int kRuns = 201;

template <typename Work>
double median_ms(const Work& work) {
  std::vector<double> times;
  for (int i = 0; i < kRuns; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - begin;
    times.push_back(taken.count());
  }
  std::ranges::nth_element(times, times.begin() + kRuns / 2);
  return times[kRuns / 2];
}

void show(SenderBench& bench) {
  const dsp::DepthMap map = bench.map();
  const dsp::Pinhole lens{
      .width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 319.5, .cy = 239.5};
  stof::test::GuardedPart<SectorFinder> finder(
      [&](dsp::Arena& arena) { return SectorFinder(lens, {}, arena); });
  std::printf("sectors %.3f ms, band of 0.3 m", median_ms([&] { finder->find(map); }));
  finder->set({.obstacle = {.above_mm = 10'000, .below_mm = 10'000, .pixels = 8}});
  std::printf("; %.3f ms, all heights\n", median_ms([&] { finder->find(map); }));
}

void measure(SenderBench& bench, const char* name, SerialParams params, std::uint32_t baud) {
  params.mode = SerialMode::kStof;
  params.baud = 12'000'000;
  params.rate_hz = 60;
  bench.sender.set(params);
  static hal::Time now{std::chrono::hours(1)};
  std::vector<std::size_t> bytes;
  std::array<std::byte, 1> one{};
  const double ms = median_ms([&] {
    bench.frame(now);
    while (bench.ring.take(one) > 0) {
    }
    now += std::chrono::milliseconds(100);
  });
  for (int i = 0; i < 11; ++i) {
    bench.drain();
    bench.records.clear();
    bench.frame(now);
    now += std::chrono::milliseconds(100);
    bench.drain();
    std::size_t on_line = 0;
    for (const Bytes& record : bench.records) {
      on_line += hal::cobs_bound(record.size()) + 1;
    }
    bytes.push_back(on_line);
  }
  std::ranges::sort(bytes);
  std::printf("%-24s %6zu bytes  %.3f ms  %5.1f Hz at %u baud\n", name, bytes[5], ms,
              static_cast<double>(baud) / 10 / static_cast<double>(bytes[5]), baud);
}

void run(const char* preset) {
  stof::test::CorridorFrame corridor(preset);
  const dsp::DepthMap map = corridor.images().map;
  SenderBench bench(map.depth.width(), map.depth.height());
  for (int y = 0; y < map.depth.height(); ++y) {
    std::ranges::copy(map.depth.row(y), bench.map().depth.row(y).begin());
    std::ranges::copy(map.width.row(y), bench.map().width.row(y).begin());
  }
  show(bench);
  measure(bench, "sectors", {.profile = SerialProfile::kSectors}, 57'600);
  measure(bench, "coarse", {.profile = SerialProfile::kCoarse}, 921'600);
  measure(bench, "coarse with width", {.profile = SerialProfile::kCoarse, .width = true}, 921'600);
  measure(bench, "medium", {.profile = SerialProfile::kMedium}, 3'000'000);
  measure(bench, "medium with width", {.profile = SerialProfile::kMedium, .width = true},
          3'000'000);
}

}  // namespace
}  // namespace stof::firmware::test

int main(int argc, char** argv) {
  stof::firmware::test::run(argc > 1 ? argv[1] : "fast");
  return 0;
}
