#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "posix/worker_threads.h"
#include "tests/firmware/appliance_rig.h"
#include "tests/support/heap_guard.h"

namespace stof::firmware::test {
namespace {

using stof::test::heap_forbidden;

// The test's own parts allocate as they like; what is forbidden is forbidden inside step().
Status step_without_heap(Loop& loop) {
  heap_forbidden = true;
  const Status status = loop.step();
  heap_forbidden = false;
  return status;
}

Status step_without_heap(Appliance& appliance) {
  heap_forbidden = true;
  const Status status = appliance.step({});
  heap_forbidden = false;
  return status;
}

constexpr hal::Peer kReceiver{.address = {}, .port = 1};

// Threads that may never allocate once they are there.
posix::WorkerThreads::Params heapless(int threads) {
  return {.threads = threads, .prepare = [](int) { heap_forbidden = true; }};
}

// Faults of every kind, again and again.
Faults all_faults() {
  const auto some = [](std::uint32_t first) {
    std::array<emu::Fault, 6> faults{};
    for (std::uint32_t i = 0; i < faults.size(); ++i) {
      faults[i] = {
          .kind = emu::kAllFaultKinds[i], .call = first + 40 * i, .every = 240, .duration = 40ms};
    }
    return emu::FaultPlan{faults[0], faults[1], faults[2], faults[3], faults[4], faults[5]};
  };
  return {.trigger = some(7), .stereo = some(17), .pmd = some(27), .link = some(31)};
}

void run_without_heap(dsp::ThreadTeam threads, std::uint64_t frames,
                      DeviceLending* lending = nullptr) {
  Rig rig({.faults = all_faults(), .threads = threads, .lending = lending});
  rig.log.edges.reserve(2 * frames);
  // One receiver, whose datagrams are signed, and that gets raw pictures.
  rig.publisher.set_receivers({.peers = {kReceiver},
                               .keys = {wire::StreamKey{.number = 1}},
                               .count = 1,
                               .raw_receiver = 0,
                               .raw = {.pictures = wire::kRawPictures, .every = 2}});
  std::uint64_t steps = 0;
  std::uint64_t lost = 0;
  while (rig.events.counters.published < frames && steps < frames + frames / 2) {
    lost += step_without_heap(rig.loop) == Status::kDeviceLost ? 1U : 0U;
    while (rig.port.take_sent()) {
    }
    while (rig.events.take()) {
    }
    ++steps;
  }
  EXPECT_EQ(rig.events.counters.published, frames);
  // The faults were there.
  EXPECT_GT(lost, frames / 200);
  EXPECT_GT(of(rig.events.counters.stereo_dropped, Drop::kTorn), frames / 500);
  EXPECT_GT(of(rig.events.counters.pmd_dropped, Drop::kStale), frames / 500);
}

TEST(NoHeap, TenThousandFramesWithFaultsOfEveryKindAllocateNothing) {
  run_without_heap({}, 10'000);
}

TEST(NoHeap, NoThreadAllocatesWhereSeveralCompute) {
  for (const int threads : {2, 4}) {
    posix::WorkerThreads workers(heapless(threads));
    ASSERT_EQ(workers.threads(), threads);
    run_without_heap({workers, threads}, 2'000);
  }
}

TEST(NoHeap, LendingLostDevicesAllocatesNothing) {
  DeviceLending lending(true);
  std::thread opener([&] {
    heap_forbidden = true;
    while (const auto device = lending.wait_for_lent()) {
      lending.give_back(*device);
    }
    heap_forbidden = false;
  });
  run_without_heap({}, 2'000, &lending);
  lending.end();
  opener.join();
}

std::ptrdiff_t threads_there() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return std::distance(begin(tasks), end(tasks));
}

TEST(NoHeap, NewCalibrationsAllocateNothing) {
  ApplianceRig box(true);
  box.rig.log.edges.reserve(1'000);
  box.subscribe(1);
  RunConfig run_config = small_run_config();
  for (std::uint32_t install = 1; install <= 100; ++install) {
    run_config.installs = install;
    run_config.setup.calibration.stereo.baseline_m *= install % 2 == 0 ? 0.5 : 2;
    const auto packet = wire::make_calibration_packet(run_config.setup.calibration, 40'000,
                                                      timing().period.count());
    ASSERT_TRUE(packet);
    run_config.calibration = *packet;
    ASSERT_TRUE(box.run_configs.push(run_config));
    for (int step = 0; step < 4; ++step) {
      static_cast<void>(step_without_heap(box.appliance));
      while (box.rig.port.take_sent()) {
      }
    }
    ASSERT_EQ(box.appliance.installs(), install);
  }
  EXPECT_GE(box.rig.events.counters.published, 300U);
}

TEST(NoHeap, NewWaysToComputeAllocateNothingAndLeaveNoThread) {
  const std::ptrdiff_t before = threads_there();
  {
    posix::WorkerThreads workers(heapless(4));
    ApplianceRig box(false, {workers, 4});
    box.rig.log.edges.reserve(2'000);
    box.subscribe(1);
    RunConfig run_config = small_run_config();
    for (int change = 0; change < 200; ++change) {
      const bool quality = change % 3 == 0;
      run_config.setup.depth.match =
          dsp::for_depth(*dsp::find_preset(quality ? "quality" : "fast"));
      run_config.setup.depth.match.disparities = kDisparities;
      run_config.setup.threads = 1 + change * 3 % 4;
      run_config.timing.period = change % 5 == 0 ? 40ms : 33ms;
      ASSERT_TRUE(box.run_configs.push(run_config));
      for (int step = 0; step < 4; ++step) {
        static_cast<void>(step_without_heap(box.appliance));
        while (box.rig.port.take_sent()) {
        }
      }
    }
    EXPECT_GE(box.rig.events.counters.published, 500U);
    EXPECT_EQ(threads_there(), before + 3);
  }
  for (int wait = 0; wait < 60'000 && threads_there() != before;
       ++wait) {  // the system takes a while
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_EQ(threads_there(), before);
}

// That the trap springs: through every door of the allocator.
template <typename Allocate>
void expect_death(const char* how, Allocate allocate) {
  EXPECT_DEATH(
      {
        heap_forbidden = true;
        allocate();
        heap_forbidden = false;
      },
      how);
}

void* volatile kept = nullptr;  // so that no allocation is left out

TEST(NoHeapDeathTest, EveryWayToAllocateIsCaught) {
  expect_death("malloc", [] { kept = std::malloc(10); });
  expect_death("calloc", [] { kept = std::calloc(2, 5); });
  void* const block = std::malloc(10);
  expect_death("realloc", [block] { kept = std::realloc(block, 1000); });
  std::free(block);
  expect_death("aligned_alloc", [] { kept = std::aligned_alloc(64, 64); });
  expect_death("operator new", [] { kept = new int; });
  expect_death("operator new", [] { kept = new int[20]; });
  expect_death("operator new", [] { kept = new (std::nothrow) int; });
  expect_death("operator new", [] { kept = new dsp::Arena({}); });
  expect_death("operator new", [] { kept = new std::string(100, 'x'); });
}

TEST(NoHeapDeathTest, AnAllocationOfAHelperIsCaught) {
  EXPECT_DEATH(
      {
        posix::WorkerThreads workers(heapless(2));
        std::atomic<bool> helped{false};
        dsp::ThreadTeam(workers, 2).run(2, [&](int part, int thread) noexcept {
          if (thread != 0) {
            kept = std::malloc(10);
            helped = true;
          }
          while (part == 0 && thread == 0 && !helped) {  // the other part is the helper's
          }
        });
      },
      "a thread that must not allocates: malloc");
}

// A device whose adapter allocates in the loop.
class AllocatingPort final : public hal::DatagramPort {
 public:
  Status send(const hal::Peer&, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override {
    const std::vector<std::byte> copy(datagrams[0].begin(), datagrams[0].end());
    kept = const_cast<std::byte*>(copy.data());
    sent = datagrams.size();
    return Status::kOk;
  }
  Result<hal::Received> receive(std::span<std::byte>, hal::Duration) noexcept override {
    return fail(Status::kTimeout);
  }
  std::uint64_t overruns() const noexcept override { return 0; }
  bool take_unreachable(hal::Peer&) noexcept override { return false; }
  std::uint16_t port() const noexcept override { return 1; }
};

TEST(NoHeapDeathTest, AnAllocationDeepInsideAStepIsCaught) {
  EXPECT_DEATH(
      {
        AllocatingPort port;
        Rig rig({.port = &port});
        for (int i = 0; i < 3; ++i) {
          static_cast<void>(step_without_heap(rig.loop));
        }
      },
      "a thread that must not allocates: operator new");
}

}  // namespace
}  // namespace stof::firmware::test
