#include "hal/linux/system/file_slots.h"

#include <utility>

#include <fcntl.h>

#include "hal/linux/system/disk_calls.h"

namespace stof::hal::linux {
namespace {

constexpr std::size_t kDiskSector = 512;

Status write_and_flush(int fd, std::size_t offset, std::span<const std::byte> bytes) noexcept {
  const Status written = write_disk(fd, offset, bytes);
  return written == Status::kOk ? flush_disk(fd) : written;
}

}  // namespace

Result<std::unique_ptr<FileSlots>> FileSlots::open(const std::string& prefix) {
  std::array<Part, kDiskParts> parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string name = prefix + std::to_string(i + 1);
    parts[i].file.reset(::open(name.c_str(), O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
    if (!parts[i].file.is_open()) {
      return fail(Status::kDeviceError);
    }
    const Result<std::size_t> bytes = bytes_of_disk(parts[i].file.get());
    if (!bytes || *bytes % kDiskSector != 0) {
      return fail(bytes ? Status::kDeviceError : bytes.error());
    }
    parts[i].bytes = *bytes;
  }
  return std::unique_ptr<FileSlots>(new FileSlots(std::move(parts)));
}

FileSlots::FileSlots(std::array<Part, kDiskParts> parts)
    : parts_(std::move(parts)), thread_([this] { run(); }) {}

FileSlots::~FileSlots() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void FileSlots::run() noexcept {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return over_ || job_.part != nullptr; });
    if (job_.part == nullptr) {
      return;
    }
    const Job job = job_;
    lock.unlock();
    const Status done = write_and_flush(job.part->file.get(), job.offset, job.bytes);
    lock.lock();
    last_ = done;
    job_.part = nullptr;
  }
}

Status FileSlots::read(DiskPart part, std::size_t offset, std::span<std::byte> to) noexcept {
  const Part& from = of(part);
  if (offset > from.bytes || to.size() > from.bytes - offset) {
    return Status::kInvalidArgument;
  }
  forget_disk(from.file.get(), offset, to.size());
  return read_disk(from.file.get(), offset, to);
}

void FileSlots::write(DiskPart part, std::size_t offset,
                      std::span<const std::byte> bytes) noexcept {
  const Part& to = of(part);
  const std::lock_guard lock(mutex_);
  if (offset > to.bytes || bytes.size() > to.bytes - offset) {
    last_ = Status::kInvalidArgument;
    return;
  }
  job_ = {.part = &to, .offset = offset, .bytes = bytes};
  changed_.notify_one();
}

Status FileSlots::progress() noexcept {
  const std::lock_guard lock(mutex_);
  return job_.part != nullptr ? Status::kTimeout : last_;
}

}  // namespace stof::hal::linux
