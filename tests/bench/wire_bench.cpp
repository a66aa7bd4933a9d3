// stof_wire_bench [PRESET]: the corridor's frame as datagrams. The shortest times of coding and
// decoding each stream, and what it takes.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <vector>

#include "dsp/fusion/decimate.h"
#include "firmware/wire/codec/interval_quantiser.h"
#include "firmware/wire/codec/rvl_decode.h"
#include "firmware/wire/codec/rvl_encode.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/frame/frame_coder.h"
#include "tests/firmware/wire/frame/coder_in_memory.h"
#include "tests/firmware/wire/frame/corridor_frame.h"

namespace stof::wire {
namespace {

constexpr int kRuns = 101;
constexpr CalibrationPacket kLens{
    .fx = 615 << 16, .fy = 615 << 16, .cx = 320 << 16, .cy = 240 << 16};

// The shortest of many: what else runs on the machine only adds to it.
template <typename Work>
double least_ms(const Work& work) {
  double least = std::numeric_limits<double>::max();
  for (int i = 0; i < kRuns; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - begin;
    least = std::min(least, taken.count());
  }
  return least;
}

using Datagrams = std::span<const std::span<const std::byte>>;

// Parses and decodes every tile; returns its pixels.
std::size_t decode(Datagrams datagrams, std::vector<std::uint16_t>& values16,
                   std::vector<std::uint8_t>& values8) {
  std::size_t pixels = 0;
  for (const std::span<const std::byte> datagram : datagrams) {
    const auto packet = parse_packet(datagram);
    if (!packet || packet->header.type != PacketType::kTile) {
      continue;
    }
    const std::size_t count = packet->header.pixel_count;
    auto status = Status::kOk;
    if (packet->header.codec == Codec::kRvl16) {
      status = rvl_decode<std::uint16_t>(packet->payload, std::span(values16).first(count));
    } else if (packet->header.codec == Codec::kRvl8) {
      status = rvl_decode<std::uint8_t>(packet->payload, std::span(values8).first(count));
    }
    pixels += status == Status::kOk ? count : 0;
  }
  return pixels;
}

// What sealing and parsing take alone: the CRC of each datagram.
std::uint32_t check(Datagrams datagrams) {
  std::uint32_t sum = 0;
  for (const std::span<const std::byte> datagram : datagrams) {
    sum ^= crc32c(datagram);
  }
  return sum;
}

void measure(test::CorridorFrame& frame, FrameCoder& coder, const char* name,
             const StreamChoice& choice) {
  const FrameImages images = frame.images();
  const Datagrams sent = coder.code({}, {}, images, choice).value();
  std::size_t bytes = 0;
  for (const std::span<const std::byte> datagram : sent) {
    bytes += datagram.size();
  }
  std::vector<std::uint16_t> values16(kMostRvlValues);
  std::vector<std::uint8_t> values8(kMostRvlValues);
  std::size_t pixels = 0;
  std::uint32_t sum = 0;
  const double code_ms = least_ms([&] { pixels += coder.code({}, {}, images, choice)->size(); });
  const double decode_ms = least_ms([&] { pixels += decode(sent, values16, values8); });
  const double crc_ms = least_ms([&] { sum ^= check(sent); });
  std::printf("%-22s %5zu packets %8zu bytes  code %.3f  decode %.3f  CRC alone %.3f ms%s\n", name,
              sent.size(), bytes, code_ms, decode_ms, crc_ms, pixels + sum == 0 ? "." : "");
}

// What rounding costs: the sum of all widths, and those of pixels that it hurts.
void print_growth(const dsp::DepthMap& map) {
  std::vector<std::uint16_t> grown(static_cast<std::size_t>(map.width.width()));
  double before = 0.0;
  double after = 0.0;
  int pixels = 0;
  int quarter = 0;
  for (int y = 0; y < map.depth.height(); ++y) {
    const unsigned scale = quantiser_scale(map, y / kQuantiserRows * kQuantiserRows);
    grow_width(map.depth.row(y), map.width.row(y), scale, grown);
    quantise_width(grown, scale);
    for (std::size_t x = 0; x < grown.size(); ++x) {
      const int width = map.width.row(y)[x];
      const int rounded = grown[x] << scale;
      before += width;
      after += rounded;
      pixels += map.depth.row(y)[x] != dsp::kNoDepth ? 1 : 0;
      quarter += 4 * (rounded - width) > width ? 1 : 0;
    }
  }
  std::printf("fit: widths grow by %.2f %%, of %.3f %% of the pixels by more than a quarter\n",
              100.0 * (after / before - 1.0), 100.0 * quarter / pixels);
}

StreamChoice only(Stream stream, Coding coding) {
  StreamChoice choice;
  choice.of(stream) = coding;
  return choice;
}

StreamChoice usual(Coding coding, bool parity) {
  StreamChoice choice{.parity = parity};
  for (const Stream stream : {Stream::kDepth, Stream::kWidth, Stream::kSource}) {
    choice.of(stream) = coding;
  }
  return choice;
}

void run(const char* preset) {
  test::CorridorFrame frame(preset);
  test::CoderInMemory in_memory({}, frame.sizes(), kLens);
  FrameCoder& coder = *in_memory;
  struct Row {
    const char* name;
    Stream stream;
  };
  for (const Row& row : {Row{"depth", Stream::kDepth}, Row{"width", Stream::kWidth},
                         Row{"source", Stream::kSource}, Row{"disparity", Stream::kDisparity},
                         Row{"PMD samples", Stream::kPmdRaw}, Row{"left", Stream::kGreyLeft}}) {
    measure(frame, coder, row.name, only(row.stream, Coding::kRvl));
  }
  measure(frame, coder, "depth, fit", only(Stream::kDepth, Coding::kQuantised));
  measure(frame, coder, "width, fit", only(Stream::kWidth, Coding::kQuantised));
  measure(frame, coder, "depth, raw", only(Stream::kDepth, Coding::kRaw));
  measure(frame, coder, "cloud, step 8", only(Stream::kCloud, Coding::kRaw));
  measure(frame, coder, "both fit, source", usual(Coding::kQuantised, false));
  measure(frame, coder, "the same with parity", usual(Coding::kQuantised, true));
  measure(frame, coder, "depth, width, source", usual(Coding::kRvl, false));
  measure(frame, coder, "the same with parity", usual(Coding::kRvl, true));
  measure(frame, coder, "the same raw", usual(Coding::kRaw, false));
  print_growth(frame.images().map);
  std::vector<dsp::QuarterMm> small(2 * 160 * 120);
  const dsp::ImageView<dsp::QuarterMm> depth(small.data(), 160, 120);
  const dsp::ImageView<dsp::QuarterMm> width(small.data() + 160 * 120, 160, 120);
  std::printf("decimate by 4          %.3f ms\n",
              least_ms([&] { dsp::decimate(frame.images().map, 4, depth, width); }));
}

}  // namespace
}  // namespace stof::wire

int main(int argc, char** argv) {
  stof::wire::run(argc > 1 ? argv[1] : "fast");
  return 0;
}
