#include <algorithm>
#include <cmath>

#include "../../effects/active.h"
#include "../../solver/object_steps.h"
#include "linear_ticks.h"
#include "replay.h"

namespace berth
{

namespace
{

class electronics
{
  public:
    explicit electronics(const rig &rig) : rig_(rig), stages_(active_stages(rig, &effect::on_samples)) {}
    double take(double force_N, double time_s)
    {
        for (auto &stage : stages_) {
            force_N = stage->take(force_N, time_s);
        }
        force_N += rig_.sensor.bias_N;
        return std::min(std::max(force_N, -rig_.sensor.saturation_N), rig_.sensor.saturation_N);
    }

  private:
    const rig &rig_;
    std::vector<std::unique_ptr<sample_stage>> stages_;
};

/* The linear object over a segment whose robot begins at `position_m`; `bulge_m`: null without corners. */
template <std::size_t kept>
void go_by_ticks(const object_steps &object, const tick_steps &tick,
                 const std::vector<object_steps::step_maps> &maps, const double *position_m, const double *bulge_m,
                 std::vector<double> &sampled)
{
    const linear_ticks<kept> ticks(object, tick, maps);
    auto state = linear_ticks<kept>::at_rest(object);
    for (double &force_N : sampled) {
        force_N = ticks.advance(state, position_m, bulge_m == nullptr ? nullptr : bulge_m + 1);
        position_m += tick.count();
        bulge_m += bulge_m == nullptr ? 0 : tick.count();
    }
}

} // namespace

void replay_force(const rig &rig, const record &record, const robot_motion &motion, std::vector<double> &force_N)
{
    const double late_s = 1e-3 * rig.sensor.delay_ms; /* for what depends on the time of the sample */
    const tick_steps &tick = motion.tick;
    object_steps object(rig);
    std::vector<object_steps::step_maps> maps(tick.kinds); /* by kind of step */
    std::vector<object_steps::step_maps> fine(tick.kinds);
    for (std::size_t step = 0; step < tick.count(); step++) {
        if (step == 0 || tick.kind[step] != tick.kind[step - 1]) {
            maps[tick.kind[step]] = object.make_maps(tick.duration_s[step]);
            fine[tick.kind[step]] = object.make_fine_maps(tick.duration_s[step]);
        }
    }
    force_N.assign(record.size(), 0.0);
    std::vector<double> sampled;
    const double *position_m = motion.position_m.data();
    const double *bulge_m = motion.bulge_m.empty() ? nullptr : motion.bulge_m.data();
    for (const record_segment &part : record.segments) {
        const std::size_t count = part.end - part.begin;
        electronics electronics(rig);
        auto filters = active_stages(rig, &effect::on_force);
        object.start(rig, *position_m, record.time_s[part.begin] - record.time_origin_s);
        double now_N = object.measured_N();
        const double rest_N = now_N;
        for (auto &filter : filters) {
            filter->start(now_N);
        }
        sampled.resize(count);
        const bool goes_by_ticks = object.is_linear() && filters.empty() && rig.sensor.low_pass_order > 0;
        if (goes_by_ticks) {
            const auto go = object.has_further_force() ? go_by_ticks<linear_law::kept> : go_by_ticks<0>;
            go(object, tick, maps, position_m, bulge_m, sampled);
            position_m += count * tick.count();
            bulge_m += bulge_m == nullptr ? 0 : count * tick.count();
        }
        for (std::size_t n = 0; n < count && !goes_by_ticks; n++) {
            double time_s = record.time_s[part.begin + n] - record.time_origin_s;
            for (std::size_t step = 0; step < tick.count(); step++) {
                if (step == tick.sample_after) {
                    sampled[n] = filters.empty() ? object.measured_N() : now_N;
                }
                const std::size_t kind = tick.kind[step];
                const robot_way way{position_m[0], position_m[1], bulge_m == nullptr ? 0.0 : bulge_m[1]};
                object.advance_watching(maps[kind], fine[kind], tick.duration_s[step], way, time_s);
                time_s += tick.duration_s[step];
                position_m++;
                bulge_m += bulge_m == nullptr ? 0 : 1;
                if (!filters.empty()) {
                    now_N = object.measured_N();
                    for (auto &filter : filters) {
                        now_N = filter->advance(now_N, tick.duration_s[step]);
                    }
                }
            }
        }
        position_m++;
        bulge_m += bulge_m == nullptr ? 0 : 1;
        for (std::size_t n = 0; n < count; n++) {
            const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(n) - tick.ticks_late;
            const double time_s = record.time_s[part.begin + n] - record.time_origin_s - late_s;
            force_N[part.begin + n] =
                electronics.take(from < 0 ? rest_N : sampled[static_cast<std::size_t>(from)], time_s);
        }
    }
}

} // namespace berth
