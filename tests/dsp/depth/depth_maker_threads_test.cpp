#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/depth/depth_maker.h"
#include "posix/worker_threads.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr int kFrames = 3;
constexpr int kShift = 6;  // px
constexpr QuarterMm kOnePeriod = 28'000;

struct Size {
  int width;
  int height;
};

template <typename T>
class Picture {
 public:
  Picture(int width, int height)
      : pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
        width_(width),
        height_(height) {}
  ImageView<T> view() { return {pixels_.data(), width_, height_}; }
  const std::vector<T>& pixels() const { return pixels_; }

 private:
  std::vector<T> pixels_;
  int width_;
  int height_;
};

template <typename T>
std::vector<T> copied(ImageView<const T> image) {
  std::vector<T> all;
  for (int y = 0; y < image.height(); ++y) {
    all.insert(all.end(), image.row(y).begin(), image.row(y).end());
  }
  return all;
}

// A slanted texture whose right view is moved, and noise in both.
void paint(ImageView<std::uint8_t> image, int shift, std::uint64_t seed) {
  test::Random random(seed);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const auto u = static_cast<unsigned>(x + shift + y / 16);
      const unsigned cell = (u / 3 * 2654435761U ^ static_cast<unsigned>(y / 3) * 40503U) >> 7;
      image.at(x, y) =
          static_cast<std::uint8_t>(cell % 200 + static_cast<unsigned>(random.between(0, 9)));
    }
  }
}

// A wall with a step in the middle, readings with noise, some of them dark.
void expose(std::array<Picture<std::uint16_t>, 4>& samples, std::uint64_t seed) {
  test::Random random(seed);
  const ImageView<std::uint16_t> first = samples[0].view();
  for (int y = 0; y < first.height(); ++y) {
    for (int x = 0; x < first.width(); ++x) {
      const double turns = 2 * x < first.width() ? 0.25 : 0.4;
      const double amplitude = random.between(0, 9) == 0 ? 2 : 500;
      for (int k = 0; k < 4; ++k) {
        const double value = 1100 + amplitude * std::cos(2 * std::numbers::pi * (turns + k / 4.0));
        samples[static_cast<std::size_t>(k)].view().at(x, y) =
            static_cast<std::uint16_t>(std::lround(value) + random.between(0, 20));
      }
    }
  }
}

struct Rig {
  std::string name;
  Calibration calibration;
  DepthParams params;
};

// f b = 6 m px, so that kShift px are a metre.
Calibration calibration_of(Size size, Size pmd) {
  Calibration rig;
  rig.stereo = {.left = {.width = size.width,
                         .height = size.height,
                         .fx = 60,
                         .fy = 60,
                         .cx = size.width / 2.0,
                         .cy = size.height / 2.0},
                .baseline_m = 0.1};
  rig.pmd.lens = {.width = pmd.width,
                  .height = pmd.height,
                  .fx = 15,
                  .fy = 15,
                  .cx = pmd.width / 2.0,
                  .cy = pmd.height / 2.0};
  return rig;
}

Calibration raw_calibration(Size size, Size pmd) {
  Calibration rig = calibration_of(size, pmd);
  RawPair& pair = rig.stereo.raw.emplace();
  pair.left = rig.stereo.left;
  pair.left.k1 = -0.05;
  pair.right = pair.left;
  pair.left_to_right = {.rotation = {0.9998, 0, 0.02, 0, 1, 0, -0.02, 0, 0.9998},
                        .translation_m = {-0.1, 0, 0}};
  EXPECT_STREQ(complete(rig.stereo), "");
  return rig;
}

DepthParams params_of(const char* preset) {
  DepthParams params{.match = for_depth(*find_preset(preset)), .fusion = {}};
  params.match.disparities = 16;
  params.match.confidence = true;
  params.fusion.trust = trust_of(params.match);
  params.fusion.max_range = kOnePeriod;
  return params;
}

// Every part of the way on and off.
std::vector<Rig> rigs_of(Size size) {
  std::vector<Rig> rigs;
  for (const char* const preset : {"fast", "quality"}) {
    const DepthParams plain = params_of(preset);
    const std::string name = std::string(preset) + " ";
    rigs.push_back({name + "stereo alone", calibration_of(size, {0, 0}), plain});
    rigs.push_back({name + "PMD", calibration_of(size, {13, 9}), plain});
    DepthParams all = plain;
    all.temporal = all.guided = true;
    rigs.push_back({name + "guide, time", calibration_of(size, {13, 9}), all});
    all.fusion.max_range = 40'000;
    rigs.push_back({name + "guide, time, wrap counts", calibration_of(size, {13, 9}), all});
    if (size.width > 30 && size.height > 20) {
      rigs.push_back({name + "raw, guide, time", raw_calibration(size, {13, 9}), all});
    }
  }
  return rigs;
}

