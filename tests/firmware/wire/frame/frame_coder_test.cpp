#include "firmware/wire/frame/frame_coder.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/rvl_decode.h"
#include "tests/firmware/wire/frame/coder_in_memory.h"
#include "tests/firmware/wire/wire_support.h"

namespace stof::wire {
namespace {

using test::Datagram;
using test::GuardedImage;
using test::kOrigin;
using test::Random;

constexpr FrameStamp kStamp{.number = 41,
                            .freshness = 40,
                            .exposure_middle_ns = 5,
                            .health = Health::kDegraded,
                            .clock = ClockState::kEmulated};
constexpr CalibrationPacket kLens{.fx = 1 << 22, .fy = 1 << 22, .cx = 1 << 21, .cy = 1 << 21};

struct Coder : test::CoderInMemory {
  explicit Coder(const FrameSizes& sizes) : CoderInMemory(kOrigin, sizes, kLens) {}
  Coder(const FrameSizes& sizes, std::size_t packets)
      : CoderInMemory(kOrigin, sizes, kLens, packets) {}
};

// Every image; rows of some have a gap, the last one ends at an unreadable page.
struct Images {
  Images(const FrameSizes& sizes, std::uint64_t seed, int most)
      : depth(sizes.width, sizes.height, sizes.width),
        width(sizes.width, sizes.height, sizes.width + 3),
        source(sizes.width, sizes.height, sizes.width + 1),
        cause(sizes.width, sizes.height, sizes.width),
        disparity(sizes.width, sizes.height, sizes.width + 2),
        left(sizes.width, sizes.height, sizes.width),
        right(sizes.width, sizes.height, sizes.width + 9) {
    Random random(seed);
    for (int k = 0; k < 4; ++k) {
      pmd.emplace_back(sizes.pmd_width, sizes.pmd_height, sizes.pmd_width + k);
      fill(pmd.back().view(), random, most);
    }
    fill(depth.view(), random, most);
    fill(width.view(), random, most);
    fill(left.view(), random, std::min(most, 255));
    fill(right.view(), random, std::min(most, 255));
    for (int y = 0; y < sizes.height; ++y) {
      for (int x = 0; x < sizes.width; ++x) {
        source.view().at(x, y) = static_cast<dsp::Source>(random.between(0, 5));
        cause.view().at(x, y) = static_cast<dsp::Cause>(random.between(0, 5));
        const int raw = random.between(-most / 2 - 1, most / 2);
        disparity.view().at(x, y) = dsp::Disparity::from_raw(static_cast<std::int16_t>(raw));
      }
    }
  }
  template <typename T>
  static void fill(dsp::ImageView<T> image, Random& random, int most) {
    for (int y = 0; y < image.height(); ++y) {
      random.fill(image.row(y), 0, most);
    }
  }

  FrameImages view() {
    return {.map = {depth.view(), width.view(), source.view(), cause.view()},
            .disparity = disparity.view(),
            .pmd = {pmd[0].view(), pmd[1].view(), pmd[2].view(), pmd[3].view()},
            .left = left.view(),
            .right = right.view()};
  }
  // What stream `stream` says of raster pixel i, as docs/WIRE.md has it.
  int pixel(Stream stream, const FrameSizes& sizes, int i) {
    const int x = i % sizes.width;
    const int y = i / sizes.width;
    switch (stream) {
      case Stream::kDepth:
        return depth.view().at(x, y);
      case Stream::kWidth:
        return width.view().at(x, y);
      case Stream::kSource:
        return static_cast<int>(source.view().at(x, y)) +
               16 * static_cast<int>(cause.view().at(x, y));
      case Stream::kDisparity:
        return disparity.view().at(x, y).raw + 32'768;
      case Stream::kGreyLeft:
        return left.view().at(x, y);
      case Stream::kGreyRight:
        return right.view().at(x, y);
      default: {
        const int row = i / sizes.pmd_width;
        const auto sample = static_cast<std::size_t>(row / sizes.pmd_height);
        return pmd[sample].view().at(i % sizes.pmd_width, row % sizes.pmd_height);
      }
    }
  }

