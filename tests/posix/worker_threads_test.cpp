#include "posix/worker_threads.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sched.h>

#include "dsp/base/thread_team.h"

namespace stof::posix {
namespace {

// Names of this process's threads.
std::vector<std::string> thread_names() {
  std::vector<std::string> names;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream file(task.path() / "comm");
    for (std::string name; std::getline(file, name);) {
      names.push_back(name);
    }
  }
  return names;
}

// As users of threads run them: through a dsp::ThreadTeam.
void run_parts(WorkerThreads& workers, int parts, int threads, dsp::PartJob job) {
  dsp::ThreadTeam(workers, threads).run(parts, job);
}

void spend(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
}

TEST(WorkerThreads, DoesEveryPartOnceForAnyNumberOfThreadsAndParts) {
  for (int threads = 1; threads <= WorkerThreads::kMost; ++threads) {
    WorkerThreads workers({.threads = threads});
    ASSERT_EQ(workers.threads(), threads);
    ASSERT_EQ(workers.error(), 0);
    for (const int parts : {0, 1, 2, 3, 5, 8, 9, 64, 1000}) {
      for (int used = 1; used <= WorkerThreads::kMost; ++used) {
        std::vector<int> done(static_cast<std::size_t>(parts));
        run_parts(workers, parts, used, [&](int part, int) noexcept {
          ++done[static_cast<std::size_t>(part)];  // not atomic: whoever does it twice is seen
        });
        ASSERT_TRUE(std::ranges::all_of(done, [](int count) { return count == 1; }))
            << threads << " threads, " << used << " used, " << parts << " parts";
      }
    }
  }
}

TEST(WorkerThreads, TwoPartsAtATimeHaveTwoThreads) {
  WorkerThreads workers({.threads = 4});
  for (int used = 1; used <= 4; ++used) {
    std::array<std::atomic<int>, WorkerThreads::kMost> inside{};
    std::atomic<bool> shared{false};
    std::atomic<int> highest{0};
    for (int run = 0; run < 200; ++run) {
      run_parts(workers, 40, used, [&](int, int thread) noexcept {
        std::atomic<int>& mine = inside[static_cast<std::size_t>(thread)];
        shared = shared || mine.fetch_add(1) != 0;
        highest = std::max<int>(highest, thread);
        mine.fetch_sub(1);
      });
    }
    EXPECT_FALSE(shared) << used;
    EXPECT_LT(highest, used);
  }
}

TEST(WorkerThreads, OneThreadGoesThroughPartsInOrder) {
  WorkerThreads workers({.threads = 2});
  std::vector<int> order;
  run_parts(workers, 5, 1, [&](int part, int thread) noexcept {
    EXPECT_EQ(thread, 0);
    order.push_back(part);
  });
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4}));
}

// A caller that waits for a thread that the system does not run would wait for good here.
TEST(WorkerThreads, WhatOneThreadDoesNotBeginOthersTakeOver) {
  WorkerThreads workers({.threads = 2});
  std::atomic<int> others{0};
  run_parts(workers, 16, 2, [&](int part, int) noexcept {
    if (part == 0) {
      while (others.load() < 15) {
        std::this_thread::yield();
      }
    } else {
      others.fetch_add(1);
    }
  });
  EXPECT_EQ(others.load(), 15);
}

TEST(WorkerThreads, WhatAThreadWroteIsThereForTheNextRun) {
  WorkerThreads workers({.threads = 3});
  std::vector<int> from(64, 0);
  std::vector<int> to(64, 0);
  for (int run = 1; run <= 2000; ++run) {
    run_parts(workers, 64, 3, [&](int part, int) noexcept {
      const std::size_t at = static_cast<std::size_t>(part);
      to[at] = from[63 - at] + 1;
    });
    std::swap(from, to);
    ASSERT_TRUE(std::ranges::all_of(from, [&](int value) { return value == run; })) << run;
  }
}

TEST(WorkerThreads, WakesThreadsThatSleep) {
  WorkerThreads workers({.threads = 2});
  for (int run = 0; run < 20; ++run) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    std::array<std::atomic<int>, 2> by{};
    std::atomic<int> begun{0};
    run_parts(workers, 2, 2, [&](int, int thread) noexcept {
      by[static_cast<std::size_t>(thread)].fetch_add(1);
      begun.fetch_add(1);
      while (begun.load() < 2) {  // both parts at once: two threads, or this never ends
        std::this_thread::yield();
      }
    });
    ASSERT_EQ(by[0].load(), 1);
    ASSERT_EQ(by[1].load(), 1);
  }
}

TEST(WorkerThreads, LongAndShortRunsFollowEachOther) {
  WorkerThreads workers({.threads = 4});
  std::atomic<int> done{0};
  int asked = 0;
  for (int run = 0; run < 300; ++run) {
    const int parts = 1 + run * 7 % 13;
    const auto time = std::chrono::microseconds(run % 5 * 10);
    run_parts(workers, parts, 1 + run % 4, [&](int, int) noexcept {
      spend(time);
      done.fetch_add(1);
    });
    asked += parts;
    ASSERT_EQ(done.load(), asked);
  }
}

std::atomic<int> prepared{0};

TEST(WorkerThreads, ThreadsHaveNamesAndArePreparedAndNoneIsMadeLater) {
  prepared = 0;
  const std::size_t before = thread_names().size();
  WorkerThreads workers({.threads = 3, .name = "very-long-name", .prepare = [](int thread) {
                           prepared.fetch_add(1 << thread);
                         }});
  std::atomic<int> begun{0};
  for (int run = 0; run < 10; ++run) {
    begun = 0;
    run_parts(workers, 3, 3, [&](int, int) noexcept {
      begun.fetch_add(1);
      while (begun.load() < 3) {
        std::this_thread::yield();
      }
    });
  }
  EXPECT_EQ(prepared.load(), 2 + 4);
  const std::vector<std::string> names = thread_names();
  EXPECT_EQ(names.size(), before + 2);
  EXPECT_EQ(std::ranges::count(names, "very-long-na-1"), 1);
  EXPECT_EQ(std::ranges::count(names, "very-long-na-2"), 1);
}

TEST(WorkerThreads, ThreadsHaveTheSchedulingOfWhoeverMakesThem) {
  const int policy = sched_getscheduler(0);
  WorkerThreads workers({.threads = 2});
  std::atomic<int> begun{0};
  std::array<int, 2> policies{-1, -1};
  run_parts(workers, 2, 2, [&](int part, int) noexcept {
    policies[static_cast<std::size_t>(part)] = sched_getscheduler(0);
    begun.fetch_add(1);
    while (begun.load() < 2) {
      std::this_thread::yield();
    }
  });
  EXPECT_EQ(policies, (std::array<int, 2>{policy, policy}));
}

TEST(WorkerThreads, WhereTheSystemRefusesThreadsTheCallerDoesAll) {
  WorkerThreads workers(
      {.threads = 4, .stack_bytes = std::size_t{1} << 56});  // nobody has that much
  EXPECT_NE(workers.error(), 0);
  EXPECT_EQ(workers.threads(), 1);
  int done = 0;
  run_parts(workers, 10, 4, [&](int, int thread) noexcept { done += thread == 0 ? 1 : 0; });
  EXPECT_EQ(done, 10);
}

}  // namespace
}  // namespace stof::posix
