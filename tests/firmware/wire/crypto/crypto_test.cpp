#include "firmware/wire/crypto/crypto.h"

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/heap_guard.h"

namespace stof::wire {
namespace {

std::vector<std::byte> bytes_of(std::string_view hex) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(digit(hex[i]) << 4 | digit(hex[i + 1])));
  }
  return bytes;
}

template <typename Array>
Array array_of(std::string_view hex) {
  Array array{};
  std::ranges::copy(bytes_of(hex), array.begin());
  return array;
}

template <typename Array>
std::vector<std::byte> listed(const Array& array) {
  return {array.begin(), array.end()};
}

Secret counted() {
  Secret secret;
  for (std::size_t i = 0; i < secret.size(); ++i) {
    secret[i] = static_cast<std::byte>(i);
  }
  return secret;
}

class CryptoTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(start_crypto()); }
};

// Figures of Python's hashlib.
TEST_F(CryptoTest, TagsAndDigestsAreKeyedBlake2b) {
  const std::vector<std::byte> abc = bytes_of("616263");
  EXPECT_EQ(listed(tag_of(counted(), {abc})), bytes_of("1a64be47e4729d951c302ee543f97cf3"));
  EXPECT_EQ(listed(digest_of({}, {})),
            bytes_of("0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8"));
  std::vector<std::byte> many;
  for (int i = 0; i < 100; ++i) {
    many.insert(many.end(), abc.begin(), abc.end());
  }
  const Secret key = counted();
  EXPECT_EQ(listed(digest_of(std::span(key).first<16>(), {many})),
            bytes_of("419b1f859a3c78d9212813de84732ffbaab5a42262e91d6a19da8d8954b02372"));
}

TEST_F(CryptoTest, PartsAreTakenOneBehindTheOther) {
  const Secret bytes = counted();
  const std::span<const std::byte> all(bytes);
  EXPECT_EQ(tag_of(bytes, {all}), tag_of(bytes, {all.first(5), {}, all.subspan(5)}));
  EXPECT_NE(tag_of(bytes, {all}), tag_of(bytes, {all.subspan(5), all.first(5)}));
}

// RFC 8439, section 2.3.2: block 1 of a keystream; 2.5.2.
TEST_F(CryptoTest, OneTimeTagsArePoly1305WithKeysOfChaCha20) {
  constexpr std::uint32_t kHigh = 0x09000000;
  constexpr std::uint64_t kLow = 0x4A000000;
  const auto third = bytes_of("10f1e7e4d13b5915500fdd1fa32071c4c7d1f4c733c068030422aa9ac3d46c4e");
  const auto fourth = bytes_of("d2826446079faa0914c2d705d98b02a2b5129cd1de164eb9cbd083e8a2503c4e");
  std::array<OneTimeKey, 16> keys;
  derive_one_time_keys(counted(), kHigh, kLow, keys);
  EXPECT_EQ(listed(keys[2]), third);
  EXPECT_EQ(listed(keys[3]), fourth);
  for (std::uint32_t place = 0; place < keys.size(); ++place) {
    EXPECT_EQ(one_time_key(counted(), kHigh, kLow, place), keys[place]) << place;
  }
  const auto key =
      array_of<OneTimeKey>("85d6be7857556d337f4452fe42d506a80103808afb0db2fd4abff6af4149f51b");
  constexpr std::string_view kText = "Cryptographic Forum Research Group";
  const auto text = std::as_bytes(std::span(kText));
  const auto expected = bytes_of("a8061dc1305136c6c22b8baf0c0127a9");
  EXPECT_EQ(listed(one_time_tag(key, {text})), expected);
  EXPECT_EQ(listed(one_time_tag(key, {text.first(3), {}, text.subspan(3)})), expected);
}

TEST_F(CryptoTest, SecretsAreEqualInAllBytesOrNot) {
  for (const std::size_t size : {16U, 32U}) {
    std::vector<std::byte> a(size, std::byte{0x5A});
    std::vector<std::byte> b = a;
    EXPECT_TRUE(equal_secrets(a, b));
    for (std::size_t i = 0; i < size; ++i) {
      b[i] ^= std::byte{0x80};
      EXPECT_FALSE(equal_secrets(a, b)) << i;
      b[i] = a[i];
    }
  }
}

