#include "host/viewer/requests.h"

#include "host/viewer/panel_messages.h"

namespace stof::viewer {

bool Mailbox::open_one() {
  const std::scoped_lock lock(mutex_);
  if (open_ == kMostOpen) {
    return false;
  }
  ++open_;
  return true;
}

void Mailbox::close_one(std::string json) {
  const std::scoped_lock lock(mutex_);
  --open_;
  messages_.push_back(std::move(json));
}

void Mailbox::put(std::string json) {
  const std::scoped_lock lock(mutex_);
  messages_.push_back(std::move(json));
}

std::optional<std::string> Mailbox::take() {
  const std::scoped_lock lock(mutex_);
  if (messages_.empty()) {
    return std::nullopt;
  }
  std::string first = std::move(messages_.front());
  messages_.pop_front();
  return first;
}

void Answer::operator()(bool done, const std::string& text) const {
  if (const std::shared_ptr<Mailbox> mailbox = to_.lock()) {
    mailbox->close_one(answer_message(id_, done, text));
    wake_();
  }
}

}  // namespace stof::viewer
