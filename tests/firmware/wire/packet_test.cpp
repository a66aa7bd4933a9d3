#include "firmware/wire/packet.h"

#include <algorithm>
#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "tests/firmware/wire/wire_support.h"

namespace stof::wire {
namespace {

using test::Datagram;
using test::parse_guarded;

// Every field has another value, so that a swap shows.
Header some_header() {
  return {.type = PacketType::kTile,
          .flags = 0x81,
          .origin = {.device_id = 0xDEADBEEF, .session_id = 0x12345678},
          .frame = {.number = 0xFFFFFFFE,
                    .freshness = 0x80000001,
                    .exposure_middle_ns = -0x0123456789ABCDEF,
                    .health = Health::kFault,
                    .clock = ClockState::kEmulated},
          .stream = Stream::kSource,
          .codec = Codec::kRaw8,
          .index = 0x0102,
          .count = 0x0304,
          .image_width = 0x0506,
          .image_height = 0x0708,
          .first_row = 0x0701,
          .first_column = 0x0505,
          .pixel_count = 40};
}

Datagram some_packet(std::size_t payload_bytes = 40, const Header& header = some_header()) {
  DatagramBuffer buffer{};
  test::Random random(payload_bytes);
  for (std::byte& byte : payload_space(buffer)) {
    byte = static_cast<std::byte>(random.next());
  }
  const std::span<const std::byte> sealed = seal_packet(header, payload_bytes, buffer);
  return {sealed.begin(), sealed.end()};
}

void reseal(Datagram& datagram) {
  const std::span<std::byte> bytes(datagram);
  put_u32(bytes.last<4>(), crc32c(bytes.first(bytes.size() - 4)));
}

Datagram changed(Datagram datagram, std::size_t offset, std::uint8_t value) {
  datagram.at(offset) = std::byte{value};
  return datagram;
}

PacketFault fault_of(const Datagram& datagram) {
  const auto parsed = parse_guarded(datagram);
  return parsed ? PacketFault{255} : parsed.error();
}

TEST(Packet, CarriesEveryFieldUnchanged) {
  const Datagram datagram = some_packet();
  const auto parsed = parse_packet(datagram);
  ASSERT_TRUE(parsed);
  const Header want = some_header();
  const Header& got = parsed->header;
  EXPECT_EQ(got.type, want.type);
  EXPECT_EQ(got.flags, want.flags);
  EXPECT_EQ(got.origin.device_id, want.origin.device_id);
  EXPECT_EQ(got.origin.session_id, want.origin.session_id);
  EXPECT_EQ(got.frame.number, want.frame.number);
  EXPECT_EQ(got.frame.freshness, want.frame.freshness);
  EXPECT_EQ(got.frame.exposure_middle_ns, want.frame.exposure_middle_ns);
  EXPECT_EQ(got.frame.health, want.frame.health);
  EXPECT_EQ(got.frame.clock, want.frame.clock);
  EXPECT_EQ(got.stream, want.stream);
  EXPECT_EQ(got.codec, want.codec);
  EXPECT_EQ(got.index, want.index);
  EXPECT_EQ(got.count, want.count);
  EXPECT_EQ(got.image_width, want.image_width);
  EXPECT_EQ(got.image_height, want.image_height);
  EXPECT_EQ(got.first_row, want.first_row);
  EXPECT_EQ(got.first_column, want.first_column);
  EXPECT_EQ(got.pixel_count, want.pixel_count);
  EXPECT_TRUE(std::ranges::equal(parsed->payload, std::span(datagram).subspan(kHeaderBytes, 40)));
}

TEST(Packet, HasRoomForNothingUpToTheLargestPayload) {
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, kMaxPayload - 1, kMaxPayload}) {
    const Datagram datagram = some_packet(bytes);
    EXPECT_EQ(datagram.size(), kHeaderBytes + bytes + kCrcBytes);
    const auto parsed = parse_packet(datagram);
    ASSERT_TRUE(parsed) << bytes;
    EXPECT_EQ(parsed->payload.size(), bytes);
  }
  EXPECT_EQ(some_packet(kMaxPayload).size(), kMaxDatagram);
}

