#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "hal/store.h"
#include "posix/fd.h"

namespace stof::hal::linux {

// A file. New contents are written beside it (NAME.new), flushed to the medium and renamed, and the
// folder is flushed: after a power cut the file is the old or the new one. A file that
// is set aside becomes NAME.bad. A name that the system finds too long, with those endings, is a
// kDeviceError. Where NAME is a folder, a device, a link, anything but a regular file, it is
// kUnsupported: never opened, renamed or replaced; so is nothing that has one of the endings.
class FileStore final : public Store {
 public:
  enum class Readers : std::uint8_t {
    kAll,
    // Mode 0600 from its first byte; a file with more is taken back to that by load(). Without
    // its folder nothing is known of it: kDeviceError.
    kOwner,
  };

  // Opens nothing; alone of all allocates.
  explicit FileStore(std::string name, Readers readers = Readers::kAll);

  Result<std::optional<std::size_t>> load(std::span<std::byte> space) noexcept override;
  Status save(std::span<const std::byte> bytes) noexcept override;
  Status set_aside() noexcept override;

 private:
  Result<posix::Fd> open() const noexcept;
  Status write_new(std::span<const std::byte> bytes) const noexcept;

  std::string name_;
  std::string new_;
  std::string bad_;
  std::string folder_;
  Readers readers_;
};

}  // namespace stof::hal::linux
