#include "tests/campaign/soak.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>

#include <malloc.h>
#include <unistd.h>

#include "tests/campaign/trial.h"

namespace stof::campaign {
namespace {

using namespace std::chrono_literals;

struct Memory {
  std::size_t heap = 0;      // bytes that are allocated
  std::size_t resident = 0;  // bytes of the process
};

Memory memory_now() {
  std::size_t pages = 0;
  std::size_t resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return {.heap = mallinfo2().uordblks,
          .resident = resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE))};
}

// A fault that begins soon; false: of a kind that only a start can have.
bool strike(World& world, test::Random& random, Plan& plan) {
  const auto all = kinds();
  const auto which = random.between(0, static_cast<int>(all.size()) - 1);
  plan = {.base = world.clock.peek() - 60 * kPeriod};  // where a steady run's faults begin
  all[static_cast<std::size_t>(which)].make(plan, Place::kMidFrame, random);
  if (plan.by != Plan::By::kTime) {
    return false;
  }
  arm(world, plan);
  return true;
}

// Whether every datagram and every frame is counted once, and the sensor tells what it did.
bool counters_true(const World& world) {
  const client::Statistics& seen = world.robot.statistics();
  const RobotCounts& counts = world.robot.counts();
  const std::optional<firmware::Counters> sensor = world.counters();
  return seen.packets() == counts.pushed &&
         seen.frames_complete + seen.frames_incomplete == counts.delivered &&
         (!sensor || (sensor->published <= sensor->edges && sensor->edges <= world.log.count()));
}

void print(const char* what, const World& world, double hours, std::uint64_t faults,
           const Memory& memory) {
  const RobotCounts& counts = world.robot.counts();
  std::printf(
      "{\"soak\": \"%s\", \"hours\": %.3f, \"edges\": %zu, \"delivered\": %llu, \"whole\": %llu, "
      "\"false\": %llu, \"stale\": %llu, \"faults\": %llu, \"oldest_ms\": %.1f, \"heap\": %zu, "
      "\"resident\": %zu}\n",
      what, hours, world.log.count(), static_cast<unsigned long long>(counts.delivered),
      static_cast<unsigned long long>(counts.whole),
      static_cast<unsigned long long>(counts.false_frames()),
      static_cast<unsigned long long>(
          counts.falsehoods[static_cast<std::size_t>(Falsehood::kStale)]),
      static_cast<unsigned long long>(faults),
      std::chrono::duration<double, std::milli>(counts.oldest).count(), memory.heap,
      memory.resident);
  std::fflush(stdout);
}

}  // namespace

bool soak(double hours, std::uint64_t seed) {
  constexpr double kEdgesAnHour = 3600.0 / 0.033;
  World world(kSoakRig, {}, static_cast<std::size_t>(hours * kEdgesAnHour * 1.2) + 10'000, seed);
  const hal::Time begin = world.clock.peek();
  const hal::Time end = begin + std::chrono::duration_cast<hal::Duration>(
                                    std::chrono::duration<double>(hours * 3600));
  // The heap is as large as it gets after some of each.
  const hal::Time settled = begin + (end - begin) / 4;
  hal::Time next_fault = begin + 5s;
  hal::Time next_look = begin + 10s;
  hal::Time next_line = begin + 600s;
  test::Random random(seed);
  std::uint64_t faults = 0;
  std::array<Memory, 2> most{};  // until it has settled, and from then on
  bool counted = true;
  const auto hours_at = [&](hal::Time at) {
    return std::chrono::duration<double>(at - begin).count() / 3600;
  };
  while (world.clock.peek() < end) {
    world.step();
    const hal::Time now = world.clock.peek();
    if (now >= next_fault) {
      Plan plan;
      faults += strike(world, random, plan) ? 1 : 0;
      next_fault = std::max(now, plan.span.end == hal::Time::max() ? now : plan.span.end) +
                   std::chrono::milliseconds(random.between(1500, 15'000));
    }
    if (now >= next_look) {
      next_look += 10s;
      world.robot.forget_records();
      counted = counted && counters_true(world);
      const Memory memory = memory_now();
      Memory& peak = most[now >= settled ? 1 : 0];
      peak = {.heap = std::max(peak.heap, memory.heap),
              .resident = std::max(peak.resident, memory.resident)};
      if (now >= next_line) {
        next_line += 600s;
        print("running", world, hours_at(now), faults, memory);
      }
    }
  }
  // Attacks leave datagrams on their way at any moment; what does not end grows by far more.
  constexpr std::size_t kSlack = std::size_t{4} << 20;
  const bool constant = most[1].resident <= most[0].resident + kSlack;
  print("ended", world, hours, faults, memory_now());
  const bool good = counted && constant && world.robot.counts().false_frames() == 0;
  std::printf(
      "{\"soak\": \"verdict\", \"good\": %s, \"counters_true\": %s, \"memory_constant\": %s, "
      "\"resident_first_quarter\": %zu, \"resident_since\": %zu}\n",
      good ? "true" : "false", counted ? "true" : "false", constant ? "true" : "false",
      most[0].resident, most[1].resident);
  return good;
}

}  // namespace stof::campaign
