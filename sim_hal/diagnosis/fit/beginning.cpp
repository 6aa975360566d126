#include "beginning.h"

#include <algorithm>

namespace berth
{

namespace
{

/* A grip that gives way too early is 60 times off in its first second; what a sixteenth does not rule out, a half
 * seldom does. */
constexpr std::size_t share = 16;

template <typename T>
void keep_first(std::vector<T> &values, std::size_t rows)
{
    values.resize(std::min(values.size(), rows));
}

sample_events first_rows(sample_events events, std::size_t rows)
{
    for (auto *const of :
         {&events.lost_command, &events.loss_shows, &events.robot_repeats, &events.force_repeats, &events.spike}) {
        keep_first(*of, rows);
    }
    return events;
}

} // namespace

beginning::beginning(const block_model &whole, const noise_model &noise, const fit_result &incumbent,
                     const known_slopes &slopes, const Eigen::VectorXd &white)
    : record_(first_rows(whole.data(), whole.data().size() / share)),
      events_(first_rows(whole.events(), record_.size())),
      model_(whole.which(), record_, incumbent.rig, events_, held_out_parts::none), noise_(noise),
      whole_square_(white.squaredNorm())
{
    std::vector<row_use> uses = whole.uses();
    keep_first(uses, record_.size());
    model_.use(std::move(uses));
    if (whole.which() == block::manipulator || record_.segments.empty()) {
        return;
    }
    here_ = white_error(model_, noise, incumbent.rig);
    const Eigen::Index rows = here_.size();
    if (rows <= slopes.white.cols() || here_ != white.head(rows)) {
        return;
    }
    base_.emplace(incumbent, known_slopes{slopes.keys, slopes.white.topRows(rows)});
    target_ = base_->target_of(here_);
}

bool beginning::rules_out(const rig &rig, double least, double most, double worth)
{
    if (!base_) {
        return false;
    }
    const Eigen::VectorXd change = white_error(model_, noise_, rig) - here_;
    return base_->least_left(target_, change, least, most) > whole_square_ - worth;
}

} // namespace berth
