#include "calibration.h"

#include <string_view>

namespace berth
{

namespace
{

struct calibration {
    std::string_view effect;
    std::string_view what;
};

/* The surest ones first: of a pair, the one that stands higher is told. */
constexpr calibration calibrations[] = {
    {"sensor.gain", "load the sensor with a known mass at rest, and compare what it shows with the weight"},
    {"sensor.bias", "read the sensor with nothing attached to it"},
    {"sensor.drift", "read the sensor with nothing attached to it for as long as the record lasted"},
    {"robot.gain",
     "move the robot between two places, and measure the way with another instrument (dial gauge, laser)"},
    {"robot.dead_time", "time the robot's answer to a step with a recorder much faster than the loop"},
    {"robot.lag", "time the robot's answer to a step with a recorder much faster than the loop"},
    {"sensor.delay", "tap the sensor while another instrument records the tap on the clock of the loop"},
    {"sensor.lag", "tap the sensor while another instrument records the tap on the clock of the loop"},
    {"manipulator.gravity_offset", "hold the manipulator at rest, and read the force that it takes"},
    {"object.hysteresis", "pull the object slowly over short ways, and record its force over the way"},
    {"object.coulomb_friction", "pull the object slowly over short ways, and record its force over the way"},
    {"manipulator.coulomb_friction",
     "pull the manipulator slowly over short ways, and record the force over the way"},
    {"object.parameters", "weigh the object, and measure its spring by itself"},
    {"manipulator.parameters", "weigh what the manipulator moves, and measure its spring by itself"},
};

} // namespace

std::string calibration_for(const effect *a, const effect *b)
{
    for (const calibration &known : calibrations) {
        if ((a != nullptr && a->name == known.effect) || (b != nullptr && b->name == known.effect)) {
            return std::string(known.what);
        }
    }
    const effect *const told = a != nullptr ? a : b;
    return told == nullptr ? "" : "measure " + std::string(told->parameters[0].key) + " by itself";
}

} // namespace berth
