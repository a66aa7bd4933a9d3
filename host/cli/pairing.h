#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "host/cli/control_flags.h"
#include "host/client/control/pair_client.h"

// Makes a key that a sensor and this user share, in the steps of who compares the digits: `stof
// pair`, and the page of `stof view`.
namespace stof::host {

struct PairingTerms {
  // How it is reached, as ControlFlags has it.
  std::string sensor{};  // HOST[:PORT]; empty with `serial`
  std::string serial{};
  unsigned baud = 0;
  std::optional<std::uint32_t> device{};
  double timeout_s = 0;
  std::string file{};  // of this user's keys
  bool again = false;  // also a sensor whose number another key has
};
// file: of the keys.
PairingTerms pairing_terms(const ControlFlags& flags, const std::string& sensor,
                           const std::string& file);

class Pairing {
 public:
  // Reaches the sensor, and sees that a key could be kept. Throws Failure, as the others.
  Pairing(PairingTerms terms, client::PairWish wish);

  // Both reveal what they have.
  void start();
  // Whether somebody has to compare digits() with those that the sensor tells, before finish().
  bool by_digits() const;
  std::uint32_t digits() const { return client_->digits(); }  // after start()
  // Waits until the key is in force, and keeps it in the user's file. goes_on: asked again and
  // again; false: it is given up.
  wire::Key finish(std::chrono::seconds patience, const std::function<bool()>& goes_on = {});

 private:
  void need_new(const wire::Key& key) const;
  void check_named(const wire::Key& key) const;

  PairingTerms terms_;
  client::PairWish wish_;
  std::string address_;
  std::unique_ptr<client::PairClient> client_;
};

// USER@HOST: whose key it is, where nobody says otherwise.
std::string user_and_host();

// With the code of the label, 32 hexadecimal digits; false: it is none.
bool prove_by_code(client::PairWish& wish, std::string_view code);

// Digits alone of what somebody typed; empty: it is something else.
std::string digits_in(std::string_view text);
std::string six_digits(std::uint32_t digits);
// One line: they differ, and what that means.
std::string other_digits(const std::string& typed, std::uint32_t ours);

// Whether a key could be kept in that file; throws Failure.
void need_key_room(const std::string& file);
// "key ID of sensor NUMBER, ROLE, is in FILE".
std::string kept_text(const wire::Key& key, const std::string& file);
// The sensor takes this key; it drops the secret of before when it has seen the new one.
bool opens_sensor(const PairingTerms& terms, const wire::Key& key);

}  // namespace stof::host
