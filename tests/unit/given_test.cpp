/* What a rig states and what is assumed; a rig whose answer would hang on an assumption is refused. */
#include <algorithm>
#include <doctest/doctest.h>

#include "../../hal/rig/given.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/assumptions.h"

namespace berth
{

namespace
{

const std::string stated_manipulator = "[manipulator]\nmass_kg = 120\n";
const std::string stated_robot = "[robot]\ndead_time_ms = 34\n";
const std::string stated_object = "[object]\nmass_kg = 40\n";

/* Empty: taken. */
std::string refusal_of(const std::string &text, const std::vector<std::string> &overrides = {})
{
    try {
        refuse_unstated(parse_rig(text, "my.toml", overrides), "my.toml");
    } catch (const input_error &error) {
        return error.what();
    }
    return "";
}

std::vector<std::string> assumed_keys(const rig &rig)
{
    std::vector<std::string> keys;
    for (const assumption &one : assumptions_of(rig)) {
        keys.emplace_back(one.key);
    }
    return keys;
}

bool has(const std::vector<std::string> &names, const std::string &name)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

} // namespace

TEST_CASE("given: object, manipulator and dead time have to be stated")
{
    CHECK(refusal_of(stated_manipulator + stated_robot + stated_object) == "");
    const std::string no_object = refusal_of(stated_manipulator + stated_robot);
    CHECK(no_object.find("my.toml: object: the section [object] is missing") == 0);
    CHECK(no_object.find("kind = \"none\"") != std::string::npos);
    CHECK(no_object.find("base = \"ess\"") != std::string::npos);
    CHECK(refusal_of(stated_robot + stated_object).find("my.toml: manipulator.mass_kg: is missing") == 0);
    CHECK(refusal_of(stated_manipulator + stated_object).find("my.toml: robot.dead_time_ms: is missing") == 0);
    CHECK(refusal_of(stated_manipulator + stated_robot + "[object]\nkind = \"gripped\"\n").find("object.mass_kg") !=
          std::string::npos);
    CHECK(refusal_of(stated_manipulator + stated_robot + "[object]\nkind = \"none\"\n") == "");
    CHECK(refusal_of(stated_manipulator + stated_robot, {"object.mass_kg=40"}) == "");
}

TEST_CASE("given: a base is taken on purpose")
{
    CHECK(refusal_of("base = \"ess\"\n" + stated_robot) == "");
    const rig rig = parse_rig("base = \"ess\"\n[robot]\ndead_time_ms = 34\n", "my.toml");
    CHECK(rig.robot.dead_time_ms == 34.0);
    CHECK(rig.object.stiffness_N_per_m == load_rig("ess").object.stiffness_N_per_m);
    CHECK(rig.name == "");
    CHECK_THROWS_WITH(parse_rig("base = \"nosuch\"\n", "my.toml"),
                      doctest::Contains("my.toml:1: base: must be a shipped rig (ess, ess-50hz, "));
    CHECK_THROWS_WITH(parse_rig("base = 1\n", "my.toml"), doctest::Contains("my.toml:1: base: must be text"));
}

TEST_CASE("given: every shipped rig states what decides")
{
    for (const shipped_file &shipped : shipped_rigs()) {
        CAPTURE(shipped.name);
        CHECK_NOTHROW(refuse_unstated(load_rig(shipped.name), shipped.name));
        CHECK(assumed_keys(load_rig(shipped.name)).empty());
    }
}

TEST_CASE("given: what is assumed all the same is listed with its value")
{
    const rig rig =
        parse_rig(stated_manipulator + stated_robot + stated_object + "[sensor]\ndelay_ms = 2\n", "my.toml");
    const std::vector<std::string> keys = assumed_keys(rig);
    for (const char *key : {"sensor.stiffness_N_per_m", "sensor.low_pass_frequency_Hz", "limits.position_max_m",
                            "object.stiffness_N_per_m"}) {
        CAPTURE(key);
        CHECK(has(keys, key));
    }
    CHECK_FALSE(has(keys, "sensor.delay_ms"));
    CHECK_FALSE(has(keys, "object.mass_kg"));
    for (const assumption &one : assumptions_of(rig)) {
        if (one.key == "sensor.low_pass_frequency_Hz") {
            CHECK(std::stod(one.value) == 20.0);
        }
    }
}

TEST_CASE("given: a printed configuration says what was given and reads back to the same")
{
    const rig rig =
        parse_rig(stated_manipulator + stated_robot + stated_object + "[sensor]\ndelay_ms = 2\n", "my.toml");
    const std::string text = print_config(rig);
    CHECK(text.find("# assumed: frequency f_L") != std::string::npos);
    CHECK(text.find("# given: sample to arrival") != std::string::npos);
    const berth::rig again = parse_rig(text, "printed.toml");
    CHECK(print_config(again) == text);
    CHECK(assumed_keys(again) == assumed_keys(rig));
    CHECK(config_hash(again) == config_hash(rig));
    CHECK(is_given(parse_rig(text, "printed.toml", {"sensor.low_pass_frequency_Hz=50"}),
                   "sensor.low_pass_frequency_Hz"));
    CHECK_THROWS_WITH(parse_rig("assumed = [\"nosuch\"]\n", "my.toml"), doctest::Contains("my.toml:1: assumed: "));
}

} // namespace berth
