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
  own_[index] = {};
  links_[index] = 0;
  for (cmsghdr* entry = CMSG_FIRSTHDR(&message); entry != nullptr;
       entry = CMSG_NXTHDR(&message, entry)) {
    if (entry->cmsg_level != SOL_SOCKET) {
      read_own(*entry, index);
    } else if (entry->cmsg_type == SO_RXQ_OVFL) {
      note_drops(*entry);
    } else if (entry->cmsg_type == SCM_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(entry), sizeof stamp);
      arrived_[index] =
          std::chrono::seconds(stamp.tv_sec) + std::chrono::nanoseconds(stamp.tv_nsec);
    }
  }
}

// Of an IPv4 datagram to an IPv6 socket both may come: only IPv4's knows what to answer from where
// it went to all hosts (ip(7), IP_PKTINFO).
void DatagramBatch::read_own(const cmsghdr& entry, std::size_t index) noexcept {
  if (entry.cmsg_level == IPPROTO_IP && entry.cmsg_type == IP_PKTINFO) {
    in_pktinfo info{};
    std::memcpy(&info, CMSG_DATA(&entry), sizeof info);
    if (info.ipi_addr.s_addr == INADDR_BROADCAST) {
      links_[index] = static_cast<unsigned>(info.ipi_ifindex);
    }
    if (info.ipi_spec_dst.s_addr != INADDR_ANY) {
      own_[index] = map_ipv4(info.ipi_spec_dst);
    }
  } else if (entry.cmsg_level == IPPROTO_IPV6 && entry.cmsg_type == IPV6_PKTINFO) {
    in6_pktinfo info{};
    std::memcpy(&info, CMSG_DATA(&entry), sizeof info);
    if (!IN6_IS_ADDR_MULTICAST(&info.ipi6_addr) && !IN6_IS_ADDR_V4MAPPED(&info.ipi6_addr)) {
      own_[index] = info.ipi6_addr;
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
