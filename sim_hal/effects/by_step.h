/* What a stage needs for a step, by the length of the step: a tick has few lengths, and they come again. */
#ifndef SIM_HAL_EFFECTS_BY_STEP_H
#define SIM_HAL_EFFECTS_BY_STEP_H

#include <array>
#include <cstddef>

namespace berth
{

template <typename T>
class by_step
{
  public:
    /* `make(step_s)` where it is not known yet. */
    template <typename Make>
    const T &at(double step_s, const Make &make)
    {
        if (step_s != known_[now_].step_s) {
            find(step_s, make);
        }
        return known_[now_].value;
    }

  private:
    struct entry {
        double step_s = -1.0;
        T value{};
    };

    template <typename Make>
    void find(double step_s, const Make &make)
    {
        for (std::size_t i = 0; i < known_.size(); i++) {
            if (known_[i].step_s == step_s) {
                now_ = i;
                return;
            }
        }
        now_ = next_;
        next_ = (next_ + 1) % known_.size();
        known_[now_] = {step_s, make(step_s)};
    }

    std::array<entry, 4> known_{}; /* dead time and force sample divide a tick into three lengths at most */
    std::size_t now_ = 0;
    std::size_t next_ = 0;
};

} // namespace berth

#endif
