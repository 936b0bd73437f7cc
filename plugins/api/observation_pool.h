/// Observations that come once per scan and are gone by the next: making one anew costs as much as filling
/// it.
#pragma once

#include <array>
#include <cstddef>
#include <memory>

namespace loopline {

/// Hands out objects that nobody else holds any more, and new ones as long as there are none.
template <typename Observation, std::size_t size = 4>
class ObservationPool {
 public:
    /// With what its last user left in it: every field is to be set.
    std::shared_ptr<Observation> take() {
        for (std::size_t tries = 0; tries < pool_.size(); ++tries) {
            next_ = (next_ + 1) % pool_.size();
            if (pool_[next_] == nullptr) pool_[next_] = Observation::Create();
            if (pool_[next_].use_count() == 1) return pool_[next_];
        }
        return pool_[next_] = Observation::Create();
    }

 private:
    std::array<std::shared_ptr<Observation>, size> pool_;
    std::size_t next_ = 0;
};

}  // namespace loopline
