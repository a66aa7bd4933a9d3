#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "host/viewer/page_rights.h"

namespace stof::viewer {

struct PlaceRules {
  std::size_t most = 8;               // connections in all
  std::size_t most_of_others = 6;     // of all that are not the user's own
  std::size_t most_of_one_other = 4;  // of one other address; on this machine: of one other user
};

// Places of pages and other clients that are connected: they are few, and whoever takes many leaves
// the user of this program some. The user's own are connections of this machine by programs of that
// user, or of the superuser. For one thread.
class PagePlaces {
 public:
  // user: who runs this program.
  PagePlaces(const PlaceRules& rules, std::uint32_t user) noexcept : rules_(rules), user_(user) {}

  bool has_room_for(const PageOrigin& who) const;
  // False, and nothing is taken: there is no room.
  bool take(const PageOrigin& who);
  void give_back(const PageOrigin& who);

 private:
  // Of one that is not the user's own: its address, or the other user of this machine. Own: empty.
  std::string owner_of(const PageOrigin& who) const;

  const PlaceRules rules_;
  const std::uint32_t user_;
  std::map<std::string, std::size_t> taken_{};  // by owner_of()
  std::size_t all_ = 0;
};

}  // namespace stof::viewer
