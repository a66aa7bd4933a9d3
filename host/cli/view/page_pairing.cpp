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

constexpr std::chrono::minutes kPairingPatience{2};   // as the sensor's
constexpr std::chrono::milliseconds kLookEvery{200};  // whether the page is there yet

}  // namespace

PagePairing::PagePairing(ConfigOptions config, Task::Tell tell)
    : config_(std::move(config)), task_({}, std::move(tell)) {}

PagePairing::Done PagePairing::begin(const viewer::Page& page, const ShownSensor& sensor,
                                     const viewer::BeginPairing& wish) {
  if (sensor.address.empty()) {
    return std::unexpected("no frame has come: nobody knows where the sensor is");
  }
  if (!wish.code.empty() && !wire::code_of(wish.code)) {
    return std::unexpected("the code has 32 hexadecimal digits: look at the label");
  }
  return task_.start(
      page, "a pairing is under way: the page that began it may give it up",
      [&wish](viewer::PairingState& state) {
        state.step = "begin";
        state.role = wish.role;
        state.text.clear();
        state.given.clear();
        state.ours.clear();
      },
      [this, page, address = sensor.address, wish] { return run(page, address, wish); });
}

PagePairing::Done PagePairing::give(const viewer::Page& page, const std::string& digits) {
  constexpr std::size_t kDigits = 6;
  const std::string read = digits_in(digits);
  return task_.change_by(page, [&](viewer::PairingState& state) -> Done {
    if (read.size() != kDigits) {
      return std::unexpected("six digits are awaited: those that the sensor tells");
    }
    if (state.step != "digits" || !state.given.empty()) {
      return std::unexpected("no digits are awaited: begin again");
    }
    state.given = read;
    return {};
  });
}

PagePairing::Done PagePairing::give_up(const viewer::Page& page) {
  return task_.end_by(page, "no pairing is under way");
}

bool PagePairing::goes_on(const viewer::Page& page) const {
  return task_.goes_on() && page.connected();
}

PagePairing::Task::End PagePairing::run(const viewer::Page& page, const std::string& sensor,
                                        const viewer::BeginPairing& wish) {
  try {
    return {.step = "paired", .text = pair(page, sensor, wish)};
  } catch (const std::exception&) {
    if (!task_.goes_on()) {
      return {.step = "failed", .text = "the pairing was given up: nothing was paired"};
    }
    if (!page.connected()) {
      return {.step = "failed",
              .text = "the page that began the pairing was closed: nothing was paired"};
    }
    throw;
  }
}

// One line: what was made. Throws Failure.
std::string PagePairing::pair(const viewer::Page& page, const std::string& sensor,
                              const viewer::BeginPairing& wish) {
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
    task_.change([](viewer::PairingState& state) { state.step = "digits"; });
    const std::string given = await_digits(page);
    const std::string ours = six_digits(pairing.digits());
    task_.change([&](viewer::PairingState& state) {
      state.step = "accept";
      state.ours = ours;
    });
    if (given != ours) {
      throw Failure(Exit::kFailure, other_digits(given, pairing.digits()));
    }
  }
  return kept_text(pairing.finish(kPairingPatience, [&] { return goes_on(page); }), terms.file);
}

std::string PagePairing::await_digits(const viewer::Page& page) {
  const auto deadline = std::chrono::steady_clock::now() + kPairingPatience;
  while (goes_on(page)) {
    if (task_.await(kLookEvery,
                    [](const viewer::PairingState& state) { return !state.given.empty(); })) {
      return task_.state().given;
    }
    if (std::chrono::steady_clock::now() >= deadline) {
      throw Failure(Exit::kFailure, "no digits were given in two minutes: nothing was paired");
    }
  }
  throw Failure(Exit::kFailure, "was given up");  // run() says by whom
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
  if (offer_ != offer) {
    offer_ = offer;
    task_.change([&](viewer::PairingState& state) { state.offer = offer; });
  }
}

}  // namespace stof::host
