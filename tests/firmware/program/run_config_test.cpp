#include "firmware/program/run_config.h"

#include <chrono>
#include <string>

#include <gtest/gtest.h>

#include "firmware/events/health_monitor.h"
#include "firmware/events/log_text.h"
#include "firmware/settings/depth_settings.h"
#include "firmware/workspace.h"

namespace stof::firmware {
namespace {

constexpr std::size_t kMemory = sizeof(Workspace::memory);

// The largest pictures that the board takes: its workspace is for one search of these.
RigInfo rig_of(int pmd_width, int pmd_height) {
  const board::StereoConfig& stereo = board::kConfig.stereo;
  RigInfo rig{.calibration = {},
              .fixed_pattern = {},
              .factory = {},
              .needs = {},
              .disparities = stereo.disparities,
              .threads = dsp::ThreadTeam::kMost};
  rig.calibration.stereo = {.left = {.width = stereo.width,
                                     .height = stereo.height,
                                     .fx = 1000,
                                     .fy = 1000,
                                     .cx = stereo.width / 2.0,
                                     .cy = stereo.height / 2.0},
                            .baseline_m = 0.1};
  rig.calibration.pmd.lens = {.width = pmd_width,
                              .height = pmd_height,
                              .fx = 500,
                              .fy = 500,
                              .cx = pmd_width / 2.0,
                              .cy = pmd_height / 2.0};
  return rig;
}

settings::Settings quality() {
  settings::Settings settings;
  settings.depth.preset = settings::DepthPreset::kQuality;
  return settings;
}

std::size_t bytes_of(firmware::Setup setup, int threads) {
  setup.threads = threads;
  return dsp::bytes_taken(
      [&](dsp::Arena& arena) { Pipeline(setup, arena, dsp::ThreadTeam::standing_for(threads)); });
}

TEST(MakePlan, TakesAsManyThreadsAsThereIsMemoryFor) {
  const RigInfo all = rig_of(board::kConfig.pmd.width, board::kConfig.pmd.height);
  int fewer = 0;
  for (int there = 1; there <= dsp::ThreadTeam::kMost; ++there) {
    RigInfo rig = all;
    rig.threads = there;
    const auto run_config = make_run_config(rig, board::kConfig, quality());
    ASSERT_TRUE(run_config) << run_config.error();
    const int threads = run_config->setup.threads;
    ASSERT_GE(threads, 1);
    ASSERT_LE(threads, there);
    EXPECT_EQ(run_config->image_bytes, bytes_of(run_config->setup, threads));
    EXPECT_LE(run_config->image_bytes, kMemory);
    if (threads < there) {
      EXPECT_GT(bytes_of(run_config->setup, threads + 1), kMemory) << "one more would have fitted";
      ++fewer;
    }
  }
  EXPECT_GT(fewer, 0) << "a board with memory for all of them shows nothing";
}

TEST(MakePlan, TakesAllThreadsWhereThereIsMemoryForThem) {
  RigInfo rig = rig_of(0, 0);
  rig.calibration.stereo.left.width = 320;
  rig.calibration.stereo.left.height = 200;
  rig.disparities = 32;
  for (int there = 1; there <= dsp::ThreadTeam::kMost; ++there) {
    rig.threads = there;
    const auto run_config = make_run_config(rig, board::kConfig, quality());
    ASSERT_TRUE(run_config) << run_config.error();
    EXPECT_EQ(run_config->setup.threads, there);
  }
}

TEST(MakePlan, RefusesNothingThatTheBoardsTableAllows) {
  const RigInfo rig = rig_of(board::kConfig.pmd.width, board::kConfig.pmd.height);
  for (const settings::DepthPreset preset :
       {settings::DepthPreset::kFast, settings::DepthPreset::kQuality}) {
    settings::Settings settings;
    settings.depth.preset = preset;
    settings.depth.guided = true;
    settings.depth.temporal = true;
    const auto run_config = make_run_config(rig, board::kConfig, settings);
    EXPECT_TRUE(run_config) << run_config.error();
  }
}

// Searches of one kind that take more and more of less memory than the board's: as many threads as
// fit, then one, then a refusal.
TEST(MakePlan, RefusesOnlyWhatOneThreadHasNoMemoryFor) {
  RigInfo rig = rig_of(board::kConfig.pmd.width, board::kConfig.pmd.height);
  settings::Settings settings = quality();
  settings.depth.guided = true;
  settings.depth.temporal = true;
  constexpr std::size_t kRoom = kMemory / 3 * 2;
  int alone = 0;
  int refused = 0;
  for (int width = 16; width <= board::kConfig.pmd.width; width += 16) {
    for (int height = 16; height <= board::kConfig.pmd.height; height += 16) {
      rig.calibration.pmd.lens.width = width;
      rig.calibration.pmd.lens.height = height;
      firmware::Setup setup{.calibration = rig.calibration,
                            .depth = settings::depth_params(settings, rig.disparities)};
      const std::size_t one = bytes_of(setup, 1);
      const auto run_config = make_run_config(rig, board::kConfig, settings, kRoom);
      ASSERT_EQ(run_config.has_value(), one <= kRoom) << width << "x" << height;
      if (run_config) {
        alone += run_config->setup.threads == 1 ? 1 : 0;
        continue;
      }
      ++refused;
      const std::string figure = "takes " + std::to_string(one / kMiB + 1) + " MiB, board " +
                                 board::kConfig.name + " has " + std::to_string(kRoom / kMiB) +
                                 ": use fewer disparities";
      ASSERT_NE(run_config.error().find(figure), std::string::npos) << run_config.error();
    }
  }
  EXPECT_GT(alone, 0);
  EXPECT_GT(refused, 0);
}

TEST(ThreadsText, SaysHowManyComputeAndWhyNotMore) {
  EXPECT_EQ(threads_text(1, 1), "1 thread");
  EXPECT_EQ(threads_text(4, 4), "4 threads");
  EXPECT_EQ(threads_text(1, 8), "1 thread (of 8: there is no memory for more searches)");
  EXPECT_EQ(threads_text(3, 4), "3 threads (of 4: there is no memory for more searches)");
}

// Threads are made once: a setting that comes later waits for the next start.
TEST(MakePlan, RefusesAPeriodThatTheCamerasOrTheWatchdogCannotFollow) {
  RigInfo rig = rig_of(0, 0);
  rig.calibration.stereo.left.width = 320;
  rig.calibration.stereo.left.height = 200;
  rig.disparities = 32;
  rig.least_period = std::chrono::milliseconds(40);
  settings::Settings settings;
  settings.period_ms = 39;
  const auto fast = make_run_config(rig, board::kConfig, settings);
  ASSERT_FALSE(fast);
  EXPECT_NE(fast.error().find("need 40 ms"), std::string::npos) << fast.error();
  settings.period_ms = 40;
  EXPECT_TRUE(make_run_config(rig, board::kConfig, settings));

  // Shorter than the exposure: the number that is told is the shortest that is taken.
  rig.least_period = {};
  settings.period_ms = 1;
  const auto shortest = make_run_config(rig, board::kConfig, settings);
  ASSERT_FALSE(shortest);
  const std::size_t at = shortest.error().find("takes at least ");
  ASSERT_NE(at, std::string::npos) << shortest.error();
  const int told = std::stoi(shortest.error().substr(at + 15));
  settings.period_ms = told - 1;
  EXPECT_FALSE(make_run_config(rig, board::kConfig, settings));
  settings.period_ms = told;
  EXPECT_TRUE(make_run_config(rig, board::kConfig, settings));

  board::Config watched = board::kConfig;
  watched.devices.watchdog_timeout = std::chrono::seconds(15);
  settings.period_ms = 5001;
  const auto slow = make_run_config(rig, watched, settings);
  ASSERT_FALSE(slow);
  EXPECT_NE(slow.error().find("watchdog"), std::string::npos) << slow.error();
  settings.period_ms = 5000;
  EXPECT_TRUE(make_run_config(rig, watched, settings));
}

TEST(MakePlan, TakesTheThreadsThatThereAre) {
  RigInfo rig = rig_of(0, 0);
  rig.calibration.stereo.left.width = 320;
  rig.threads = 2;
  settings::Settings settings;
  for (int threads = 0; threads <= settings::kMostThreads; ++threads) {
    settings.compute.threads = threads;
    EXPECT_EQ(make_run_config(rig, board::kConfig, settings)->setup.threads, 2);
  }
}

TEST(MakePlan, ASerialLineThatIsNoneCarriesNoDepth) {
  const auto blinding = [](const settings::Settings& settings) {
    const auto config = make_run_config(rig_of(64, 48), board::kConfig, settings);
    EXPECT_TRUE(config) << config.error();
    return config ? config->publisher.blinding : 0;
  };
  settings::Settings settings;
  EXPECT_EQ(blinding(settings), 0U);
  settings.streams.of(wire::Stream::kDepth) = wire::Coding::kOff;
  settings.streams.of(wire::Stream::kCloud) = wire::Coding::kOff;
  EXPECT_EQ(blinding(settings), HealthMonitor::kNoDepthStream);
  settings.serial.mode = settings::SerialMode::kStof;
  EXPECT_EQ(blinding(settings), HealthMonitor::kNoDepthStream);
  settings.serial.device = decltype(settings.serial.device)("/dev/ttyAMA0");
  EXPECT_EQ(blinding(settings), 0U);
}

}  // namespace
}  // namespace stof::firmware
