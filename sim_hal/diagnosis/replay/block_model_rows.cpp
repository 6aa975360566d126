/* Rows that cannot be compared: at the start of a part, and behind setpoints that were put in. */
#include <algorithm>
#include <cmath>

#include "block_model.h"
#include "robot_start.h"
#include "sensor_ringing.h"

namespace berth
{

namespace
{

/* Until what was before the record has died away, but for the sensor's ringing. */
constexpr double settle_s = 0.4;

double share_behind_missing(const record &record, std::size_t rows)
{
    std::size_t behind = 0;
    std::size_t until = 0;
    for (std::size_t n = 0; n < record.size(); n++) {
        until = record.is_filled(n) ? n + 1 + rows : until;
        behind += n < until;
    }
    return static_cast<double>(behind) / static_cast<double>(record.size());
}

} // namespace

/* By segment: rows that tell what was before it. A manipulator's windows start from their own states. */
std::vector<std::size_t> block_model::rows_to_settle(const rig &base)
{
    std::vector<std::size_t> rows(record_.segments.size(), 0);
    std::size_t longest = 0;
    for (const record_segment &segment : record_.segments) {
        longest = std::max(longest, segment.end - segment.begin);
    }
    /* Of segments that are shorter nothing counts. */
    const auto settle = std::min(static_cast<std::size_t>(settle_s / record_.period_s), longest / 4);
    if (block_ == block::robot) {
        const robot_at_rest rest(record_, 1e-3 * base.robot.dead_time_ms);
        for (std::size_t i = 0; i < rows.size(); i++) {
            rows[i] = rest.begins(record_.segments[i]) ? 0 : settle;
        }
    } else if (block_ == block::force) {
        const sensor_ringing ringing(base, record_);
        for (std::size_t i = 0; i < rows.size(); i++) {
            const double dies_away = ringing.dies_away_s(record_.segments[i]) / record_.period_s;
            const double most = 0.75 * static_cast<double>(longest);
            rings_on_ = rings_on_ || dies_away > most;
            rows[i] = std::max(settle, static_cast<std::size_t>(std::min(dies_away, most))) +
                      until_play_is_crossed(record_.segments[i]);
        }
    }
    return rows;
}

/* Of a setpoint that is missing and put in by what is about it: until the robot has been there, and the force has
 * rung from how far it is off. Not where so many are missing that little would be left, which is better than much
 * that is wrong. */
std::size_t block_model::rows_to_forget(const rig &base) const
{
    constexpr double most = 0.25;       /* of the rows */
    constexpr double most_heard = 0.75; /* where the force is wrong behind them */
    if (record_.filled.empty() || block_ == block::manipulator || record_.moves_as_measured()) {
        return 0;
    }
    const auto rows_of = [&](double rung_s) {
        return static_cast<std::size_t>(std::ceil((1e-3 * base.robot.dead_time_ms + rung_s) / record_.period_s)) + 2;
    };
    const sensor_ringing ringing(base, record_);
    const bool is_force = block_ == block::force;
    if (is_force && ringing.hears(record_.command_guess_rms_m)) {
        const std::size_t rows = rows_of(ringing.forgets_s(record_.command_guess_rms_m));
        if (share_behind_missing(record_, rows) < most_heard) {
            return rows;
        }
    }
    const std::size_t rows = rows_of(is_force ? ringing.to_a_twentieth_s() : 0.0);
    return share_behind_missing(record_, rows) < most ? rows : 0;
}

bool block_model::compares_guesses(const rig &rig, double noise_rms) const
{
    constexpr int coarse_rows = 3; /* of a chirp to 5 Hz, of 10 mm, fewer leave a stiff sensor's noise as it is */
    constexpr double shows = 0.1;  /* of the noise: in places it is several times its rms */
    if (record_.filled.empty() || rows_to_forget_ > 0 || block_ == block::manipulator) {
        return false;
    }
    const double answer = block_ == block::force ? rig.sensor.stiffness_N_per_m : 1.0;
    if (!record_.moves_as_measured() && answer * record_.command_guess_rms_m < shows * noise_rms) {
        return false;
    }
    int run = 0;
    return std::any_of(record_.filled.begin(), record_.filled.end(), [&](std::uint8_t is_filled) {
        run = is_filled != 0 ? run + 1 : 0;
        return run >= coarse_rows;
    });
}

} // namespace berth
