/* What a run's motion shows, tick by tick and as a whole: evidence for a verdict, and no verdict itself. */
#ifndef SIM_HAL_MOTION_H
#define SIM_HAL_MOTION_H

#include <cstdint>
#include <optional>
#include <vector>

#include "../firmware/recorder.h"
#include "../firmware/supervisor.h"
#include "../hal/rig/rig.h"
#include "stability/growth_fit.h"
#include "thinned_signal.h"

namespace berth
{

/* As many ticks of a run are kept at most, so that a day's run takes no more memory than an hour's. */
constexpr std::size_t kept_ticks_max = 1 << 20;

/* Swings lower than this say nothing of growth: the steps of the wire show, 10 pm of the setpoint. */
constexpr double growth_floor_m = 1e-8;

/* Motion of the manipulator while it runs, without interruption by a limit or an order, from when the object is
 * gripped until it is let go. After kept_ticks_max another one begins. */
struct free_motion {
    std::vector<double> position_m;
    std::vector<std::int64_t> tick;     /* index of each sample's tick */
    std::int64_t motor_limit_ticks = 0; /* of them: an arm's motors were at their torque limit */
};

/* Why a run ended before its time. */
struct run_stop {
    stop_cause cause = STOP_NONE;
    double after_s = 0.0; /* since the start of the run */

    /* Something stopped it: neither its end nor a person who asked for it. */
    bool is_early() const { return cause != STOP_NONE && cause != STOP_REQUESTED; }

    /* A person or the rig file ordered it. */
    bool is_ordered() const { return cause == STOP_EMERGENCY_STOP || cause == STOP_ENABLE_OFF; }

    /* The motion itself, or the force that it made, was too large. */
    bool is_of_motion() const;
};

struct force_peak {
    double force_N = 0.0;
    double at_s = 0.0;
};

/* One stay of a tool in the material. Speeds of the manipulator, once the force of the stay has reached the loop. */
struct bounce {
    double touched_s;
    double
        left_s; /* when the material pushes no more: where it has damping, before the tool is back at the surface */
    double speed_in_m_per_s;
    double speed_out_m_per_s;
    double speed_noise_m_per_s = 0.0; /* what the sensor's noise makes of it, standard deviation */
    double operator_J = 0.0;          /* the operator's work meanwhile */

    double restitution() const { return speed_out_m_per_s / speed_in_m_per_s; }
};

/* Speed of the manipulator where it passes the surface, reckoned from a tick nearby: what its spring holds there,
 * more than at the surface, is motion at the surface. The tool moves with it. Its sign is that of the tick. */
double speed_at_surface_m_per_s(const rig &rig, const tick_record &record);

/* How far the robot is from where the manipulator is. */
struct tracking_error {
    double rms_m = 0.0;
    double peak_m = 0.0;
    double range_m = 0.0; /* of the manipulator's motion */
};

enum class motion_trend {
    unknown, /* neither of the others, or too short to tell */
    comes_to_rest,
    moves_more, /* in the second half than in the first */
};

/* A force that a compensation has led up to the limit of what it may use. */
struct force_at_limit {
    double limit_N = 0.0;
    double from_s = 0.0;
    double share = 0.0;   /* of the ticks of running since then */
    bool is_late = false; /* in the last quarter of the run as well */

    /* To the end, in most ticks: the limit bounds what grows from tick to tick. */
    bool rattles() const { return is_late && share > 0.5; }
};

struct motion_evidence {
    double running_s = 0.0;
    bool has_run = false;
    bool has_touched = false; /* gripped or touched the object: there was a loop */
    bool touches_now = false; /* at the end */
    bool has_moved = false;
    bool is_driven = false;  /* an operator's profile moved it for most of the run */
    bool is_ordered = false; /* an operator orders an arm elsewhere */
    bool is_contact = false;
    bool has_effects_of_size = false; /* backlash and the like: small motions say nothing of large ones */
    bool is_too_short = false;        /* did not swing often enough to tell growth from decay */
    std::optional<growth_fit> growth; /* of the free motion */
    double motor_limit_share = 0.0;   /* of the ticks of that */
    double limited_share = 0.0;       /* of the ticks of running: limits acted */
    bool limits_acted_late = false;   /* in the last quarter: they bound what grows */
    std::optional<bool> falls;        /* under limits: the swing is lower in the second half */
    double height_m = 0.0;            /* of the last swings, from crest to trough */
    double swing_Hz = 0.0;            /* how often those come; 0: too few */
    motion_trend trend = motion_trend::unknown;
    bool force_grows = false;          /* measured, by a factor of 2 and more from the first half to the second */
    bool force_falls = false;          /* its peak is lower in the second half */
    std::optional<force_at_limit> led; /* by force lead or prediction, to the limit; nothing: it never came there */
    std::vector<bounce> bounces;
    tracking_error tracking;
    force_peak measured_peak;
    std::optional<force_peak> true_peak; /* in the sensor's spring, at the ticks; nothing: known to no log */
    run_stop stop;
};

/* Takes the ticks of one run. */
class motion_recorder
{
  public:
    explicit motion_recorder(const rig &rig);

    /* `spring_force_N`: of the sensor's spring at this tick; nothing where nobody knows. */
    void note_tick(const tick_record &record, bool motors_at_limit, std::optional<double> spring_force_N);

    /* Once, after the last tick. */
    motion_evidence conclude();

    const free_motion &longest() const { return longest_; } /* what growth is measured from */
    std::int64_t held_ticks() const { return held_ticks_; }

  private:
    void note_running(const tick_record &record);
    void note_bounce(const tick_record &record);
    void note_led_force(const tick_record &record);
    void note_peaks(const tick_record &record, std::optional<double> spring_force_N);
    void end_free_motion();
    void forget_motion();

    rig rig_;
    double period_s_;
    std::int64_t settle_ticks_; /* until a force that has gone is gone from the loop, too */
    motion_evidence evidence_;
    std::int64_t held_ticks_ = 0;
    std::int64_t running_ticks_ = 0;
    std::int64_t limited_ticks_ = 0;    /* of those: limits acted */
    std::int64_t led_before_ticks_ = 0; /* of running, before the led force first came to its limit */
    std::int64_t led_ticks_ = 0;        /* at the limit */
    std::int64_t led_until_ticks_ = 0;  /* of running, when it was there last */
    bool holds_ = false;                /* in this tick */
    /* Since the grip, in all ticks of running, limited or not: the manipulator, and the measured force. */
    thinned_signal running_m_{thinning::first, kept_ticks_max};
    thinned_signal running_N_{thinning::largest, kept_ticks_max};
    std::size_t limited_until_tick_ = 0; /* of those: limits acted last before this one */
    free_motion newest_;
    free_motion longest_;
    std::optional<bounce> open_bounce_;
    double robot_before_m_ = 0.0;       /* in the last tick of running */
    double operator_before_J_ = 0.0;    /* the operator's work until the stay began */
    std::int64_t settled_in_tick_ = -1; /* when the last stay's force has gone */
    double tracking_square_sum_m2_ = 0.0;
    double lowest_m_ = 0.0;
    double highest_m_ = 0.0;
};

} // namespace berth

#endif
