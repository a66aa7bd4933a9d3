#include "firmware/keys/keyring.h"

#include <array>
#include <string>

#include <gtest/gtest.h>

#include "firmware/wire/keys/key_text.h"
#include "hal/emu/devices/store.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/support/heap_guard.h"

namespace stof::keys {
namespace {

using test::numbered_key;

class KeyringTest : public testing::Test {
 protected:
  // The next start.
  Keyring started() {
    Keyring ring(&store_, &aside_);
    std::array<char, 320> space;
    settings::PagedWriter line(space);
    ring.load("keys", line);
    told_ = line.text();
    return ring;
  }
  void put(std::string_view text) {
    const auto bytes = std::as_bytes(std::span(text));
    store_.bytes().assign(bytes.begin(), bytes.end());
  }

  hal::emu::Store store_;
  hal::emu::Store aside_;
  std::string told_;
};

TEST_F(KeyringTest, IsUnpairedUntilTheFirstKeyAndAfterTheLast) {
  Keyring ring = started();
  EXPECT_EQ(ring.pairing(), Pairing::kUnpaired);
  ASSERT_EQ(ring.add(numbered_key(1)), Status::kOk);
  EXPECT_EQ(ring.pairing(), Pairing::kPaired);
  EXPECT_EQ(started().pairing(), Pairing::kPaired);
  ASSERT_EQ(ring.remove(1), Status::kOk);
  EXPECT_EQ(ring.pairing(), Pairing::kUnpaired);
  EXPECT_EQ(started().pairing(), Pairing::kUnpaired);
  EXPECT_EQ(told_, "");
  EXPECT_EQ(ring.remove(1), Status::kInvalidArgument);
}

TEST_F(KeyringTest, TheNextStartHasTheSameKeys) {
  Keyring ring = started();
  for (std::uint32_t id = 1; id <= kMostKeys; ++id) {
    ASSERT_EQ(ring.add(numbered_key(id)), Status::kOk);
  }
  EXPECT_EQ(ring.add(numbered_key(99)), Status::kTooLarge);
  EXPECT_EQ(ring.add(numbered_key(1)), Status::kTooLarge);
  ASSERT_EQ(ring.replace(5, numbered_key(77).secret, Shown::kFormer), Status::kOk);
  EXPECT_EQ(ring.replace(99, {}, Shown::kFormer), Status::kInvalidArgument);
  const Keyring next = started();
  ASSERT_EQ(next.keys().count(), kMostKeys);
  for (const wire::Key& key : next.keys().all()) {
    EXPECT_EQ(key.secret, numbered_key(key.id == 5 ? 77 : key.id).secret);
  }
}

TEST_F(KeyringTest, ARenewedKeyHasBothSecretsUntilTheNewOneHasSigned) {
  Keyring ring = started();
  ASSERT_EQ(ring.add(numbered_key(1)), Status::kOk);
  ASSERT_EQ(ring.add(numbered_key(2)), Status::kOk);
  ASSERT_EQ(ring.replace(1, numbered_key(7).secret, Shown::kFormer), Status::kOk);
  for (const std::uint32_t newest : {7U, 8U}) {  // the answer was lost, it was renewed again
    ASSERT_EQ(ring.replace(1, numbered_key(newest).secret, Shown::kFormer), Status::kOk);
    const Keyring next = started();
    EXPECT_EQ(told_, "");
    ASSERT_EQ(next.keys().count(), 2U);
    EXPECT_EQ(next.keys().find(1)->secret, numbered_key(newest).secret);
    EXPECT_EQ(next.keys().find(1)->former, numbered_key(1).secret);
    EXPECT_EQ(next.keys().find(2)->former, std::nullopt);
  }
  ring.settle(1);
  EXPECT_EQ(ring.keys().find(1)->former, std::nullopt);
  const Keyring next = started();
  EXPECT_EQ(next.keys().find(1)->secret, numbered_key(8).secret);
  EXPECT_EQ(next.keys().find(1)->former, std::nullopt);
}

TEST_F(KeyringTest, ARoleThatIsNoneIsNoKey) {
  Keyring ring = started();
  wire::Key key = numbered_key(1);
  for (const int role : {0, 4, 255}) {
    key.role = static_cast<wire::Role>(role);
    EXPECT_EQ(ring.add(key), Status::kInvalidArgument);
  }
  EXPECT_EQ(started().pairing(), Pairing::kUnpaired);
}

TEST_F(KeyringTest, WhatWasNotSavedIsNotInForce) {
  Keyring ring = started();
  ASSERT_EQ(ring.add(numbered_key(1)), Status::kOk);
  store_.break_down(true);
  EXPECT_EQ(ring.add(numbered_key(2)), Status::kDeviceError);
  EXPECT_EQ(ring.remove(1), Status::kDeviceError);
  EXPECT_EQ(ring.replace(1, {}, Shown::kFormer), Status::kDeviceError);
  ASSERT_EQ(ring.keys().count(), 1U);
  EXPECT_EQ(ring.keys().all()[0], numbered_key(1));
}

TEST_F(KeyringTest, ADamagedFileIsToldAndLetsNobodyIn) {
  for (const std::string text : {"", "x", "stof keys 1\n", "{}"}) {
    put(text);
    Keyring ring = started();
    EXPECT_EQ(ring.pairing(), Pairing::kLost) << text;
    EXPECT_NE(told_.find("keys: no key file, or damaged: no client's key is known"),
              std::string::npos)
        << told_;
    EXPECT_EQ(store_.bytes().size(), text.size());  // still there
  }
  put(std::string(2 * wire::kMostKeyText, 'x'));
  EXPECT_EQ(started().pairing(), Pairing::kLost);
}

TEST_F(KeyringTest, AnUnreadableFileIsToldAndNeverReplaced) {
  store_.break_down(true);
  Keyring ring = started();
  EXPECT_EQ(ring.pairing(), Pairing::kLost);
  EXPECT_NE(told_.find("cannot be read"), std::string::npos) << told_;
  EXPECT_EQ(ring.add(numbered_key(1)), Status::kDeviceError);
  EXPECT_EQ(ring.pairing(), Pairing::kLost);
  store_.break_down(true, Status::kUnsupported);
  EXPECT_EQ(started().pairing(), Pairing::kLost);
  EXPECT_NE(told_.find("no regular file"), std::string::npos) << told_;
}

TEST_F(KeyringTest, TheFirstNewKeyReplacesADamagedFileWhichIsKeptAside) {
  put("damaged");
  Keyring ring = started();
  aside_.break_down(true);
  EXPECT_EQ(ring.add(numbered_key(1)), Status::kDeviceError);
  EXPECT_EQ(ring.pairing(), Pairing::kLost);
  aside_.break_down(false);
  EXPECT_EQ(ring.add(numbered_key(1)), Status::kOk);
  EXPECT_EQ(ring.pairing(), Pairing::kPaired);
  EXPECT_EQ(aside_.bytes().size(), 7U);
  EXPECT_EQ(started().pairing(), Pairing::kPaired);
}

TEST_F(KeyringTest, WithoutAFileKeysLiveUntilTheEnd) {
  Keyring ring(nullptr, nullptr);
  std::array<char, 320> space;
  settings::PagedWriter line(space);
  ring.load("keys", line);
  EXPECT_EQ(ring.pairing(), Pairing::kUnpaired);
  ASSERT_EQ(ring.add(numbered_key(1)), Status::kOk);
  EXPECT_EQ(ring.pairing(), Pairing::kPaired);
}

TEST(KeyringNoHeap, KeysComeAndGoWithoutHeap) {
  Keyring ring(nullptr, nullptr);
  const int before = test::allocations;
  for (std::uint32_t id = 1; id <= 8; ++id) {
    ASSERT_EQ(ring.add(numbered_key(id)), Status::kOk);
    ASSERT_EQ(ring.replace(id, numbered_key(id + 1).secret, Shown::kFormer), Status::kOk);
  }
  std::array<char, wire::kMostKeyText> space;
  wire::KeyTable read;
  const std::span<char> text = wire::write_keys(ring.keys(), space);
  ASSERT_EQ(wire::read_keys({text.data(), text.size()}, read), Status::kOk);
  ASSERT_EQ(ring.remove(3), Status::kOk);
  EXPECT_EQ(test::allocations, before);
}

}  // namespace
}  // namespace stof::keys
