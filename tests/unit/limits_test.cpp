#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "firmware/limits.h"
#include "not_finite.h"
#include "seeded.h"

namespace
{

using seeded::log_uniform;
using seeded::uniform;

app_config random_config(seeded::engine &random)
{
    static const std::int64_t rates_Hz[] = {50, 250, 400, 1000, 10000};
    app_config config = config_default();
    config.loop.rate_Hz = rates_Hz[random() % 5];
    config.limits.position_min_m = -log_uniform(random, 1e-3, 5.0);
    config.limits.position_max_m = log_uniform(random, 1e-3, 5.0);
    config.limits.velocity_m_per_s = log_uniform(random, 1e-2, 10.0);
    config.limits.acceleration_m_per_s2 = log_uniform(random, 1e-1, 1e3);
    config.manipulator.initial_position_m =
        uniform(random, config.limits.position_min_m, config.limits.position_max_m);
    REQUIRE(config_validate(&config).key == nullptr);
    return config;
}

/* Wanted positions of every kind, one kind for a while. */
class hostile_input
{
  public:
    explicit hostile_input(const limits_config &config) : config_(config) {}

    double next(seeded::engine &random)
    {
        if (ticks_left_ == 0) {
            ticks_left_ = 1 + random() % 60;
            kind_ = random() % 7;
            level_m_ = somewhere(random, 1.0);
            slope_m_per_tick_ = somewhere(random, 1e-2);
        }
        ticks_left_--;
        level_m_ += kind_ == 1 ? slope_m_per_tick_ : 0.0;
        switch (kind_) {
        case 0: /* held */
        case 1: /* ramp */
            return level_m_;
        case 2: /* noise */
            return somewhere(random, 1.5);
        case 3: /* an end of the range, exactly */
            return slope_m_per_tick_ > 0.0 ? config_.position_max_m : config_.position_min_m;
        case 4:
            return random() % 2 ? 1e308 : -1e308;
        case 5:
            return random() % 2 ? infinity : -infinity;
        default:
            return not_a_number;
        }
    }

  private:
    double somewhere(seeded::engine &random, double scale) const
    {
        return scale * uniform(random, config_.position_min_m, config_.position_max_m);
    }

    limits_config config_;
    std::uint64_t ticks_left_ = 0;
    std::uint64_t kind_ = 0;
    double level_m_ = 0.0;
    double slope_m_per_tick_ = 0.0;
};

/* What goes out, watched from outside: positions only. Rounding of a position shows in a velocity as ulp / T. */
struct motion_watch {
    const app_config &config;
    double position_m = config.manipulator.initial_position_m;
    double velocity_m_per_s = 0.0;
    double excess_velocity_m_per_s = 0.0;
    double excess_velocity_change_m_per_s = 0.0;
    bool is_finite = true;
    bool is_in_range = true;

    void note(double next_m)
    {
        const limits_config &limits = config.limits;
        const double period_s = config_period_s(&config);
        const double velocity = (next_m - position_m) / period_s;
        is_finite = is_finite && std::isfinite(next_m);
        is_in_range = is_in_range && next_m >= limits.position_min_m && next_m <= limits.position_max_m;
        excess_velocity_m_per_s = std::fmax(excess_velocity_m_per_s, std::fabs(velocity) - limits.velocity_m_per_s);
        excess_velocity_change_m_per_s =
            std::fmax(excess_velocity_change_m_per_s,
                      std::fabs(velocity - velocity_m_per_s) - limits.acceleration_m_per_s2 * period_s);
        position_m = next_m;
        velocity_m_per_s = velocity;
    }

    double rounding_m_per_s() const
    {
        const double largest_m = std::fmax(-config.limits.position_min_m, config.limits.position_max_m);
        const double epsilon = std::numeric_limits<double>::epsilon();
        return 8.0 * epsilon * (largest_m / config_period_s(&config) + config.limits.velocity_m_per_s);
    }

    /* Rounding walks at random through the n ticks of a brake: n^1/2 in the velocity, n^3/2 in the distance that is
     * left to the last tick. */
    double rounding_of_change_m_per_s() const
    {
        const limits_config &limits = config.limits;
        const double range_m = limits.position_max_m - limits.position_min_m;
        const double fastest =
            std::fmin(limits.velocity_m_per_s, std::sqrt(2.0 * limits.acceleration_m_per_s2 * range_m));
        const double braking_ticks = fastest / (limits.acceleration_m_per_s2 * config_period_s(&config));
        return std::pow(1.0 + braking_ticks, 1.5) * rounding_m_per_s();
    }
};

} // namespace

TEST_CASE("limits: whatever comes in, what goes out is finite, in range, and no faster or harder than configured")
{
    SEEDED(random, "limits:*");
    for (int run = 0; run < 300; run++) {
        CAPTURE(run);
        const app_config config = random_config(random);
        limits limits;
        limits_start(&limits, &config);
        hostile_input input(config.limits);
        motion_watch watch{config};
        for (int tick = 0; tick < 2000; tick++) {
            watch.note(limits_step(&limits, input.next(random)));
        }
        CHECK(watch.is_finite);
        CHECK(watch.is_in_range);
        CHECK(watch.excess_velocity_m_per_s <= watch.rounding_m_per_s());
        CHECK(watch.excess_velocity_change_m_per_s <= watch.rounding_of_change_m_per_s());
    }
}

