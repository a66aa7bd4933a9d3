#include "firmware/update/trial.h"

namespace stof::update {

Trial::Verdict Trial::tick(hal::Time now, const Published& published,
                           hal::Duration period) noexcept {
  if (verdict_ != Verdict::kOpen) {
    return verdict_;
  }
  const hal::Duration gap = gap_of(period);
  begun_ = begun_.value_or(now);
  lately_.note(now, published);
  if ((lately_.within(now, gap) & needed_) != needed_) {
    since_.reset();
  } else if (!since_) {
    since_ = now;
  }
  if (since_ && now - *since_ >= kProof) {
    verdict_ = Verdict::kConfirmed;
  } else if (now - *begun_ >= kLimit + 3 * gap) {
    verdict_ = Verdict::kLeft;
  }
  return verdict_;
}

}  // namespace stof::update
