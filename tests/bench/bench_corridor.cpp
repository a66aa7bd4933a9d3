#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "dsp/depth/depth_maker.h"
#include "firmware/wire/codec/rvl_decode.h"
#include "firmware/wire/codec/rvl_encode.h"
#include "firmware/wire/crc32c.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"
#include "host/evaluate/workspace.h"
#include "tests/bench/bench_work.h"
#include "tests/firmware/wire/frame/coder_in_memory.h"

namespace stof::bench {
namespace {

constexpr wire::CalibrationPacket kLens{
    .fx = 615 << 16, .fy = 615 << 16, .cx = 320 << 16, .cy = 240 << 16};

constexpr std::size_t kExposures = 6;

// What both cameras see by turns: the noise differs.
struct Exposure {
  dataset::Image<std::uint8_t> left;
  std::vector<dataset::Image<std::uint16_t>> samples;
};

dsp::DepthParams depth_params(const dsp::MatchParams& match, bool temporal) {
  dsp::DepthParams params{.match = match, .fusion = {}, .temporal = temporal};
  params.fusion.trust = dsp::trust_of(match);
  return params;
}

wire::StreamChoice depth_alone() {
  wire::StreamChoice choice;
  choice.of(wire::Stream::kDepth) = wire::Coding::kRvl;
  return choice;
}

// What a subscriber gets who asks for nothing in particular.
wire::StreamChoice three_streams() {
  wire::StreamChoice choice;
  choice.of(wire::Stream::kDepth) = wire::Coding::kQuantised;
  choice.of(wire::Stream::kWidth) = wire::Coding::kQuantised;
  choice.of(wire::Stream::kSource) = wire::Coding::kRvl;
  return choice;
}

}  // namespace

// All that a frame passes through, with what it leaves.
struct CorridorWork::State {
  State(hal::emu::RenderedScene& scene, const dsp::MatchParams& match, bool temporal)
      : calibration(scene.calibration()),
        params(depth_params(match, temporal)),
        pictures{.name = "corridor",
                 .left = {scene.stereo_size().width, scene.stereo_size().height},
                 .right = {scene.stereo_size().width, scene.stereo_size().height}},
        depth(pictures.left.width, pictures.left.height),
        width(depth.width, depth.height),
        source(depth.width, depth.height),
        cause(depth.width, depth.height),
        memory(dsp::bytes_taken(
            [&](dsp::Arena& measure) { dsp::DepthMaker(calibration, params, measure); })),
        arena(memory.arena()),
        maker(calibration, params, arena),
        sizes{.width = depth.width,
              .height = depth.height,
              .pmd_width = scene.pmd_size().width,
              .pmd_height = scene.pmd_size().height},
        coder({}, sizes, kLens),
        coded(depth.pixels.size() * 4) {
    scene.right(1, pictures.right.view());
    for (std::uint32_t number = 1; number <= kExposures; ++number) {
      Exposure& exposure = exposures.emplace_back();
      exposure.left = {depth.width, depth.height};
      scene.left(number, exposure.left.view());
      for (int k = 0; k < 4; ++k) {
        scene.pmd(number, k,
                  exposure.samples.emplace_back(sizes.pmd_width, sizes.pmd_height).view());
      }
    }
    show(0);
  }

  void show(std::size_t exposure) {
    now = exposure;
    pictures.left.pixels = exposures[now].left.pixels;
  }

  void code(const wire::StreamChoice& choice) {
    const auto sent = coder->code(
        {}, {}, {.map = {depth.view(), width.view(), source.view(), cause.view()}}, choice);
    STOF_CHECK(sent.has_value());
  }

  dsp::Calibration calibration;
  dsp::DepthParams params;
  Pictures pictures;
  std::vector<Exposure> exposures;
  std::size_t now = 0;
  dataset::Image<dsp::QuarterMm> depth;
  dataset::Image<dsp::QuarterMm> width;
  dataset::Image<dsp::Source> source;
  dataset::Image<dsp::Cause> cause;
  host::Workspace memory;
  dsp::Arena arena;
  dsp::DepthMaker maker;
  wire::FrameSizes sizes;
  test::CoderInMemory coder;
  std::vector<std::byte> coded;
  std::vector<std::pair<std::size_t, wire::RvlCoded>> parts;  // of `coded`, and where they begin
  std::uint32_t sum = 0;
};

CorridorWork::CorridorWork(const dsp::MatchParams& params, bool temporal) {
  hal::emu::RenderedScene scene(hal::emu::corridor(), hal::emu::corridor_rig());
  state_ = std::make_unique<State>(scene, params, temporal);
  frame();
  encode();
}

CorridorWork::~CorridorWork() = default;

void CorridorWork::convert() {
  State& s = *state_;
  const std::vector<dataset::Image<std::uint16_t>>& samples = s.exposures[s.now].samples;
  const dsp::PmdExposure exposure{
      .samples = {samples[0].view(), samples[1].view(), samples[2].view(), samples[3].view()}};
  s.maker.convert({.first = {&exposure, 1}});
}

void CorridorWork::match() {
  state_->maker.match(state_->pictures.left.view(), state_->pictures.right.view());
}

void CorridorWork::fuse() {
  State& s = *state_;
  s.maker.fuse({s.depth.view(), s.width.view(), s.source.view(), s.cause.view()});
}

void CorridorWork::convert_and_fuse() {
  convert();
  fuse();
}

void CorridorWork::stand() {
  state_->show((state_->now + 1) % kExposures);
  convert_and_fuse();
}

void CorridorWork::code_depth() { state_->code(depth_alone()); }
void CorridorWork::code_three() { state_->code(three_streams()); }

void CorridorWork::encode() {
  State& s = *state_;
  s.parts.clear();
  std::span<const dsp::QuarterMm> values(s.depth.pixels);
  std::size_t at = 0;
  while (!values.empty()) {
    const wire::RvlCoded part = wire::rvl_encode(values, std::span(s.coded).subspan(at));
    s.parts.emplace_back(at, part);
    values = values.subspan(part.values);
    at += part.bytes;
  }
}

void CorridorWork::decode() {
  State& s = *state_;
  std::size_t pixel = 0;
  for (const auto& [at, part] : s.parts) {
    const Status status =
        wire::rvl_decode<std::uint16_t>(std::span(s.coded).subspan(at, part.bytes),
                                        std::span(s.width.pixels).subspan(pixel, part.values));
    STOF_CHECK(status == Status::kOk);
    pixel += part.values;
  }
}

void CorridorWork::check() {
  state_->sum ^= wire::crc32c(std::as_bytes(std::span(state_->depth.pixels)));
}

void CorridorWork::frame() {
  convert();
  match();
  fuse();
  code_depth();
}

const Pictures& CorridorWork::pictures() const { return state_->pictures; }

}  // namespace stof::bench
