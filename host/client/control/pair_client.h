#pragma once

#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/wire/keys/pair_secrets.h"
#include "host/client/control/control_client.h"

namespace stof::client {

struct PairWish {
  wire::PairMethod method = wire::PairMethod::kDigits;
  wire::Role role = wire::Role::kAdmin;
  std::string name{};              // whose key it shall be
  std::vector<std::byte> known{};  // of methods code and key: the code, the key's secret
  std::uint32_t key_id = 0;        // of method key
};

// How the two minutes stand that the cable opened for others.
struct PairWindow {
  std::optional<wire::PairOffer> offer{};  // the sensor's digits, as soon as somebody has come
  std::uint32_t key_id = 0;                // of the key that came of it; 0: not yet
};

// Makes a key with one sensor; blocks. For one thread, and for one key. What it began, and did not
// end, ends with it at the sensor, too, so that nobody's hold of the button makes a key for nobody.
class PairClient {
 public:
  PairClient(std::unique_ptr<ControlTransport> transport, PairWish wish,
             ControlOptions options = {});
  ~PairClient();
  PairClient(const PairClient&) = delete;
  PairClient& operator=(const PairClient&) = delete;

  // Both reveal what they have. kTimeout: no answer; kUnsupported: the sensor does not pair now, or
  // not so; kWouldBlock: somebody else pairs, or it was too often; kCorrupt: somebody is between,
  // or the code is another; kDeviceLost.
  std::expected<void, ControlError> start();
  // After start(), of method digits: 0 to 999,999. Only where the sensor tells the same is there
  // nobody between.
  std::uint32_t digits() const { return secrets_->digits(); }
  // After start(): what the key will be, if the sensor takes it.
  wire::Key key() const;
  // After start(), and the user's consent: waits until the key is in force. As start(), and
  // kTooLarge: the sensor keeps no more keys; kTimeout: nobody accepted it there, or `goes_on`,
  // which is asked again and again, said no.
  std::expected<wire::Key, ControlError> finish(Duration patience,
                                                const std::function<bool()>& goes_on = {});

  // In place of all that, over a cable: opens two minutes for others, as the button does; asked
  // again, tells how they stand. As start(), and kTimeout: nobody has come, or not agreed in time.
  std::expected<PairWindow, ControlError> open_window();
  // Accepts somebody else's digits, as the button does that is held. As start().
  std::expected<PairWindow, ControlError> accept(std::uint32_t digits);

 private:
  std::expected<PairWindow, ControlError> ask_window(const wire::PairRequest& request);
  void give_up(wire::PairRequest request);
  Status send(wire::PairRequest& request);
  std::expected<wire::PairAnswer, ControlError> ask(wire::PairRequest request);
  std::optional<wire::PairAnswer> await_consent();
  std::expected<wire::PairAnswer, ControlError> ask_overheard(wire::PairRequest request);
  std::optional<wire::PairAnswer> await(std::uint32_t request_id, Time deadline);
  bool is_done(const wire::PairAnswer& answer) const;
  std::unexpected<ControlError> refuse_confirmed(wire::PairResult why) const;
  std::unexpected<ControlError> unproven(ControlError why) const;
  std::unexpected<ControlError> no_answer() const;
  wire::PairRequest request(wire::PairStep step) const;
  std::unexpected<ControlError> refuse(wire::PairResult why) const;
  std::unexpected<ControlError> error(Status status, std::string_view what) const;

  std::unique_ptr<ControlTransport> transport_;
  PairWish wish_;
  ControlOptions options_;
  wire::Exchange exchange_;
  wire::PairTranscript said_{};
  std::optional<wire::PairSecrets> secrets_;
  std::optional<wire::Origin> heard_;  // who sent the answer that counts
  std::uint64_t attempt_ = 0;
  std::uint64_t cookie_ = 0;
  bool opened_ = false;  // a window
  bool ended_ = false;   // what was begun
  std::uint32_t request_id_;
};

}  // namespace stof::client