TEST(Packet, EverySingleBitFlipIsRejected) {
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{40}, kMaxPayload}) {
    const Datagram good = some_packet(bytes);
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
      Datagram bad = good;
      bad[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
      ASSERT_FALSE(parse_packet(bad)) << "bit " << bit << " of " << good.size() << " bytes";
    }
  }
}

TEST(Packet, EveryTruncationIsRejectedAsSuch) {
  const Datagram good = some_packet();
  for (std::size_t length = 0; length < good.size(); ++length) {
    ASSERT_EQ(fault_of({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)}),
              PacketFault::kTruncated)
        << length;
  }
}

TEST(Packet, EveryTrailingByteIsRejected) {
  Datagram longer = some_packet();
  longer.push_back(std::byte{0});
  EXPECT_EQ(fault_of(longer), PacketFault::kLength);
  Datagram longest = some_packet(kMaxPayload);
  longest.push_back(std::byte{0});
  EXPECT_EQ(fault_of(longest), PacketFault::kLength);
}

TEST(Packet, RejectsWithTheExactReason) {
  const Datagram good = some_packet();
  EXPECT_EQ(fault_of(changed(good, 0, 's')), PacketFault::kMagic);
  EXPECT_EQ(fault_of(changed(good, 60, std::to_integer<std::uint8_t>(good.at(60)) ^ 1)),
            PacketFault::kCrc);
  Datagram version = changed(good, 4, 2);
  reseal(version);
  EXPECT_EQ(fault_of(version), PacketFault::kVersion);
  Datagram header_length = changed(good, 6, 51);
  reseal(header_length);
  EXPECT_EQ(fault_of(header_length), PacketFault::kLength);
  Header header = some_header();
  header.index = header.count;
  EXPECT_EQ(fault_of(some_packet(40, header)), PacketFault::kField);
  header.index = header.count = 0;
  EXPECT_EQ(fault_of(some_packet(40, header)), PacketFault::kField);
}

TEST(Packet, HostileLengthsNeverReachBeyondTheBytes) {
  for (int header_length = 0; header_length <= 255; ++header_length) {
    for (const int payload : {0, 1, 39, 40, 41, 1176, 1177, 32767, 32768, 65534, 65535}) {
      Datagram bad = some_packet();
      bad[6] = static_cast<std::byte>(header_length);
      put_u16(std::span(bad).subspan<50, 2>(), static_cast<std::uint16_t>(payload));
      reseal(bad);
      const bool fits = header_length >= 52 && header_length + payload == 92;
      ASSERT_EQ(parse_guarded(bad).has_value(), fits) << header_length << " " << payload;
    }
  }
}

TEST(Packet, SkipsTheTailOfANewerHeader) {
  Datagram newer = some_packet();
  newer.insert(newer.begin() + kHeaderBytes, 8, std::byte{0xEE});
  newer[6] = std::byte{kHeaderBytes + 8};
  reseal(newer);
  const auto parsed = parse_packet(newer);
  ASSERT_TRUE(parsed);
  const Datagram old = some_packet();
  EXPECT_TRUE(std::ranges::equal(parsed->payload, std::span(old).subspan(kHeaderBytes, 40)));
}

TEST(Packet, RandomMutationsAreRejectedAndHarmless) {
  test::Random random(3);
  const Datagram good = some_packet();
  test::GuardedBuffer<std::byte> guarded(good.size());
  for (int round = 0; round < 100'000; ++round) {
    std::ranges::copy(good, guarded.span().begin());
    const int changes = random.between(1, 8);
    for (int i = 0; i < changes; ++i) {
      const int at = random.between(0, static_cast<int>(good.size()) - 1);
      guarded[static_cast<std::size_t>(at)] = static_cast<std::byte>(random.next());
    }
    // The end of the bytes stays at the unreadable page.
    const int cut =
        random.between(0, 3) == 0 ? random.between(0, static_cast<int>(good.size())) : 0;
    const std::span<const std::byte> bytes =
        std::span<const std::byte>(guarded.span()).subspan(static_cast<std::size_t>(cut));
    const auto parsed = parse_packet(bytes);
    ASSERT_TRUE(!parsed || std::ranges::equal(bytes, good)) << "round " << round;
  }
}

