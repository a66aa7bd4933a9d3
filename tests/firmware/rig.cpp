#include "tests/firmware/rig.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::firmware::test {
namespace {

// Seven distances; an edge and the six before it differ.
constexpr std::size_t kDistances = 7;

std::uint8_t texture(int x, int y, std::size_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^
                    static_cast<std::uint32_t>(y) * 0x85EBCA77U ^
                    static_cast<std::uint32_t>(seed) * 0xC2B2AE3DU;
  h ^= h >> 15;
  h *= 0x2C1B3C6DU;
  h ^= h >> 12;
  return static_cast<std::uint8_t>(h >> 24);
}

// The emulated camera's own memory behind a read-only view.
template <typename T>
dsp::ImageView<T> writable(dsp::ImageView<const T> view) {
  return {const_cast<T*>(view.data()), view.width(), view.height(), view.stride()};
}

void paint_view(dsp::ImageView<std::uint8_t> out, std::size_t edge, int shift) {
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      out.at(x, y) = texture(x + shift, y, edge);
    }
  }
}

void paint_black(dsp::ImageView<std::uint8_t> out) {
  for (int y = 0; y < out.height(); ++y) {
    std::ranges::fill(out.row(y), std::uint8_t{0});
  }
}

void paint_noise(dsp::ImageView<std::uint16_t> out, std::size_t seed) {
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      out.at(x, y) = static_cast<std::uint16_t>(500 + texture(x, y, seed) % 4);
    }
  }
}

void paint_sample(dsp::ImageView<std::uint16_t> out, double depth_m, int k,
                  const dsp::Pinhole& lens) {
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const double u = (x - lens.cx) / lens.fx;
      const double v = (y - lens.cy) / lens.fy;
      const double radial = depth_m * std::sqrt(u * u + v * v + 1);
      const double phase = radial * 4 * std::numbers::pi * 20e6 / dsp::kLightMetresPerSecond;
      out.at(x, y) = static_cast<std::uint16_t>(
          std::lround(1500 + 1000 * std::cos(phase + k * std::numbers::pi / 2)));
    }
  }
}

emu::PmdTiming pmd_timing(const RigOptions& options) {
  return {.integration = options.timing.pmd_integration,
          .readout = 4ms,
          .every = options.timing.pmd_every};
}

Setup setup_of(const RigOptions& options) {
  Setup setup = small_setup(options.with_pmd);
  setup.threads = options.threads.threads();
  setup.depth.temporal = options.temporal;
  setup.require_both = options.require_both;
  return setup;
}

std::size_t bytes(const Setup& setup) {
  return dsp::bytes_taken([&](dsp::Arena& arena) {
    Pipeline(setup, arena, dsp::ThreadTeam::standing_for(setup.threads));
    arena.take<wire::DatagramBuffer>(Publisher::kSignedAtOnce);
    arena.take<wire::DatagramBuffer>(RawSender::kBurst);
    const wire::FrameSizes sizes = sizes_of(setup);
    wire::FrameCoder({}, sizes, {}, arena, wire::FrameCoder::usual_packets(sizes));
  });
}

}  // namespace

int disparity_of(std::size_t edge) { return 1 + static_cast<int>(edge * 3 % kDistances); }
double depth_of(std::size_t edge) { return kFocal * kBaseline / disparity_of(edge); }

std::optional<std::size_t> EdgeLog::find(hal::Time edge) const noexcept {
  const auto found = std::ranges::find(edges, edge);
  return found == edges.end() ? std::nullopt : std::optional<std::size_t>(found - edges.begin());
}

double EdgeLog::pmd_depth(hal::Time edge) const noexcept {
  const double noise = still_ ? 0.002 * static_cast<double>(find(edge).value_or(0) * 3 % 5) : 0;
  return depth_of(scene(edge)) * (1 + noise);
}

Result<hal::BorrowedFrame<hal::StereoFrame>> PaintedStereo::wait_frame(
    hal::Time deadline) noexcept {
  latest_deadline = std::max(latest_deadline, deadline);
  Result<hal::BorrowedFrame<hal::StereoFrame>> frame = camera_.wait_frame(deadline);
  if (frame) {
    const auto paint = [](dsp::ImageView<const std::uint8_t> view, const PixelFault& fault,
                          std::size_t edge, bool shifted) {
      const std::size_t shown = fault.shown(edge);
      if (fault.dark && fault.strikes(edge)) {
        paint_black(writable(view));
      } else {
        paint_view(writable(view), shown, shifted ? disparity_of(shown) : 0);
      }
    };
    paint((*frame)->left, faults_.left, log_.scene((*frame)->left_exposure.begin), false);
    paint((*frame)->right, faults_.right, log_.scene((*frame)->right_exposure.begin), true);
  }
  return frame;
}

