#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "hal/store.h"

namespace stof::hal::linux {

// A file. New contents are written beside it (NAME.new), flushed to the medium and renamed, and the
// folder is flushed: after a power cut the file is the old or the new one. What is set aside
// becomes NAME.bad.
class FileStore final : public Store {
 public:
  static constexpr std::size_t kMostName = 250;

  // Only the first kMostName bytes of the name are used. Opens nothing.
  explicit FileStore(std::string_view name) noexcept;

  Result<std::size_t> load(std::span<std::byte> space) noexcept override;
  Status save(std::span<const std::byte> bytes) noexcept override;
  Status set_aside() noexcept override;

 private:
  using Name = std::array<char, kMostName + 5>;  // with an ending and 0

  Status write_new(std::span<const std::byte> bytes) const noexcept;

  Name name_{};
  Name new_{};
  Name bad_{};
  Name folder_{};
};

}  // namespace stof::hal::linux
