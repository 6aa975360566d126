/* The Lyapunov exponent of loops that change from tick to tick: against eigenvalues where the loop only seems to
 * change, against runs of firmware and simulated rig where it does. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <fstream>

#include "../../sim_hal/stability/lyapunov.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../support/closed_loop.h"
#include "../support/files.h"
#include "../support/random_rigs.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

wake_histogram always_late_by(std::int64_t lateness_ns)
{
    wake_histogram histogram;
    histogram.lateness_ns = {lateness_ns};
    histogram.share = {1.0};
    return histogram;
}

/* Mean growth of |(x, v/w)|, w from the signal itself, after the first eighth: weighted so that what swings and both
 * ends are forgotten. */
double growth_in_run_per_s(const std::vector<Eigen::Vector2d> &motion, double period_s)
{
    const std::size_t first = motion.size() / 8;
    const auto count = static_cast<double>(motion.size() - first - 1);
    double x2 = 0.0;
    double v2 = 0.0;
    for (std::size_t i = first; i < motion.size(); i++) { /* in equal shares whatever the growth */
        const double size2 = motion[i].squaredNorm();
        x2 += motion[i](0) * motion[i](0) / size2;
        v2 += motion[i](1) * motion[i](1) / size2;
    }
    const double w2 = v2 / x2;
    const auto logarithm = [&](std::size_t i) {
        return 0.5 * std::log(motion[i](0) * motion[i](0) + motion[i](1) * motion[i](1) / w2);
    };
    double sum = 0.0;
    double weights = 0.0;
    for (std::size_t i = first; i + 1 < motion.size(); i++) {
        const double share = (static_cast<double>(i - first) + 0.5) / count;
        const double weight = std::exp(-0.25 / (share * (1.0 - share)));
        sum += weight * (logarithm(i + 1) - logarithm(i));
        weights += weight;
    }
    return sum / weights / period_s;
}

/* A histogram that a loop might have: most wake-ups soon, a few late. */
std::string write_histogram(const std::string &path, double largest_us, random_stream &random)
{
    std::string text = "{\"thread\": {\"0\": {\"histogram\": {\"3\": 1000";
    for (int i = 0; i < 20; i++) {
        const double share = random.uniform();
        text += ", \"" + std::to_string(static_cast<int>(4.0 + share * share * (largest_us - 5.0)) * 21 / 21 + i) +
                "\": " + std::to_string(static_cast<int>(400.0 * random.uniform()) + 1);
    }
    std::ofstream(path) << text << "}}}}";
    return path;
}

/* Adds one to three effects that change the loop from tick to tick. */
void disturb(rig &rig, const std::string &histogram_path, random_stream &random)
{
    const double period_ms = 1e3 * config_period_s(&rig.firmware);
    const int count = 1 + static_cast<int>(3.0 * random.uniform());
    for (int i = 0; i < count; i++) {
        switch (static_cast<int>(8.0 * random.uniform())) {
        case 0:
            rig.robot.jitter_ms = 0.2 * random.uniform() * period_ms;
            break;
        case 1:
            rig.run.lateness_file = write_histogram(histogram_path, 500.0 * period_ms * random.uniform(), random);
            break;
        case 2:
            rig.robot.clock = robot_clock::free;
            rig.robot.clock_phase_ms = random.uniform() * period_ms;
            rig.robot.clock_drift_ppm = 400.0 * (random.uniform() - 0.5);
            break;
        case 3:
            rig.sensor.loss_probability = 0.2 * random.uniform();
            break;
        case 4:
            rig.bus.loss_probability = 0.05 * random.uniform();
            break;
        case 5:
            rig.bus.burst_probability = 0.005 * random.uniform();
            rig.bus.burst_length_frames = 1.0 + 4.0 * random.uniform();
            break;
        case 6:
            rig.sensor.rate_Hz = rig.firmware.loop.rate_Hz * (0.4 + 2.6 * random.uniform());
            break;
        default:
            rig.sensor.stale_probability = 0.2 * random.uniform();
            rig.bus.error_probability = 0.02 * random.uniform();
        }
    }
}

/* A random rig with random effects. */
rig disturbed_rig(rig_draw &rigs, const std::string &histogram_path, random_stream &random)
{
    for (;;) {
        rig drawn = rigs.draw();
        disturb(drawn, histogram_path, random);
        drawn.run.seed = static_cast<std::int64_t>(1e9 * random.uniform());
        if (!complete_and_check(drawn)) {
            return drawn;
        }
    }
}

