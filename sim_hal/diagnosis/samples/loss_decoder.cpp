#include "loss_decoder.h"

#include <algorithm>
#include <utility>

namespace berth
{

namespace
{

/* Losses rise in the error within some five ticks: two to that power, several times. Doubled, nothing changed in
 * hidden records. */
constexpr std::size_t histories_max = 128;

struct history {
    double square;    /* that its losses leave up to now */
    double cost;      /* with what they have to explain */
    driven_path path; /* up to the last setpoint */
    int run;          /* of losses up to now */
};

struct choice {
    double square;
    double cost;
    double way_m; /* by which the robot lacks the setpoint */
    std::uint8_t from;
    bool is_lost;
};

constexpr std::size_t rows_between_looks = 64; /* at what is left at least */

/* How a history came about, in one byte. */
static_assert(histories_max <= 128);
constexpr std::uint8_t lost_bit = 128;

class decoder
{
  public:
    decoder(const std::vector<double> &sent, const driven_path &path, const loss_trace &loss,
            const std::vector<double> &error, const std::vector<double> &counts, double penalty)
        : sent_(sent), loss_(loss), error_(error), counts_(counts), penalty_(penalty),
          ends_(sent.size() - std::min(sent.size(), loss.first)), length_(loss.values.size()),
          due_(histories_max * length_, 0.0), due_next_(histories_max * length_, 0.0), kept_{{0.0, 0.0, path, 0}},
          lost_paths_(histories_max, path), start_(path), without_(path)
    {
        ways_back_.resize(ends_ * histories_max);
    }

    std::optional<decoded_losses> decode(double square_max)
    {
        const auto cheaper = [](const choice &a, const choice &b) { return a.cost < b.cost; };
        const auto leaves_less = [](const choice &a, const choice &b) { return a.square < b.square; };
        for (std::size_t n = 1; n < ends_; n++) {
            without_m_ = without_.take(sent_[n]);
            branch(n);
            const std::size_t keep = std::min(choices_.size(), histories_max);
            std::nth_element(choices_.begin(), choices_.begin() + static_cast<std::ptrdiff_t>(keep - 1),
                             choices_.end(), cheaper);
            choices_.resize(keep);
            if (n % rows_between_looks == 0 &&
                std::min_element(choices_.begin(), choices_.end(), leaves_less)->square > square_max) {
                return {};
            }
            go_on(n);
        }
        return best();
    }

  private:
    /* What the row that setpoint n is the last one to change costs either way; each history's own path takes it. */
    void branch(std::size_t n)
    {
        choices_.clear();
        const std::size_t row = n + loss_.first;
        for (std::size_t i = 0; i < kept_.size(); i++) {
            history &before = kept_[i];
            const double due = error_[row] + due_[i * length_];
            const auto add = [&](double at_m, bool is_lost) {
                const double way_m = without_m_ - at_m;
                const double rest = due - way_m * loss_.values[0];
                const double square = counts_[row] * rest * rest;
                const double cost = before.cost + (square + (is_lost ? penalty_ : 0.0));
                choices_.push_back({before.square + square, cost, way_m, static_cast<std::uint8_t>(i), is_lost});
            };
            const bool may_lose = before.run < losses_in_a_row_max;
            if (may_lose) {
                lost_paths_[i] = before.path;
            }
            const double taken_m = before.path.take(sent_[n]);
            if (may_lose) {
                const double lost_m = lost_paths_[i].go_on();
                if (lost_m != taken_m) {
                    add(lost_m, true);
                }
            }
            add(taken_m, false);
        }
    }

    void go_on(std::size_t n)
    {
        kept_next_.clear();
        for (std::size_t i = 0; i < choices_.size(); i++) {
            const choice &one = choices_[i];
            const double *const old = &due_[one.from * length_];
            double *const made = &due_next_[i * length_];
            for (std::size_t k = 0; k + 1 < length_; k++) {
                made[k] = old[k + 1] - one.way_m * loss_.values[k + 1];
            }
            made[length_ - 1] = 0.0;
            history &before = kept_[one.from];
            kept_next_.push_back({one.square, one.cost, std::move(one.is_lost ? lost_paths_[one.from] : before.path),
                                  one.is_lost ? before.run + 1 : 0});
            ways_back_[n * histories_max + i] = static_cast<std::uint8_t>(one.from | (one.is_lost ? lost_bit : 0));
        }
        due_.swap(due_next_);
        kept_.swap(kept_next_);
    }

    decoded_losses best() const
    {
        decoded_losses made{std::vector<std::uint8_t>(sent_.size(), 0), error_};
        if (ends_ < 2) {
            return made;
        }
        const auto cheaper = [](const history &a, const history &b) { return a.cost < b.cost; };
        auto at = static_cast<std::size_t>(std::min_element(kept_.begin(), kept_.end(), cheaper) - kept_.begin());
        for (std::size_t n = ends_ - 1; n > 0; n--) {
            const std::uint8_t way_back = ways_back_[n * histories_max + at];
            made.lost[n] = (way_back & lost_bit) != 0;
            at = way_back & ~lost_bit;
        }
        driven_path without = start_;
        driven_path with = start_;
        for (std::size_t n = 1; n < ends_; n++) {
            const double at_m = made.lost[n] != 0 ? with.go_on() : with.take(sent_[n]);
            const double way_m = without.take(sent_[n]) - at_m;
            for (std::size_t k = 0; k < length_ && n + loss_.first + k < made.rest.size(); k++) {
                made.rest[n + loss_.first + k] -= way_m * loss_.values[k];
            }
        }
        return made;
    }

    const std::vector<double> &sent_;
    const loss_trace &loss_;
    const std::vector<double> &error_;
    const std::vector<double> &counts_;
    double penalty_;
    std::size_t ends_;
    std::size_t length_;
    std::vector<double> due_; /* of each history what its losses still do to the rows to come */
    std::vector<double> due_next_;
    std::vector<history> kept_;
    std::vector<history> kept_next_;
    std::vector<driven_path> lost_paths_; /* of each kept history, had it lost the setpoint */
    driven_path start_;
    driven_path without_; /* any loss */
    double without_m_ = 0.0;
    std::vector<choice> choices_;
    std::vector<std::uint8_t> ways_back_; /* of each history after each setpoint */
};

} // namespace

std::optional<decoded_losses> decode_losses(const std::vector<double> &sent, const driven_path &path,
                                            const loss_trace &loss, const std::vector<double> &error,
                                            const std::vector<double> &counts, double penalty, double square_max)
{
    return decoder(sent, path, loss, error, counts, penalty).decode(square_max);
}

} // namespace berth