  GuardedImage<dsp::QuarterMm> depth, width;
  GuardedImage<dsp::Source> source;
  GuardedImage<dsp::Cause> cause;
  GuardedImage<dsp::Disparity> disparity;
  GuardedImage<std::uint8_t> left, right;
  std::vector<GuardedImage<std::uint16_t>> pmd;
};

StreamChoice everything(Coding coding) {
  StreamChoice choice{.parity = true, .cloud_step = 3};
  choice.coding.fill(coding);
  return choice;
}

// What is told in steps, as it was.
std::vector<int> summed(std::vector<std::uint8_t> values, const Header& header) {
  for (std::size_t i = 1; i < values.size() && is_xor_delta(header); ++i) {
    if ((header.first_column + i) % header.image_width != 0) {
      values[i] ^= values[i - 1];
    }
  }
  return {values.begin(), values.end()};
}

// Pixels of a tile as numbers.
std::vector<int> pixels_of(const PacketView& tile) {
  const std::size_t count = tile.header.pixel_count;
  std::vector<std::uint16_t> values16(count);
  std::vector<std::uint8_t> values8(count);
  switch (tile.header.codec) {
    case Codec::kRaw16:
      get_pixels(tile.payload, std::span(values16));
      break;
    case Codec::kRvl16:
      EXPECT_EQ(rvl_decode<std::uint16_t>(tile.payload, values16), Status::kOk);
      break;
    case Codec::kRaw8:
      get_pixels(tile.payload, std::span(values8));
      return summed(values8, tile.header);
    default:
      EXPECT_EQ(tile.header.codec, Codec::kRvl8);
      EXPECT_EQ(rvl_decode<std::uint8_t>(tile.payload, values8), Status::kOk);
      return summed(values8, tile.header);
  }
  return {values16.begin(), values16.end()};
}

void expect_frame(std::span<const std::span<const std::byte>> datagrams, Images& images,
                  const FrameSizes& sizes, const StreamChoice& choice) {
  std::array<int, kStreams> next{};  // pixel
  std::array<std::uint16_t, kStreams> tiles{};
  const PacketView first = parse_packet(datagrams[0]).value();
  ASSERT_EQ(first.header.type, PacketType::kFrameInfo);
  const FrameInfo info = decode_frame_info(first.payload).value();
  const std::uint16_t parts = first.header.count;
  ASSERT_EQ(datagrams.size(), parts + (choice.parity ? parity_groups(parts) : 0U));
  auto last = Stream::kNone;
  for (std::size_t i = 1; i < parts; ++i) {
    const PacketView tile = parse_packet(datagrams[i]).value();
    ASSERT_EQ(tile.header.type, PacketType::kTile);
    ASSERT_EQ(tile.header.index, i);
    ASSERT_EQ(tile.header.count, parts);
    ASSERT_EQ(tile.header.frame.number, kStamp.number);
    ASSERT_TRUE(consistent_tile(tile));
    const Stream stream = tile.header.stream;
    ASSERT_GE(stream, last);
    last = stream;
    const std::size_t index = static_cast<std::size_t>(stream) - 1;
    ++tiles[index];
    if (stream == Stream::kCloud) {
      next[index] += tile.header.pixel_count;
      continue;
    }
    for (const int value : pixels_of(tile)) {
      ASSERT_EQ(value, images.pixel(stream, sizes, next[index])) << index << " at " << next[index];
      ++next[index];
    }
  }
  const int pixels = sizes.width * sizes.height;
  const int samples = 4 * sizes.pmd_width * sizes.pmd_height;
  const int points = (sizes.width + 2) / 3 * ((sizes.height + 2) / 3);
  for (std::size_t k = 0; k < kStreams; ++k) {
    const auto stream = static_cast<Stream>(k + 1);
    const int all = stream == Stream::kPmdRaw  ? samples
                    : stream == Stream::kCloud ? points
                                               : pixels;
    ASSERT_EQ(next[k], choice.coding[k] == Coding::kOff ? 0 : all);
  }
  EXPECT_EQ(info.tiles, tiles);
  EXPECT_EQ(info.parity_groups, choice.parity ? std::min<int>(parity_groups(parts), 255) : 0);
  EXPECT_EQ(info.cloud_step, choice.of(Stream::kCloud) != Coding::kOff ? 3 : 0);
  EXPECT_EQ(info.settings_revision, 17U);
}

TEST(FrameCoderTest, SendsEveryImageBitForBit) {
  for (const FrameSizes& sizes : {FrameSizes{37, 29, 11, 7}, FrameSizes{1, 1, 1, 1},
                                  FrameSizes{640, 31, 352, 5}, FrameSizes{1280, 9, 0, 0}}) {
    Coder coder(sizes);
    for (const int most : {30, 65'535}) {
      Images images(sizes, static_cast<std::uint64_t>(sizes.width), most);
      for (const Coding coding : {Coding::kRaw, Coding::kRvl}) {
        const auto sent =
            coder->code(kStamp, {.settings_revision = 17}, images.view(), everything(coding));
        ASSERT_TRUE(sent.has_value());
        expect_frame(*sent, images, sizes, everything(coding));
      }
    }
  }
}

// A byte that wraps would say of 256 that there is none.
TEST(FrameCoderTest, ManyPacketsOfParityAreNotToldAsNone) {
  StreamChoice choice{.parity = true};
  choice.of(Stream::kPmdRaw) = Coding::kRaw;
  std::set<std::size_t> told;
  for (int height = 956; height <= 969; height += 3) {  // a packet more for each row and sample
    const FrameSizes sizes{1, 1, 600, height};
    Coder coder(sizes);
    Images images(sizes, 1, 65'535);
    const auto sent = coder->code(kStamp, {.settings_revision = 17}, images.view(), choice);
    ASSERT_TRUE(sent.has_value());
    expect_frame(*sent, images, sizes, choice);
    told.insert(parity_groups(parse_packet(sent->front())->header.count));
  }
  EXPECT_TRUE(told.contains(255) && told.contains(256) && told.contains(257));
}

TEST(FrameCoderTest, SendsOnlyWhatIsChosen) {
  const FrameSizes sizes{64, 20, 16, 12};
  Coder coder(sizes);
  Images images(sizes, 1, 500);
  for (std::size_t k = 0; k < kStreams; ++k) {
    StreamChoice choice{.cloud_step = 3};
    choice.coding[k] = Coding::kRvl;
    const auto sent = coder->code(kStamp, {.settings_revision = 17}, images.view(), choice);
    ASSERT_TRUE(sent.has_value());
    expect_frame(*sent, images, sizes, choice);
  }
  const auto nothing = coder->code(kStamp, {}, images.view(), {});
  ASSERT_EQ(nothing->size(), 1U);
  EXPECT_EQ(parse_packet(nothing->front())->header.count, 1);
}

TEST(FrameCoderTest, SendsOnlyWhatIsThere) {
  const FrameSizes sizes{64, 20, 16, 12};
  Coder coder(sizes);
  const auto sent = coder->code(kStamp, {}, {}, everything(Coding::kRvl));
  ASSERT_EQ(sent->size(), 2U);  // frame info and its parity
  EXPECT_EQ(parse_packet(sent->front())->header.image_width, 64);
}

TEST(FrameCoderTest, RefusesImagesLargerThanSaid) {
  Coder coder({32, 20, 16, 12});
  Images larger({33, 20, 16, 12}, 1, 5);
  EXPECT_EQ(coder->code(kStamp, {}, larger.view(), {}).error(), Status::kTooLarge);
  Images more_pmd({32, 20, 16, 13}, 1, 5);
  EXPECT_EQ(coder->code(kStamp, {}, more_pmd.view(), {}).error(), Status::kTooLarge);
  Images smaller({31, 19, 15, 11}, 1, 5);
  EXPECT_TRUE(coder->code(kStamp, {}, smaller.view(), everything(Coding::kRaw)).has_value());
}

// Keeps copies, as the datagrams are gone afterwards.
struct Kept final : DatagramSink {
  void take(Datagrams datagrams, std::size_t all) noexcept override {
    most = std::max(most, datagrams.size());
    told.push_back(all);
    for (const std::span<const std::byte> datagram : datagrams) {
      sent.emplace_back(datagram.begin(), datagram.end());
    }
  }
  std::vector<std::vector<std::byte>> sent;
  std::vector<std::size_t> told;
  std::size_t most = 0;
};

// whole: what a coder with enough memory sends.
void expect_same_in_little(const FrameSizes& sizes, Images& images, const StreamChoice& choice,
                           Datagrams whole, std::size_t packets) {
  SCOPED_TRACE(std::to_string(sizes.width) + " wide in " + std::to_string(packets));
  Coder little(sizes, packets);
  for (int repeat = 0; repeat < 2; ++repeat) {  // nothing is left of the frame before
    Kept kept;
    ASSERT_EQ(little->code(kStamp, {}, images.view(), choice, kept), Status::kOk);
    ASSERT_EQ(kept.sent.size(), whole.size());
    for (std::size_t i = 0; i < whole.size(); ++i) {
      ASSERT_TRUE(std::ranges::equal(kept.sent[i], whole[i])) << "datagram " << i;
    }
    ASSERT_TRUE(std::ranges::all_of(kept.told, [&](std::size_t n) { return n == whole.size(); }));
    ASSERT_LE(kept.most, std::max<std::size_t>(packets, 8) + 1);
  }
  const auto at_once = little->code(kStamp, {}, images.view(), choice);
  if (whole.size() > std::max<std::size_t>(packets, 8) + 1) {
    ASSERT_EQ(at_once.error(), Status::kTooLarge);
  }
}

TEST(FrameCoderTest, LittleMemorySendsTheSame) {
  for (const FrameSizes& sizes : {FrameSizes{37, 29, 11, 7}, FrameSizes{640, 31, 352, 5},
                                  FrameSizes{1280, 9, 0, 0}, FrameSizes{320, 100, 64, 40}}) {
    for (const int most : {2, 30, 2000, 65'535}) {  // from steps to noise, which goes raw
      Images images(sizes, static_cast<std::uint64_t>(sizes.width + most), most);
      for (const Coding coding : {Coding::kRaw, Coding::kRvl, Coding::kQuantised}) {
        for (const bool parity : {true, false}) {
          StreamChoice choice = everything(coding);
          choice.parity = parity;
          Coder large(sizes);
          const Datagrams whole = large->code(kStamp, {}, images.view(), choice).value();
          for (const std::size_t packets : {0U, 8U, 9U, 33U}) {
            expect_same_in_little(sizes, images, choice, whole, packets);
          }
        }
      }
    }
  }
}

// Attempts at shorter codes take more memory than what they end with.
TEST(FrameCoderTest, HardlyEnoughMemorySendsTheSame) {
  for (const FrameSizes& sizes : {FrameSizes{640, 31, 0, 0}, FrameSizes{1280, 40, 0, 0}}) {
    for (const int most : {30, 2000, 65'535}) {
      Images images(sizes, static_cast<std::uint64_t>(sizes.width + most), most);
      for (const Coding coding : {Coding::kRvl, Coding::kQuantised}) {
        for (const Stream last : {Stream::kDepth, Stream::kWidth, Stream::kSource}) {
          StreamChoice choice;
          for (Stream stream = Stream::kDepth; stream <= last;
               stream = static_cast<Stream>(static_cast<int>(stream) + 1)) {
            choice.of(stream) = coding;
          }
          Coder large(sizes);
          const Datagrams whole = large->code(kStamp, {}, images.view(), choice).value();
          const std::size_t all = whole.size();
          for (std::size_t packets = all - std::min<std::size_t>(all, 4); packets <= all;
               ++packets) {
            expect_same_in_little(sizes, images, choice, whole, packets);
          }
        }
      }
    }
  }
}

TEST(FrameCoderTest, EachLostDatagramComesBackFromParity) {
  const FrameSizes sizes{160, 90, 32, 24};
  Coder coder(sizes);
  Images images(sizes, 4, 300);
  const auto sent = coder->code(kStamp, {}, images.view(), everything(Coding::kRvl)).value();
  const std::uint16_t count = parse_packet(sent[0])->header.count;
  const std::uint16_t groups = parity_groups(count);
  for (std::size_t lost = 0; lost < count; ++lost) {
    ParityGroup group;
    for (std::size_t i = lost % groups; i < sent.size(); i += groups) {
      const PacketView packet = parse_packet(sent[i]).value();
      if (packet.header.type != PacketType::kParity && i != lost) {
        ASSERT_EQ(group.add(packet.header, packet.payload), Status::kOk);
      }
    }
    const PacketView parity = parse_packet(sent[count + lost % groups]).value();
    ASSERT_EQ(group.add_parity(parity), Status::kOk);
    const Result<PacketView> found = group.recover();
    ASSERT_TRUE(found.has_value());
    DatagramBuffer buffer{};
    std::ranges::copy(found->payload, payload_space(buffer).begin());
    EXPECT_TRUE(
        std::ranges::equal(seal_packet(found->header, found->payload.size(), buffer), sent[lost]));
  }
}

}  // namespace
}  // namespace stof::wire