std::string effects_of(const rig &rig)
{
    std::string text;
    for (const std::string &effect : what_varies(rig, load_wake_histogram(rig))) {
        text += effect + "; ";
    }
    return text;
}

/* The same rig for a run that neither limits nor losses stop. */
rig run_rig_of(rig rig, double start_m, std::int64_t ticks)
{
    constexpr double never_ms = 1e9;
    rig.run.duration_s = static_cast<double>(ticks) * config_period_s(&rig.firmware) + 10.0;
    rig.run.release_s = 0.0;
    rig.firmware.limits = {-5.0, 5.0, 1e6, 1e12};
    rig.firmware.sensor_channel.force_limit_N = 5.4e4;
    rig.firmware.sensor_channel.stale_after_ms = never_ms;
    rig.firmware.reflex = without_reflexes(rig.firmware.reflex);
    rig.firmware.robot_channel = {ROBOT_PROFILE_BERTH, never_ms, never_ms, never_ms, 1.0, 0};
    rig.firmware.operator_command.stale_after_ms = never_ms;
    rig.firmware.manipulator.initial_position_m = start_m;
    REQUIRE(!complete_and_check(rig));
    return rig;
}

/* Position and velocity of the manipulator while the rig runs free of limits, for `ticks` ticks: released from as
 * far out as the expected growth allows, and shaken a little at first, because a release alone may hardly stir the
 * mode that will rule. */
std::vector<Eigen::Vector2d> run_free(const rig &rig, double expected_growth_per_s, std::int64_t ticks,
                                      double largest_m = 5e-3)
{
    constexpr int shaken_ticks = 16;
    constexpr double shake = 0.02;
    const double run_s = static_cast<double>(ticks) * config_period_s(&rig.firmware);
    const double start_m = std::min(largest_m, 2e4 * largest_m / rig.object.stiffness_N_per_m) *
                           std::exp(-run_s * std::max(0.0, expected_growth_per_s));
    random_stream random(test_seed(), 6);
    closed_loop loop(run_rig_of(rig, start_m, ticks));
    std::vector<Eigen::Vector2d> motion;
    while (static_cast<std::int64_t>(motion.size()) < ticks && loop.tick()) {
        if (loop.is_running() || !motion.empty()) {
            const tick_record &record = loop.app().recorder.tick;
            motion.emplace_back(record.manipulator_position_m, record.manipulator_velocity_m_per_s);
            if (motion.size() <= shaken_ticks) {
                loop.app().manipulator.position_m += shake * start_m * (random.uniform() - 0.5);
            }
        }
    }
    if (!loop.is_running()) { /* the sensor was saturated on the way */
        REQUIRE(largest_m > 1e-6);
        return run_free(rig, expected_growth_per_s, ticks, 0.1 * largest_m);
    }
    return motion;
}

} // namespace

TEST_CASE("Lyapunov exponent: of a loop that does not change it is the growth of its largest eigenvalue")
{
    REPRODUCIBLE();
    for (const char *name : {"ess", "ess-50hz", "ess-half-dead-time"}) {
        const rig rig = load_rig(name);
        const double growth_per_s = loop_spectrum(rig).growth_per_s;
        const lyapunov_exponent exponent = exponent_of(rig, {}, 20000);
        CHECK(std::abs(exponent.growth_per_s / growth_per_s - 1.0) < 1e-9);
        CHECK(exponent.ci95_per_s < 1e-9 * std::abs(growth_per_s));
    }
    rig_draw rigs(test_seed());
    double worst = 0.0;
    for (int i = 0; i < 60; i++) {
        const rig rig = rigs.draw();
        const spectrum spectrum = loop_spectrum(rig);
        const lyapunov_exponent exponent = exponent_of(rig, {}, 200 * rig.firmware.loop.rate_Hz);
        const double error = std::abs(exponent.growth_per_s / spectrum.growth_per_s - 1.0);
        worst = std::max(worst, error);
        INFO("rig ", i, ": exponent ", exponent.growth_per_s, " /s, eigenvalues ", spectrum.growth_per_s, ", ",
             spectrum.modes[1].growth_per_s, ", ", spectrum.modes[2].growth_per_s, " /s");
        CHECK(error < 1e-6);
    }
    MESSAGE("largest relative difference " << worst);
}

