/* One verdict from prediction and motion, on made-up evidence: a table of cases. */
#include <doctest/doctest.h>

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

motion_evidence too_short(motion_evidence motion)
{
    motion.is_too_short = true;
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
    {"predicted to decay, and stopped by a motion that did not grow", predicts(-0.3),
     stopped(moving(), STOP_POSITION_LIMIT), verdict_kind::stable, yes,
     "stable by prediction, as this run was stopped before it could show it; stopped by the position limit"},
    {"predicted to decay, and stopped by a motion that grew", predicts(-0.3),
     stopped(with_trend(motion_trend::moves_more), STOP_POSITION_LIMIT), verdict_kind::undetermined, open,
     "the motion reached a limit before its growth could be measured"},
    {"predicted to decay, and launched into a limit", predicts(-0.3),
     stopped(too_short(with_trend(motion_trend::moves_more)), STOP_POSITION_LIMIT), verdict_kind::stable, yes,
     "stable by prediction"},
    {"predicted to decay, and stopped by the reflex on growth", predicts(-0.3), stopped(moving(), STOP_GROWTH),
     verdict_kind::undetermined, open, "the run ended before its growth could be measured"},
    {"predicted to decay, and stopped by an order", predicts(-0.3), stopped(moving(), STOP_EMERGENCY_STOP),
     verdict_kind::stable, yes,
     "stable by prediction, as this run was stopped before it could show it; stopped by the emergency stop"},
    {"stopped by an order, without a model", predicts_nothing(), stopped(moving(), STOP_EMERGENCY_STOP),
     verdict_kind::undetermined, open, "the run ended before its growth could be measured"},
    {"an operator moves it until it is stopped", predicts(-0.3), stopped(driven(moving()), STOP_FORCE_LIMIT),
     verdict_kind::driven, yes, "the eigenvalues say -0.3 /s: halves every 2.31 s; stopped by the force limit"},
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
    {"bounces that gain", predicts(1.0), bounced({1.1, 1.2, 1.15}, true), verdict_kind::unstable, no,
     "restitution 1.15 (1.1 to 1.2): a bounce gains"},
    {"bounces that are alike at three digits", predicts(1.0), bounced({1.1901, 1.1902, 1.1903}, true),
     verdict_kind::unstable, no, "3 bounces, restitution 1.19: a bounce gains"},
    {"bounces that gain, stable in contact", predicts(-1.0), bounced({1.1, 1.2, 1.15}, true), verdict_kind::unstable,
     no, "the eigenvalues say -1 /s, of a tool that stays in contact"},
    {"bounces that lose, unstable in contact", predicts(1.0), bounced({0.9, 0.8, 0.85}, true),
     verdict_kind::unstable, no, "the eigenvalues say +1 /s: what stays in contact grows"},
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

TEST_CASE("verdict: a caveat where a run's growth lies far outside of the predicted one, and which to believe")
{
    const struct {
        growth_prediction prediction;
        motion_evidence motion;
        const char *says; /* empty: no caveat */
    } rows[] = {
        {predicts(-0.3), measured(-0.31, 0.001), ""},    /* within a factor of 2 */
        {predicts(-0.3), measured(-0.9, 0.25), ""},      /* within three intervals */
        {predicts(-0.3, 0.2), measured(-0.9, 0.01), ""}, /* within those of the prediction */
        {predicts(-0.3), measured(-0.9, 0.1), "predicted -0.3 /s, this run measured -0.9 +- 0.1 /s: another mode"},
        {predicts(3.6), measured(0.001, 0.0001),
         "or the run is too short for the one that decides; believe the pred"},
        {predicts(0.08), measured(-0.3, 0.1), "believe the prediction"},
        {predicts(-0.9), measured(-0.3, 0.1),
         "the size of the motion do what the prediction leaves out; believe the"},
        {predicts(-0.3), measured(0.2, 0.01), "believe the run"},
        {predicts(-0.3), driven(measured(-0.9, 0.1)), ""},
        {predicts_nothing(), measured(-0.9, 0.1), ""},
        {predicts(1e-9), measured(-0.9, 0.1), ""}, /* rounding predicts nothing */
    };
    for (const auto &row : rows) {
        const std::string caveat = judge({row.prediction, row.motion, {}, {}, 100.0, {}, ""}).caveat;
        CAPTURE(caveat);
        CAPTURE(*row.says);
        CHECK(caveat.empty() == std::string(row.says).empty());
        CHECK(caveat.find(row.says) != std::string::npos);
    }
    motion_evidence saturated = measured(-0.01, 0.001);
    saturated.motor_limit_share = 0.4;
    CHECK(judge({predicts(-0.3), saturated, {}, {}, 100.0, {}, ""})
              .caveat.find("for small motions believe the pred") != std::string::npos);
    CHECK(judge({predicts(0.5), held_by_limits(), {}, {}, 100.0, {}, ""}).caveat.empty());
}

TEST_CASE("verdict: what an operator does to a tool in the material is no gain of a bounce")
{
    motion_evidence motion = bounced({1.1, 1.2, 1.15}, true);
    for (bounce &one : motion.bounces) {
        one.operator_J = 0.02; /* of 0.5 J that the tool came with */
    }
    stability_verdict found = judge({predicts(-1.0), motion, {}, {}, 100.0, {}, ""});
    CHECK(found.kind == verdict_kind::bouncing);
    CHECK(found.is_stable == yes);
    CHECK(found.because.find("the operator's work is in it") != std::string::npos);
    motion.bounces.push_back({1.0, 2.0, 0.1, 0.08}); /* one in which he rests tells */
    found = judge({predicts(-1.0), motion, {}, {}, 100.0, {}, ""});
    CHECK(found.bounces->count == 1);
    CHECK(found.because.find("1 bounce, restitution 0.8: a bounce loses") != std::string::npos);
    motion.bounces.back().operator_J = 0.004; /* next to nothing */
    CHECK(judge({predicts(-1.0), motion, {}, {}, 100.0, {}, ""}).bounces->count == 1);
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
    motion.swing_Hz = 1.02;
    CHECK(judge({predicts_nothing(), motion, {}, {}, 100.0, {near}, ""}).because ==
          "it swings for ever at a height of 80 mm and 1.02 Hz; harmonic balance predicts 82 mm at 1 Hz");
    motion.falls = true;
    CHECK(judge({predicts_nothing(), motion, {}, {}, 100.0, {near}, ""}).kind != verdict_kind::limit_cycle);
}

TEST_CASE("verdict: limits that acted in most ticks stand beside what they spoil")
{
    motion_evidence motion = measured(-0.3, 0.01);
    motion.limited_share = 0.5;
    CHECK(judge({predicts(-0.3), motion, {}, {}, 100.0, {}, ""}).because.find("limits") == std::string::npos);
    motion.limited_share = 0.51;
    CHECK(judge({predicts(-0.3), motion, {}, {}, 100.0, {}, ""}).because.find("limits acted in 51 %") !=
          std::string::npos);
}

TEST_CASE("verdict: a led force that stays at its limit is unstable, whatever the motion does")
{
    motion_evidence motion = measured(-0.3, 0.001);
    motion.led = force_at_limit{2e4, 0.16, 0.98, true};
    const stability_verdict rattling =
        judge({{-0.2, {}, 0.0, prediction_source::eigenvalues}, motion, {}, {}, {}, {}, {}});
    CHECK(rattling.is_stable == std::optional<bool>(false));
    CHECK(rattling.because.find("at its limit of 2e+04 N in 98 % of the ticks from 0.16 s on, to the end") !=
          std::string::npos);
    motion.led->is_late = false;
    const stability_verdict once =
        judge({{-0.2, {}, 0.0, prediction_source::eigenvalues}, motion, {}, {}, {}, {}, {}});
    CHECK(once.is_stable == std::optional<bool>(true));
    CHECK(once.because.find("from 0.16 s on (sensor_channel.force_limit_N)") != std::string::npos);
}

TEST_CASE("verdict: limits that hold a motion of its own whose force does not fall hold what grows")
{
    motion_evidence motion = moving();
    motion.limits_acted_late = true;
    motion.limited_share = 0.96;
    motion.height_m = 0.02;
    CHECK(judge({{{}, "no eigenvalues"}, motion, {}, {}, {}, {}, {}}).is_stable == std::optional<bool>(false));
    motion.force_falls = true;
    CHECK(judge({{{}, "no eigenvalues"}, motion, {}, {}, {}, {}, {}}).kind == verdict_kind::undetermined);
    motion.force_falls = false;
    CHECK(judge({{{}, "no eigenvalues"}, driven(motion), {}, {}, {}, {}, {}}).kind == verdict_kind::driven);
}

} // namespace berth
