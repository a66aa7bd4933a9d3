#pragma once

#include <utility>

namespace stof::hal {

// Takes slots back. Implemented by cameras.
class SlotOwner {
 public:
  virtual ~SlotOwner() = default;
  virtual void give_back(int slot) noexcept = 0;
};

// A frame in a slot that a camera owns: readable while this lives, given back by its destructor.
// Frames are views, cheap to copy; the pixels behind them are valid until then. It must not
// outlive its camera.
template <typename Frame>
class BorrowedFrame {
 public:
  BorrowedFrame(const Frame& frame, SlotOwner& owner, int slot) noexcept
      : frame_(frame), owner_(&owner), slot_(slot) {}
  BorrowedFrame(BorrowedFrame&& other) noexcept
      : frame_(other.frame_), owner_(std::exchange(other.owner_, nullptr)), slot_(other.slot_) {}
  BorrowedFrame& operator=(BorrowedFrame&& other) noexcept {
    if (this != &other) {
      release();
      frame_ = other.frame_;
      owner_ = std::exchange(other.owner_, nullptr);
      slot_ = other.slot_;
    }
    return *this;
  }
  BorrowedFrame(const BorrowedFrame&) = delete;
  BorrowedFrame& operator=(const BorrowedFrame&) = delete;
  ~BorrowedFrame() { release(); }

  const Frame& operator*() const noexcept { return frame_; }
  const Frame* operator->() const noexcept { return &frame_; }

 private:
  void release() noexcept {
    if (owner_ != nullptr) {
      std::exchange(owner_, nullptr)->give_back(slot_);
    }
  }

  Frame frame_;
  SlotOwner* owner_;
  int slot_;
};

}  // namespace stof::hal
