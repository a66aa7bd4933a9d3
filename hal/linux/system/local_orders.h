#pragma once

#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace stof::hal::linux {

// Takes orders in text from programs of the same user, at a socket in the file system, in a thread
// of its own that no signal disturbs. An order is one datagram of at most 256 bytes, its answer
// another one.
class LocalOrders {
 public:
  using Obey = std::function<std::string(std::string_view order)>;  // the answer

  // obey: called by the thread, for as long as this lives. path: at most 107 bytes. The error: one
  // line, what and what to do. May allocate, as each answer does.
  static std::expected<LocalOrders, std::string> open(const std::string& path, Obey obey);
  LocalOrders(LocalOrders&&) noexcept;
  LocalOrders& operator=(LocalOrders&&) noexcept;
  ~LocalOrders();  // the socket's file goes, too

 private:
  struct Parts;
  explicit LocalOrders(std::unique_ptr<Parts> parts) noexcept;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stof::hal::linux
