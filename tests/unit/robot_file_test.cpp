#include <doctest/doctest.h>

#include <string>

#include "hal/rig/robot_file.h"

using namespace berth;

namespace
{

const std::string source = "source = \"a user\"\n";

robot_preset preset_of(const std::string &sections)
{
    return parse_robot(source + sections, "mine.toml");
}

std::string refusal_of(const std::string &text)
{
    try {
        (void)parse_robot(text, "mine.toml");
    } catch (const input_error &error) {
        return error.what();
    }
    return "";
}

} // namespace

TEST_CASE("robot preset: what it states goes into the rig, everything else stays the rig's")
{
    const robot_preset robot = preset_of("[loop]\nperiod_ms = 8.0\n[robot]\ndead_time_ms = 35.0\n"
                                         "interpolation = \"hold\"\n[sensor]\ndelay_ms = 3.0\n");
    const rig with = load_rig("ess", {}, &robot);
    CHECK(config_period_ns(&with.firmware) == 8000000);
    CHECK(with.robot.dead_time_ms == 35.0);
    CHECK(with.robot.interpolation == interpolation::hold);
    CHECK(with.sensor.delay_ms == 3.0);
    rig expected = load_rig("ess");
    expected.firmware.loop.rate_Hz = 125.0;
    expected.robot.dead_time_ms = 35.0;
    expected.robot.interpolation = interpolation::hold;
    expected.sensor.delay_ms = 3.0;
    CHECK(print_rig(with) == print_rig(expected));
}

TEST_CASE("robot preset: comes after the rig file and before overrides")
{
    const robot_preset robot = preset_of("[loop]\nperiod_ms = 4.0\n[robot]\ndead_time_ms = [40.0, 80.0]\n");
    CHECK(load_rig("ess-50hz", {}, &robot).robot.dead_time_ms == 80.0);
    CHECK(load_rig("ess-50hz", {"robot.dead_time_ms=50"}, &robot).robot.dead_time_ms == 50.0);
    CHECK(load_rig("ess-50hz", {"loop.rate_Hz=100"}, &robot).firmware.loop.rate_Hz == 100.0);
}

TEST_CASE("robot preset: a period of 12 ms, which is no whole number of Hz")
{
    const robot_preset robot = preset_of("[loop]\nperiod_ms = 12.0\n[robot]\ndead_time_ms = 120.0\n");
    const rig rig = load_rig("ess", {}, &robot);
    CHECK(config_period_ns(&rig.firmware) == 12000000);
}

TEST_CASE("robot preset: a dead time in periods follows the rig and its overrides")
{
    const robot_preset robot = preset_of("[robot]\ndead_time_periods = 3.0\n");
    CHECK(load_rig("ess", {}, &robot).robot.dead_time_ms == 7.5);
    CHECK(load_rig("ess-50hz", {}, &robot).robot.dead_time_ms == 60.0);
    CHECK(load_rig("ess", {"loop.rate_Hz=1000"}, &robot).robot.dead_time_ms == 3.0);
    CHECK(load_rig("ess", {"robot.dead_time_ms=9"}, &robot).robot.dead_time_ms == 9.0);
}

TEST_CASE("robot preset: a band is a range that nothing overrides")
{
    const robot_preset range = preset_of("[robot]\ndead_time_ms = [40, 80.0]\n");
    const auto band = dead_time_band(range, {"object.mass_kg=50"});
    REQUIRE(band.has_value());
    CHECK(band->from == 40.0);
    CHECK(band->to == 80.0);
    CHECK_FALSE(dead_time_band(range, {"robot.dead_time_ms=50"}).has_value());
    CHECK_FALSE(dead_time_band(preset_of("[robot]\ndead_time_ms = 40.0\n"), {}).has_value());
    CHECK_FALSE(dead_time_band(preset_of("[robot]\ndead_time_ms = [40.0, 40.0]\n"), {}).has_value());
}

TEST_CASE("robot preset: both ends of a range must be possible")
{
    const robot_preset robot = preset_of("[robot]\ndead_time_ms = [1.0, 80.0]\n");
    CHECK_THROWS_WITH_AS(load_rig("ess", {}, &robot),
                         doctest::Contains("mine.toml:3: robot.dead_time_ms: must be at least one period"),
                         input_error);
    CHECK_THROWS_WITH_AS(load_rig("ess", {}, &robot), doctest::Contains("lower end"), input_error);
    CHECK_NOTHROW(load_rig("ess", {"loop.rate_Hz=1000"}, &robot));
}

TEST_CASE("robot preset: a rig that does not fit is told with the preset's name")
{
    robot_preset robot = preset_of("[loop]\nperiod_ms = 1.0\n[robot]\ndead_time_ms = 5.0\n");
    robot.name = "quick";
    const std::string text = "[sensor]\nsample_phase_ms = 2.0\n";
    CHECK_NOTHROW(parse_rig(text, "rig.toml"));
    CHECK_THROWS_WITH_AS(parse_rig(text, "rig.toml", {}, &robot),
                         doctest::Contains("rig.toml:2: sensor.sample_phase_ms"), input_error);
    CHECK_THROWS_WITH_AS(parse_rig(text, "rig.toml", {}, &robot), doctest::Contains("robot preset quick"),
                         input_error);
}