TEST(Packet, UnknownNamesAreNoError) {
  Header header = some_header();
  header.type = PacketType{63};
  header.stream = Stream{200};
  header.codec = Codec{99};
  header.frame.health = Health{77};
  const Datagram datagram = some_packet(5, header);
  const auto parsed = parse_packet(datagram);
  ASSERT_TRUE(parsed);
  EXPECT_TRUE(part_of_frame(parsed->header.type));
  EXPECT_FALSE(part_of_frame(PacketType::kCalibration));
  EXPECT_EQ(pixel_bytes(parsed->header.stream, parsed->header.codec), 0U);
}

// 3 x 2 pixels of 16 bits: every run that lies in the image, and nothing else, is consistent.
TEST(Tile, IsConsistentExactlyWhenItLiesInItsImage) {
  const std::vector<std::byte> payload(40);
  for (std::uint16_t row = 0; row < 4; ++row) {
    for (std::uint16_t column = 0; column < 5; ++column) {
      for (std::uint16_t count = 0; count < 9; ++count) {
        for (std::size_t bytes = 0; bytes < 20; ++bytes) {
          const PacketView packet{.header = {.stream = Stream::kDepth,
                                             .codec = Codec::kRaw16,
                                             .image_width = 3,
                                             .image_height = 2,
                                             .first_row = row,
                                             .first_column = column,
                                             .pixel_count = count},
                                  .payload = std::span(payload).first(bytes)};
          const bool inside = column < 3 && row * 3 + column + count <= 6;
          ASSERT_EQ(consistent_tile(packet), inside && count > 0 && bytes == 2U * count)
              << row << " " << column << " " << count << " " << bytes;
        }
      }
    }
  }
}

TEST(Tile, OnlyDepthAndWidthHaveAScaleAndOnlySourceHasSteps) {
  const std::vector<std::byte> payload(8);
  for (const auto& [stream, codec, allowed] : {std::tuple{Stream::kDepth, Codec::kRaw16, true},
                                               {Stream::kDepth, Codec::kRvl16, true},
                                               {Stream::kWidth, Codec::kRaw16, true},
                                               {Stream::kWidth, Codec::kRvl16, true},
                                               {Stream::kSource, Codec::kRaw8, false},
                                               {Stream::kSource, Codec::kRvl8, false},
                                               {Stream::kDisparity, Codec::kRaw16, false},
                                               {Stream::kPmdRaw, Codec::kRvl16, false},
                                               {Stream::kGreyLeft, Codec::kRaw8, false},
                                               {Stream::kCloud, Codec::kPoints, false}}) {
    const std::size_t bytes = raw_pixel_bytes(codec) == 0 ? 8 : raw_pixel_bytes(codec);
    PacketView packet{
        .header = {.stream = stream, .codec = codec, .image_width = 1, .image_height = 1},
        .payload = std::span(payload).first(bytes)};
    packet.header.pixel_count = 1;
    for (unsigned flags = 0; flags < 256; ++flags) {  // bits 5 to 7 are ignored
      packet.header.flags = static_cast<std::uint8_t>(flags);
      const bool xor_delta = (flags & kXorDeltaFlag) != 0;
      EXPECT_EQ(consistent_tile(packet),
                (allowed || flags % 16 == 0) && (!xor_delta || stream == Stream::kSource))
          << flags;
    }
  }
}

TEST(Tile, StatesAtTheEndsOfTheirRangesDoNotWrap) {
  const std::vector<std::byte> payload(kMaxPayload);
  PacketView packet{.header = {.stream = Stream::kSource,
                               .codec = Codec::kRaw8,
                               .image_width = 65535,
                               .image_height = 65535,
                               .first_row = 65534,
                               .first_column = 65534,
                               .pixel_count = 1},
                    .payload = std::span(payload).first(1)};
  EXPECT_TRUE(consistent_tile(packet));
  packet.header.first_row = 65535;
  EXPECT_FALSE(consistent_tile(packet));
  packet.header.image_width = 0;
  packet.header.first_row = 0;
  packet.header.first_column = 0;
  EXPECT_FALSE(consistent_tile(packet));
}

}  // namespace
}  // namespace stof::wire