Result<hal::BorrowedFrame<hal::PmdFrame>> PaintedPmd::wait_frame(hal::Time deadline) noexcept {
  latest_deadline = std::max(latest_deadline, deadline);
  Result<hal::BorrowedFrame<hal::PmdFrame>> frame = camera_.wait_frame(deadline);
  if (frame) {
    const dsp::Pinhole lens = small_setup(true).calibration.pmd.lens;
    for (int k = 0; k < 4; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const hal::Time edge = (*frame)->exposures[i].begin - integration_ * k / 4;
      const std::size_t number = log_.find(edge).value_or(0);
      const bool faulty = fault_.strikes(number);
      const double depth = faulty ? depth_of(fault_.shown(log_.scene(edge))) : log_.pmd_depth(edge);
      if (faulty && fault_.dark) {
        paint_noise(writable((*frame)->samples[i]), 4 * number + i);
      } else {
        paint_sample(writable((*frame)->samples[i]), depth, k, lens);
      }
    }
  }
  return frame;
}

Setup small_setup(bool with_pmd) {
  Setup setup;
  setup.calibration.stereo = {
      .left =
          {.width = kWidth, .height = kHeight, .fx = kFocal, .fy = kFocal, .cx = 15.5, .cy = 11.5},
      .baseline_m = kBaseline};
  if (with_pmd) {
    setup.calibration.pmd.lens = {
        .width = kPmdWidth, .height = kPmdHeight, .fx = 20, .fy = 20, .cx = 7.5, .cy = 5.5};
  }
  setup.depth.match = {.disparities = kDisparities,
                       .block_width = 5,
                       .block_height = 5,
                       .left_right_tolerance = 1,
                       .subpixel = dsp::Subpixel::kEquiangular,
                       .confidence = true};
  // So narrow that no two of the distances could be taken for one.
  setup.depth.fusion.trust.sigma_by_ratio.fill(4);
  return setup;
}

Rig::Rig(const RigOptions& options)
    : log(options.still),
      stereo(clock, imagery, {.exposure = options.timing.stereo_exposure}, options.faults.stereo),
      pmd(clock, imagery, pmd_timing(options), options.faults.pmd),
      painted_stereo(stereo, log, options.pixels),
      painted_pmd(pmd, log, options.timing.pmd_integration, options.pixels),
      trigger(clock, 50us, {&log, &stereo, &pmd}, options.faults.trigger),
      port(256, options.faults.link),
      board{.clock = clock,
            .trigger = trigger,
            .stereo = painted_stereo,
            .pmd = options.with_pmd ? &painted_pmd : nullptr,
            .port = options.port != nullptr ? *options.port : port,
            .serial = nullptr,
            .to = std::nullopt,
            .network = network,
            .mdns = nullptr,
            .calibration = small_setup(options.with_pmd).calibration,
            .disparities = kDisparities,
            .emulated_time = true,
            .recorded = options.still,
            .notes = {}},
      setup(setup_of(options)),
      memory(bytes(setup)),
      arena(memory.span()),
      pipeline(setup, arena, options.threads),
      publisher({.origin = {.device_id = 7, .session_id = 9},
                 .clock = wire::ClockState::kEmulated,
                 .calibration =
                     wire::make_calibration_packet(setup.calibration, setup.depth.fusion.max_range,
                                                   options.timing.period.count())
                         .value()},
                sizes_of(setup), clock, board.port, nullptr, events, arena),
      loop(board, options.timing, setup, pipeline, publisher, events, options.lending) {
  publisher.set_params({.choice = options.choice, .period = options.timing.period});
  const hal::Peer receiver{.address = {}, .port = 1};
  publisher.set_receivers({.peers = {receiver}, .count = 1});
}

std::size_t Received::count(dsp::Source which) const {
  return static_cast<std::size_t>(std::ranges::count(source, static_cast<std::uint8_t>(which)));
}

double Received::depth_m(dsp::Source of) const {
  std::vector<std::uint16_t> found;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (source[i] == static_cast<std::uint8_t>(of)) {
      found.push_back(depth[i]);
    }
  }
  if (found.empty()) {
    return 0;
  }
  std::ranges::nth_element(found, found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2));
  return static_cast<double>(found[found.size() / 2]) / dsp::kQuarterMmPerMetre;
}

