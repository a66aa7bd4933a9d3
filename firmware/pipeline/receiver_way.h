#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/wire/datagram_sink.h"
#include "firmware/wire/keys/signed_stream.h"

namespace stof::firmware {

// How datagrams go to one receiver, for as long as it is one.
struct ReceiverWay {
  std::size_t stream = 0;        // of the port
  wire::StreamTagger tagger{};   // with its key; number 0: nothing is signed
  std::uint64_t signed_all = 0;  // datagrams
  wire::Datagrams prepared{};    // as this receiver gets them

  bool signs() const noexcept { return tagger.key().number != 0; }
  // The next datagram that its key signs: a part of `space`.
  std::span<const std::byte> sign(std::span<const std::byte> datagram,
                                  wire::DatagramBuffer& space) noexcept {
    return wire::sign_datagram(datagram, tagger, ++signed_all, space);
  }
};

}  // namespace stof::firmware
