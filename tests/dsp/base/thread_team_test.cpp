#include "dsp/base/thread_team.h"

#include <array>
#include <cstddef>

#include <gtest/gtest.h>

#include "posix/worker_threads.h"

namespace stof::dsp {
namespace {

TEST(ThreadTeam, RunsRowsInStripes) {
  posix::WorkerThreads workers({.threads = 3});
  for (const ThreadTeam& team : {ThreadTeam(), ThreadTeam(workers, 1), ThreadTeam(workers, 2),
                                 ThreadTeam(workers, 99), ThreadTeam(workers, 99).first(2)}) {
    for (const Rows rows : {Rows{0, 0}, Rows{0, 1}, Rows{3, 50}, Rows{0, 48}}) {
      for (const int step : {1, 16, 100}) {
        std::array<int, 64> seen{};
        team.run_rows(rows, step, [&](Rows some, int thread) noexcept {
          EXPECT_LT(thread, team.threads());
          EXPECT_TRUE(some.count() == step || some.end == rows.end);
          for (int y = some.begin; y < some.end; ++y) {
            ++seen[static_cast<std::size_t>(y)];
          }
        });
        for (int y = 0; y < 64; ++y) {
          ASSERT_EQ(seen[static_cast<std::size_t>(y)], y >= rows.begin && y < rows.end ? 1 : 0);
        }
      }
    }
  }
  EXPECT_EQ(ThreadTeam().threads(), 1);
  EXPECT_EQ(ThreadTeam(workers, 99).threads(), 3);
  EXPECT_EQ(ThreadTeam(workers, 99).first(2).threads(), 2);
  EXPECT_EQ(ThreadTeam(workers, 2).first(99).threads(), 2);
  EXPECT_EQ(ThreadTeam().first(99).threads(), 1);
}

}  // namespace
}  // namespace stof::dsp
