#include "measured_motion.h"

#include <algorithm>

#include "motion_noise.h"
#include "smoothed.h"

namespace berth
{

namespace
{

/* A step goes straight, so what a damper gives is half a step late: a 64th of a row. */
constexpr int steps_a_row = 32;

/* Second derivatives of the natural cubic spline through the rows of a segment. */
void bend(const std::vector<double> &x_m, const record_segment &part, double period_s, std::vector<double> &bend)
{
    std::vector<double> share(part.end - part.begin, 0.0);
    for (std::size_t n = part.begin + 1; n + 1 < part.end; n++) { /* Thomas' algorithm: 1 4 1 */
        const double second = 6.0 * (x_m[n + 1] - 2.0 * x_m[n] + x_m[n - 1]) / (period_s * period_s);
        share[n - part.begin] = 1.0 / (4.0 - share[n - part.begin - 1]);
        bend[n] = share[n - part.begin] * (second - bend[n - 1]);
    }
    for (std::size_t n = part.end; n-- > part.begin + 1;) {
        if (n + 1 < part.end) {
            bend[n] -= share[n - part.begin] * bend[n + 1];
        }
    }
}

/* Of the way from a row to the next one. */
struct piece {
    double from_m;
    double to_m;
    double from_bend_m_per_s2;
    double to_bend_m_per_s2;
    double period_s;

    /* `place`: from 0 to 1. */
    double at(double place) const
    {
        const double rest = 1.0 - place;
        return rest * from_m + place * to_m +
               period_s * period_s / 6.0 *
                   ((rest * rest * rest - rest) * from_bend_m_per_s2 +
                    (place * place * place - place) * to_bend_m_per_s2);
    }
};

/* After the last row it goes on as it went. */
piece piece_after(const record &record, const record_segment &part, std::size_t n)
{
    const std::vector<double> &x_m = record.command_position_m;
    const std::vector<double> &bend = record.bend_m_per_s2;
    if (n + 1 < part.end) {
        return {x_m[n], x_m[n + 1], bend[n], bend[n + 1], record.period_s};
    }
    const double before_m = n > part.begin ? x_m[n - 1] : x_m[n];
    return {x_m[n], 2.0 * x_m[n] - before_m, 0.0, 0.0, record.period_s};
}

} // namespace

void drive_by_measured_motion(record &record)
{
    if (!record.command_position_m.empty() || record.robot_position_m.empty() || record.force_N.empty()) {
        return;
    }
    record.command_position_m =
        smoothed(record, record.robot_position_m, noise_from_row_to_row(record, record.robot_position_m));
    record.bend_m_per_s2.assign(record.size(), 0.0);
    for (const record_segment &part : record.segments) {
        bend(record.command_position_m, part, record.period_s, record.bend_m_per_s2);
    }
    record.notes.push_back(
        "there is no command_position_m: robot_position_m drives the force, smoothed to what its noise lets it "
        "tell; what noise is left comes out as force where a contact is stiff");
}

void replay_measured_motion(const rig &rig, const record &record, int steps_min, robot_motion &motion)
{
    motion.tick = divide_tick(rig, record.period_s, std::max(steps_a_row, steps_min));
    motion.at_tick_m = record.command_position_m;
    motion.position_m.clear();
    motion.bulge_m.clear();
    for (const record_segment &part : record.segments) {
        motion.position_m.push_back(record.command_position_m[part.begin]);
        for (std::size_t n = part.begin; n < part.end; n++) {
            const piece way = piece_after(record, part, n);
            double place = 0.0;
            for (const double step_s : motion.tick.duration_s) {
                place += step_s / record.period_s;
                motion.position_m.push_back(way.at(place));
            }
        }
    }
}

} // namespace berth
