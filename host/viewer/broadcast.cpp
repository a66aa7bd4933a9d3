#include "host/viewer/broadcast.h"

#include <algorithm>
#include <span>
#include <utility>

#include "firmware/wire/crypto/crypto.h"
#include "host/viewer/page_message.h"
#include "host/viewer/panel_messages.h"
#include "host/viewer/rate_limit.h"
#include "host/viewer/web_access.h"

namespace stof::viewer {

// The page asks for each frame: what it did not ask for is not sent, so that nothing ever waits for
// it on the way.
class PageConversation : public Conversation {
 public:
  PageConversation(Broadcast& all, Visitor visitor)
      : all_(all),
        visitor_(std::move(visitor)),
        page_{.number = ++all.pages_, .place = visitor_.place, .there = mailbox_} {
    all_.visited_ = true;
    const bool may = visitor_.why_not.empty();
    mailbox_->put(rights_message({.why = visitor_.why_not,
                                  .why_not_pair = may ? visitor_.why_not_pair : visitor_.why_not,
                                  .ticket = may ? ticket_ : "",
                                  .page = page_.number}));
  }
  ~PageConversation() override {
    if (frames_ > 0) {
      --all_.waiting_;
    }
  }
  PageConversation(const PageConversation&) = delete;
  PageConversation& operator=(const PageConversation&) = delete;

  bool take(std::string_view message) override;
  std::optional<MessageKind> next(std::vector<std::uint8_t>& bytes) override;

 private:
  void allow(int frames);
  bool serve(Request request);
  const std::string& why_not(const Wish& wish) const;

  Broadcast& all_;
  const Visitor visitor_;
  const std::string ticket_ = random_token();
  const std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
  const Page page_;
  // A seek bar that is dragged asks ten times a second.
  RateLimit limit_{20, std::chrono::milliseconds(50)};
  bool greeted_ = false;
  bool quiet_ = false;
  Planes planes_ = 0;
  int frames_ = 0;  // that may still be sent
  std::uint64_t frame_ = 0;
  std::array<std::uint64_t, kTopics> topics_{};
  std::uint64_t event_ = 0;
};

void PageConversation::allow(int frames) {
  all_.waiting_ += (frames > 0 ? 1 : 0) - (frames_ > 0 ? 1 : 0);
  frames_ = frames;
}

bool PageConversation::take(std::string_view message) {
  std::optional<PageMessage> said = parse_page_message(message);
  if (!said) {
    return false;
  }
  if (auto* const request = std::get_if<Request>(&*said)) {
    return serve(std::move(*request));
  }
  const Look& look = std::get<Look>(*said);
  planes_ = look.planes;
  quiet_ = look.quiet;
  allow(look.planes == 0 ? 0 : std::min(frames_ + look.frames, Look::kMostFrames));
  return true;
}

// One line; empty: it may.
const std::string& PageConversation::why_not(const Wish& wish) const {
  const bool pairs = std::holds_alternative<BeginPairing>(wish) ||
                     std::holds_alternative<GiveDigits>(wish) ||
                     std::holds_alternative<EndPairing>(wish);
  return visitor_.why_not.empty() && pairs ? visitor_.why_not_pair : visitor_.why_not;
}

// False: it asks for more than anybody can want.
bool PageConversation::serve(Request request) {
  const auto refuse = [&](const std::string& why) {
    mailbox_->put(answer_message(request.id, false, why));
  };
  const bool knows_ticket = request.ticket.size() == ticket_.size() &&
                            wire::equal_secrets(std::as_bytes(std::span(request.ticket)),
                                                std::as_bytes(std::span(ticket_)));
  // First of all: what is refused costs an answer, too.
  if (!limit_.take(Broadcast::Clock::now())) {
    return false;
  }
  if (const std::string& why = why_not(request.wish); !why.empty()) {
    refuse(why);
  } else if (!knows_ticket || !all_.serve_) {
    refuse("this page was not asked: load it again");
  } else if (!mailbox_->open_one()) {
    refuse("the sensor has not answered what was asked before: wait a moment");
  } else {
    all_.serve_(page_, std::move(request.wish), Answer(mailbox_, request.id, all_.wake_));
  }
  return true;
}

std::optional<MessageKind> PageConversation::next(std::vector<std::uint8_t>& bytes) {
  const auto text = [&](const std::string& json) {
    bytes.insert(bytes.end(), json.begin(), json.end());
    return MessageKind::kText;
  };
  if (!std::exchange(greeted_, true)) {
    return text(all_.hello());
  }
  if (const std::optional<Broadcast::Text> event = all_.event_after(event_)) {
    event_ = event->number;
    return text(event->json);
  }
  for (std::size_t i = 0; i < kTopics && !quiet_; ++i) {
    if (const Broadcast::Text newest = all_.newest(static_cast<Topic>(i));
        newest.number > topics_[i]) {
      topics_[i] = newest.number;
      return text(newest.json);
    }
  }
  // Behind what is told to all: an answer is about that.
  if (const std::optional<std::string> letter = mailbox_->take()) {
    return text(*letter);
  }
  if (frames_ > 0) {
    const Broadcast::Newest newest = all_.newest_frame();
    if (newest.frame != nullptr && newest.number > frame_) {
      frame_ = newest.number;
      allow(frames_ - 1);
      append_frame_message(*newest.frame, planes_, bytes);
      return MessageKind::kBinary;
    }
  }
  return std::nullopt;
}

void Broadcast::show(FramePlanes frame) {
  auto shared = std::make_shared<const FramePlanes>(std::move(frame));
  const std::scoped_lock lock(mutex_);
  frame_ = {.number = frame_.number + 1, .frame = std::move(shared), .shown = Clock::now()};
}

void Broadcast::tell(Topic topic, std::string json) {
  const std::scoped_lock lock(mutex_);
  Text& text = topics_[static_cast<std::size_t>(topic)];
  text = {.number = text.number + 1, .json = std::move(json)};
}

void Broadcast::tell_event(std::string json) {
  const std::scoped_lock lock(mutex_);
  const std::uint64_t number = events_.empty() ? 1 : events_.back().number + 1;
  events_.push_back({.number = number, .json = std::move(json)});
  if (events_.size() > kMostEvents) {
    events_.pop_front();
  }
}

Broadcast::Newest Broadcast::newest_frame() const {
  const std::scoped_lock lock(mutex_);
  Newest newest = frame_;
  if (Clock::now() - newest.shown > most_age_) {
    newest.frame.reset();
  }
  return newest;
}

Broadcast::Text Broadcast::newest(Topic topic) const {
  const std::scoped_lock lock(mutex_);
  return topics_[static_cast<std::size_t>(topic)];
}

std::optional<Broadcast::Text> Broadcast::event_after(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  const auto at =
      std::ranges::find_if(events_, [&](const Text& one) { return one.number > number; });
  return at == events_.end() ? std::nullopt : std::optional(*at);
}

std::unique_ptr<Conversation> Broadcast::open_conversation(const Visitor& visitor) {
  return std::make_unique<PageConversation>(*this, visitor);
}

}  // namespace stof::viewer
