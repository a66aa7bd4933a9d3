#include "host/cli/view/page_pairing.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "firmware/wire/keys/key_text.h"
#include "host/cli/failure.h"
#include "host/cli/own_keys.h"
#include "host/cli/pairing.h"

namespace stof::host {
namespace {

constexpr std::chrono::minutes kPairingPatience{2};  // as the sensor's
constexpr const char* kGivenUp = "was given up: nothing was paired";

}  // namespace

PagePairing::PagePairing(ConfigOptions config, bool takes_code, Tell tell)
    : config_(std::move(config)), tell_(std::move(tell)) {
  state_.takes_code = takes_code;
}

PagePairing::~PagePairing() {
  static_cast<void>(give_up());
  if (thread_.joinable()) {
    thread_.join();
  }
}

// Told in the order in which it happened.
template <typename Change>
void PagePairing::change(Change&& how) {
  const std::scoped_lock lock(mutex_);
  std::forward<Change>(how)(state_);
  told_ = true;
  tell_(state_);
}

PagePairing::Done PagePairing::begin(const ShownSensor& sensor, const viewer::BeginPairing& wish) {
  if (sensor.address.empty()) {
    return std::unexpected("no frame has come: nobody knows where the sensor is");
  }
  if (!wish.code.empty() && !state_.takes_code) {
    return std::unexpected(
        "the label's code is not taken here: others may read this network; use stof pair SENSOR "
        "--code @FILE");
  }
  if (!wish.code.empty() && !wire::code_of(wish.code)) {
    return std::unexpected("the code has 32 hexadecimal digits: look at the label");
  }
  {
    const std::scoped_lock lock(mutex_);
    if (under_way_) {
      return std::unexpected("a pairing is under way: give it up first");
    }
    under_way_ = true;
    ends_ = false;
    digits_.reset();
  }
  if (thread_.joinable()) {
    thread_.join();  // it has ended
  }
  change([](viewer::PairingState& state) {
    state.step = "begin";
    state.text.clear();
    state.given.clear();
    state.ours.clear();
  });
  thread_ = std::thread([this, address = sensor.address, wish] { run(address, wish); });
  return {};
}

PagePairing::Done PagePairing::give(const std::string& digits) {
  constexpr std::size_t kDigits = 6;
  std::string read = digits_in(digits);
  if (read.size() != kDigits) {
    return std::unexpected("six digits are awaited: those that the sensor tells");
  }
  {
    const std::scoped_lock lock(mutex_);
    if (state_.step != "digits" || digits_) {
      return std::unexpected("no digits are awaited: begin again");
    }
    digits_ = std::move(read);
  }
  wake_.notify_all();
  return {};
}

PagePairing::Done PagePairing::give_up() {
  {
    const std::scoped_lock lock(mutex_);
    if (!under_way_) {
      return std::unexpected("no pairing is under way");
    }
    ends_ = true;
  }
  wake_.notify_all();
  return {};
}

bool PagePairing::goes_on() const {
  const std::scoped_lock lock(mutex_);
  return !ends_;
}

void PagePairing::run(const std::string& sensor, const viewer::BeginPairing& wish) {
  std::string text;
  const char* step = "paired";
  try {
    text = pair(sensor, wish);
  } catch (const std::exception& problem) {
    step = "failed";
    text = goes_on() ? problem.what() : std::string("the pairing ") + kGivenUp;
  }
  change([&](viewer::PairingState& state) {
    state.step = step;
    state.text = text;
    if (step == std::string("paired")) {
      state.offer.clear();
    }
    under_way_ = false;
  });
}

// One line: what was made. Throws Failure.
std::string PagePairing::pair(const std::string& sensor, const viewer::BeginPairing& wish) {
  need_crypto();
  client::PairWish asked{.role = wire::role_of(wish.role), .name = user_and_host()};
  if (!wish.code.empty()) {
    prove_by_code(asked, wish.code);
  }
  PairingTerms terms = pairing_terms(config_, sensor, config_.keys);
  terms.timeout_s = std::max(terms.timeout_s, 1.0);  // who waits sees it
  Pairing pairing(terms, asked);
  pairing.start();
  if (pairing.by_digits()) {
    change([](viewer::PairingState& state) { state.step = "digits"; });
    const std::string given = await_digits();
    const std::string ours = six_digits(pairing.digits());
    change([&](viewer::PairingState& state) {
      state.step = "accept";
      state.given = given;
      state.ours = ours;
    });
    if (given != ours) {
      throw Failure(Exit::kFailure, other_digits(given, pairing.digits()));
    }
  }
  return kept_text(pairing.finish(kPairingPatience, [this] { return goes_on(); }), terms.file);
}

std::string PagePairing::await_digits() {
  std::unique_lock lock(mutex_);
  if (!wake_.wait_for(lock, kPairingPatience, [this] { return ends_ || digits_.has_value(); })) {
    throw Failure(Exit::kFailure, "no digits were given in two minutes: nothing was paired");
  }
  if (ends_) {
    throw Failure(Exit::kFailure, kGivenUp);
  }
  return *digits_;
}

void PagePairing::look(const ShownSensor& sensor) {
  std::string offer;
  if (sensor.told) {
    try {
      const OwnRole own = own_role(sensor, config_);
      if (own.doubt.empty() && own.role == "anybody") {
        offer = "unpaired";
      } else if (own.doubt.empty() && own.role == "none") {
        offer = "no_key";
      }
    } catch (const std::exception&) {
      offer.clear();  // the settings panel says what is wrong with the file
    }
  }
  {
    const std::scoped_lock lock(mutex_);
    if (told_ && offer == state_.offer) {
      return;
    }
  }
  change([&](viewer::PairingState& state) { state.offer = offer; });
}

}  // namespace stof::host
