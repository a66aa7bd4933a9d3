#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "host/recording/mcap/storage.h"

namespace stof::test {

// A file in memory, on a disk of so many bytes.
class MemorySink : public mcap::ByteSink {
 public:
  explicit MemorySink(std::size_t room = std::numeric_limits<std::size_t>::max()) : room_(room) {}

  std::expected<void, mcap::Problem> write(mcap::Bytes bytes) override {
    const std::size_t count = std::min(bytes.size(), room_ - std::min(room_, file.size()));
    mcap::append_bytes(file, bytes.first(count));
    if (count < bytes.size()) {
      return std::unexpected(mcap::Problem{"disk: is full: make room"});
    }
    return {};
  }
  std::expected<void, mcap::Problem> sync() override {
    synced = file.size();
    return {};
  }
  std::expected<void, mcap::Problem> cut_to(std::uint64_t size) override {
    file.resize(static_cast<std::size_t>(size));
    return {};
  }

  mcap::Buffer file;
  std::size_t synced = 0;  // bytes that a power cut leaves for sure

 private:
  std::size_t room_;
};

}  // namespace stof::test
