#include "firmware/wire/keys/key_text.h"

#include <string>

#include <gtest/gtest.h>

#include "firmware/wire/crc32c.h"
#include "tests/firmware/keys/some_keys.h"

namespace stof::wire {
namespace {

using test::numbered_key;

std::string text_of(const KeyTable& keys) {
  std::string space(kMostKeyText, '\0');
  const std::span<char> text = write_keys(keys, space);
  return {text.begin(), text.end()};
}

bool same(const KeyTable& a, const KeyTable& b) { return std::ranges::equal(a.all(), b.all()); }

TEST(KeyTable, KeepsWhatWasAddedInOrderUntilItIsRemoved) {
  KeyTable keys;
  for (const std::uint32_t id : {3U, 1U, 2U}) {
    EXPECT_EQ(keys.add(numbered_key(id)), Status::kOk);
  }
  EXPECT_TRUE(keys.remove(1));
  EXPECT_FALSE(keys.remove(1));
  ASSERT_EQ(keys.count(), 2U);
  EXPECT_EQ(keys.all()[0], numbered_key(3));
  EXPECT_EQ(keys.all()[1], numbered_key(2));
  EXPECT_EQ(keys.find(1), nullptr);
  ASSERT_NE(keys.find(2), nullptr);
}

TEST(KeyTable, RefusesTwoOfOneNumberAndKeysOfNobody) {
  KeyTable keys;
  EXPECT_EQ(keys.add(numbered_key(0)), Status::kInvalidArgument);
  EXPECT_EQ(keys.add(numbered_key(1, Role::kNone)), Status::kInvalidArgument);
  EXPECT_EQ(keys.add(numbered_key(1)), Status::kOk);
  EXPECT_EQ(keys.add(numbered_key(1)), Status::kInvalidArgument);
  for (std::uint32_t id = 2; id <= KeyTable::kMost; ++id) {
    EXPECT_EQ(keys.add(numbered_key(id)), Status::kOk);
  }
  EXPECT_EQ(keys.add(numbered_key(1000)), Status::kTooLarge);
}

TEST(KeyTable, NamesAreWordsThatCanBePrinted) {
  const auto text = [](std::string_view name) {
    return std::string(Key{.name = key_name(name)}.name_text());
  };
  EXPECT_EQ(text("ann@robot-3.lab_B"), "ann@robot-3.lab_B");
  EXPECT_EQ(text("a b\n\x1b\xff"), "a-b---");
  EXPECT_EQ(text(""), "-");
  EXPECT_EQ(text(std::string(50, 'x')), std::string(kKeyNameBytes, 'x'));
}

TEST(KeyText, ReadsWhatItWrote) {
  KeyTable keys;
  KeyTable read;
  EXPECT_EQ(read_keys(text_of(keys), read), Status::kOk);
  EXPECT_TRUE(same(keys, read));
  const std::array roles{Role::kView, Role::kTune, Role::kAdmin};
  for (std::uint32_t id = 1; id <= KeyTable::kMost; ++id) {
    Key key = numbered_key(id, roles[id % 3]);
    key.name = key_name(std::string(1 + id % kKeyNameBytes, 'n'));
    ASSERT_EQ(keys.add(key), Status::kOk);
    ASSERT_EQ(read_keys(text_of(keys), read), Status::kOk);
    ASSERT_TRUE(same(keys, read)) << id;
  }
}

// The worked example of docs/WIRE.md.
TEST(KeyText, IsAsTheDocumentSays) {
  KeyTable keys;
  Key key{.id = 0x1A2B3C4D, .device = 1, .role = Role::kTune, .name = key_name("ann@laptop")};
  for (std::size_t i = 0; i < key.secret.size(); ++i) {
    key.secret[i] = static_cast<std::byte>(i);
  }
  ASSERT_EQ(keys.add(key), Status::kOk);
  EXPECT_EQ(
      text_of(keys),
      "stof keys 1\n"
      "1a2b3c4d 00000001 tune 000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f "
      "ann@laptop\n"
      "crc32c eb1dacb0\n");
}

TEST(KeyText, EveryDamageIsSeenAndLeavesNoKey) {
  KeyTable keys;
  ASSERT_EQ(keys.add(numbered_key(5)), Status::kOk);
  ASSERT_EQ(keys.add(numbered_key(6, Role::kView)), Status::kOk);
  const std::string good = text_of(keys);
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ 1 << bit);
      KeyTable read = keys;
      ASSERT_NE(read_keys(bad, read), Status::kOk) << i << " " << bit;
      ASSERT_EQ(read.count(), 0U);
    }
    KeyTable read = keys;
    ASSERT_EQ(read_keys(good.substr(0, i), read), Status::kCorrupt) << i;
    ASSERT_EQ(read.count(), 0U);
  }
  KeyTable read;
  EXPECT_EQ(read_keys(good + " ", read), Status::kCorrupt);
}

TEST(KeyText, ALaterVersionIsNoDamage) {
  const KeyTable keys;
  std::string text = text_of(keys);
  text.replace(text.find('1'), 1, "2");
  KeyTable read;
  EXPECT_EQ(read_keys(text, read), Status::kCorrupt);
  const auto sum = crc32c(std::as_bytes(std::span(text).first(text.size() - 16)));
  char digits[9];
  std::snprintf(digits, sizeof digits, "%08x", sum);
  text.replace(text.size() - 9, 8, digits);
  EXPECT_EQ(read_keys(text, read), Status::kUnsupported);
}

}  // namespace
}  // namespace stof::wire
