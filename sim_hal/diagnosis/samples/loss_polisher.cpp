#include "loss_polisher.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "loss_settler.h"

namespace berth
{

namespace
{

constexpr double stands_out = 6.0;       /* sigma */
constexpr std::size_t spots_max = 40;    /* a replay each, times what is tried there */
constexpr std::size_t setpoints = 12;    /* before a spot */
constexpr std::size_t paired_within = 3; /* of two that are tried together */

class loss_polisher
{
  public:
    loss_polisher(block_model &model, const rig &rig, const loss_trace &loss, double least, sample_events &events)
        : model_(model), rig_(rig), loss_(loss), least_(least), events_(events)
    {
        events_.lost_command.resize(model.data().size(), 0);
        look();
        tried_.resize(error_.size(), 0);
    }

    void polish()
    {
        for (std::size_t i = 0; i < spots_max; i++) {
            const std::size_t spot = worst_spot();
            if (spot == error_.size()) {
                break;
            }
            if (!better_before(spot)) {
                const std::size_t end = std::min(error_.size(), spot + loss_.values.size());
                std::fill(tried_.begin() + static_cast<std::ptrdiff_t>(spot),
                          tried_.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{1});
            }
        }
    }

  private:
    void look()
    {
        square_ = square_now();
        sigma_ = sigma_of(error_, model_.uses());
    }

    double square_now()
    {
        model_.forget_motion();
        model_.error(rig_, error_);
        double sum = 0.0;
        for (std::size_t n = 0; n < error_.size(); n++) {
            sum += model_.uses()[n] != row_use::none ? error_[n] * error_[n] : 0.0;
        }
        return sum;
    }

    /* The first row of the largest error that nothing was tried for; the error's size if there is none. */
    std::size_t worst_spot() const
    {
        const auto stands = [&](std::size_t n) {
            return model_.uses()[n] != row_use::none && tried_[n] == 0 && std::abs(error_[n]) > stands_out * sigma_;
        };
        std::size_t worst = error_.size();
        for (std::size_t n = 0; n < error_.size(); n++) {
            if (stands(n) && (worst == error_.size() || std::abs(error_[n]) > std::abs(error_[worst]))) {
                worst = n;
            }
        }
        while (worst != error_.size() && worst > 0 && stands(worst - 1)) {
            worst--;
        }
        return worst;
    }

    bool better_before(std::size_t spot)
    {
        const std::size_t last = spot > loss_.first ? std::min(spot - loss_.first + 1, error_.size() - 1) : 0;
        const std::size_t first = std::max<std::size_t>(1, last > setpoints ? last - setpoints : 1);
        double best = square_ - least_ * sigma_ * sigma_;
        std::pair<std::size_t, std::size_t> which{0, 0};
        for (std::size_t one = first; one <= last; one++) {
            for (std::size_t other = one; other <= std::min(last, one + paired_within); other++) {
                flip(one, other);
                const double square = square_now();
                flip(one, other);
                if (square < best) {
                    best = square;
                    which = {one, other};
                }
            }
        }
        if (which.first != 0) {
            flip(which.first, which.second);
        }
        look();
        return which.first != 0;
    }

    void flip(std::size_t one, std::size_t other)
    {
        events_.lost_command[one] ^= 1;
        if (other != one) {
            events_.lost_command[other] ^= 1;
        }
    }

    block_model &model_;
    const rig &rig_;
    const loss_trace &loss_;
    double least_;
    sample_events &events_;
    std::vector<double> error_;
    std::vector<std::uint8_t> tried_;
    double square_ = 0.0;
    double sigma_ = 0.0;
};

} // namespace

void polish_losses(block_model &model, const rig &rig, const loss_trace &loss, double least, sample_events &events)
{
    loss_polisher(model, rig, loss, least, events).polish();
}

} // namespace berth
