#include "host/viewer/broadcast.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

namespace stof::viewer {

// The page asks for each frame: what it did not ask for is not sent, so that nothing ever waits for
// it on the way.
class PageConversation : public Conversation {
 public:
  explicit PageConversation(Broadcast& all) : all_(all) { all_.visited_ = true; }
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
  static constexpr int kMostFrames = 2;

  void allow(int frames);

  Broadcast& all_;
  bool greeted_ = false;
  bool quiet_ = false;
  Planes planes_ = 0;
  int frames_ = 0;  // that may still be sent
  std::uint64_t frame_ = 0;
  std::uint64_t status_ = 0;
  std::uint64_t event_ = 0;
};

void PageConversation::allow(int frames) {
  all_.waiting_ += (frames > 0 ? 1 : 0) - (frames_ > 0 ? 1 : 0);
  frames_ = frames;
}

// {"show": ["depth"], "frames": 1, "quiet": false}: all three, and nothing else.
bool PageConversation::take(std::string_view message) {
  const nlohmann::json said = nlohmann::json::parse(message, nullptr, false);
  if (!said.is_object() || said.size() != 3 || !said.contains("show") || !said["show"].is_array() ||
      !said.contains("frames") || !said["frames"].is_number_unsigned() ||
      said["frames"].get<std::uint64_t>() > kMostFrames || !said.contains("quiet") ||
      !said["quiet"].is_boolean()) {
    return false;
  }
  Planes planes = 0;
  for (const nlohmann::json& one : said["show"]) {
    const auto* const name = one.get_ptr<const std::string*>();
    const std::optional<Plane> plane = name == nullptr ? std::nullopt : plane_named(*name);
    if (!plane) {
      return false;
    }
    planes |= *plane;
  }
  planes_ = planes;
  quiet_ = said["quiet"].get<bool>();
  allow(std::min(frames_ + said["frames"].get<int>(), kMostFrames));
  if (planes == 0) {
    allow(0);
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
  if (const Broadcast::Text status = all_.newest_status(); status.number > status_ && !quiet_) {
    status_ = status.number;
    return text(status.json);
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

void Broadcast::tell_status(std::string json) {
  const std::scoped_lock lock(mutex_);
  status_ = {.number = status_.number + 1, .json = std::move(json)};
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

Broadcast::Text Broadcast::newest_status() const {
  const std::scoped_lock lock(mutex_);
  return status_;
}

std::optional<Broadcast::Text> Broadcast::event_after(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  const auto at =
      std::ranges::find_if(events_, [&](const Text& one) { return one.number > number; });
  return at == events_.end() ? std::nullopt : std::optional(*at);
}

std::unique_ptr<Conversation> Broadcast::open_conversation() {
  return std::make_unique<PageConversation>(*this);
}

}  // namespace stof::viewer
