#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "hal/slots.h"
#include "posix/fd.h"

namespace stof::hal::linux {

// Partitions of a disk by their common name, such as "/dev/mmcblk0p" with 1, 2 and 3 behind it; or
// files of such names. A thread of its own writes, and flushes each write to the medium.
class FileSlots final : public Slots {
 public:
  // kDeviceError: one of them cannot be opened, or has no whole sectors; kUnsupported: it is
  // neither a file nor a block device.
  static Result<std::unique_ptr<FileSlots>> open(const std::string& prefix);

  ~FileSlots() override;
  FileSlots(const FileSlots&) = delete;
  FileSlots& operator=(const FileSlots&) = delete;

  std::size_t bytes(DiskPart part) const noexcept override { return of(part).bytes; }
  Status read(DiskPart part, std::size_t offset, std::span<std::byte> to) noexcept override;
  void write(DiskPart part, std::size_t offset, std::span<const std::byte> bytes) noexcept override;
  Status progress() noexcept override;

 private:
  struct Part {
    posix::Fd file;
    std::size_t bytes = 0;
  };
  struct Job {
    const Part* part = nullptr;
    std::size_t offset = 0;
    std::span<const std::byte> bytes;
  };

  explicit FileSlots(std::array<Part, kDiskParts> parts);
  const Part& of(DiskPart part) const noexcept { return parts_[static_cast<std::size_t>(part)]; }
  void run() noexcept;

  std::array<Part, kDiskParts> parts_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Job job_;                    // no part: there is none
  Status last_ = Status::kOk;  // of the job before
  bool over_ = false;
  std::thread thread_;
};

}  // namespace stof::hal::linux