TEST_CASE("Lyapunov exponent: always as late is the same loop with its samples so much earlier")
{
    /* Seen from the ticks, only the sensor's samples move. */
    for (const char *interpolation : {"linear", "hold"}) {
        const rig late = load_rig("ess", {"sensor.sample_phase_ms=1.0", "sensor.delay_ms=2.0",
                                          std::string("robot.interpolation=") + interpolation});
        for (const std::int64_t lateness_ns : {200000, 500000, 900000}) {
            rig early = late;
            early.sensor.sample_phase_ms -= 1e-6 * static_cast<double>(lateness_ns);
            const double expected_per_s = loop_spectrum(early).growth_per_s;
            const double growth_per_s = exponent_of(late, always_late_by(lateness_ns), 40000).growth_per_s;
            CHECK(std::abs(growth_per_s / expected_per_s - 1.0) < 1e-9);
        }
    }
}

TEST_CASE("Lyapunov exponent: a sensor of another rate is so much older a force in each tick of its pattern")
{
    /* Five samples in two ticks: the force of every other tick has come half a sample period before it. Slow modes
     * see the mean age. */
    const double growth_per_s = exponent_of(load_rig("ess", {"sensor.rate_Hz=1000"}), {}, 40000).growth_per_s;
    const double mean_per_s =
        loop_spectrum(load_rig("ess", {"sensor.sample_phase_ms=2.25", "sensor.delay_ms=2.75"})).growth_per_s;
    const double least_per_s = loop_spectrum(load_rig("ess", {})).growth_per_s;
    CHECK(std::abs(growth_per_s - mean_per_s) < 0.02 * std::abs(mean_per_s - least_per_s));
}

TEST_CASE("Lyapunov exponent: it is taken along the very motion that the simulated rig makes")
{
    REPRODUCIBLE();
    constexpr std::int64_t ticks = 800;
    constexpr int shaken_ticks = 16;
    constexpr double shake_m = 1e-4;
    const temporary_folder folder;
    rig_draw rigs(test_seed() + 2);
    random_stream random(test_seed(), 7);
    double worst = 0.0;
    for (int i = 0; i < 60; i++) {
        const rig rig = disturbed_rig(rigs, folder / "histogram.json", random);
        const loop_timeline timeline = make_timeline(rig, load_wake_histogram(rig), ticks);
        transition_cache cache;
        linear_loop alone(rig, timeline, cache);
        closed_loop loop(run_rig_of(rig, 0.0, ticks));
        loop.start();
        REQUIRE(loop.is_running());
        double largest_m = 0.0;
        double difference_m = 0.0;
        std::int64_t tick = 0;
        for (const timeline_step &step : timeline.steps) {
            const double position_m = alone.position_m();
            alone.advance(step);
            if (step.what != timeline_step::kind::tick) {
                continue;
            }
            largest_m = std::max(largest_m, std::abs(position_m));
            difference_m =
                std::max(difference_m, std::abs(position_m - loop.app().recorder.tick.manipulator_position_m));
            if (largest_m > 1e-3) {
                break; /* the sensor would soon be saturated */
            }
            if (tick++ < shaken_ticks) {
                const double push_m = shake_m * (random.uniform() - 0.5);
                loop.app().manipulator.position_m += push_m;
                alone.push(push_m);
            }
            REQUIRE(loop.tick());
        }
        worst = std::max(worst, difference_m / largest_m);
        INFO("rig ", i, ": ", tick, " ticks, largest position ", largest_m, " m, largest difference ", difference_m,
             " m: ", effects_of(rig));
        CHECK(loop.is_running());
        CHECK(difference_m < 1e-4 * largest_m); /* steps of frames: 10 pm, behind a spring of 2e7 N/m */
    }
    MESSAGE("largest difference " << worst << " of the largest position");
}

