// Names and messages of DNS, also those that nobody should send.
#include "firmware/wire/dns.h"

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::wire::dns {
namespace {

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> out;
  for (const int value : values) {
    out.push_back(static_cast<std::byte>(value));
  }
  return out;
}

std::vector<std::byte> with_header(std::initializer_list<int> body, int questions = 1) {
  std::vector<std::byte> out(kHeaderBytes);
  out[5] = static_cast<std::byte>(questions);
  const auto rest = bytes(body);
  out.insert(out.end(), rest.begin(), rest.end());
  return out;
}

// Reads all that a message says it has, and the names in its data. How many records there were.
int read_all(std::span<const std::byte> message) {
  Reader reader(message);
  const auto header = reader.header();
  if (!header) {
    return 0;
  }
  for (int i = 0; i < header->questions; ++i) {
    if (!reader.question()) {
      return 0;
    }
  }
  int records = 0;
  for (int i = 0; i < header->answers + header->authorities + header->additionals; ++i) {
    const auto record = reader.record();
    if (!record) {
      return records;
    }
    static_cast<void>(reader.name_at(record->data_offset));
    static_cast<void>(reader.name_at(record->data_offset + 6));
    ++records;
  }
  return records;
}

TEST(DnsName, ComparesWithoutRegardToCapitals) {
  EXPECT_EQ((Name{"Stof", "LOCAL"}), (Name{"stof", "local"}));
  EXPECT_FALSE((Name{"stof", "local"}) == (Name{"stof"}));
  EXPECT_FALSE((Name{"ab"}) == (Name{"a", "b"}));
}

TEST(DnsName, RefusesLabelsThatDoNotFit) {
  Name name;
  EXPECT_EQ(name.append(""), Status::kTooLarge);
  EXPECT_EQ(name.append(std::string(64, 'x')), Status::kTooLarge);
  EXPECT_TRUE(name.is_root());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(name.append(std::string(63, 'x')), Status::kOk);
  }
  EXPECT_EQ(name.append(std::string(62, 'x')), Status::kTooLarge);  // 256 bytes
  EXPECT_EQ(name.append(std::string(61, 'x')), Status::kOk);        // 255
  EXPECT_EQ(name.bytes().size(), Name::kMost);
}

TEST(DnsReader, FollowsPointersBack) {
  const auto message = with_header({2, 'a', 'b', 0, 0, 1, 0, 1,      // ab at 12
                                    1, 'c', 0xc0, 12, 0, 1, 0, 1});  // c.ab
  Reader reader(message);
  ASSERT_TRUE(reader.header());
  ASSERT_TRUE(reader.question());
  const auto question = reader.question();
  ASSERT_TRUE(question);
  EXPECT_EQ(question->name, (Name{"c", "ab"}));
  EXPECT_EQ(question->type, Type::kA);
}

TEST(DnsReader, RefusesNamesThatDoNotEnd) {
  for (const auto& message : {
           with_header({0xc0, 12, 0, 1, 0, 1}),            // points at itself
           with_header({0xc0, 14, 0xc0, 12, 0, 1, 0, 1}),  // forward
           with_header({1, 'a', 0xc0, 12, 0, 1, 0, 1}),    // round and round
           with_header({0xc0, 0, 0, 1, 0, 1}),             // into the header
           with_header({0x40, 'a', 0, 0, 1, 0, 1}),        // kinds of label that are not ours
           with_header({0x80, 'a', 0, 0, 1, 0, 1}),
           with_header({5, 'a', 'b'}),  // ends inside
           with_header({0xc0}),
           with_header({}),
       }) {
    Reader reader(message);
    ASSERT_TRUE(reader.header());
    EXPECT_FALSE(reader.question());
  }
}

TEST(DnsWriter, WritesNamesOnceAndReadsThemBack) {
  std::array<std::byte, 512> space{};
  Writer writer(space, 7, kResponse);
  EXPECT_TRUE(writer.empty());
  writer.begin_record({"_stof", "_udp", "local"}, Type::kPtr, kInternet, 0x01020304);
  writer.data_name({"x", "_stof", "_udp", "local"});
  ASSERT_TRUE(writer.finish(Writer::Section::kAnswer));
  const std::size_t first = writer.message().size();
  EXPECT_EQ(first, kHeaderBytes + 18 + 10 + 4);  // the second name is a label and a pointer
  writer.begin_record({"x", "_stof", "_udp", "local"}, Type::kTxt, kInternet | kTopBit, 1);
  writer.data_text("key", "value");
  ASSERT_TRUE(writer.finish(Writer::Section::kAdditional));
  EXPECT_EQ(writer.message().size(), first + 2 + 10 + 10);

  Reader reader(writer.message());
  const auto header = reader.header();
  ASSERT_TRUE(header);
  EXPECT_EQ(header->id, 7);
  EXPECT_EQ(header->answers, 1);
  EXPECT_EQ(header->additionals, 1);
  const auto pointer = reader.record();
  ASSERT_TRUE(pointer);
  EXPECT_EQ(pointer->ttl_s, 0x01020304U);
  EXPECT_EQ(*reader.name_at(pointer->data_offset), (Name{"x", "_stof", "_udp", "local"}));
  const auto text = reader.record();
  ASSERT_TRUE(text);
  EXPECT_EQ(text->name, (Name{"x", "_stof", "_udp", "local"}));
  EXPECT_EQ(text->data.size(), 10U);
}

TEST(DnsWriter, LeavesOutWhatDoesNotFit) {
  for (std::size_t size = kHeaderBytes; size < 80; ++size) {
    test::GuardedBuffer<std::byte> space(size);
    Writer writer(space.span(), 0, 0);
    int fitted = 0;
    for (int i = 0; i < 3; ++i) {
      writer.begin_record({"a", "local"}, Type::kA, kInternet, 1);
      writer.data(bytes({1, 2, 3, 4}));
      fitted += writer.finish(Writer::Section::kAnswer) ? 1 : 0;
    }
    EXPECT_EQ(read_all(writer.message()), fitted);
  }
}

// Every byte lies before an unreadable page.
TEST(DnsReader, ReadsNothingOutsideOfAnyBytes) {
  std::array<std::byte, 512> space{};
  Writer writer(space, 0, kResponse);
  static_cast<void>(writer.question({"_stof", "_udp", "local"}, Type::kPtr, kInternet));
  for (int i = 0; i < 4; ++i) {
    writer.begin_record({"x", "_stof", "_udp", "local"}, Type::kSrv, kInternet, 1);
    writer.data(bytes({0, 0, 0, 0, 1, 2}));
    writer.data_name({"host", "local"});
    ASSERT_TRUE(writer.finish(Writer::Section::kAnswer));
  }
  const auto good = writer.message();
  for (std::size_t size = 0; size <= good.size(); ++size) {
    test::GuardedBuffer<std::byte> cut(size);
    std::ranges::copy(good.first(size), cut.span().begin());
    EXPECT_EQ(read_all(cut.span()) == 4, size == good.size());
  }
  test::Random random(11);
  test::GuardedBuffer<std::byte> damaged(good.size());
  const int last = static_cast<int>(good.size()) - 1;
  for (int round = 0; round < 20'000; ++round) {
    std::ranges::copy(good, damaged.span().begin());
    for (int i = 0; i < 1 + round % 4; ++i) {
      damaged[static_cast<std::size_t>(random.between(0, last))] =
          static_cast<std::byte>(random.next());
    }
    EXPECT_LE(read_all(damaged.span()), 3 * 65535);
  }
}

}  // namespace
}  // namespace stof::wire::dns
