#include "firmware/workspace.h"

#include <algorithm>
#include <array>
#include <string>

#include <gtest/gtest.h>

#include "dsp/base/arena.h"
#include "dsp/fusion/drift/drift_monitor.h"
#include "dsp/fusion/fuser.h"
#include "dsp/fusion/guide/guide_maker.h"
#include "dsp/fusion/temporal/past_frames.h"
#include "dsp/fusion/unwrap/unwrapper.h"
#include "dsp/pmd/converter.h"
#include "dsp/stereo/matcher.h"
#include "dsp/stereo/rectify/rectifier.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/publisher.h"
#include "firmware/program/appliance.h"

namespace stof::firmware {
namespace {

struct Sizes {
  board::StereoConfig stereo;
  board::PmdConfig pmd;
};

constexpr std::array kBoards{
    Sizes{board::kConfig.stereo, board::kConfig.pmd}, Sizes{kVga, kVgaPmd},
    Sizes{{.width = 320, .height = 200, .disparities = 17, .block_width = 1, .block_height = 1},
          {.width = 64, .height = 16}},
    Sizes{{.width = 1, .height = 1, .disparities = 1, .block_width = 1, .block_height = 1},
          {.width = 1, .height = 1}},
    Sizes{{.width = 4096, .height = 16, .disparities = 256, .block_width = 64, .block_height = 64},
          {.width = 1, .height = 800}}};

dsp::MatchParams preset(const char* name, const board::StereoConfig& stereo) {
  dsp::MatchParams params = dsp::find_preset(name)->params;
  params.disparities = stereo.disparities;
  params.subpixel = dsp::Subpixel::kEquiangular;
  params.confidence = true;
  return params;
}

// The largest block that the board takes, as far as its sums fit.
dsp::MatchParams large_blocks(const board::StereoConfig& stereo) {
  dsp::MatchParams params{.disparities = stereo.disparities,
                          .block_width = stereo.block_width,
                          .block_height = stereo.block_height,
                          .prefilter_cap = 1,
                          .left_right_tolerance = 1,
                          .subpixel = dsp::Subpixel::kEquiangular};
  while (!dsp::blocks_fit(params)) {
    --params.block_height;
  }
  return params;
}

// The rig that asks most of a board: raw pictures, two frequencies, lights beside the lens.
dsp::Calibration largest_rig(const Sizes& board) {
  const auto lens = [](int width, int height) {
    const double focal = std::max(width, height);
    return dsp::Pinhole{.width = width,
                        .height = height,
                        .fx = focal,
                        .fy = focal,
                        .cx = width / 2.0,
                        .cy = height / 2.0};
  };
  dsp::Calibration rig;
  rig.stereo.left = lens(board.stereo.width, board.stereo.height);
  rig.stereo.baseline_m = 0.1;
  if (board.stereo.width > 1 && board.stereo.height > 1) {  // else nothing can be rectified
    dsp::RawPair& pair = rig.stereo.raw.emplace();
    pair.left = pair.right = rig.stereo.left;
    pair.left_to_right.translation_m = {-0.1, 0, 0};
    EXPECT_STREQ(dsp::complete(rig.stereo), "");
  }
  rig.pmd.lens = lens(board.pmd.width, board.pmd.height);
  rig.pmd.second = dsp::PmdFrequency{.modulation = {18'750'000}};
  rig.pmd.emitter_count = 1;
  return rig;
}

dsp::Calibration converging(dsp::Calibration rig) {
  rig.stereo.raw.reset();
  rig.stereo.converging = dsp::Converging{
      .alpha_rad = 0.02, .beta_rad = -0.02, .f1_m = 0.003, .f2_m = 0.003, .pixel_m = 1e-5};
  return rig;
}

TEST(Workspace, BoundsWhatEachPartTakesOnEveryBoard) {
  for (const Sizes& board : kBoards) {
    SCOPED_TRACE(std::to_string(board.stereo.width));
    const board::StereoConfig& s = board.stereo;
    const dsp::Calibration rig = largest_rig(board);
    if (rig.stereo.raw) {
      EXPECT_LE(dsp::bytes_taken([&](dsp::Arena& arena) { dsp::Rectifier(rig.stereo, arena); }),
                rectifier_share(s).bytes());
    }
    for (const dsp::MatchParams& params :
         {preset("fast", s), preset("quality", s), preset("chapter", s), large_blocks(s)}) {
      EXPECT_LE(dsp::bytes_taken(
                    [&](dsp::Arena& arena) { dsp::Matcher(params, s.width, s.height, arena); }),
                matcher_share(s).bytes());
    }
    EXPECT_LE(dsp::bytes_taken([&](dsp::Arena& arena) { dsp::PmdConverter(rig.pmd, arena); }),
              converter_share(board.pmd).bytes());
    for (const dsp::Calibration& each : {rig, converging(rig)}) {
      EXPECT_LE(dsp::bytes_taken([&](dsp::Arena& arena) {
                  dsp::Fuser(each, {}, 0, s.disparities, s.width, s.height, arena);
                }),
                fuser_share(s, board.pmd).bytes());
      EXPECT_LE(dsp::bytes_taken([&](dsp::Arena& arena) {
                  dsp::Unwrapper(each, {}, 0, s.disparities, s.width, s.height, arena);
                }),
                unwrapper_share(s, board.pmd).bytes());
    }
    EXPECT_LE(dsp::bytes_taken([&](dsp::Arena& arena) {
                dsp::GuideMaker(rig, {}, 0, s.disparities, s.width, s.height, arena);
              }),
              guide_share(s, board.pmd).bytes());
    EXPECT_LE(dsp::bytes_taken(
                  [&](dsp::Arena& arena) { dsp::PastFrames(s.width, s.height, 40000, arena); }),
              past_share(s, board.pmd).lasting);
    EXPECT_LE(dsp::bytes_taken([&](dsp::Arena& arena) { dsp::DriftMonitor(rig, {}, arena); }),
              monitor_share(board.stereo, board.pmd).bytes());
  }
}

firmware::Setup largest_setup(const Sizes& board, const dsp::MatchParams& match) {
  firmware::Setup setup;  // gtest has a Setup too
  setup.calibration = largest_rig(board);
  setup.depth.match = match;
  setup.depth.temporal = true;
  return setup;
}

std::size_t image_bytes_of(const firmware::Setup& setup) {
  return dsp::bytes_taken([&](dsp::Arena& arena) { Pipeline(setup, arena); });
}

// Of what the appliance lays out beside the images.
std::size_t coded_bytes_of(const firmware::Setup& setup) {
  const dsp::Pinhole& left = setup.calibration.stereo.left;
  const wire::CalibrationPacket calibration{.image_width = static_cast<std::uint16_t>(left.width),
                                            .image_height = static_cast<std::uint16_t>(left.height),
                                            .fx = 1 << 16,  // any lens takes the same
                                            .fy = 1 << 16};
  return dsp::bytes_taken([&](dsp::Arena& arena) {
    std::array<std::byte, 1> no_line{};
    ByteRing ring(no_line);
    SerialSender({.origin = {}, .calibration = calibration}, ring, arena);
    arena.take<wire::DatagramBuffer>(Publisher::kSignedAtOnce);
    arena.take<wire::DatagramBuffer>(RawSender::kBurst);
    const wire::FrameSizes sizes = sizes_of(setup);
    wire::FrameCoder({}, sizes, calibration, arena, wire::FrameCoder::usual_packets(sizes));
  });
}

// Whatever preset and streams: all static memory of a VGA board, as it is taken and as it is
// reserved.
TEST(Workspace, OfAVgaBoardStaysWithin17MiBWithEveryPreset) {
  const Sizes vga{kVga, kVgaPmd};
  const std::size_t reserved =
      workspace_bytes(vga.stereo, vga.pmd) + coded_bytes(vga.stereo, vga.pmd) + kOtherStaticBytes;
  EXPECT_LE(reserved, kVgaLimit);
  std::size_t most = 0;
  for (const char* const name : {"fast", "quality", "chapter"}) {
    SCOPED_TRACE(name);
    const firmware::Setup setup = largest_setup(vga, preset(name, vga.stereo));
    const std::size_t images = image_bytes_of(setup);
    EXPECT_LE(images, workspace_bytes(vga.stereo, vga.pmd));
    EXPECT_LE(coded_bytes_of(setup), coded_bytes(vga.stereo, vga.pmd));
    most = std::max(most, images);
  }
  // A guide and the past go together.
  for (const char* const name : {"fast", "quality"}) {
    SCOPED_TRACE(name);
    firmware::Setup guided = largest_setup(vga, preset(name, vga.stereo));
    guided.depth.guided = true;
    EXPECT_LE(image_bytes_of(guided), workspace_bytes(vga.stereo, vga.pmd));
  }
  EXPECT_GE(most, workspace_bytes(vga.stereo, vga.pmd) / 10 * 8);  // the bound is a near one
}

// The bound is meant to be one: no part of the limit is left to chance, none is wasted.
TEST(Workspace, HoldsTheLargestFramesAndLittleMore) {
  const firmware::Setup setup = largest_setup({board::kConfig.stereo, board::kConfig.pmd},
                                              preset("quality", board::kConfig.stereo));
  const std::size_t bytes = image_bytes_of(setup);
  EXPECT_LE(bytes, sizeof(Workspace::memory));
  EXPECT_GE(bytes, sizeof(Workspace::memory) / 10 * 8);
  EXPECT_LE(coded_bytes_of(setup), sizeof(Workspace::coded));
  EXPECT_GE(coded_bytes_of(setup), sizeof(Workspace::coded) / 10 * 8);
}

TEST(Workspace, GrowsWithEveryDimension) {
  const std::size_t vga = workspace_bytes(kVga, kVgaPmd);
  EXPECT_LE(vga, kVgaLimit);
  board::StereoConfig wider = kVga;
  ++wider.width;
  EXPECT_GT(workspace_bytes(wider, kVgaPmd), vga);
  EXPECT_GT(workspace_bytes(kVga, {.width = 176, .height = 145}), vga);
  board::StereoConfig deeper = kVga;
  ++deeper.disparities;
  EXPECT_GT(workspace_bytes(deeper, kVgaPmd), vga);
}

}  // namespace
}  // namespace stof::firmware