TEST_CASE("Lyapunov exponent: 60 random rigs grow in a run as their exponent says")
{
    REPRODUCIBLE();
    const temporary_folder folder;
    rig_draw rigs(test_seed() + 1);
    random_stream random(test_seed(), 5);
    constexpr double largest_folds = 10.0; /* by e: what frames resolve */
    constexpr std::int64_t least_ticks = 400;
    constexpr int rigs_drawn = cases_to_draw(60);
    int unstable = 0;
    int outside = 0;
    int few_ticks = 0;
    double worst = 0.0;
    for (int i = 0; i < rigs_drawn; i++) {
        rig rig = disturbed_rig(rigs, folder / "histogram.json", random);
        const double period_s = config_period_s(&rig.firmware);
        const wake_histogram histogram = load_wake_histogram(rig);
        const double expected_per_s = exponent_of(rig, histogram).growth_per_s;
        const auto ticks_in = [&](double growth_per_s) {
            return static_cast<std::int64_t>(std::min(40.0, largest_folds / std::abs(growth_per_s)) / period_s);
        };
        /* A part of a drift may grow much faster than all of it. */
        std::int64_t ticks = ticks_in(expected_per_s);
        lyapunov_exponent same = exponent_of(rig, histogram, std::max(ticks, least_ticks));
        for (int shorter = 0; shorter < 3 && ticks_in(same.growth_per_s) < ticks; shorter++) {
            ticks = ticks_in(same.growth_per_s);
            same = exponent_of(rig, histogram, std::max(ticks, least_ticks));
        }
        const double run_per_s = growth_in_run_per_s(run_free(rig, same.growth_per_s, ticks), period_s);
        rig.run.seed += 1000000;
        const lyapunov_exponent other = exponent_of(rig, histogram, std::max(ticks, least_ticks));

        unstable += expected_per_s > 0.0;
        if (ticks >= least_ticks) {
            worst = std::max(worst, std::abs(run_per_s / same.growth_per_s - 1.0));
        }
        few_ticks += ticks < least_ticks;
        const bool is_outside =
            ticks >= least_ticks && std::abs(run_per_s - other.growth_per_s) > std::sqrt(2.0) * other.ci95_per_s;
        outside += is_outside;
        INFO("rig ", i, ": ", rig.firmware.loop.rate_Hz, " Hz, ", ticks, " ticks: run ", run_per_s, " /s, exponent ",
             same.growth_per_s, " +- ", same.ci95_per_s, ", with another seed ", other.growth_per_s, " +- ",
             other.ci95_per_s, " /s: ", effects_of(rig));
        /* The same sequence meets another phase of the swing: within the interval, of which 2.5 times is five
         * standard deviations. Where frames resolve no more than a few ticks, there is the mode that rules after
         * them, too, of which a release stirs maybe 1/150 of the motion: e^-5. */
        const double stirred_per_s = ticks < least_ticks ? 5.0 / (static_cast<double>(ticks) * period_s) : 0.0;
        CHECK(std::abs(run_per_s - same.growth_per_s) <
              std::max({1e-2 * std::abs(same.growth_per_s), 2.5 * same.ci95_per_s, stirred_per_s}));
    }
    MESSAGE(unstable << " of " << rigs_drawn << " unstable; run and exponent of the same sequence differ by at most "
                     << worst << " of it, but for " << few_ticks
                     << " rigs that grow too fast to be measured as well; " << outside
                     << " runs outside the 95 % interval of another sequence");
    CHECK(outside <= 12); /* 3 of 60 are expected, and short runs have but rough intervals */
}

TEST_CASE("Lyapunov exponent: a slow drift of the robot's clock averages the growth over all phases")
{
    for (const char *name : {"ess", "ess-50hz"}) {
        rig drifting = load_rig(name, {"robot.clock=free", "robot.clock_drift_ppm=40"});
        const lyapunov_exponent exponent = exponent_of(drifting, {}, 200000);
        /* At a fixed phase the free clock is one more dead time: until it looks for a setpoint that has come over
         * the bus behind feedback and operator command. */
        const double arrival_ms = 3e-6 * static_cast<double>(frame_time_ns(drifting.bus, 8));
        const double period_ms = 1e3 * config_period_s(&drifting.firmware);
        constexpr int phases = 64;
        double mean_per_s = 0.0;
        double least_per_s = 1e9;
        double largest_per_s = -1e9;
        for (int i = 0; i < phases; i++) {
            rig fixed = without_variation(drifting);
            fixed.robot.dead_time_ms += arrival_ms + period_ms * (i + 0.5) / phases;
            const double growth_per_s = loop_spectrum(fixed).growth_per_s;
            mean_per_s += growth_per_s / phases;
            least_per_s = std::min(least_per_s, growth_per_s);
            largest_per_s = std::max(largest_per_s, growth_per_s);
        }
        INFO(name, ": exponent ", exponent.growth_per_s, " +- ", exponent.ci95_per_s, ", mean of the phases ",
             mean_per_s, ", from ", least_per_s, " to ", largest_per_s, " /s");
        CHECK(std::abs(exponent.growth_per_s - mean_per_s) < 0.02 * (largest_per_s - least_per_s));

        drifting.robot.clock_drift_ppm = 0.0; /* and at a fixed phase it is the eigenvalue there */
        drifting.robot.clock_phase_ms = 0.7 * period_ms;
        rig fixed = without_variation(drifting);
        fixed.robot.dead_time_ms += drifting.robot.clock_phase_ms;
        CHECK(std::abs(exponent_of(drifting, {}, 20000).growth_per_s / loop_spectrum(fixed).growth_per_s - 1.0) <
              1e-9);
    }
}

} // namespace berth
