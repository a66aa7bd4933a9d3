#include "firmware/settings/network_trial.h"

#include <span>

#include "firmware/settings/text/as_text.h"
#include "firmware/settings/text/paged_writer.h"

namespace stof::settings {
namespace {

std::string_view yes_or_no_text(bool yes) noexcept { return yes ? "yes" : "no"; }

void write_network(const NetworkSettings& network, PagedWriter& out) noexcept {
  out << "dhcp " << yes_or_no_text(network.dhcp) << "\nlink_local "
      << yes_or_no_text(network.link_local) << '\n';
  if (!network.address.view().empty()) {
    out << "address " << network.address.view() << '\n';
  }
  if (!network.gateway.view().empty()) {
    out << "gateway " << network.gateway.view() << '\n';
  }
  out << "hostname " << network.hostname.view() << '\n';
}

}  // namespace

bool NetworkTrial::begin(const NetworkSettings& network) noexcept {
  active_ = confirmed_ = network;
  due_.reset();
  until_.reset();
  return write();
}

void NetworkTrial::change(const NetworkSettings& next, hal::Time now) noexcept {
  if (next == active_) {
    return;
  }
  active_ = next;
  due_ = now + kAnswerTime;
  until_ = next == confirmed_ ? std::nullopt : std::optional(now + kAnswerTime + kConfirmTime);
}

void NetworkTrial::confirm() noexcept {
  confirmed_ = active_;
  until_.reset();
}

std::optional<NetworkSettings> NetworkTrial::tick(hal::Time now) noexcept {
  if (due_ && now >= *due_) {
    due_.reset();
    static_cast<void>(write());  // where it fails, the former comes back
  } else if (pending_ && is_done()) {
    pending_ = false;
  }
  return until_ && now >= *until_ ? std::optional(confirmed_) : std::nullopt;
}

bool NetworkTrial::write() noexcept {
  std::array<char, kDocumentBytes> space;
  PagedWriter out(space);
  write_network(active_, out);
  pending_ = true;
  return out.complete() && wanted_.save(std::as_bytes(std::span(out.text()))) == Status::kOk;
}

bool NetworkTrial::is_done() noexcept {
  std::array<char, kDocumentBytes> space;
  PagedWriter out(space);
  write_network(active_, out);
  std::array<std::byte, kDocumentBytes> bytes;
  const Result<std::optional<std::size_t>> loaded = done_.load(bytes);
  return loaded && *loaded && as_text(std::span(bytes).first(**loaded)) == out.text();
}

}  // namespace stof::settings