TEST_CASE("limits: a setpoint within the limits passes bit for bit, up to both ends of the range")
{
    SEEDED(random, "limits:*");
    for (int run = 0; run < 200; run++) {
        CAPTURE(run);
        app_config config = random_config(random);
        const limits_config &range = config.limits;
        config.manipulator.initial_position_m = range.position_min_m;
        /* A cosine from end to end, as fast as the tighter of both limits allows. */
        const double amplitude_m = 0.5 * (range.position_max_m - range.position_min_m);
        const double middle_m = range.position_min_m + amplitude_m;
        const double w = 0.999 * std::fmin(range.velocity_m_per_s / amplitude_m,
                                           std::sqrt(range.acceleration_m_per_s2 / amplitude_m));
        limits limits;
        limits_start(&limits, &config);
        int changed = 0;
        for (int tick = 0; tick < 2000; tick++) {
            const double angle = w * tick * config_period_s(&config);
            const double wanted_m = std::fmin(
                std::fmax(middle_m - amplitude_m * std::cos(angle), range.position_min_m), range.position_max_m);
            changed += limits_step(&limits, wanted_m) != wanted_m || limits.active != 0;
        }
        CHECK(changed == 0);
    }
}

TEST_CASE("limits: after any past the setpoints come to rest where they are asked to be, and say so")
{
    SEEDED(random, "limits:*");
    for (int run = 0; run < 200; run++) {
        CAPTURE(run);
        const app_config config = random_config(random);
        const limits_config &range = config.limits;
        const double period_s = config_period_s(&config);
        limits limits;
        limits_start(&limits, &config);
        hostile_input input(range);
        for (int tick = 0; tick < 500; tick++) {
            limits_step(&limits, input.next(random));
        }
        const double target_m = uniform(random, range.position_min_m, range.position_max_m);
        motion_watch watch{config, limits.position_m, limits.velocity_m_per_s};
        /* At worst: brake, cross the range from a standstill, brake. */
        const double length_m = range.position_max_m - range.position_min_m;
        const double time_s = 3.0 * range.velocity_m_per_s / range.acceleration_m_per_s2 +
                              length_m / range.velocity_m_per_s +
                              2.0 * std::sqrt(length_m / range.acceleration_m_per_s2);
        const auto ticks = static_cast<std::int64_t>(time_s / period_s) + 10;
        for (std::int64_t tick = 0; tick < ticks; tick++) {
            watch.note(limits_step(&limits, target_m));
        }
        CHECK(watch.is_in_range);
        CHECK(limits.position_m == target_m);
        CHECK(limits_at_rest(&limits));
        CHECK(limits_step(&limits, target_m) == target_m);
        CHECK(limits.active == 0);
    }
}

TEST_CASE("limits: each one acts under its own name and is counted")
{
    app_config config = config_default();
    config.limits = {-0.5, 0.5, 1.0, 20.0};
    limits limits;
    const auto restart = [&] { limits_start(&limits, &config); };

    restart();
    CHECK(limits_step(&limits, not_a_number) == 0.0);
    CHECK(limits.active == LIMIT_NOT_FINITE);
    CHECK(limits_step(&limits, infinity) == 0.0);
    CHECK(limits_step(&limits, -infinity) == 0.0);
    CHECK(limits.active_ticks[0] == 3);
    REQUIRE(limits_step(&limits, 1e-5) == 1e-5);
    REQUIRE(limits_step(&limits, 1e-5) == 1e-5);
    for (const double wanted_m : {not_a_number, infinity, -infinity}) {
        CHECK(limits_step(&limits, wanted_m) == 1e-5); /* stays where it was last asked to be */
    }

    restart();
    CHECK(limits_step(&limits, 1e-5) == 1e-5);
    CHECK(limits.active == 0);
    limits_step(&limits, 0.5 * 20.0 * 0.0025 * 0.0025); /* half of what one tick's acceleration allows, and back */
    CHECK(limits.active == 0);

    restart();
    CHECK(limits_step(&limits, 0.01) == doctest::Approx(20.0 * 0.0025 * 0.0025).epsilon(1e-12));
    CHECK((limits.active & LIMIT_ACCELERATION) != 0);
    CHECK((limits.active & LIMIT_POSITION) == 0);

    restart();
    limits_step(&limits, 0.6);
    CHECK((limits.active & LIMIT_POSITION) != 0);
    CHECK(limits.active_ticks[1] == 1);

    restart();
    for (int tick = 0; tick < 100; tick++) {
        limits_step(&limits, 0.4); /* 4 m/s to go there in one tick's time: as fast as allowed */
    }
    CHECK(limits.velocity_m_per_s == doctest::Approx(1.0));
    CHECK(limits.active_ticks[2] > 0);
    for (const char *name : limit_names) {
        CHECK(name != nullptr);
    }
}
