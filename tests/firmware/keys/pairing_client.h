#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/wire/bytes.h"
#include "firmware/wire/keys/pair_secrets.h"

namespace stof::test {

// The client's end, made of docs/WIRE.md: what it sends, and what it computes of the answers.
class PairingClient {
 public:
  PairingClient(wire::Origin sensor, wire::PairMethod method, wire::Role role,
                std::span<const std::byte> known = {}, std::uint32_t key_id = 0)
      : known_(known) {
    said_ = {.sensor = sensor,
             .key_id = key_id,
             .method = method,
             .role = role,
             .name = wire::key_name("client")};
    said_.client_key = exchange_.public_key();
    wire::fill_random(said_.client_nonce);
  }

  wire::PairRequest begin() {
    wire::PairRequest request = step(wire::PairStep::kBegin);
    wire::put_bytes(wire::commitment_of(said_.client_key, said_.client_nonce), request.value);
    if (proves_ && !known_.empty()) {
      wire::put_bytes(wire::begin_proof(known_, request), request.nonce);
    }
    return request;
  }
  wire::PairRequest reveal(const wire::PairAnswer& begun) {
    attempt_ = begun.attempt;
    said_.key_id = begun.key_id;
    said_.sensor_key = wire::bytes_in<wire::PublicKey>(begun.value);
    said_.sensor_nonce = wire::bytes_in<wire::PairNonce>(begun.nonce);
    wire::PairRequest request = step(wire::PairStep::kReveal);
    wire::put_bytes(said_.client_key, request.value);
    wire::put_bytes(said_.client_nonce, request.nonce);
    return request;
  }
  wire::PairRequest confirm() {
    wire::PairRequest request = step(wire::PairStep::kConfirm);
    wire::put_bytes(secrets().client_tag(), request.value);
    return request;
  }
  // As clients that are older than the proof in begin.
  void prove_nothing() { proves_ = false; }
  // Of whoever holds the cable.
  wire::PairRequest open() {
    wire::PairRequest request = step(wire::PairStep::kOpen);
    wire::put_bytes(said_.client_nonce, request.nonce);
    return request;
  }
  wire::PairRequest accept(std::uint32_t digits) {
    wire::PairRequest request = step(wire::PairStep::kAccept);
    wire::put_u32(std::as_writable_bytes(std::span(request.value)).first<4>(), digits);
    return request;
  }
  // After reveal().
  wire::PairSecrets secrets() const {
    return {said_, exchange_.shared_with(said_.sensor_key).value_or(wire::Secret{}), known_};
  }
  wire::PairTranscript& said() { return said_; }
  const wire::PairTranscript& said() const { return said_; }

 private:
  wire::PairRequest step(wire::PairStep step) const {
    wire::PairRequest request{.request_id = 1,
                              .step = step,
                              .method = said_.method,
                              .role = said_.role,
                              .attempt = attempt_,
                              .key_id = said_.method == wire::PairMethod::kKey ? said_.key_id : 0};
    std::ranges::copy(said_.name, request.name.begin());
    return request;
  }

  wire::Exchange exchange_;
  wire::PairTranscript said_;
  std::span<const std::byte> known_;
  std::uint64_t attempt_ = 0;
  bool proves_ = true;
};

}  // namespace stof::test
