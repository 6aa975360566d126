/* The library of effects: what a real rig does and the base model does not. An effect is one file that says what it
 * is, which keys of the rig switch it on, from where a search for it starts, and what it does in its block; and one
 * line in effects.h. */
#ifndef SIM_HAL_EFFECTS_EFFECT_H
#define SIM_HAL_EFFECTS_EFFECT_H

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "../../hal/rig/keys.h"
#include "stages.h"

namespace berth
{

/* A robot's clock that runs off the loop's. */
struct clock_guess {
    double drift_ppm = 0.0;
    double phase_ms = 0.0;
};

/* What a record shows of the size of things, so that a search starts where the effect would matter. All rms or
 * largest values about the mean. */
struct record_scales {
    double period_s = 0.0;
    double duration_s = 0.0;
    double position_m = 0.0;       /* largest excursion of the block's input position */
    double velocity_m_per_s = 0.0; /* largest */
    double acceleration_m_per_s2 = 0.0;
    double force_N = 0.0;                 /* largest */
    double residual = 0.0;                /* rms of the block's error, in m or N */
    double residual_m = 0.0;              /* the same as a way: of a force, by how far the contact gives */
    double residual_peak = 0.0;           /* one row in 200 is further off */
    double residual_frequency_Hz = 0.0;   /* strongest line of the error */
    std::vector<double> residual_pitch_m; /* strongest periods of the error over position */
    std::vector<clock_guess> clocks;      /* whose sawtooth of dead time is most like the error */
};

using effect_values = std::vector<double>; /* one for each parameter, in order */

struct effect_parameter {
    std::string_view key; /* of the rig */
    double low;           /* bounds of a fit */
    double high;
    std::string_view meaning; /* only for keys that the effect brings along; else empty: a key that every rig has */
};

/* What is left of an effect for the stability of small motions about rest. */
enum class small_motion {
    depends_on_size, /* no linearisation: growth depends on the amplitude */
    higher_order,    /* nothing, but growth depends on the amplitude all the same */
    drifts,          /* none: it changes the loop for as long as it runs */
    no_influence,    /* nothing: an input from outside */
    in_the_equations /* exactly what it is, eigenvalues or exponents have it */
};

/* What to measure by itself where no excitation of the loop tells the effect from another one. */
struct calibration {
    int rank = 0;          /* of a pair of effects, the one with the lower rank is the surer one to measure */
    std::string_view what; /* empty: its first parameter */
};

/* Of objects: those that a tool touches from one side are contacts. */
enum class object_needed { any, contact, no_contact };

struct effect {
    std::string_view name;    /* block.what */
    std::string_view physics; /* one sentence with the equation */
    std::string_view source;
    std::vector<effect_parameter> parameters;
    berth::calibration calibration;
    object_needed object = object_needed::any;

    /* Whether the robot's position shows it, though it is of another block. */
    bool acts_in_robot = false;

    /* Sizes from which a fit starts. */
    std::vector<effect_values> (*starts)(const rig &base, const record_scales &scales);

    /* How many times smaller or larger than a start a fit may go: what is another effect beyond it stays apart. */
    double reach = 30.0;

    /* Whether the record spans enough for what was fitted to be this effect; nullptr: it does. */
    bool (*is_seen)(const rig &fitted, const record_scales &scales) = nullptr;

    /* Of a robot: whether it is a curve over the position, so that on a path too short for is_seen it is still seen
     * if no plain curve will do. */
    bool is_curve = false;

    /* Whether twice the first parameter does about twice as much: then the best of all sizes follows from one. */
    bool is_proportional = false;

    /* An effect that this one contains, and that is enough where both explain the same. */
    std::string_view generalises;

    /* An effect that hardly any record can tell from this one: only a calibration can. */
    std::string_view look_alike;

    /* An effect that says more about this other one, where that was found before; empty: none. */
    std::string_view refines;

    /* Whether the error jumps with its size, so that slopes mean nothing: it is searched on a grid. */
    bool is_rough = false;

    /* Of a rough one: whether it acts from the first movement on, so that the beginning of a record tells its size.
     */
    bool acts_at_once = false;

    /* Whether it acts by thresholds: of a size a little off, it now and then acts at another tick. */
    bool switches = false;

    /* Of a robot: whether it may be too small for the reports of the robot and yet show in the force of a stiff
     * contact, which is then asked for it. */
    bool hides_in_reports = false;

    /* Where it switches decides all that follows: what is left then is no evidence for another effect. */
    bool decides_what_follows = false;

    /* Of how many parameters, from the first on, an interval that holds zero says that it is none: what the others
     * then make up for is something else. Elsewhere such an interval may be what the tolerances leave open. */
    std::size_t sizes = 0;

    /* A line in the spectrum that no motion makes: however small beside what was found, it is none of its finer
     * ways. */
    bool is_of_time_alone = false;

    /* Of its replay: a share of the values, which are known no better however small the noise. */
    double precision = 0.0;

    /* How many of the starts are worth a fit. */
    int fits_max = 2;

    /* Whether it is seen in single samples rather than fitted: what was lost, repeated, thrown off. */
    bool is_of_single_samples = false;

    /* Whether its error has several minima over the last parameter, a scale: from each a fit finds the next one
     * only.
     */
    bool has_minima_by_scale = false;

    /* What else must be so for the keys to count. */
    void (*switch_on)(rig &) = nullptr;

    /* For rigs that have one of its own keys. */
    small_motion when_small = small_motion::depends_on_size;

    /* What it does, where its keys are not those of the base model. At most one of them is not nullptr. */
    std::unique_ptr<setpoint_stage> (*on_setpoints)(const rig &) = nullptr;
    std::unique_ptr<motion_stage> (*on_motion)(const rig &) = nullptr;
    std::unique_ptr<force_stage> (*on_body)(const rig &) = nullptr;
    std::unique_ptr<motion_stage> (*on_force)(const rig &) = nullptr; /* between low-pass and sample */
    std::unique_ptr<sample_stage> (*on_samples)(const rig &) = nullptr;

    std::string_view block() const { return name.substr(0, name.find('.')); }
};

const std::vector<effect> &effect_library();
const effect *find_effect(std::string_view name);

/* The effect is in the rig: a key that it brought along is not 0. */
bool is_active(const effect &effect, const rig &rig);

/* Value of a number of the rig by its key; the key must be known. */
double value_of(const rig &rig, std::string_view key);
void set_number(rig &rig, std::string_view key, double value);

} // namespace berth

#endif