// RFC 7748, section 6.1.
TEST_F(CryptoTest, BothSidesOfAnExchangeKnowTheSame) {
  const Exchange alice(
      array_of<Secret>("77076d0a7318a57d3c16c17251b26645df4c2f87ebc0992ab177fba51db92c2a"));
  const Exchange bob(
      array_of<Secret>("5dab087e624a8a4b79e17f8b83800ee66f3bb1292618b6fd1c2f8b27ff88e0eb"));
  EXPECT_EQ(listed(alice.public_key()),
            bytes_of("8520f0098930a754748b7ddcb43ef75a0dbf3a0d26381af4eba4a98eaa9b4e6a"));
  EXPECT_EQ(listed(bob.public_key()),
            bytes_of("de9edb7d7b7dc1b4d35b61c2ece435373f8343c85b78674dadfc7e146f882b4f"));
  const auto shared = bytes_of("4a5d9d5ba4ce2de1728e3bf480350f25e07e21c947d19e3376f09b3c1e161742");
  EXPECT_EQ(listed(alice.shared_with(bob.public_key()).value()), shared);
  EXPECT_EQ(listed(bob.shared_with(alice.public_key()).value()), shared);
}

TEST_F(CryptoTest, APointThatAnybodyKnowsTheResultOfIsRefused) {
  const Exchange ours;
  PublicKey point{};
  EXPECT_FALSE(ours.shared_with(point).has_value());
  point[0] = std::byte{1};
  EXPECT_FALSE(ours.shared_with(point).has_value());
  // Of order 8.
  EXPECT_FALSE(
      ours.shared_with(array_of<PublicKey>(
                           "e0eb7a7c3b41b8ae1656e3faf19fc46ada098deb9c32b1fd866205165f49b800"))
          .has_value());
}

TEST_F(CryptoTest, ExchangesAndRandomBytesDiffer) {
  Secret a{};
  Secret b{};
  fill_random(a);
  fill_random(b);
  EXPECT_FALSE(equal_secrets(a, b));
  EXPECT_NE(Exchange().public_key(), Exchange().public_key());
}

// RFC 8032, section 7.1, test 2.
TEST_F(CryptoTest, SignaturesAreEd25519) {
  const auto key =
      array_of<PublicKey>("3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c");
  const auto signature = array_of<Signature>(
      "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da"
      "085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00");
  const std::vector<std::byte> message = bytes_of("72");
  EXPECT_TRUE(is_signed(key, signature, message));
  EXPECT_FALSE(is_signed(key, signature, bytes_of("73")));
  EXPECT_FALSE(is_signed(key, signature, {}));
  EXPECT_FALSE(is_signed(PublicKey{}, signature, message));
  EXPECT_FALSE(is_signed(PublicKey{}, Signature{}, message));  // a point that anybody knows
  for (std::size_t bit = 0; bit < 8 * signature.size(); ++bit) {
    Signature other = signature;
    other[bit / 8] ^= std::byte{1} << (bit % 8);
    EXPECT_FALSE(is_signed(key, other, message)) << bit;
  }
}

TEST_F(CryptoTest, ComparesAndWipesEveryByte) {
  Secret a = counted();
  for (std::size_t i = 0; i < a.size(); ++i) {
    Secret b = a;
    EXPECT_TRUE(equal_secrets(a, b));
    b[i] ^= std::byte{0x80};
    EXPECT_FALSE(equal_secrets(a, b)) << i;
  }
  wipe(a);
  EXPECT_EQ(a, Secret{});
}

TEST_F(CryptoTest, AllocatesNothing) {
  const int before = test::allocations;
  ASSERT_TRUE(start_crypto());
  Secret secret;
  fill_random(secret);
  const Exchange other;
  std::array<std::byte, 1176> packet{};
  for (int i = 0; i < 100; ++i) {
    const Exchange exchange;
    const auto shared = exchange.shared_with(other.public_key());
    ASSERT_TRUE(shared.has_value());
    packet[0] ^= tag_of(*shared, {packet})[0] ^ digest_of(secret, {packet})[1];
  }
  EXPECT_EQ(test::allocations, before);
}

}  // namespace
}  // namespace stof::wire
