#include "host/viewer/page_places.h"

namespace stof::viewer {
namespace {

std::size_t count_in(const std::map<std::string, std::size_t>& taken, const std::string& owner) {
  const auto at = taken.find(owner);
  return at == taken.end() ? 0 : at->second;
}

}  // namespace

std::string PagePlaces::owner_of(const PageOrigin& who) const {
  if (!who.loopback) {
    return who.address.empty() ? "unknown" : who.address;
  }
  if (who.user && (*who.user == user_ || *who.user == 0)) {
    return {};
  }
  return who.user ? "user " + std::to_string(*who.user) : "unknown user";
}

bool PagePlaces::has_room_for(const PageOrigin& who) const {
  const std::string owner = owner_of(who);
  return all_ < rules_.most &&
         (owner.empty() || (all_ - count_in(taken_, {}) < rules_.most_of_others &&
                            count_in(taken_, owner) < rules_.most_of_one_other));
}

bool PagePlaces::take(const PageOrigin& who) {
  if (!has_room_for(who)) {
    return false;
  }
  ++taken_[owner_of(who)];
  ++all_;
  return true;
}

void PagePlaces::give_back(const PageOrigin& who) {
  const auto at = taken_.find(owner_of(who));
  if (at == taken_.end()) {
    return;
  }
  --all_;
  if (--at->second == 0) {
    taken_.erase(at);
  }
}

}  // namespace stof::viewer