struct Frame {
  std::vector<Disparity> disparity;
  std::vector<std::uint8_t> left;
  std::vector<QuarterMm> depth;
  std::vector<QuarterMm> width;
  std::vector<Source> source;
  std::vector<Cause> cause;
  std::uint32_t drift_patches = 0;

  bool operator==(const Frame&) const = default;
};

struct alignas(Arena::kAlign) Line {
  std::byte bytes[Arena::kAlign];  // NOLINT(modernize-avoid-c-arrays): a cache line
};

std::size_t bytes_of(const Rig& rig, int threads) {
  return bytes_taken([&](Arena& arena) {
    DepthMaker(rig.calibration, rig.params, arena, ThreadTeam::standing_for(threads));
  });
}

// Some frames, in exactly the memory that was asked for.
std::vector<Frame> run(const Rig& rig, Size size, const ThreadTeam& team) {
  const std::size_t bytes = bytes_of(rig, team.threads());
  std::vector<Line> memory((bytes + Arena::kAlign - 1) / Arena::kAlign);
  std::memset(static_cast<void*>(memory.data()), 0x5A, memory.size() * sizeof(Line));
  Arena arena({memory.data()->bytes, bytes});
  DepthMaker maker(rig.calibration, rig.params, arena, team);
  const Pinhole& pmd = rig.calibration.pmd.lens;
  Picture<std::uint8_t> left(size.width, size.height);
  Picture<std::uint8_t> right(size.width, size.height);
  const Picture<std::uint16_t> sample(pmd.width, pmd.height);
  std::array<Picture<std::uint16_t>, 4> samples{sample, sample, sample, sample};
  Picture<QuarterMm> depth(size.width, size.height);
  Picture<QuarterMm> width(size.width, size.height);
  Picture<Source> source(size.width, size.height);
  Picture<Cause> cause(size.width, size.height);
  std::vector<Frame> frames;
  for (std::uint64_t frame = 0; frame < kFrames; ++frame) {
    paint(left.view(), 0, 2 * frame);
    paint(right.view(), kShift, 2 * frame + 1);
    if (pmd.width > 0) {
      expose(samples, 100 + frame);
      const PmdExposure exposure{
          .samples = {samples[0].view(), samples[1].view(), samples[2].view(), samples[3].view()}};
      maker.convert({.first = {&exposure, 1}});
    }
    maker.match(left.view(), right.view());
    maker.fuse({depth.view(), width.view(), source.view(), cause.view()});
    maker.watch();
    frames.push_back({.disparity = copied(maker.stereo().disparity),
                      .left = copied(maker.left()),
                      .depth = depth.pixels(),
                      .width = width.pixels(),
                      .source = source.pixels(),
                      .cause = cause.pixels(),
                      .drift_patches = maker.drift().patches});
  }
  return frames;
}

TEST(DepthMakerThreads, DepthIsTheSameForAnyNumberOfThreads) {
  posix::WorkerThreads workers({.threads = 4});
  for (const Size size :
       {Size{1, 1}, Size{1, 37}, Size{53, 1}, Size{47, 15}, Size{33, 17}, Size{97, 131}}) {
    for (const Rig& rig : rigs_of(size)) {
      ASSERT_STREQ(problem(rig.calibration), "") << rig.name;
      const std::vector<Frame> alone = run(rig, size, {});
      for (int threads = 1; threads <= 4; ++threads) {
        ASSERT_TRUE(run(rig, size, ThreadTeam(workers, threads)) == alone)
            << size.width << "x" << size.height << ", " << rig.name << ", " << threads
            << " threads";
      }
    }
  }
}

// That there is something to compare.
TEST(DepthMakerThreads, DepthOfAllSourcesIsThere) {
  const Size size{97, 131};
  posix::WorkerThreads workers({.threads = 3});
  for (const Rig& rig : rigs_of(size)) {
    const Frame last = run(rig, size, ThreadTeam(workers, 3)).back();
    const auto with = [&](Source source) { return std::ranges::count(last.source, source); };
    EXPECT_GT(with(Source::kStereo) + with(Source::kBoth), 97 * 131 / 4) << rig.name;
    if (rig.calibration.pmd.lens.width > 0) {
      EXPECT_GT(with(Source::kPmd) + with(Source::kBoth) + with(Source::kResolved), 0) << rig.name;
      EXPECT_GT(std::ranges::count_if(last.cause, [](Cause c) { return c != Cause::kNone; }), 0)
          << rig.name;
    }
  }
}

TEST(DepthMakerThreads, EachThreadTakesMemoryOfItsOwn) {
  const Rig rig{"", calibration_of({640, 480}, {176, 144}), params_of("quality")};
  std::size_t before = bytes_of(rig, 1);
  for (int threads = 2; threads <= ThreadTeam::kMost; ++threads) {
    const std::size_t bytes = bytes_of(rig, threads);
    EXPECT_GT(bytes, before) << threads;
    before = bytes;
  }
}

}  // namespace
}  // namespace stof::dsp
