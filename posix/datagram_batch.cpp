#include "posix/datagram_batch.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace stof::posix {

DatagramBatch::DatagramBatch() noexcept {
  for (std::size_t i = 0; i < kMost; ++i) {
    vectors_[i] = {.iov_base = space_[i].data(), .iov_len = kSpace};
    messages_[i] = {};
    messages_[i].msg_hdr.msg_iov = &vectors_[i];
    messages_[i].msg_hdr.msg_iovlen = 1;
    messages_[i].msg_hdr.msg_name = &from_[i].storage;
    messages_[i].msg_hdr.msg_control = control_[i].data();
  }
}

std::expected<std::size_t, int> DatagramBatch::read(int fd) noexcept {
  for (mmsghdr& message : messages_) {
    message.msg_hdr.msg_namelen = sizeof(sockaddr_storage);
    message.msg_hdr.msg_controllen = kControlSpace;
  }
  // MSG_TRUNC: the whole length of what is too long.
  const int count = recvmmsg(fd, messages_.data(), kMost, MSG_DONTWAIT | MSG_TRUNC, nullptr);
  if (count < 0) {
    return std::unexpected(errno);
  }
  const std::size_t read = static_cast<std::size_t>(count);
  for (std::size_t i = 0; i < read; ++i) {
    from_[i].length = messages_[i].msg_hdr.msg_namelen;
    read_control(messages_[i].msg_hdr, i);
  }
  return read;
}

std::span<const std::byte> DatagramBatch::datagram(std::size_t index) const noexcept {
  return std::span(space_[index]).first(std::min(whole_size(index), kSpace));
}

void DatagramBatch::read_control(msghdr& message, std::size_t index) noexcept {
  arrived_[index].reset();
  for (cmsghdr* entry = CMSG_FIRSTHDR(&message); entry != nullptr;
       entry = CMSG_NXTHDR(&message, entry)) {
    if (entry->cmsg_level != SOL_SOCKET) {
      continue;
    }
    if (entry->cmsg_type == SO_RXQ_OVFL) {
      note_drops(*entry);
    } else if (entry->cmsg_type == SCM_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(entry), sizeof stamp);
      arrived_[index] =
          std::chrono::seconds(stamp.tv_sec) + std::chrono::nanoseconds(stamp.tv_nsec);
    }
  }
}

void DatagramBatch::note_drops(const cmsghdr& entry) noexcept {
  std::uint32_t count = 0;
  std::memcpy(&count, CMSG_DATA(&entry), sizeof count);
  dropped_.fetch_add(count - kernel_count_, std::memory_order_relaxed);
  kernel_count_ = count;
}

}  // namespace stof::posix