void Receiver::drain(emu::DatagramPort& port) {
  while (const auto sent = port.take_sent()) {
    bytes.insert(bytes.end(), sent->bytes.begin(), sent->bytes.end());
    if (const auto packet = wire::parse_packet(sent->bytes)) {
      take(*packet);
    } else {
      ++damaged;
    }
  }
}

void Receiver::take(const wire::PacketView& packet) {
  const wire::Header& header = packet.header;
  if (header.type == wire::PacketType::kCalibration) {
    ++calibrations;
    return;
  }
  if (header.type == wire::PacketType::kEvent) {
    events.push_back(wire::decode_event_report(packet.payload).value());
    return;
  }
  if (header.type == wire::PacketType::kHealth) {
    healths.push_back(wire::decode_health_report(packet.payload).value());
    return;
  }
  Received& frame = frames[header.frame.number];
  frame.stamp = header.frame;
  frame.depth.resize(std::size_t{kWidth} * kHeight);
  frame.source.resize(std::size_t{kWidth} * kHeight);
  ++frame.packets;
  if (header.type == wire::PacketType::kFrameInfo) {
    frame.info = wire::decode_frame_info(packet.payload).value();
    return;
  }
  const std::size_t first = std::size_t{header.first_row} * kWidth + header.first_column;
  if (header.stream == wire::Stream::kDepth) {
    wire::get_pixels(packet.payload, std::span(frame.depth).subspan(first, header.pixel_count));
  } else if (header.stream == wire::Stream::kSource) {
    wire::get_pixels(packet.payload, std::span(frame.source).subspan(first, header.pixel_count));
  }
}

void run(Rig& rig, Receiver& receiver, int steps) {
  for (int i = 0; i < steps; ++i) {
    static_cast<void>(rig.loop.step());
    receiver.drain(rig.port);
  }
}

namespace {

// The pixels: the sensors saw the wall that stood there at this edge.
void expect_depth_of_its_sensors(const Received& frame, double depth_m) {
  const bool stereo = (frame.info.sensors & kStereoSensor) != 0;
  const bool pmd = (frame.info.sensors & kPmdSensor) != 0;
  const dsp::Source alone = stereo ? dsp::Source::kStereo : dsp::Source::kPmd;
  const dsp::Source source = stereo && pmd ? dsp::Source::kBoth : alone;
  EXPECT_TRUE(stereo || pmd);
  EXPECT_EQ(frame.info.pmd_present, pmd ? 1 : 0);
  EXPECT_EQ(frame.info.exposure_end_ns - frame.info.exposure_begin_ns,
            hal::Duration(stereo ? 4ms : 16ms).count());
  EXPECT_EQ(frame.info.pmd_age_ns, stereo && pmd ? hal::Duration(2ms - 8ms).count() : 0);
  // The middle of what a quarter of a pixel to both sides leaves of 4 m is 4.27 m.
  EXPECT_NEAR(frame.depth_m(source), depth_m, (pmd ? 0.03 : 0.07) * depth_m);
  EXPECT_GE(frame.count(source), frame.source.size() / 3);
  EXPECT_LE(frame.count(dsp::Source::kConflict), frame.source.size() / 20);
  const std::size_t of_one = frame.count(dsp::Source::kStereo) + frame.count(dsp::Source::kPmd);
  if (stereo != pmd) {
    EXPECT_EQ(frame.count(source), of_one) << "nothing of a sensor that is not there";
    EXPECT_EQ(frame.count(dsp::Source::kBoth), 0U);
    EXPECT_EQ(frame.stamp.health, std::max(frame.stamp.health, wire::Health::kDegraded));
  }
}

}  // namespace

std::vector<std::size_t> expect_true_frames(const Rig& rig, const Receiver& receiver) {
  std::vector<std::size_t> edges;
  std::optional<wire::FrameStamp> before;
  for (const auto& [number, frame] : receiver.frames) {
    if (!frame.complete()) {
      continue;
    }
    const auto edge = rig.log.find(hal::Time(hal::Duration(frame.info.exposure_begin_ns)));
    if (!edge) {
      ADD_FAILURE() << "frame " << number << " begins at no edge";
      continue;
    }
    SCOPED_TRACE("frame " + std::to_string(number));
    expect_depth_of_its_sensors(frame, depth_of(*edge));
    EXPECT_TRUE(edges.empty() || *edge > edges.back()) << "frame " << number << " is not new";
    if (before) {
      EXPECT_GT(frame.stamp.freshness, before->freshness);
      EXPECT_GT(frame.stamp.exposure_middle_ns, before->exposure_middle_ns);
    }
    before = frame.stamp;
    edges.push_back(*edge);
  }
  return edges;
}

}  // namespace stof::firmware::test
