#include <algorithm>
#include <array>
#include <cstring>

#include <gtest/gtest.h>
#include <wire_golden.h>

#include "tests/support/guarded_memory.h"

// wire_golden.h is made by scripts/wire_table.py --golden when this is configured: of each message
// a value whose fields all differ, and the bytes that Python packs of it.
namespace stof::wire {
namespace {

TEST(GoldenMessages, EveryMessageIsWhatPythonPacks) {
  golden::visit_messages([]<typename T, std::size_t kBytes>(
                             const char* name, const golden::Golden<T, kBytes>& golden,
                             void (*encode)(const T&, std::span<std::byte, kBytes>) noexcept,
                             Result<T> (*decode)(std::span<const std::byte>) noexcept) {
    SCOPED_TRACE(name);
    test::GuardedBuffer<std::byte> expected(kBytes);
    std::memcpy(expected.span().data(), golden.bytes.data(), kBytes);
    std::array<std::byte, kBytes> out;
    out.fill(std::byte{0xEE});
    encode(golden.value, out);
    EXPECT_TRUE(std::ranges::equal(out, expected.span())) << "encoded";

    const Result<T> decoded = decode(expected.span());
    ASSERT_TRUE(decoded);
    out.fill(std::byte{0xEE});
    encode(*decoded, out);
    EXPECT_TRUE(std::ranges::equal(out, expected.span())) << "decoded and encoded";

    for (std::size_t size = 0; size < kBytes; ++size) {
      const test::GuardedBuffer<std::byte> less(size);
      ASSERT_EQ(decode(less.span()).error(), Status::kCorrupt) << size;
    }
  });
}

}  // namespace
}  // namespace stof::wire
