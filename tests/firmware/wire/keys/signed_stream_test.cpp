#include "firmware/wire/keys/signed_stream.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/frame/parity.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/support/heap_guard.h"

namespace stof::wire {
namespace {

using Bytes = std::vector<std::byte>;

// The first block between ```hex and ``` below a heading of docs/WIRE.md.
Bytes of_document(const std::string& heading) {
  std::ifstream file(STOF_WIRE_DOCUMENT);
  Bytes bytes;
  std::string line;
  while (std::getline(file, line) && line != heading) {
  }
  while (std::getline(file, line) && line != "```hex") {
  }
  while (std::getline(file, line) && line != "```") {
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      unsigned value = 256;
      std::from_chars(word.data(), word.data() + word.size(), value, 16);
      bytes.push_back(static_cast<std::byte>(value));
    }
  }
  return bytes;
}

StreamKey counting_key(std::uint32_t number = 1) {
  StreamKey key{.number = number};
  for (std::size_t i = 0; i < key.secret.size(); ++i) {
    key.secret[i] = static_cast<std::byte>(i);
  }
  return key;
}

Bytes plain(std::size_t payload_bytes) {
  DatagramBuffer buffer{};
  std::ranges::fill(payload_space(buffer).first(payload_bytes), std::byte{0x5A});
  const auto sealed =
      seal_packet({.origin = {.device_id = 1, .session_id = 2}}, payload_bytes, buffer);
  return {sealed.begin(), sealed.end()};
}

Bytes signed_by(const StreamKey& key, std::uint64_t counter, std::span<const std::byte> datagram) {
  DatagramBuffer buffer{};
  StreamTagger tagger(key);
  const auto made = sign_datagram(datagram, tagger, counter, buffer);
  return {made.begin(), made.end()};
}

bool good(const StreamKey& key, std::span<const std::byte> datagram) {
  const auto signature = signature_of(datagram);
  return signature && signed_with(StreamTagger(key), *signature, datagram);
}

class SignedStream : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(start_crypto()); }
};

// The document's bytes were computed by plain Python, written from RFC 8439.
TEST_F(SignedStream, TheWorkedDatagramIsWhatTheDocumentSays) {
  const Bytes packet = of_document("## A worked packet");
  const Bytes expected = of_document("## The same packet, signed");
  ASSERT_EQ(expected.size(), packet.size() + kStreamSignatureBytes);
  EXPECT_EQ(signed_by(counting_key(), 39, packet), expected);
  EXPECT_TRUE(good(counting_key(), expected));
}

// Whether it comes of a block or is made by itself, before, behind and within the one that is kept.
TEST_F(SignedStream, EachCounterHasAKeyOfItsOwnHoweverItIsMade) {
  StreamTagger kept(counting_key());
  kept.keep(40);
  StreamTagger tagger(counting_key());
  std::set<OneTimeKey> all;
  for (std::uint64_t counter = 0; counter < 100; ++counter) {
    tagger.keep(counter);
    const OneTimeKey key = tagger.key_of(counter);
    EXPECT_EQ(key, StreamTagger(counting_key()).key_of(counter)) << counter;
    EXPECT_EQ(key, kept.key_of(counter)) << counter;
    EXPECT_TRUE(all.insert(key).second) << counter;
  }
  tagger.keep(3);  // older: stays where it is
  EXPECT_EQ(tagger.key_of(3), kept.key_of(3));
  EXPECT_EQ(tagger.key_of(99), kept.key_of(99));
  // The same secret under another number has other keys.
  EXPECT_FALSE(all.contains(StreamTagger(counting_key(2)).key_of(5)));
}

TEST_F(SignedStream, TheLastCountersHaveKeysToo) {
  const std::uint64_t last = ~std::uint64_t{0};
  StreamTagger tagger(counting_key());
  for (const std::uint64_t counter : {last - 16, last - 15, last - 1, last}) {
    tagger.keep(counter);
    EXPECT_EQ(tagger.key_of(counter), StreamTagger(counting_key()).key_of(counter));
  }
}

