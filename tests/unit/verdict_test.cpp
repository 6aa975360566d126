/* One verdict from prediction and motion, on made-up evidence: a table of cases. */
#include <doctest/doctest.h>

#include "../../sim_hal/schedule.h"
#include "../../sim_hal/verdict_words.h"

namespace berth
{

namespace
{

growth_prediction predicts(double growth_per_s, double ci95_per_s = 0.0)
{
    return {growth_per_s,
            {},
            ci95_per_s,
            ci95_per_s > 0.0 ? prediction_source::lyapunov_exponent : prediction_source::eigenvalues};
}

growth_prediction predicts_nothing()
{
    return {{}, "an arm moves far"};
}

growth_fit fit(double growth_per_s, double ci95_per_s)
{
    growth_fit made{};
    made.growth_per_s = growth_per_s;
    made.growth_ci95_per_s = ci95_per_s;
    made.frequency_Hz = 0.9285;
    return made;
}

/* A run of 20 s that moved. */
motion_evidence moving()
{
    motion_evidence motion;
    motion.running_s = 20.0;
    motion.has_run = motion.has_touched = motion.touches_now = motion.has_moved = true;
    return motion;
}

motion_evidence measured(double growth_per_s, double ci95_per_s)
{
    motion_evidence motion = moving();
    motion.growth = fit(growth_per_s, ci95_per_s);
    return motion;
}

motion_evidence stopped(motion_evidence motion, stop_cause cause)
{
    motion.stop = {cause, 1.19};
    return motion;
}

motion_evidence driven(motion_evidence motion)
{
    motion.is_driven = true;
    motion.tracking = {1e-3, 3e-3, 0.02};
    return motion;
}

motion_evidence held_by_limits()
{
    motion_evidence motion = measured(-0.02, 0.001);
    motion.limits_acted_late = true;
    motion.falls = false;
    motion.height_m = 0.08;
    return motion;
}

motion_evidence falling(motion_evidence motion)
{
    motion.falls = true;
    return motion;
}

motion_evidence bounced(std::vector<double> restitutions, bool touches_now)
{
    motion_evidence motion = moving();
    motion.is_contact = true;
    motion.touches_now = touches_now;
    for (const double restitution : restitutions) {
        motion.bounces.push_back({1.0, 2.0, 0.1, 0.1 * restitution});
    }
    return motion;
}

motion_evidence with_trend(motion_trend trend)
{
    motion_evidence motion = moving();
    motion.trend = trend;
    return motion;
}

motion_evidence with_growing_force()
{
    motion_evidence motion = moving();
    motion.force_grows = true;
    return motion;
}

motion_evidence never_ran()
{
    return {};
}

motion_evidence never_touched()
{
    motion_evidence motion = moving();
    motion.has_touched = motion.touches_now = false;
    return motion;
}

motion_evidence still()
{
    motion_evidence motion = moving();
    motion.has_moved = false;
    return motion;
}

struct row {
    const char *what;
    growth_prediction prediction;
    motion_evidence motion;
    verdict_kind kind;
    std::optional<bool> is_stable;
    const char *because; /* is part of it */
};

const auto yes = std::optional<bool>(true);
const auto no = std::optional<bool>(false);
const auto open = std::optional<bool>();

const row table[] = {
    {"both decay", predicts(-0.298369), measured(-0.298364, 4e-5), verdict_kind::stable, yes,
     "decays by 0.29836 +- 0.00004 /s at 0.9285 Hz: halves every 2.32 s; the eigenvalues say -0.298 /s"},
    {"both grow", predicts(1.1), measured(1.105, 0.2), verdict_kind::unstable, no,
     "grows by 1.1 +- 0.2 /s at 0.9285 Hz: doubles every 0.627 s"},
    {"predicted to grow, and stopped by its own motion", predicts(4.32), stopped(moving(), STOP_POSITION_LIMIT),
     verdict_kind::unstable, no,
     "the eigenvalues say +4.32 /s: doubles every 0.16 s; stopped by the position limit after 1.19 s"},
    {"predicted to grow, stopped, its fit falls under limits", predicts(4.32),
     stopped(measured(-0.67, 10.0), STOP_FORCE_LIMIT), verdict_kind::unstable, no, "stopped by the force limit"},
    {"predicted to decay, and stopped by its own motion", predicts(-0.3), stopped(moving(), STOP_POSITION_LIMIT),
     verdict_kind::undetermined, open, "the motion reached a limit before its growth could be measured"},
    {"predicted to decay, and stopped by something else", predicts(-0.3), stopped(moving(), STOP_EMERGENCY_STOP),
     verdict_kind::undetermined, open, "the run ended before its growth could be measured"},
    {"decayed before it was stopped", predicts(-0.3), stopped(measured(-0.3, 0.01), STOP_EMERGENCY_STOP),
     verdict_kind::stable, yes, "stopped by the emergency stop after 1.19 s"},
    {"a person ended it", predicts(-0.3), stopped(measured(-0.3, 0.01), STOP_REQUESTED), verdict_kind::stable, yes,
     "decays by 0.30 +- 0.01 /s"},
    {"moves more until a limit stops it, without a model", predicts_nothing(),
     stopped(with_trend(motion_trend::moves_more), STOP_FORCE_LIMIT), verdict_kind::unstable, no,
     "moves more and more; stopped by the force limit"},
    {"its force grows until a limit stops it, without a model", predicts_nothing(),
     stopped(with_growing_force(), STOP_FORCE_LIMIT), verdict_kind::unstable, no,
     "its force grows; stopped by the force limit"},
    {"a force that grows and is not stopped", predicts_nothing(), with_growing_force(), verdict_kind::undetermined,
     open, "too little oscillation"},
    {"an operator moves it into a limit, without a model", predicts_nothing(),
     stopped(driven(with_trend(motion_trend::moves_more)), STOP_FORCE_LIMIT), verdict_kind::undetermined, open,
     "the motion reached a limit"},
    {"no number", predicts(-0.3), stopped(moving(), STOP_NOT_FINITE), verdict_kind::unstable, no, "not finite"},
    {"measured growth outweighs the model of small motions", predicts(-0.3), measured(0.2, 0.01),
     verdict_kind::unstable, no, "grows by 0.20 +- 0.01 /s"},
    {"what grows has not come up yet", predicts(0.09), measured(-0.3, 0.01), verdict_kind::unstable, no,
     "has not come up yet"},
    {"a growth within its interval leaves it to the model", predicts(-0.3), measured(0.67, 10.0),
     verdict_kind::stable, yes, "the eigenvalues say -0.3 /s: halves every 2.31 s; this run does not show"},
    {"the same without a model", predicts_nothing(), measured(0.67, 10.0), verdict_kind::undetermined, open,
     "smaller than its interval"},
    {"a swing that falls, with a growth within its interval and no limit at work", predicts_nothing(),
     falling(measured(-0.03, 0.2)), verdict_kind::undetermined, open, "smaller than its interval"},
    {"an exponent within its interval", predicts(0.01, 0.02), moving(), verdict_kind::undetermined, open,
     "too little oscillation"},
    {"an exponent beyond its interval", predicts(0.03, 0.02), moving(), verdict_kind::unstable, no,
     "the Lyapunov exponent is +0.030 +- 0.020 /s"},
    {"limits hold it at one height", predicts(0.5), held_by_limits(), verdict_kind::limit_cycle, no,
     "swings for ever at a height of 80 mm, held by the limits"},
    {"limits hold it although small motions decay", predicts(-0.5), held_by_limits(), verdict_kind::limit_cycle, no,
     "held by the limits; the eigenvalues say -0.5 /s for small motions: noise, limits"},
    {"an operator moves it", predicts(-0.3), driven(measured(1e-6, 1e-9)), verdict_kind::driven, yes,
     "the robot is 1 mm rms off the manipulator (5 % of its range), 3 mm at most; the eigenvalues say -0.3 /s"},
    {"an operator moves it, without a model", predicts_nothing(), driven(moving()), verdict_kind::driven, open,
     "not predicted: an arm moves far"},
    {"an operator moves what is unstable", predicts(0.3), driven(moving()), verdict_kind::unstable, no,
     "+0.3 /s: doubles every 2.31 s; the operator drove most of this run, so berth does not judge it by its growth"},
    {"bounces that lose", predicts(-1.0), bounced({0.9, 0.8, 0.85}, true), verdict_kind::bouncing, yes,
     "3 bounces, restitution 0.85 (0.8 to 0.9): a bounce loses"},
    {"bounces that gain", predicts(1.0), bounced({1.1, 1.2, 1.15}, true), verdict_kind::bouncing, no,
     "restitution 1.15 (1.1 to 1.2): a bounce gains"},
    {"bounces that gain, stable in contact", predicts(-1.0), bounced({1.1, 1.2, 1.15}, true), verdict_kind::bouncing,
     no, "the eigenvalues say -1 /s, of a tool that stays in contact"},
    {"bounces that lose, unstable in contact", predicts(1.0), bounced({0.9, 0.8, 0.85}, true),
     verdict_kind::bouncing, no, "the eigenvalues say +1 /s: what stays in contact grows"},
    {"bounces that lose, without a model of the contact", predicts_nothing(), bounced({0.9, 0.8, 0.85}, true),
     verdict_kind::bouncing, open, "stays in contact is stable is not predicted: an arm moves far"},
    {"left for good", predicts(-1.0), bounced({0.9}, false), verdict_kind::bouncing, yes,
     "1 bounce, restitution 0.9: a bounce loses"},
    {"one bounce, then stays", predicts(-1.0), bounced({0.9}, true), verdict_kind::stable, yes,
     "the eigenvalues say -1 /s"},
    {"comes to rest without oscillation", predicts_nothing(), with_trend(motion_trend::comes_to_rest),
     verdict_kind::stable, yes, "the motion comes to rest"},
    {"moves more without oscillation", predicts_nothing(), with_trend(motion_trend::moves_more),
     verdict_kind::unstable, no, "moves more and more"},
    {"in between", predicts_nothing(), moving(), verdict_kind::undetermined, open, "too little oscillation"},
    {"nothing moves, the model knows", predicts(-0.3), still(), verdict_kind::stable, yes,
     "nothing moved in this run"},
    {"nothing moves, the model grows", predicts(0.3), still(), verdict_kind::unstable, no,
     "doubles every 2.31 s; nothing moved in this run"},
    {"too little oscillation, the model grows", predicts(0.3), moving(), verdict_kind::unstable, no,
     "this run has too little oscillation to measure it"},
    {"nothing moves, nobody knows", predicts_nothing(), still(), verdict_kind::undetermined, open,
     "nothing moved: there is no motion to judge; not predicted: an arm moves far"},
    {"never ran", predicts(-0.3), never_ran(), verdict_kind::undetermined, open, "never came to running"},
    {"never gripped", predicts(-0.3), never_touched(), verdict_kind::undetermined, open,
     "never with the object gripped"},
};

} // namespace

TEST_CASE("verdict of prediction and motion")
{
    for (const row &row : table) {
        CAPTURE(row.what);
        const stability_verdict found = judge({row.prediction, row.motion, {}, {}, 100.0, {}, ""});
        CAPTURE(found.because);
        CHECK(std::string(verdict_name(found.kind)) == verdict_name(row.kind));
        CHECK(found.is_stable == row.is_stable);
        CHECK(found.because.find(row.because) != std::string::npos);
        CHECK((found.kind != verdict_kind::undetermined || !found.advice.empty()));
    }
}

TEST_CASE("verdict: a growth smaller than its interval is no finding")
{
    const stability_verdict found =
        judge({predicts(4.32), stopped(measured(-0.67, 10.0), STOP_POSITION_LIMIT), {}, {}, 100.0, {}, ""});
    CHECK(found.because.find("0.67") == std::string::npos);
    CHECK(found.growth->origin == growth_origin::predicted);
}

TEST_CASE("verdict of the model alone")
{
    CHECK(judge(predicts(-0.3), {}).kind == verdict_kind::stable);
    CHECK(judge(predicts(0.3), {}).kind == verdict_kind::unstable);
    CHECK(judge(predicts(0.3, 0.4), {}).kind == verdict_kind::undetermined);
    CHECK(judge(predicts_nothing(), {}).because == "an arm moves far");
    const stability_verdict stuck = judge({0.0, {}, 0.0, prediction_source::run}, {});
    CHECK(stuck.kind == verdict_kind::undetermined);
    CHECK(stuck.because == "a run without noise neither grows nor decays");
}

TEST_CASE("verdict: energy of a bounce is that of the manipulator's speeds")
{
    const stability_verdict found = judge({predicts(1.0), bounced({1.2}, false), {}, {}, 100.0, {}, ""});
    CHECK(found.bounces->energy_J == doctest::Approx(0.5 * 100.0 * (0.12 * 0.12 - 0.1 * 0.1)));
}

TEST_CASE("verdict: a limit cycle beside the one that harmonic balance predicts")
{
    motion_evidence motion = measured(-0.001, 0.01);
    motion.has_effects_of_size = true;
    motion.falls = false;
    motion.height_m = 0.08;
    const limit_cycle parts{0.01, 1.1, false};
    const limit_cycle far{0.2, 0.9, true};
    const limit_cycle near{0.041, 1.0, true};
    const stability_verdict found = judge({predicts_nothing(), motion, {}, {}, 100.0, {parts, near, far}, ""});
    CHECK(found.kind == verdict_kind::limit_cycle);
    CHECK(found.because == "it swings for ever at a height of 80 mm; harmonic balance predicts 82 mm at 1 Hz");
    CHECK(judge({predicts_nothing(), motion, {}, {}, 100.0, {parts, far}, ""}).kind == verdict_kind::undetermined);
    motion.falls = true;
    CHECK(judge({predicts_nothing(), motion, {}, {}, 100.0, {near}, ""}).kind != verdict_kind::limit_cycle);
}

TEST_CASE("verdict: safe is stable with the margin that is asked for")
{
    stability_verdict stable;
    stable.is_stable = true;
    stability_margin margin;
    margin.dead_time_ms = 5.0;
    CHECK(is_safe(stable, margin, 0.0));
    CHECK(is_safe(stable, margin, 5.0));
    CHECK_FALSE(is_safe(stable, margin, 5.1));
    CHECK_FALSE(is_safe(stable, {}, 1.0));
    margin.is_dead_time_open = true; /* as far as was searched, and no further */
    CHECK_FALSE(is_safe(stable, margin, 5.1));
    CHECK_FALSE(is_safe(stability_verdict(), margin, 0.0));
}

TEST_CASE("verdict: a rate has the digits that its interval leaves it")
{
    CHECK(rate_text(0.298364, 4e-5) == "0.29836 +- 0.00004");
    CHECK(rate_text(1.10502, 0.2) == "1.1 +- 0.2");
    CHECK(rate_text(25.3, 12.0) == "25 +- 12");
    CHECK(rate_text(4.32123, 0.0) == "4.32");
    CHECK(rate_text(0.0118, 0.0098) == "0.0118 +- 0.0098");
}

TEST_CASE("advice is rounded to where the loop is stable")
{
    CHECK(rounded_beyond(194.576, 210.0, 4) == doctest::Approx(194.5));
    CHECK(rounded_beyond(194.576, 150.0, 4) == doctest::Approx(194.6));
    CHECK(rounded_beyond(-0.0123456, -0.02, 3) == doctest::Approx(-0.0123));
    CHECK(rounded_beyond(-0.0123456, -0.01, 3) == doctest::Approx(-0.0124));
    stability_advice advice;
    advice.change = parameter_cure{"object.mass_kg", 210.0, 194.5, -0.001};
    advice.compensation = cure{"--with prediction", -0.4712};
    CHECK(advice_text(advice) == "object.mass_kg below 194.5, or --with prediction: -0.47 /s");
    advice.change->value = 210.1;
    CHECK(advice_text(advice) == "object.mass_kg above 210.1, or --with prediction: -0.47 /s");
    CHECK(advice_text({}).empty());
    advice = {};
    advice.was_sought = true;
    CHECK(advice_text(advice) == "no single parameter and no compensation that was tried makes it stable");
}

TEST_CASE("verdict: a schedule is reported stretch by stretch, with the growth of the stretches that do not decide")
{
    growth_prediction told = predicts(0.5);
    const auto loop = [](double from_s, double growth_per_s) {
        return scheduled_growth{from_s, 20.0, 1e3, growth_per_s, 0.0, growth_per_s < 0.0};
    };
    CHECK(schedule_words(told).empty());
    told.schedule = {loop(0.1, -0.2), loop(5.0, 0.5)};
    CHECK(schedule_words(told) == "stable before 5 s (-0.2 /s), unstable from then on");
    CHECK(judge(told, {}).because ==
          "stable before 5 s (-0.2 /s), unstable from then on: the eigenvalues say +0.5 /s: doubles every 1.39 s");
    told.schedule = {loop(0.1, -0.2), loop(2.0, 0.5), loop(5.0, 0.4), loop(7.0, -0.1)};
    CHECK(schedule_words(told) ==
          "stable before 2 s (-0.2 /s), unstable from 2 to 7 s, stable from then on (-0.1 /s)");
}

} // namespace berth
