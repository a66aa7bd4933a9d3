#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/records/record_disk.h"
#include "tests/support/random.h"

namespace stof::records::test {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::size_t count, std::uint64_t seed) {
  stof::test::Random random(seed);
  Bytes bytes(count);
  for (std::byte& byte : bytes) {
    byte = static_cast<std::byte>(random.next() & 0xFFU);
  }
  return bytes;
}

inline constexpr std::size_t kMostTested = 32'000;  // bytes of a document here

inline Bytes empty_disk() { return Bytes(kRecordsBytes); }

// None: there is none. An error is an empty `optional` with `lost`.
struct Read {
  std::optional<Bytes> bytes{};
  bool lost = false;

  friend bool operator==(const Read&, const Read&) = default;
};

inline Read read(RecordDisk& disk, Document document) {
  Bytes space(std::min(most_bytes(document), kMostTested));
  const auto loaded = disk.load(document, space);
  if (!loaded) {
    return {.bytes = {}, .lost = true};
  }
  if (!*loaded) {
    return {};
  }
  space.resize(**loaded);
  return {.bytes = space};
}

inline std::span<std::byte> at(Bytes& content, std::size_t offset, std::size_t count) {
  return std::span(content).subspan(offset, count);
}

// Where the area of a disk of these bytes lies, and the place of a document in it.
inline std::size_t area_of(const Bytes& content, std::size_t area) {
  return content.size() - kRecordsBytes + area * kBetweenAreas;
}
inline std::size_t place_of(const Bytes& content, std::size_t area, Document document) {
  return area_of(content, area) + kPlaces[number(document)];
}
inline std::span<std::byte> directory_of(Bytes& content, std::size_t area) {
  return at(content, area_of(content, area) + kDirectoryPlace, kHeadBytes);
}

// As programs wrote it that knew no directories.
inline void forget_directories(Bytes& content) {
  for (std::size_t area = 0; area < kAreas; ++area) {
    std::ranges::fill(directory_of(content, area), std::byte{0});
    for (std::size_t i = 0; i < kDocuments; ++i) {
      const std::span<std::byte> sector =
          at(content, place_of(content, area, static_cast<Document>(i)), kHeadBytes);
      if (auto head = read_head(sector.first<kHeadUsed>())) {
        head->listed = false;
        std::ranges::copy(write_head(*head), sector.begin());
      }
    }
  }
}

// What a sensor knows of all its documents.
using All = std::array<Read, kDocuments>;

inline All read_all(RecordDisk& disk) {
  All all;
  for (std::size_t i = 0; i < kDocuments; ++i) {
    all[i] = read(disk, static_cast<Document>(i));
  }
  return all;
}

}  // namespace stof::records::test
