#include "dsp/base/thread_team.h"

#include <array>
#include <cstddef>

#include <gtest/gtest.h>

#include "posix/worker_threads.h"

namespace stof::dsp {
namespace {

TEST(Crew, RunsRowsInStripes) {
  posix::WorkerThreads workers({.threads = 3});
  for (const Crew& crew : {Crew(), Crew(workers, 1), Crew(workers, 2), Crew(workers, 99),
                           Crew(workers, 99).first(2)}) {
    for (const Rows rows : {Rows{0, 0}, Rows{0, 1}, Rows{3, 50}, Rows{0, 48}}) {
      for (const int step : {1, 16, 100}) {
        std::array<int, 64> seen{};
        crew.run_rows(rows, step, [&](Rows some, int thread) noexcept {
          EXPECT_LT(thread, crew.threads());
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
  EXPECT_EQ(Crew().threads(), 1);
  EXPECT_EQ(Crew(workers, 99).threads(), 3);
  EXPECT_EQ(Crew(workers, 99).first(2).threads(), 2);
  EXPECT_EQ(Crew(workers, 2).first(99).threads(), 2);
  EXPECT_EQ(Crew().first(99).threads(), 1);
}

}  // namespace
}  // namespace stof::dsp