TEST_CASE("robot preset: what is wrong with a file is told with file, line and key")
{
    const struct {
        std::string text;
        const char *says;
    } cases[] = {
        {"[robot]\ndead_time_ms = 3.0\n", "mine.toml: source: is missing"},
        {"source = \"\"\n", "mine.toml: source: is missing"},
        {source + "[robot]\ndead_time = 3.0\n",
         "mine.toml:3: robot.dead_time: unknown key; the nearest known one is robot.dead_time_ms"},
        {source + "[robot]\ndead_time_ms = [80.0, 40.0]\n",
         "mine.toml:3: robot.dead_time_ms: the range from 80.0 to 40.0 is reversed; did you mean [40.0, 80.0]?"},
        {source + "[robot]\ndead_time_ms = nan\n", "mine.toml:3: robot.dead_time_ms: must be a finite number"},
        {source + "[robot]\ndead_time_ms = [40.0, nan]\n",
         "mine.toml:3: robot.dead_time_ms: must be a finite number"},
        {source + "[robot]\ndead_time_ms = [nan, 40.0]\n",
         "mine.toml:3: robot.dead_time_ms: must be a finite number"},
        {source + "[robot]\ndead_time_ms = [-1.0, 40.0]\n", "mine.toml:3: robot.dead_time_ms: must be 0 or more"},
        {source + "[robot]\ndead_time_ms = [40.0]\n",
         "mine.toml:3: robot.dead_time_ms: must be a number or a range of two"},
        {source + "[robot]\ndead_time_ms = [[1.0], 2.0]\n", "mine.toml:3: robot.dead_time_ms: must be a number"},
        {source + "[robot]\ndead_time_ms = \"40 ms\"\n", "mine.toml:3: robot.dead_time_ms: must be a number"},
        {source + "[robot]\ndead_time_periods = 0\n",
         "mine.toml:3: robot.dead_time_periods: must be a finite number greater than 0"},
        {source + "[robot]\ndead_time_periods = inf\n",
         "mine.toml:3: robot.dead_time_periods: must be a finite number"},
        {source + "[robot]\ndead_time_ms = 3.0\ndead_time_periods = 3.0\n", "says the same as another key"},
        {source + "[loop]\nperiod_ms = -4.0\n",
         "mine.toml:3: loop.period_ms: must be a finite number greater than 0"},
        {source + "[loop]\nperiod_ms = nan\n", "mine.toml:3: loop.period_ms: must be a finite number"},
        {source + "[loop]\nperiod_ms = 4.0\nrate_Hz = 250\n", "says the same as another key"},
        {source + "[robot]\nplus_drive_lag = 1\n", "mine.toml:3: robot.plus_drive_lag: must be true or false"},
        {source + "[object]\nmass_kg = 1.0\n", "mine.toml:2: object: is no section of a robot preset"},
        {source + "period_ms = 4.0\n", "mine.toml:2: period_ms: unknown key"},
        {"source = 3\n", "mine.toml:1: source: must be text in quotes"},
        {source + "name = \"../up\"\n", "mine.toml:2: name: "},
        {source + "[robot\n", "mine.toml:2: "},
    };
    for (const auto &c : cases) {
        CAPTURE(c.text);
        const std::string refusal = refusal_of(c.text);
        CHECK_MESSAGE(refusal.find(c.says) != std::string::npos, refusal);
        CHECK(refusal.find('\n') == std::string::npos);
    }
}

TEST_CASE("robot preset: every shipped one says who reports it, and goes with the reference case")
{
    CHECK(shipped_robots().size() == 11);
    for (const shipped_file &shipped : shipped_robots()) {
        CAPTURE(shipped.name);
        const robot_preset robot = load_robot(shipped.name);
        CHECK(robot.name == shipped.name);
        CHECK_FALSE(robot.description.empty());
        CHECK_FALSE(robot.source.empty());
        CHECK_NOTHROW(load_rig("ess", {}, &robot));
        CHECK_NOTHROW(load_rig("ess-50hz", {}, &robot));
        CHECK_NOTHROW(load_rig("concept-copper", {}, &robot));
    }
}

TEST_CASE("robot preset: a name that is not known leads to the nearest")
{
    CHECK_THROWS_WITH_AS(load_robot("abb-emg"), doctest::Contains("the nearest is abb-egm"), input_error);
    CHECK_THROWS_WITH_AS(load_robot("yaskawa-dx20"), doctest::Contains("the nearest is yaskawa-dx200"), input_error);
    CHECK_THROWS_WITH_AS(load_robot("no/such.toml"), doctest::Contains("cannot be read"), input_error);
}