TEST_F(SignedStream, ReadersThatKnowNothingOfItReadWhatTheyReadBefore) {
  for (const std::size_t bytes :
       {std::size_t{0}, std::size_t{1}, std::size_t{15}, kParityFieldsBytes + kMaxTilePayload}) {
    const Bytes before = plain(bytes);
    const Bytes after = signed_by(counting_key(), 1, before);
    ASSERT_LE(after.size(), kMaxDatagram);
    const auto is = parse_packet(after);
    const auto was = parse_packet(before);
    ASSERT_TRUE(is && was);
    EXPECT_TRUE(std::ranges::equal(is->payload, was->payload));
    EXPECT_EQ(is->header.origin.session_id, 2U);
    EXPECT_FALSE(signature_of(before).has_value());
  }
}

TEST_F(SignedStream, EveryByteIsCovered) {
  const Bytes made = signed_by(counting_key(), 3, plain(100));
  for (std::size_t at = 0; at + kCrcBytes < made.size(); ++at) {
    for (const unsigned bit : {0U, 7U}) {
      Bytes changed = made;
      changed[at] ^= std::byte{1} << bit;
      put_u32(std::span(changed).last<kCrcBytes>(),
              crc32c(std::span(changed).first(changed.size() - kCrcBytes)));
      if (parse_packet(changed)) {  // else nobody looks at it
        EXPECT_FALSE(good(counting_key(), changed)) << "byte " << at;
      }
    }
  }
}

TEST_F(SignedStream, AnotherKeyOrCounterIsNoneOfIt) {
  const Bytes made = signed_by(counting_key(), 3, plain(100));
  StreamKey other = counting_key();
  other.secret[31] ^= std::byte{1};
  EXPECT_FALSE(good(other, made));
  EXPECT_NE(signed_by(counting_key(), 4, plain(100)), made);
}

TEST_F(SignedStream, TheKeyIsHandedOverToWhoeverHasTheSecretAlone) {
  const Key key = test::numbered_key(4);
  const Origin sensor{.device_id = 1, .session_id = 7};
  const StreamKey stream = counting_key(9);
  const StreamKeyFields fields =
      seal_stream_key(stream, {.sensor = sensor, .key = key, .counter = 5});
  EXPECT_EQ(open_stream_key(fields, {.sensor = sensor, .key = key, .counter = 5}), stream);
  EXPECT_FALSE(std::ranges::equal(std::as_bytes(std::span(fields.sealed)), stream.secret));
  // Another secret, answer or session hides it.
  const Key other = test::numbered_key(5);
  EXPECT_NE(open_stream_key(fields, {.sensor = sensor, .key = other, .counter = 5}), stream);
  EXPECT_NE(open_stream_key(fields, {.sensor = sensor, .key = key, .counter = 6}), stream);
  EXPECT_NE(open_stream_key(
                fields, {.sensor = {.device_id = 1, .session_id = 8}, .key = key, .counter = 5}),
            stream);
}

// Of a sensor that makes tags in another way nothing could be verified.
TEST_F(SignedStream, AKeyForOtherTagsIsNone) {
  const Key key = test::numbered_key(4);
  const KeyHandover to{.sensor = {.device_id = 1, .session_id = 7}, .key = key, .counter = 5};
  StreamKeyFields fields = seal_stream_key(counting_key(9), to);
  for (const int tags : {0, 2, 255}) {
    fields.tags = static_cast<std::uint8_t>(tags);
    EXPECT_EQ(open_stream_key(fields, to), StreamKey{}) << tags;
  }
  fields.tags = kStreamTags;
  EXPECT_EQ(open_stream_key(fields, to), counting_key(9));
}

TEST_F(SignedStream, AllocatesNothing) {
  const Bytes datagram = plain(kMaxTilePayload);
  StreamTagger tagger(counting_key());
  DatagramBuffer buffer{};
  const int before = test::allocations;
  for (std::uint64_t counter = 1; counter < 100; ++counter) {
    const auto made = sign_datagram(datagram, tagger, counter, buffer);
    ASSERT_TRUE(signed_with(tagger, *signature_of(made), made));
  }
  EXPECT_EQ(test::allocations, before);
}

}  // namespace
}  // namespace stof::wire
